//! Independent ground truth inside the project: what photon mapping is checked against, by two estimators that share
//! no path with each other.

mod light_tracer;
mod path_tracer;
mod pixel_estimates;

pub use light_tracer::share_seen_specular;

use crate::film::Image;
use crate::scene::Scene;

use pixel_estimates::PixelEstimates;

/// From which end paths start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// A unidirectional path tracer with next-event estimation, of unlimited depth.
    ///
    /// It cannot find point lights through glass, water or masks, since no sampled path hits a point: there its picture is
    /// the light that does not pass such surfaces on its way to the last diffuse one.
    ///
    /// # Source
    /// Kajiya, "The Rendering Equation", SIGGRAPH 1986; Veach 1997, chapter 10, for next-event estimation.
    Path,
    /// A light tracer (particle tracer): paths start at the lights, and each of their diffuse bounces is connected to
    /// the pinhole.
    ///
    /// It finds all light on diffuse surfaces that the camera sees directly, caustics from point lights included, and
    /// the lamps that it sees directly. What is seen in mirrors and through glass or water is missing, since no sampled
    /// path hits the pinhole: [`share_seen_specular`] tells how much of the picture that is.
    ///
    /// A surface that faces the pinhole at an angle of `cos θ` and is met by the power `Φ` of one of `N` paths adds
    /// `Φ / N · albedo / π · cos θ / (A cos³ θ_c d²)` to its pixel, whose area on the image plane at distance 1 is
    /// `A`; see [`crate::camera::Camera::project`]. `N` is the number of pixels. One path may add to several pixels of
    /// a sample, so the errors of pixels are only nearly independent.
    ///
    /// # Source
    /// Veach, "Robust Monte Carlo Methods for Light Transport Simulation", 1997, chapter 4 (particle tracing)
    /// and section 5.3 (shading normals); Dutré, Lafortune and Willems, "Monte Carlo Light Tracing with Direct Computation of Pixel
    /// Intensities", Compugraphics 1993.
    Light,
}

/// An unbiased picture that grows by one sample of every pixel at a time.
pub struct Estimator<'s> {
    scene: &'s Scene,
    method: Method,
    seed: u64,
    pixels: PixelEstimates,
}

impl<'s> Estimator<'s> {
    /// A picture without samples.
    pub fn new(scene: &'s Scene, method: Method, seed: u64) -> Estimator<'s> {
        Estimator { scene, method, seed, pixels: PixelEstimates::new(scene.film()) }
    }

    /// Adds one sample to every pixel: one path from it or, on average, one from the lights.
    pub fn add_sample(&mut self) {
        let (scene, seed, sample) = (self.scene, self.seed, self.pixels.samples());
        match self.method {
            Method::Path => {
                self.pixels.add(|pixel| path_tracer::pixel_radiance(scene, seed, sample, pixel).as_dvec3());
            }
            Method::Light => {
                let splatted = light_tracer::splat(scene, seed, sample);
                let seen = |pixel| light_tracer::seen_emission(scene, seed, sample, pixel).as_dvec3();
                self.pixels.add(|pixel| splatted[pixel] + seen(pixel));
            }
        }
    }

    /// Samples a pixel so far.
    pub fn samples(&self) -> u32 {
        self.pixels.samples()
    }

    /// The mean of the samples (radiance).
    pub fn picture(&self) -> Image {
        self.pixels.mean()
    }

    /// The standard error of [`Estimator::picture`], estimated from the samples: `√(Σ (L - mean)² / (n (n - 1)))`.
    ///
    /// Infinite below two samples, where nothing is known of it.
    pub fn standard_error(&self) -> Image {
        self.pixels.standard_error()
    }
}
