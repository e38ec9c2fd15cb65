use std::ffi::{CStr, CString};
use std::ptr::{self, NonNull};

use super::error::{EmbreeError, describe, record_error};
use super::memory::MemoryCount;
use super::{Version, sys};

/// A running Embree. Scenes that were made with it stay alive without it.
#[derive(Debug)]
pub struct Device {
    handle: NonNull<sys::RTCDeviceTy>,
    version: Version,
    /// Released after the reference to the device, which may be the last.
    memory: MemoryCount,
}

// SAFETY: Embree counts references to devices atomically, and makes objects of one device on any thread.
unsafe impl Send for Device {}
// SAFETY: as above; a device has no state of its own that `&self` changes.
unsafe impl Sync for Device {}

impl Device {
    /// Starts Embree with its default settings.
    ///
    /// # Errors
    /// If Embree does not support this processor, or if the loaded library has another major version than the
    /// headers of this build or is older than they are.
    pub fn new() -> Result<Device, EmbreeError> {
        Device::configured(c"")
    }

    /// Starts Embree so that it builds with `threads` threads; 0 means as many as there are.
    ///
    /// # Errors
    /// As [`Device::new`].
    pub fn with_threads(threads: usize) -> Result<Device, EmbreeError> {
        let text = format!("threads={threads}");
        Device::configured(&CString::new(text).unwrap_or_default())
    }

    fn configured(configuration: &CStr) -> Result<Device, EmbreeError> {
        // SAFETY: the configuration ends with a zero byte; an empty one asks for the defaults.
        let raw = unsafe { sys::rtcNewDevice(configuration.as_ptr()) };
        let handle = NonNull::new(raw).ok_or_else(start_failure)?;
        // SAFETY: the handle is alive; the callback takes a null user pointer and lives as long as the program.
        unsafe { sys::rtcSetDeviceErrorFunction(raw, Some(record_error), ptr::null_mut()) };
        // SAFETY: the handle is alive, and every device has this property.
        let number = unsafe { sys::rtcGetDeviceProperty(raw, sys::RTC_DEVICE_PROPERTY_VERSION) };
        let version = Version::from_number(u32::try_from(number).unwrap_or(0));
        let device = Device { handle, version, memory: MemoryCount::default() };
        // SAFETY: the handle is alive; whoever keeps the device alive holds a `Device`, and so the count.
        unsafe { device.memory.follow(raw) };
        check_fit(Version::from_number(sys::RTC_VERSION), device.version)?;
        Ok(device)
    }

    /// The version of the loaded library.
    pub fn version(&self) -> Version {
        self.version
    }

    /// The memory that Embree holds for all that was made with this device and is not released yet, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.memory.bytes()
    }

    /// Another owner of the same device.
    pub(super) fn share(&self) -> Device {
        // SAFETY: the handle is alive; the new owner releases this reference.
        unsafe { sys::rtcRetainDevice(self.handle.as_ptr()) };
        Device { handle: self.handle, version: self.version, memory: self.memory.clone() }
    }

    pub(super) fn as_raw(&self) -> sys::RTCDevice {
        self.handle.as_ptr()
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: this owner's reference, released once.
        unsafe { sys::rtcReleaseDevice(self.handle.as_ptr()) };
    }
}

fn start_failure() -> EmbreeError {
    // SAFETY: a null device asks for the error of the device that could not be made on this thread.
    let code = unsafe { sys::rtcGetDeviceError(ptr::null_mut()) };
    EmbreeError::Refused { action: "start", reason: describe(code, "") }
}

/// The size of a ray and the meaning of constants may change between the headers and another library.
fn check_fit(headers: Version, library: Version) -> Result<(), EmbreeError> {
    if library.major() == headers.major() && library >= headers {
        return Ok(());
    }
    Err(EmbreeError::Mismatch { headers, library })
}

#[cfg(test)]
mod tests {
    use super::super::SceneBuilder;
    use super::*;
    use crate::math::Vec3;

    #[test]
    fn the_loaded_library_tells_its_version() {
        let version = Device::new().unwrap().version();
        assert_eq!(version.major(), 4);
        assert!(version >= Version::from_number(sys::RTC_VERSION));
        assert!(version.to_string().starts_with("4."));
    }

    #[test]
    fn a_library_must_be_of_the_same_major_and_no_older() {
        let fit = |headers, library| check_fit(Version::from_number(headers), Version::from_number(library));
        assert_eq!(fit(40_303, 40_303), Ok(()));
        assert_eq!(fit(40_303, 40_400), Ok(()));
        assert!(fit(40_303, 50_000).is_err());
        assert!(fit(40_303, 31_300).is_err());
        assert_eq!(
            fit(40_303, 40_302).unwrap_err().to_string(),
            "the Embree library 4.3.2 does not fit the headers 4.3.3 of this build: install an Embree 4 library \
             that is 4.3.3 or newer, or build again against the headers of 4.3.2"
        );
    }

    #[test]
    fn memory_is_counted_until_the_last_scene_is_gone() {
        let device = Device::new().unwrap();
        let scene = |n: u32| {
            let mut builder = SceneBuilder::new(&device).unwrap();
            let vertices: Vec<Vec3> = (0..3 * n).map(|k| Vec3::new(k as f32, (k % 3) as f32, 1.0)).collect();
            let triangles: Vec<[u32; 3]> = (0..n).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
            builder.add_triangles(&vertices, &triangles).unwrap();
            builder.commit().unwrap()
        };
        let few = scene(1000);
        let bytes_of_few = device.memory_bytes();
        let many = scene(50_000);
        let bytes_of_many = device.memory_bytes() - bytes_of_few;
        let input = |n: usize| n * (3 * size_of::<Vec3>() + size_of::<[u32; 3]>());
        assert!(bytes_of_few > input(1000) && bytes_of_many > input(50_000));
        assert!(bytes_of_many < 10 * input(50_000), "{bytes_of_many} bytes");
        drop((few, many));
        assert_eq!(device.memory_bytes(), 0);
    }

    #[test]
    fn devices_cross_threads() {
        fn crosses<T: Send + Sync>() {}
        crosses::<Device>();
    }
}
