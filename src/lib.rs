//! Progressive photon mapping on Embree 4.

pub mod bsdf;
pub mod camera;
pub mod light;
pub mod math;
