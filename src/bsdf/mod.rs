//! How surfaces scatter light: a closed set of materials, in the local shading frame.
//!
//! [`Bsdf::scatter`] names all lobes of a surface for light along one direction. The eye pass follows every
//! specular lobe; photons and the path tracer choose one by roulette ([`Scattering::choose`]).

mod fresnel;
mod ggx;
mod metals;
mod plastic;
mod rough;
mod scattering;

pub use fresnel::{Refraction, fresnel_reflectance, pane_reflectance, refract};
pub use ggx::Ggx;
pub use metals::{METALS, Metal};
pub use plastic::{Coat, Plastic};
pub use rough::{GlossyLobe, Interface, Response, RoughSurface};
pub use scattering::{
    Choice, DiffuseSampling, Event, SPECULAR, Scattering, SpecularLobe, Transport, sample_diffuse,
};

use crate::math::{Rgb, Vec2, Vec3};
use fresnel::{conductor_reflectance, reflect};

/// A surface's scattering function. Reflectances are dimensionless and in `[0, 1]` per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian, two-sided: `f = albedo / π`.
    Diffuse {
        /// Reflected share of the incident power.
        albedo: Rgb,
    },
    /// A perfect mirror on both sides, without Fresnel's law.
    Mirror {
        /// Reflected share of the incident power.
        reflectance: Rgb,
    },
    /// A smooth, lossless interface that obeys Fresnel's law.
    Dielectric {
        /// Index of refraction inside (behind the geometric normal) over outside.
        ior: f32,
    },
    /// A thin, flat pane of glass: what it does not mirror goes straight on.
    ThinDielectric {
        /// Index of refraction of the pane over that of what lies on both of its sides.
        ior: f32,
    },
    /// Smooth metal on both sides, by Fresnel's law for the index `eta - i k`.
    Conductor {
        /// Real part of the index, by channel.
        eta: Rgb,
        /// Imaginary part of the index, by channel.
        k: Rgb,
        /// Factor on what is reflected; 1 of pure metal.
        reflectance: Rgb,
    },
    /// A rough metal or a rough interface.
    Rough(RoughSurface),
    /// A diffuse base under a smooth coat, on both sides.
    Plastic(Plastic),
    /// The course's material: fixed shares of mirror reflection and refraction, the rest Lambertian.
    ///
    /// `f = (1 - reflectivity - transparency) color / π` beside the two specular shares; no Fresnel's law.
    FixedWeight {
        /// Colour of the Lambertian share.
        color: Rgb,
        /// Share of mirror reflection.
        reflectivity: f32,
        /// Share of refraction; under total internal reflection it is mirrored.
        transparency: f32,
        /// Index of refraction inside (behind the geometric normal) over outside.
        ior: f32,
    },
}

