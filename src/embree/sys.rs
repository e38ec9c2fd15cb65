//! The C interface of Embree 4, generated from its headers by `build.rs`.

#![allow(non_camel_case_types, non_snake_case, non_upper_case_globals, dead_code)]

include!(concat!(env!("OUT_DIR"), "/embree4.rs"));

/// What `geomID` holds when nothing was hit; the header's macro is a cast, which has no binding.
pub const RTC_INVALID_GEOMETRY_ID: u32 = u32::MAX;

// Headers before 4.3 lack `instPrimID` and give 80 bytes: the library would then write beyond the end.
const _: () = assert!(size_of::<RTCRayHit>() == 96);
const _: () = assert!(size_of::<RTCRay>() == 48);
const _: () = assert!(align_of::<RTCRayHit>() == 16 && align_of::<RTCRay>() == 16);
const _: () = assert!(size_of::<RTCRayHit8>() == 672 && align_of::<RTCRayHit8>() == 32);
const _: () = assert!(size_of::<RTCRayHit16>() == 1344 && align_of::<RTCRayHit16>() == 64);
