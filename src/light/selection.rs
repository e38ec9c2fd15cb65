use std::f64::consts::PI;
use std::sync::Arc;

use super::choice::choice;
use super::emitter::Emitter;
use super::{EmissionSample, Environment, IlluminationSample, Light, sphere_area, versine_of_sphere};
use crate::math::{Rgb, Rng, Vec3, mean};

/// The lights of a scene that emit anything, and the choice among them in proportion to their flux.
///
/// Lights of zero power are left out: they contribute nothing, and 0/0 cannot arise.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    delta: Vec<Light>,
    area: Vec<Light>,
    /// Of all lights, in the order of `photons`.
    emitters: Vec<Emitter>,
    photons: Distribution,
    shadows: Distribution,
    /// The mean flux of all area lights (W).
    area_flux: f64,
    /// The one among the area lights, and the probability by which shadow rays choose it.
    environment: Option<(Arc<Environment>, f32)>,
}

impl Lights {
    /// Takes over the lights with power, of which one at most is an environment.
    pub fn new(lights: impl IntoIterator<Item = Light>) -> Lights {
        let (delta, area): (Vec<_>, Vec<_>) =
            lights.into_iter().filter(|l| mean(l.flux()) > 0.0).partition(Light::is_delta);
        let photons = Distribution::by_flux(delta.iter().chain(&area));
        let shadows = Distribution::by_flux(&area);
        let emitters = delta.iter().chain(&area).cloned().map(Emitter::new).collect();
        let area_flux = area.iter().map(|light| f64::from(mean(light.flux()))).sum();
        let around = |(light, p): (&Light, f64)| match light {
            Light::Environment(environment) => Some((Arc::clone(environment), p as f32)),
            _ => None,
        };
        let environment = area.iter().zip(shadows.probabilities()).find_map(around);
        Lights { delta, area, emitters, photons, shadows, area_flux, environment }
    }

    /// Those whose numbers, in the order of [`Lights::iter`], are to be kept.
    pub fn filtered(&self, keep: impl Fn(u32) -> bool) -> Lights {
        Lights::new(self.iter().zip(0..).filter(|(_, number)| keep(*number)).map(|(light, _)| light.clone()))
    }

    /// Whether nothing emits.
    pub fn is_empty(&self) -> bool {
        self.delta.is_empty() && self.area.is_empty()
    }

    /// Whether some illumination has to be sampled, so that one shadow ray does not tell it exactly.
    pub fn any_area(&self) -> bool {
        !self.area.is_empty()
    }

    /// Whether the light of this number, in the order of [`Lights::iter`], has no extent.
    pub fn is_delta(&self, number: usize) -> bool {
        number < self.delta.len()
    }

    /// How many lights there are.
    pub fn len(&self) -> usize {
        self.delta.len() + self.area.len()
    }

    /// All lights.
    pub fn iter(&self) -> impl Iterator<Item = &Light> {
        self.delta.iter().chain(&self.area)
    }

    /// What shines from all around, where anything does.
    pub fn environment(&self) -> Option<&Environment> {
        self.environment.as_ref().map(|(environment, _)| &**environment)
    }

    /// The density by which [`Lights::illuminate_area`] chooses a direction to the environment (1/sr).
    pub fn environment_pdf_w(&self, dir: Vec3) -> f32 {
        self.environment.as_ref().map_or(0.0, |(environment, p)| p * environment.pdf_w(dir))
    }

    /// The flux of all lights together (W).
    pub fn flux(&self) -> Rgb {
        self.iter().map(Light::flux).sum()
    }

    /// A photon from a light chosen with probability `p` in proportion to its flux; its power is over `p`.
    ///
    /// `None` if nothing emits.
    pub fn sample_emission(&self, rng: &mut Rng) -> Option<EmissionSample> {
        self.sample_numbered_emission(rng).map(|(_, sample)| sample)
    }

    /// The same, and the number of the photon's light in the order of [`Lights::iter`].
    pub fn sample_numbered_emission(&self, rng: &mut Rng) -> Option<(usize, EmissionSample)> {
        let (number, p) = self.photons.choose(draw_choice(rng))?;
        let sample = self.emitters.get(number)?.sample(rng);
        Some((number, EmissionSample { power: sample.power / p, ..sample }))
    }