impl Bsdf {
    /// The diffuse share of the incident power, seen at an angle of the cosine `cos`: `f = albedo / π` on the side of `wo`, times what
    /// of light from `wi` passes [`Bsdf::coat`].
    pub fn albedo(&self, cos: f32) -> Rgb {
        match *self {
            Bsdf::Diffuse { albedo } => albedo,
            Bsdf::Plastic(plastic) => plastic.albedo(cos),
            Bsdf::Mirror { .. }
            | Bsdf::Dielectric { .. }
            | Bsdf::ThinDielectric { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::Rough(_) => Rgb::ZERO,
            Bsdf::FixedWeight { color, reflectivity, transparency, .. } => {
                (1.0 - reflectivity - transparency).max(0.0) * color
            }
        }
    }

    /// The same with another colour: of the diffuse share, or of what a mirror or metal reflects. Glass stays as it is.
    #[must_use]
    pub fn with_color(self, color: Rgb) -> Bsdf {
        match self {
            Bsdf::Diffuse { .. } => Bsdf::Diffuse { albedo: color },
            Bsdf::Mirror { .. } => Bsdf::Mirror { reflectance: color },
            Bsdf::Conductor { eta, k, .. } => Bsdf::Conductor { eta, k, reflectance: color },
            Bsdf::Plastic(plastic) => Bsdf::Plastic(plastic.with_base(color)),
            Bsdf::Rough(RoughSurface { facets, interface: Interface::Conductor { eta, k, .. } }) => {
                Bsdf::Rough(RoughSurface {
                    facets,
                    interface: Interface::Conductor { eta, k, reflectance: color },
                })
            }
            Bsdf::FixedWeight { reflectivity, transparency, ior, .. } => {
                Bsdf::FixedWeight { color, reflectivity, transparency, ior }
            }
            Bsdf::Dielectric { .. } | Bsdf::ThinDielectric { .. } | Bsdf::Rough(_) => self,
        }
    }

    /// The same with another roughness, where it has one.
    #[must_use]
    pub fn with_roughness(self, alpha: f32) -> Bsdf {
        match self {
            Bsdf::Rough(RoughSurface { interface, .. }) => {
                let alpha = alpha.clamp(Ggx::LEAST_ALPHA, 1.0);
                Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface })
            }
            smooth => smooth,
        }
    }

    /// What lies on the diffuse base.
    pub fn coat(&self) -> Coat {
        match self {
            Bsdf::Plastic(plastic) => plastic.coat(),
            _ => Coat::NONE,
        }
    }

    /// The share of the incident power that is scattered diffusely: [`Bsdf::albedo`] times what passes the coat on average.
    pub fn diffuse_share(&self, cos: f32) -> Rgb {
        match self {
            Bsdf::Plastic(plastic) => plastic.albedo(cos) * plastic.enters(),
            _ => self.albedo(cos),
        }
    }

    /// Whether any of its lobes is perfectly specular.
    pub fn is_specular(&self) -> bool {
        match *self {
            _ if !SPECULAR => false,
            Bsdf::Diffuse { .. } | Bsdf::Rough(_) => false,
            Bsdf::Mirror { reflectance } | Bsdf::Conductor { reflectance, .. } => reflectance != Rgb::ZERO,
            Bsdf::Dielectric { .. } | Bsdf::ThinDielectric { .. } | Bsdf::Plastic(_) => true,
            Bsdf::FixedWeight { reflectivity, transparency, .. } => reflectivity + transparency > 0.0,
        }
    }

    /// Whether light goes on behind the surface.
    pub fn transmits(&self) -> bool {
        match *self {
            Bsdf::Diffuse { .. } | Bsdf::Mirror { .. } | Bsdf::Conductor { .. } | Bsdf::Plastic(_) => false,
            Bsdf::Dielectric { .. } | Bsdf::ThinDielectric { .. } => true,
            Bsdf::Rough(RoughSurface { interface, .. }) => matches!(interface, Interface::Dielectric { .. }),
            Bsdf::FixedWeight { transparency, .. } => transparency > 0.0,
        }
    }

    /// The index of refraction inside over outside, of what has an inside: not of a pane, whose sides are alike.
    pub fn ior(&self) -> Option<f32> {
        match *self {
            Bsdf::Diffuse { .. }
            | Bsdf::Mirror { .. }
            | Bsdf::Conductor { .. }
            | Bsdf::Plastic(_)
            | Bsdf::ThinDielectric { .. } => None,
            Bsdf::Dielectric { ior } => Some(ior),
            Bsdf::Rough(RoughSurface { interface: Interface::Dielectric { ior }, .. }) => Some(ior),
            Bsdf::Rough(RoughSurface { interface: Interface::Conductor { .. }, .. }) => None,
            Bsdf::FixedWeight { transparency, ior, .. } => (transparency > 0.0).then_some(ior),
        }
    }

    /// All lobes for a path that arrives along `wo` (unit, local, pointing back along the path).
    ///
    /// Radiance crossing an interface is scaled by `1 / eta²`, since its cone widens or narrows (Veach, "Robust
    /// Monte Carlo Methods for Light Transport Simulation", 1997, section 5.2); power is not. The course's
    /// material is the exception that its assignment asks for: along the specular chain from the camera its
    /// transparency is the whole weight.
    ///
    /// A rough surface has no lobes before a facet is drawn: see [`Bsdf::scatter_by`].
    pub fn scatter(&self, wo: Vec3, transport: Transport) -> Scattering {
        let specular = match *self {
            _ if !SPECULAR => [None, None],
            Bsdf::Diffuse { .. } | Bsdf::Rough(_) => [None, None],
            Bsdf::Mirror { reflectance } => [Some(mirrored(wo, reflectance)), None],
            Bsdf::Dielectric { ior } => dielectric_lobes(wo, ior, transport),
            Bsdf::ThinDielectric { ior } => pane_lobes(wo, ior),
            Bsdf::Conductor { eta, k, reflectance } => {
                [Some(mirrored(wo, reflectance * conductor_reflectance(wo.z.abs(), eta, k))), None]
            }
            Bsdf::Plastic(plastic) => {
                let mirrored = mirrored(wo, Rgb::splat(1.0 - plastic.coat().transmittance(wo.z)));
                return Scattering::new(plastic.albedo(wo.z), [Some(mirrored), None])
                    .under(plastic.coat(), plastic.enters());
            }
            Bsdf::FixedWeight { reflectivity, transparency, ior, .. } => {
                fixed_weight_lobes(wo, [reflectivity, transparency], ior, transport)
            }
        };
        Scattering::new(self.albedo(wo.z), specular)
    }

    /// The same by a facet where the surface is rough, which `u` draws: two numbers of the unit square.
    pub fn scatter_by(&self, wo: Vec3, transport: Transport, u: impl FnOnce() -> Vec2) -> Scattering {
        match self.glossy(wo, transport) {
            Some(glossy) => Scattering::new(Rgb::ZERO, glossy.facet(u())),
            None => self.scatter(wo, transport),
        }
    }

    /// The rough share, for a path that arrives along `wo`. `None` of other surfaces, and along the surface.
    pub fn glossy(&self, wo: Vec3, transport: Transport) -> Option<GlossyLobe> {
        match self {
            Bsdf::Rough(surface) if SPECULAR => surface.seen_from(wo, transport),
            _ => None,
        }
    }
}

