//! Progressive photon mapping on Embree 4.

pub mod bsdf;
pub mod embree;
pub mod math;