    /// The running sums, up to 1, of the probabilities by which photons choose each light.
    pub fn choice_bounds(&self) -> &[f64] {
        &self.photons.cumulative
    }

    /// The number of the light, in the order of [`Lights::iter`], that photons choose by `u` in `[0, 1)`.
    pub fn chosen(&self, u: f64) -> Option<usize> {
        self.photons.choose(u).map(|(number, _)| number)
    }

    /// Every light with the probability by which photons choose it.
    pub(super) fn emitters(&self) -> impl Iterator<Item = (&Emitter, f64)> {
        self.emitters.iter().zip(self.photons.probabilities())
    }

    /// The light of a photon and its probability, for `u` in `[0, 1)`.
    pub(super) fn choose_emitter(&self, u: f64) -> Option<(&Emitter, f32)> {
        let (index, p) = self.photons.choose(u)?;
        Some((self.emitters.get(index)?, p))
    }

    /// The exact illumination of `p` by every point light.
    pub fn illuminate_delta(&self, p: Vec3) -> impl Iterator<Item = IlluminationSample> {
        self.delta.iter().filter_map(move |light| light.illuminate(p, Default::default()))
    }

    /// A sample of the illumination of `p` by the area lights: one of them, chosen like a photon's.
    pub fn illuminate_area(&self, p: Vec3, rng: &mut Rng) -> Option<IlluminationSample> {
        let (index, probability) = self.shadows.choose(draw_choice(rng))?;
        let sample = self.area.get(index)?.illuminate(p, rng.next_vec2())?;
        let (irradiance, pdf_w) = (sample.irradiance / probability, probability * sample.pdf_w);
        Some(IlluminationSample { irradiance, pdf_w, ..sample })
    }

    /// The density by which [`Lights::illuminate_area`] chooses a direction to a sphere of this radius whose centre is so far
    /// (1/sr): `π 4π R² L / Φ` over the solid angle; 0 inside.
    pub fn sphere_pdf_w(&self, radiance: Rgb, radius: f32, distance2: f32) -> f32 {
        let share = PI * f64::from(sphere_area(radius)) * f64::from(mean(radiance)) / self.area_flux;
        versine_of_sphere(radius, distance2)
            .map_or(0.0, |versine| (share / (2.0 * PI * f64::from(versine))) as f32)
    }

    /// The density by which [`Lights::illuminate_area`] chooses the direction to a point of a triangle that shines (1/sr): lights are
    /// chosen by flux, so it is `π L / Φ · d² / cos θ` for the mean radiance `L` and the flux `Φ` of all of them.
    ///
    /// `cos` is that of the angle at the light, `distance2` the squared distance.
    pub fn area_pdf_w(&self, radiance: Rgb, cos: f32, distance2: f32) -> f32 {
        let share = f64::from(mean(radiance)) * PI / self.area_flux;
        (share * f64::from(distance2) / f64::from(cos)) as f32
    }
}

/// How many numbers after that which chooses a light comes the one that refines it, behind those of an emission.
const REFINING_NUMBER: usize = 5;

/// [`choice`] by the next number and one that is only looked ahead at: whoever draws it later shares it with a choice of a
/// light that hung on it, which one in millions does.
fn draw_choice(rng: &mut Rng) -> f64 {
    let coarse = rng.next_f32();
    let mut ahead = rng.clone();
    let fine = (0..REFINING_NUMBER).fold(0.0, |_, _| ahead.next_f32());
    choice(coarse, fine)
}

/// A discrete distribution in proportion to flux: running sums in f64, normalised.
#[derive(Clone, Debug, Default)]
struct Distribution {
    cumulative: Vec<f64>,
}

