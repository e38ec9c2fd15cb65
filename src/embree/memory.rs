use std::ffi::c_void;
use std::sync::Arc;
use std::sync::atomic::{AtomicIsize, Ordering};

use super::sys;

/// The bytes that Embree holds for a device; shared by all who keep the device alive.
#[derive(Clone, Debug, Default)]
pub(super) struct MemoryCount(Arc<AtomicIsize>);

impl MemoryCount {
    /// Lets Embree count from now on.
    ///
    /// # Safety
    /// `device` must be alive, and some clone of this count must outlive it.
    pub unsafe fn follow(&self, device: sys::RTCDevice) {
        let user = Arc::as_ptr(&self.0).cast_mut().cast::<c_void>();
        // SAFETY: the caller vouches for the device, and for the count, which is atomic, as long as it lives.
        unsafe { sys::rtcSetDeviceMemoryMonitorFunction(device, Some(add_bytes), user) };
    }

    pub fn bytes(&self) -> usize {
        usize::try_from(self.0.load(Ordering::Relaxed)).unwrap_or(0)
    }
}

/// Embree's callback for memory taken (positive) and given back (negative).
///
/// # Safety
/// The user pointer must be that of an `AtomicIsize`.
unsafe extern "C" fn add_bytes(user: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the caller vouches for it.
    unsafe { &*user.cast::<AtomicIsize>() }.fetch_add(bytes, Ordering::Relaxed);
    true
}
