//! Direct light where eye paths are retraced: the mean over passes of what each of them sees.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::pixel_lists::PixelLists;
use crate::math::{DVec3, Rgb};

/// The light that pixels see without photons, summed over passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PixelLight {
    /// Radiance of lights that are seen and of what shadow rays bring.
    sums: Vec<DVec3>,
    /// Whether any hit point was seen.
    sees: Vec<bool>,
    pub passes: u32,
    rays: u64,
}

impl PixelLight {
    pub fn new(pixels: usize) -> PixelLight {
        PixelLight { sums: vec![DVec3::ZERO; pixels], sees: vec![false; pixels], passes: 0, rays: 0 }
    }

    /// Adds what a pass sees: `emitted` by pixel, the irradiance by hit point.
    pub fn add_pass(&mut self, lists: &PixelLists, emitted: &[Rgb], (irradiance, rays): (Vec<DVec3>, u64)) {
        let pixels = self.sums.par_iter_mut().zip(&mut self.sees).zip(emitted).enumerate();
        pixels.for_each(|(pixel, ((sum, sees), emitted))| {
            let seen = lists.of(pixel);
            let reflected = seen.iter().map(|s| s.factor.as_dvec3() * irradiance[s.position as usize]);
            *sum += emitted.as_dvec3() + reflected.sum::<DVec3>();
            *sees |= !seen.is_empty();
        });
        self.passes += 1;
        self.rays += rays;
    }

    /// Empties the sums over passes.
    pub fn forget(&mut self) {
        self.sums.fill(DVec3::ZERO);
        self.sees.fill(false);
        self.passes = 0;
    }

    /// The mean over the passes.
    pub fn radiance(&self, pixel: usize) -> DVec3 {
        self.sums[pixel] / f64::from(self.passes)
    }

    /// Whether a pixel saw any hit point so far.
    pub fn sees(&self, pixel: usize) -> bool {
        self.sees[pixel]
    }

    /// Shadow rays so far.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Whether both are of as many pixels.
    pub fn is_like(&self, other: &PixelLight) -> bool {
        (self.sums.len(), self.sees.len()) == (other.sums.len(), other.sees.len())
    }

    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.sums) + size_of_val(&*self.sees)
    }
}
