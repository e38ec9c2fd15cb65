use std::f32::consts::PI;

use crate::math::{Frame, Vec2, Vec3, warp};

/// How the facets of a rough surface lie: the isotropic distribution of Trowbridge and Reitz ("GGX").
///
/// ```text
/// D(m)    = α² / (π (sin² θ_m + α² cos² θ_m)²)          with sin² = m_x² + m_y², which cancels nothing
/// G1(w)   = 2 / (1 + √(1 + α² tan² θ_w))
/// D_wo(m) = G1(wo) (wo·m) D(m) / cos θ_wo               density of the normals that are seen from wo
/// ```
/// All directions are unit and local, on the upper side.
///
/// # Source
/// Walter, Marschner, Li and Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007; Heitz, "Understanding
/// the Masking-Shadowing Function in Microfacet-Based BRDFs", JCGT 3(2), 2014.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// `α`: the roughness, above 0 and up to 1.
    pub alpha: f32,
}

impl Ggx {
    /// Smoother surfaces are better taken for smooth: f32 hardly tells their facets apart.
    pub const LEAST_ALPHA: f32 = 0.001;

    /// `D(m)` (1/sr).
    pub fn density(self, m: Vec3) -> f32 {
        let alpha2 = self.alpha * self.alpha;
        let spread = m.x * m.x + m.y * m.y + alpha2 * m.z * m.z;
        alpha2 / (PI * spread * spread)
    }

    /// `G1(w)`: the share of the facets facing `w` that are seen from there.
    pub fn masking(self, w: Vec3) -> f32 {
        let sin2 = w.x * w.x + w.y * w.y;
        let tan2 = sin2 / (w.z * w.z);
        2.0 / (1.0 + (1.0 + self.alpha * self.alpha * tan2).sqrt())
    }

    /// `D_wo(m)` (1/sr): the density of [`Ggx::sample`].
    pub fn visible_density(self, wo: Vec3, m: Vec3) -> f32 {
        self.masking(wo) * wo.dot(m).max(0.0) * self.density(m) / wo.z
    }

    /// A facet's normal, by `u` in the unit square, as often as such facets are seen from `wo`.
    ///
    /// # Source
    /// Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018.
    pub fn sample(self, wo: Vec3, u: Vec2) -> Vec3 {
        let stretched = Vec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z).normalize();
        let disc = warp::square_to_disk(u);
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - disc.x * disc.x).max(0.0).sqrt() + share * disc.y;
        let z = (1.0 - disc.x * disc.x - y * y).max(0.0).sqrt();
        let hemisphere = around(stretched).to_world(Vec3::new(disc.x, y, z));
        Vec3::new(self.alpha * hemisphere.x, self.alpha * hemisphere.y, hemisphere.z.max(0.0))
            .normalize_or(Vec3::Z)
    }
}

