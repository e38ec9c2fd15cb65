use std::ptr::NonNull;

use super::device::Device;
use super::error::{EmbreeError, check};
use super::geometry::null;
use super::{SceneOptions, sys};
use crate::math::{Aabb, Vec3};

/// A reference to an Embree scene, which keeps its device and geometries alive.
#[derive(Debug)]
pub(super) struct SceneHandle {
    scene: NonNull<sys::RTCSceneTy>,
    /// Released after the scene, whose memory it counts.
    device: Device,
}

impl SceneHandle {
    pub(super) fn new(device: &Device, options: SceneOptions) -> Result<SceneHandle, EmbreeError> {
        const ACTION: &str = "make a scene";
        // SAFETY: the device is alive.
        let raw = unsafe { sys::rtcNewScene(device.as_raw()) };
        check(ACTION)?;
        let scene = NonNull::new(raw).ok_or_else(|| null(ACTION))?;
        let scene = SceneHandle { scene, device: device.share() };
        // SAFETY: the scene is alive, and this handle is its only one.
        unsafe { sys::rtcSetSceneFlags(raw, options.raw_flags()) };
        // SAFETY: as above.
        unsafe { sys::rtcSetSceneBuildQuality(raw, options.raw_quality()) };
        check("set the quality of a scene")?;
        Ok(scene)
    }

    pub(super) fn as_raw(&self) -> sys::RTCScene {
        self.scene.as_ptr()
    }

    pub(super) fn device(&self) -> &Device {
        &self.device
    }

    /// The box around a committed scene; the empty box around nothing.
    pub(super) fn bounds(&self) -> Aabb {
        let (nowhere, pad) = (f32::NAN, 0.0);
        let mut b = sys::RTCBounds {
            lower_x: nowhere,
            lower_y: nowhere,
            lower_z: nowhere,
            align0: pad,
            upper_x: nowhere,
            upper_y: nowhere,
            upper_z: nowhere,
            align1: pad,
        };
        // SAFETY: the scene is alive and committed; the bounds are aligned and ours to write.
        unsafe { sys::rtcGetSceneBounds(self.as_raw(), &raw mut b) };
        let (min, max) =
            (Vec3::new(b.lower_x, b.lower_y, b.lower_z), Vec3::new(b.upper_x, b.upper_y, b.upper_z));
        if min.cmple(max).all() { Aabb { min, max } } else { Aabb::EMPTY }
    }
}

impl Drop for SceneHandle {
    fn drop(&mut self) {
        // SAFETY: this handle's reference, released once.
        unsafe { sys::rtcReleaseScene(self.as_raw()) };
    }
}