fn mirrored(wo: Vec3, share: Rgb) -> SpecularLobe {
    SpecularLobe { event: Event::Reflection, wi: reflect(wo), share, scale: 1.0, pdf_w: f32::INFINITY }
}

fn transmitted(wi: Vec3, share: f32, scale: f32) -> SpecularLobe {
    SpecularLobe { event: Event::Transmission, wi, share: Rgb::splat(share), scale, pdf_w: f32::INFINITY }
}

fn pane_lobes(wo: Vec3, ior: f32) -> [Option<SpecularLobe>; 2] {
    let reflectance = pane_reflectance(wo.z.abs(), ior);
    [Some(mirrored(wo, Rgb::splat(reflectance))), Some(transmitted(-wo, 1.0 - reflectance, 1.0))]
}

fn dielectric_lobes(wo: Vec3, ior: f32, transport: Transport) -> [Option<SpecularLobe>; 2] {
    let Some(refraction) = refract(wo, ior) else {
        return [Some(mirrored(wo, Rgb::ONE)), None];
    };
    let reflectance = fresnel_reflectance(wo.z.abs(), refraction.wi.z.abs(), refraction.eta);
    let scale = match transport {
        Transport::Camera | Transport::Radiance => refraction.eta.powi(-2),
        Transport::Power => 1.0,
    };
    [Some(mirrored(wo, Rgb::splat(reflectance))), Some(transmitted(refraction.wi, 1.0 - reflectance, scale))]
}