impl Distribution {
    fn by_flux<'a>(lights: impl IntoIterator<Item = &'a Light>) -> Distribution {
        let mut sum = 0.0;
        let add = |light: &Light| {
            sum += f64::from(mean(light.flux()));
            sum
        };
        let mut cumulative: Vec<f64> = lights.into_iter().map(add).collect();
        cumulative.iter_mut().for_each(|c| *c /= sum);
        Distribution { cumulative }
    }

    fn probabilities(&self) -> impl Iterator<Item = f64> {
        let below = [0.0].into_iter().chain(self.cumulative.iter().copied());
        self.cumulative.iter().zip(below).map(|(&c, below)| c - below)
    }

    /// The chosen index and its probability, for `u` in `[0, 1)`; `None` of an empty distribution.
    fn choose(&self, u: f64) -> Option<(usize, f32)> {
        let index = self.cumulative.partition_point(|&c| c <= u);
        let below = index.checked_sub(1).map_or(0.0, |i| self.cumulative[i]);
        self.cumulative.get(index).map(|&c| (index, (c - below) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, UNIT};

    fn point(watts: f32) -> Light {
        Light::Point { position: Vec3::ZERO, intensity: Rgb::splat(watts) }
    }

    #[test]
    fn dark_lights_are_left_out() {
        let lights = Lights::new([point(0.0), point(2.0), point(0.0)]);
        assert_eq!(lights.len(), 1);
        assert!(Lights::new([point(0.0)]).is_empty());
        assert!(Lights::new([]).sample_emission(&mut Rng::new(0, Stream::Test, 0, 0)).is_none());
    }

    /// Every photon carries the whole flux of the scene, however unequal the lights are.
    #[test]
    fn power_is_divided_by_the_probability_of_the_light() {
        let lights = Lights::new([point(1.0), point(1e12), point(3.0)]);
        let total = mean(lights.flux());
        let mut rng = Rng::new(2, Stream::Test, 0, 0);
        for _ in 0..1000 {
            let photon = lights.sample_emission(&mut rng).unwrap();
            assert!((mean(photon.power) / total - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn lights_are_chosen_in_proportion_to_their_flux() {
        let distribution = Distribution::by_flux([&point(1.0), &point(3.0)]);
        for (u, index, probability) in
            [(0.0, 0, 0.25), (0.2499, 0, 0.25), (0.2501, 1, 0.75), (1.0 - 1e-9, 1, 0.75)]
        {
            let (chosen, p) = distribution.choose(u).unwrap();
            assert!(chosen == index && (p - probability).abs() < 1e-6);
        }
    }

    /// 24 bits would choose the light in 10⁻¹² first once in 2²⁴ times, and last never.
    #[test]
    fn faint_lights_are_chosen_as_rarely_as_they_should() {
        let faint_first = Distribution::by_flux([&point(1.0), &point(1e12)]);
        let faint_last = Distribution::by_flux([&point(1e12), &point(1.0)]);
        let chosen = |lights: &Distribution, coarse, fine| lights.choose(choice(coarse, fine)).unwrap().0;
        let last = 1.0 - UNIT;
        assert_eq!([chosen(&faint_first, 0.0, 1e-5), chosen(&faint_first, 0.0, 3e-5)], [0, 1]);
        assert_eq!([chosen(&faint_last, last, 1.0 - 3e-5), chosen(&faint_last, last, 1.0 - 1e-5)], [0, 1]);
    }

    /// What a shadow ray is drawn by is what facets are told that meet the same place: two area lights of unequal flux, and the sky.
    #[test]
    fn densities_are_those_of_the_samples() {
        let (center, radius, radiance) = (Vec3::new(1.0, 3.0, 0.5), 0.75, Rgb::new(1.0, 2.0, 6.0));
        let corners = [Vec3::new(-2.0, 2.0, 0.0), Vec3::new(-1.0, 2.0, 0.0), Vec3::new(-2.0, 2.0, 1.0)];
        let triangle = Light::Triangle { corners, radiance: 2.0 * radiance };
        let lights = Lights::new([Light::Sphere { center, radius, radiance }, triangle, point(5.0)]);
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        let mut found = [0; 2];
        for _ in 0..200 {
            let Some(sample) = lights.illuminate_area(Vec3::ZERO, &mut rng) else { continue };
            let on_sphere = sample.target.distance(center) < 1.01 * radius;
            let expected = if on_sphere {
                lights.sphere_pdf_w(radiance, radius, center.length_squared())
            } else {
                lights.area_pdf_w(2.0 * radiance, sample.wi.y, sample.target.length_squared())
            };
            assert!((sample.pdf_w / expected - 1.0).abs() < 1e-4, "{} instead of {expected}", sample.pdf_w);
            found[usize::from(on_sphere)] += 1;
        }
        assert!(found.iter().all(|&n| n > 5), "{found:?}");
        assert_eq!(lights.sphere_pdf_w(radiance, radius, 0.5 * radius * radius), 0.0);
        assert_eq!(lights.environment_pdf_w(Vec3::Y), 0.0);
    }
}