/// With a horizontal tangent, by which the halves of the disc are those of the hemisphere.
fn around(normal: Vec3) -> Frame {
    let tangent = Vec3::new(-normal.y, normal.x, 0.0).normalize_or(Vec3::X);
    Frame { tangent, bitangent: normal.cross(tangent), normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    fn direction(cos: f32) -> Vec3 {
        let sin = (1.0 - cos * cos).sqrt();
        Vec3::new(0.6 * sin, 0.8 * sin, cos)
    }

    /// Cells of equal solid angle: bands of equal height times sectors.
    const BANDS: usize = 24;
    const SECTORS: usize = 16;

    /// The integral of `of` over the upper hemisphere by the midpoints of fine cells, those near the pole finer.
    fn integral(of: impl Fn(Vec3) -> f64) -> f64 {
        const FINE: usize = 1500;
        const AROUND: usize = 96;
        let cell = |k: usize| {
            let (i, j) = (k / AROUND, k % AROUND);
            let theta = (i as f64 + 0.5) / FINE as f64 * std::f64::consts::FRAC_PI_2;
            let phi = (j as f64 + 0.5) / AROUND as f64 * std::f64::consts::TAU;
            let m = Vec3::new(
                (theta.sin() * phi.cos()) as f32,
                (theta.sin() * phi.sin()) as f32,
                theta.cos() as f32,
            );
            theta.sin() * of(m)
        };
        let area = std::f64::consts::FRAC_PI_2 / FINE as f64 * std::f64::consts::TAU / AROUND as f64;
        area * (0..FINE * AROUND).map(cell).sum::<f64>()
    }

    /// The facets cover the surface, and those that are seen cover it as seen: `∫ D cos = 1`, `∫ D_wo = 1`. Catches a wrong
    /// power of `α`, or a masking that does not belong to the distribution.
    #[test]
    fn facets_cover_the_surface_from_everywhere() {
        for alpha in [0.05, 0.3, 1.0] {
            let ggx = Ggx { alpha };
            let all = integral(|m| f64::from(ggx.density(m) * m.z));
            assert!((all - 1.0).abs() < 2e-3, "{alpha}: {all}");
            for cos in [0.1, 0.5, 1.0] {
                let seen = integral(|m| f64::from(ggx.visible_density(direction(cos), m)));
                assert!((seen - 1.0).abs() < 5e-3, "{alpha} {cos}: {seen}");
            }
        }
    }

    /// Chi-square of samples in cells against the integral of the density over each. Catches a frame that turns, a stretch
    /// that is not undone, or a density of something else.
    #[test]
    fn samples_follow_their_density() {
        const N: usize = 100_000;
        for (alpha, cos) in [(0.3, 0.3), (0.7, 0.9), (1.0, 0.1)] {
            let (ggx, wo) = (Ggx { alpha }, direction(cos));
            let mut rng = Rng::new(5, Stream::Test, 0, 0);
            let mut counts = vec![0f64; BANDS * SECTORS];
            for _ in 0..N {
                let m = ggx.sample(wo, rng.next_vec2());
                counts[cell(m)] += 1.0;
            }
            let expected: Vec<f64> = (0..counts.len()).map(|k| N as f64 * share(ggx, wo, k)).collect();
            let (mut chi2, mut cells) = (0.0, 0);
            for (count, expected) in counts.iter().zip(&expected).filter(|(_, expected)| **expected >= 10.0) {
                chi2 += (count - expected).powi(2) / expected;
                cells += 1;
            }
            let bound = f64::from(cells) + 5.0 * (2.0 * f64::from(cells)).sqrt();
            assert!(chi2 < bound && cells > 40, "{alpha} {cos}: chi² {chi2:.0} of {cells} cells");
        }
    }

    fn cell(m: Vec3) -> usize {
        let band = ((f64::from(m.z) * BANDS as f64) as usize).min(BANDS - 1);
        let turn = f64::from(m.y.atan2(m.x)) / std::f64::consts::TAU;
        let sector = ((turn.rem_euclid(1.0) * SECTORS as f64) as usize).min(SECTORS - 1);
        band * SECTORS + sector
    }

    /// The density over a cell, by a grid in it.
    fn share(ggx: Ggx, wo: Vec3, cell: usize) -> f64 {
        const FINE: usize = 24;
        let (band, sector) = (cell / SECTORS, cell % SECTORS);
        let at = |i: usize, j: usize| {
            let z = (band as f64 + (i as f64 + 0.5) / FINE as f64) / BANDS as f64;
            let phi =
                (sector as f64 + (j as f64 + 0.5) / FINE as f64) / SECTORS as f64 * std::f64::consts::TAU;
            let sin = (1.0 - z * z).sqrt();
            let m = Vec3::new((sin * phi.cos()) as f32, (sin * phi.sin()) as f32, z as f32);
            f64::from(ggx.visible_density(wo, m))
        };
        let sum: f64 = (0..FINE * FINE).map(|k| at(k / FINE, k % FINE)).sum();
        sum / (FINE * FINE) as f64 * std::f64::consts::TAU / (BANDS * SECTORS) as f64
    }
}