fn fixed_weight_lobes(
    wo: Vec3,
    [reflectivity, transparency]: [f32; 2],
    ior: f32,
    transport: Transport,
) -> [Option<SpecularLobe>; 2] {
    let Some(refraction) = refract(wo, ior) else {
        return [Some(mirrored(wo, Rgb::splat(reflectivity + transparency))), None];
    };
    let scale = match transport {
        Transport::Radiance => refraction.eta.powi(-2),
        Transport::Camera | Transport::Power => 1.0,
    };
    [Some(mirrored(wo, Rgb::splat(reflectivity))), Some(transmitted(refraction.wi, transparency, scale))]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::math::{Rng, Stream};

    const WATER: Bsdf =
        Bsdf::FixedWeight { color: Rgb::new(0.6, 0.6, 0.7), reflectivity: 0.2, transparency: 0.7, ior: 1.33 };

    fn all_materials() -> [Bsdf; 8] {
        [
            Bsdf::Plastic(Plastic::new(Rgb::new(0.9, 0.5, 0.1), 1.5, true)),
            Bsdf::ThinDielectric { ior: 1.5 },
            Bsdf::Conductor {
                eta: Rgb::new(0.2, 0.9, 1.1),
                k: Rgb::new(3.9, 2.4, 2.1),
                reflectance: Rgb::ONE,
            },
            Bsdf::Diffuse { albedo: Rgb::new(0.7, 0.1, 0.0) },
            Bsdf::Mirror { reflectance: Rgb::new(0.9, 0.8, 0.7) },
            Bsdf::Dielectric { ior: 1.5 },
            WATER,
            Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.5, transparency: 0.5, ior: 0.7 },
        ]
    }

    fn direction(cos: f32, above: bool) -> Vec3 {
        Vec3::new((1.0 - cos * cos).sqrt(), 0.0, if above { cos } else { -cos })
    }

    proptest! {
        /// Catches a lobe that is added twice or a share that is not taken from the rest.
        #[test]
        fn shares_never_exceed_the_incident_power(cos in 0f32..1.0, above: bool) {
            for bsdf in all_materials() {
                let scattering = bsdf.scatter(direction(cos, above), Transport::Power);
                let total = scattering.specular().fold(scattering.diffuse_share(), |sum, lobe| sum + lobe.share);
                prop_assert!(total.max_element() <= 1.0 + 1e-6, "{bsdf:?} gives {total}");
            }
        }

        /// Catches radiance scaled on one side only: into and out of a medium must cancel.
        #[test]
        fn radiance_through_a_slab_is_scaled_by_one(cos in 0.3f32..1.0) {
            for (bsdf, transport) in [
                (Bsdf::Dielectric { ior: 1.5 }, Transport::Camera),
                (Bsdf::Dielectric { ior: 1.5 }, Transport::Radiance),
                (WATER, Transport::Radiance),
            ] {
                let refracted = |wo| {
                    let scattering = bsdf.scatter(wo, transport);
                    *scattering.specular().find(|l| l.event == Event::Transmission).unwrap()
                };
                let into = refracted(direction(cos, true));
                let out = refracted(into.wi);
                prop_assert!((into.scale * out.scale - 1.0).abs() < 1e-5);
                prop_assert!(into.scale < 0.6);
            }
        }
    }

    #[test]
    fn fixed_weights_are_the_eye_weights_and_the_photon_shares() {
        for transport in [Transport::Camera, Transport::Power] {
            let scattering = WATER.scatter(direction(0.8, true), transport);
            let weights: Vec<f32> = scattering.specular().map(|lobe| lobe.weight().x).collect();
            assert_eq!(weights, [0.2, 0.7]);
            assert!((scattering.albedo - 0.1 * Rgb::new(0.6, 0.6, 0.7)).abs().max_element() < 1e-6);
        }
    }

    #[test]
    fn total_internal_reflection_mirrors_the_refracted_share() {
        for (bsdf, share) in [(WATER, 0.9), (Bsdf::Dielectric { ior: 1.33 }, 1.0)] {
            let lobes: Vec<SpecularLobe> =
                bsdf.scatter(direction(0.1, false), Transport::Power).specular().copied().collect();
            assert_eq!(lobes.len(), 1);
            assert_eq!((lobes[0].event, lobes[0].wi.z < 0.0), (Event::Reflection, true));
            assert!((lobes[0].share.x - share).abs() < 1e-6);
        }
    }

    fn mean_entry(bsdf: &Bsdf) -> f32 {
        if let Bsdf::Plastic(plastic) = bsdf { plastic.enters() } else { 1.0 }
    }

    /// The mean factor of each kind of event over many roulettes is its weight: compensation happens exactly once.
    #[test]
    fn roulette_is_unbiased_for_every_material() {
        const N: usize = 200_000;
        for bsdf in all_materials() {
            let wo = direction(0.6, true);
            let scattering = bsdf.scatter(wo, Transport::Camera);
            let expected =
                scattering.specular().fold(scattering.diffuse_share(), |sum, lobe| sum + lobe.weight());
            for choose in [Scattering::choose, Scattering::choose_any] {
                let mut rng = Rng::new(11, Stream::Test, 0, 0);
                let factors =
                    (0..N).filter_map(|_| choose(&scattering, rng.next_f32())).map(|choice| match choice {
                        Choice::Diffuse { factor } => (factor * mean_entry(&bsdf)).as_dvec3(),
                        Choice::Specular { factor, .. } => factor.as_dvec3(),
                    });
                let mean = (factors.sum::<crate::math::DVec3>() / N as f64).as_vec3();
                assert!(
                    (mean - expected).abs().max_element() < 0.006,
                    "{bsdf:?}: {mean} instead of {expected}"
                );
            }
        }
    }

    /// Both samplings estimate the same integrals of the hemisphere: `∫ cos/π dω = 1` and `∫ cos²/π dω = 2/3`.
    #[test]
    fn both_samplings_integrate_the_cosine_lobe() {
        const N: u32 = 200_000;
        for sampling in [DiffuseSampling::Cosine, DiffuseSampling::Uniform] {
            for wo in [Vec3::Z, Vec3::NEG_Z] {
                let mut rng = Rng::new(3, Stream::Test, 0, 0);
                let (mut first, mut second) = (0f64, 0f64);
                for _ in 0..N {
                    let (wi, factor) = sample_diffuse(sampling, wo, &mut rng);
                    assert!(wi.z * wo.z >= 0.0);
                    first += f64::from(factor);
                    second += f64::from(factor * wi.z.abs());
                }
                assert!((first / f64::from(N) - 1.0).abs() < 0.005, "{sampling:?}: {first}");
                assert!((second / f64::from(N) - 2.0 / 3.0).abs() < 0.005, "{sampling:?}: {second}");
            }
        }
    }

    /// Catches a coat that is forgotten on the way in: a white base under it scatters what the coat does not mirror.
    #[test]
    fn a_coated_base_scatters_what_enters() {
        let plastic = Plastic::new(Rgb::ONE, 1.5, false);
        let bsdf = Bsdf::Plastic(plastic);
        for cos in [0.1, 0.5, 1.0] {
            let entered = bsdf.coat().transmittance(cos);
            assert!((bsdf.diffuse_share(cos) - Rgb::splat(entered)).abs().max_element() < 1e-4, "{cos}");
            assert!(entered < 0.97, "{cos}: {entered}");
        }
        let diffuse = Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
        assert_eq!((diffuse.coat(), diffuse.diffuse_share(0.5)), (Coat::NONE, Rgb::splat(0.5)));
    }

    #[test]
    fn the_course_s_material_has_an_inside_where_it_lets_light_through() {
        let opaque = Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.5, transparency: 0.0, ior: 1.33 };
        assert_eq!(
            [WATER, opaque].map(|bsdf| (bsdf.transmits(), bsdf.ior())),
            [(true, Some(1.33)), (false, None)]
        );
    }
}
