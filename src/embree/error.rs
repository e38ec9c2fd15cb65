use std::cell::Cell;
use std::ffi::{CStr, c_char, c_void};

use super::{Version, sys};
use crate::math::Vec3;

/// Embree drops primitives that reach beyond this: squares of larger coordinates overflow.
pub(super) const MAX_COORDINATE: f32 = 1.8e18;

/// Why Embree cannot be used as asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EmbreeError {
    /// The library that was loaded does not fit the headers that the program was built with.
    #[error(
        "the Embree library {library} does not fit the headers {headers} of this build: install an Embree {major} \
         library that is {headers} or newer, or build again against the headers of {library}",
        major = headers.major()
    )]
    Mismatch {
        /// The version of the headers.
        headers: Version,
        /// The version of the loaded library.
        library: Version,
    },
    /// Embree refused a call.
    #[error("Embree cannot {action}: {reason}")]
    Refused {
        /// What was asked of it.
        action: &'static str,
        /// Its answer.
        reason: String,
    },
    /// A geometry without primitives.
    #[error("a geometry needs at least one of its {primitives}, but there are none")]
    Empty {
        /// What it would consist of.
        primitives: &'static str,
    },
    /// More items than Embree can number.
    #[error("a geometry of {count} {items} is too large: at most {} can be numbered", u32::MAX)]
    TooMany {
        /// What there is too much of.
        items: &'static str,
        /// How many there are.
        count: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, but the vertices end at {}", vertices.saturating_sub(1))]
    Index {
        /// The number of the triangle.
        triangle: usize,
        /// The vertex that it names.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex that Embree would silently drop, with all triangles around it.
    #[error("vertex {vertex} is at {position}: its coordinates must be finite and within ±{limit:e}", limit = MAX_COORDINATE)]
    Vertex {
        /// The number of the vertex.
        vertex: usize,
        /// Where it is.
        position: Vec3,
    },
    /// A sphere whose bounds Embree cannot represent.
    #[error("sphere {sphere} has its center at {center} and radius {radius}: the radius must be positive, and the sphere finite and within ±{limit:e}", limit = MAX_COORDINATE)]
    Sphere {
        /// The number of the sphere.
        sphere: usize,
        /// Its center.
        center: Vec3,
        /// Its radius.
        radius: f32,
    },
}

thread_local! {
    /// What Embree last complained about on this thread. Calls report on the thread that made them.
    static COMPLAINT: Cell<Option<String>> = const { Cell::new(None) };
}

/// Embree's error callback.
///
/// # Safety
/// `message` must be null or a string that ends with a zero byte.
pub(super) unsafe extern "C" fn record_error(
    _user: *mut c_void,
    code: sys::RTCError,
    message: *const c_char,
) {
    let text = if message.is_null() {
        String::new()
    } else {
        // SAFETY: not null, and the caller vouches for the zero byte at its end.
        unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned()
    };
    COMPLAINT.set(Some(describe(code, &text)));
}

/// Turns a complaint that Embree made on this thread since the last check into an error.
pub(super) fn check(action: &'static str) -> Result<(), EmbreeError> {
    match COMPLAINT.take() {
        Some(reason) => Err(EmbreeError::Refused { action, reason }),
        None => Ok(()),
    }
}

/// An error code and its message in words.
pub(super) fn describe(code: sys::RTCError, message: &str) -> String {
    let kind = match code {
        sys::RTC_ERROR_INVALID_ARGUMENT => "invalid argument",
        sys::RTC_ERROR_INVALID_OPERATION => "invalid operation",
        sys::RTC_ERROR_OUT_OF_MEMORY => "out of memory",
        sys::RTC_ERROR_UNSUPPORTED_CPU => "this processor is not supported (SSE2 is required)",
        sys::RTC_ERROR_CANCELLED => "cancelled",
        _ => "unknown error",
    };
    if message.is_empty() { kind.to_owned() } else { format!("{kind}: {message}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complaint_is_reported_once_with_its_words() {
        let complain = |message: *const c_char| {
            // SAFETY: null or a literal that ends with a zero byte.
            unsafe { record_error(std::ptr::null_mut(), sys::RTC_ERROR_INVALID_ARGUMENT, message) }
        };
        complain(c"no such thing".as_ptr());
        let error = check("do it").unwrap_err();
        assert_eq!(error.to_string(), "Embree cannot do it: invalid argument: no such thing");
        assert_eq!(check("do it"), Ok(()));
        complain(std::ptr::null());
        assert_eq!(check("do it").unwrap_err().to_string(), "Embree cannot do it: invalid argument");
    }

    #[test]
    fn a_complaint_stays_on_its_thread() {
        // SAFETY: a null message is allowed.
        unsafe { record_error(std::ptr::null_mut(), sys::RTC_ERROR_UNKNOWN, std::ptr::null()) };
        std::thread::spawn(|| assert_eq!(check("do it"), Ok(()))).join().unwrap();
        assert!(check("do it").is_err());
    }
}
