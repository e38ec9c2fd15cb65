//! Progressive photon mapping on Embree 4.

pub mod bsdf;
pub mod compare;
pub mod film;
pub mod math;
pub mod output;
