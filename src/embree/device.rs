use std::ffi::{CStr, CString};
use std::fmt;
use std::ptr::{self, NonNull};

use super::error::{EmbreeError, describe, record_error};
use super::sys;

/// A version of Embree, ordered by age; displayed as `4.4.0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    major: u32,
    minor: u32,
    patch: u32,
}

impl Version {
    /// From Embree's own notation, `10000 major + 100 minor + patch`.
    fn from_number(number: u32) -> Version {
        Version { major: number / 10_000, minor: number / 100 % 100, patch: number % 100 }
    }

    /// The first of the three numbers: interfaces change with it.
    pub fn major(self) -> u32 {
        self.major
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// A running Embree. Scenes that were made with it stay alive without it.
#[derive(Debug)]
pub struct Device {
    handle: NonNull<sys::RTCDeviceTy>,
    version: Version,
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
        let device = Device { handle, version: Version::from_number(u32::try_from(number).unwrap_or(0)) };
        check_fit(Version::from_number(sys::RTC_VERSION), device.version)?;
        Ok(device)
    }

    /// The version of the loaded library.
    pub fn version(&self) -> Version {
        self.version
    }

    /// Another owner of the same device.
    pub(super) fn share(&self) -> Device {
        // SAFETY: the handle is alive; the new owner releases this reference.
        unsafe { sys::rtcRetainDevice(self.handle.as_ptr()) };
        Device { handle: self.handle, version: self.version }
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
    if library.major == headers.major && library >= headers {
        return Ok(());
    }
    Err(EmbreeError::Mismatch { headers, library })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loaded_library_tells_its_version() {
        let version = Device::new().unwrap().version();
        assert_eq!(version.major(), 4);
        assert!(version >= Version::from_number(sys::RTC_VERSION));
        assert!(version.to_string().starts_with("4."));
    }

    #[test]
    fn versions_read_and_order_as_embree_numbers_them() {
        assert_eq!(Version::from_number(40_303).to_string(), "4.3.3");
        assert!(Version::from_number(40_400) > Version::from_number(40_399));
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
    fn devices_cross_threads() {
        fn crosses<T: Send + Sync>() {}
        crosses::<Device>();
    }
}
