use std::ptr::{self, NonNull};

use super::device::Device;
use super::error::{EmbreeError, check};
use super::{SceneOptions, sys};
use crate::math::Vec3;

/// A value without padding, of which one buffer slot of Embree holds many.
pub(super) trait BufferItem: Copy {
    const KIND: sys::RTCBufferType;
    const FORMAT: sys::RTCFormat;
}

impl BufferItem for Vec3 {
    const KIND: sys::RTCBufferType = sys::RTC_BUFFER_TYPE_VERTEX;
    const FORMAT: sys::RTCFormat = sys::RTC_FORMAT_FLOAT3;
}

impl BufferItem for [u32; 3] {
    const KIND: sys::RTCBufferType = sys::RTC_BUFFER_TYPE_INDEX;
    const FORMAT: sys::RTCFormat = sys::RTC_FORMAT_UINT3;
}

impl BufferItem for [f32; 4] {
    const KIND: sys::RTCBufferType = sys::RTC_BUFFER_TYPE_VERTEX;
    const FORMAT: sys::RTCFormat = sys::RTC_FORMAT_FLOAT4;
}

const _: () = assert!(size_of::<Vec3>() == 12);

/// A geometry that is being filled; scenes keep theirs alive by themselves.
pub(super) struct Geometry {
    handle: NonNull<sys::RTCGeometryTy>,
    /// Released after the geometry, whose memory it counts.
    _device: Device,
}

impl Geometry {
    pub(super) fn new(device: &Device, kind: sys::RTCGeometryType) -> Result<Geometry, EmbreeError> {
        const ACTION: &str = "make a geometry";
        // SAFETY: the device is alive.
        let raw = unsafe { sys::rtcNewGeometry(device.as_raw(), kind) };
        check(ACTION)?;
        let handle = NonNull::new(raw).ok_or_else(|| null(ACTION))?;
        Ok(Geometry { handle, _device: device.share() })
    }

    /// Copies `items` into a buffer that Embree owns, and pads as its 16-byte loads need.
    pub(super) fn fill<T: BufferItem>(&mut self, items: &[T]) -> Result<(), EmbreeError> {
        const ACTION: &str = "allocate a geometry buffer";
        // SAFETY: the geometry is alive, and this handle is its only one.
        let buffer = unsafe {
            sys::rtcSetNewGeometryBuffer(self.as_raw(), T::KIND, 0, T::FORMAT, size_of::<T>(), items.len())
        };
        check(ACTION)?;
        let buffer = NonNull::new(buffer.cast::<u8>()).ok_or_else(|| null(ACTION))?;
        // SAFETY: Embree has just allocated at least `items.len() * size_of::<T>()` bytes that nobody else refers to;
        // items have no padding, and bytes need no alignment.
        unsafe { ptr::copy_nonoverlapping(items.as_ptr().cast(), buffer.as_ptr(), size_of_val(items)) };
        Ok(())
    }

    /// Counts only in scenes of low quality, which have a tree for each geometry.
    pub(super) fn set_quality(&mut self, options: SceneOptions) -> Result<(), EmbreeError> {
        // SAFETY: the geometry is alive, and this handle is its only one.
        unsafe { sys::rtcSetGeometryBuildQuality(self.as_raw(), options.raw_quality()) };
        check("set the quality of a geometry")
    }

    pub(super) fn commit(&mut self) -> Result<(), EmbreeError> {
        // SAFETY: the geometry is alive, and this handle is its only one.
        unsafe { sys::rtcCommitGeometry(self.as_raw()) };
        check("commit a geometry")
    }

    pub(super) fn as_raw(&self) -> sys::RTCGeometry {
        self.handle.as_ptr()
    }
}

impl Drop for Geometry {
    fn drop(&mut self) {
        // SAFETY: this handle's reference, released once.
        unsafe { sys::rtcReleaseGeometry(self.as_raw()) };
    }
}

/// The error of a call that gave nothing and did not say why.
pub(super) fn null(action: &'static str) -> EmbreeError {
    EmbreeError::Refused { action, reason: "it gave no reason".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn embree_complaints_become_errors() {
        let device = Device::new().unwrap();
        let error = Geometry::new(&device, 77_777).err().unwrap();
        assert!(error.to_string().ends_with("invalid geometry type"), "{error}");
        let mut spheres = Geometry::new(&device, sys::RTC_GEOMETRY_TYPE_SPHERE_POINT).unwrap();
        let error = spheres.fill(&[[0u32, 1, 2]]).unwrap_err();
        assert!(error.to_string().contains("invalid "), "{error}");
    }
}
