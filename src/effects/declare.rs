//! What every part of a scene needs. All matches are exhaustive and all fields are named: whoever adds a material, a light
//! or a property of the camera must say here what it asks for.

use super::{Effect, EffectSet};
use crate::bsdf::{Bsdf, Interface, Plastic, RoughSurface};
use crate::light::Light;
use crate::math::{Rgb, mean};
use crate::scene::{CameraDesc, FilmDesc, Material, PixelFilter, Textures};

/// What a surface needs: its lobes of non-zero share, its emission, and its pictures. Constants of what is pictured are the
/// largest values, so no place of the surface has other lobes.
pub fn of_material(material: &Material) -> EffectSet {
    let Material { name: _, bsdf, emission, opacity: _, absorption, textures } = material;
    let Textures { color, roughness, opacity } = textures;
    of_bsdf(bsdf)
        .with(Effect::Emission, *emission != Rgb::ZERO)
        .with(Effect::Texture, color.is_some() || roughness.is_some() || opacity.is_some())
        .with(Effect::Mask, material.is_mask())
        .with(Effect::Absorption, *absorption != Rgb::ZERO && material.inside().is_some())
}

/// What a way of scattering needs: nothing for lobes without a share.
///
/// Wherever light is refracted some may be mirrored, by Fresnel's law or by total internal reflection.
pub fn of_bsdf(bsdf: &Bsdf) -> EffectSet {
    let diffuse = EffectSet::NONE.with(Effect::Diffuse, bsdf.albedo(1.0) != Rgb::ZERO);
    match *bsdf {
        Bsdf::Diffuse { albedo: _ } => diffuse,
        Bsdf::Mirror { reflectance } => diffuse.union(specular(reflectance.max_element() > 0.0, false)),
        Bsdf::Dielectric { ior: _ } => diffuse.union(specular(true, true)),
        Bsdf::ThinDielectric { ior: _ } => diffuse.union(specular(true, true)),
        Bsdf::Conductor { eta: _, k: _, reflectance } => {
            diffuse.union(specular(reflectance.max_element() > 0.0, false))
        }
        Bsdf::Plastic(Plastic { base: _, ior: _, nonlinear: _, .. }) => diffuse.union(specular(true, false)),
        Bsdf::Rough(RoughSurface { facets: _, interface }) => {
            diffuse.with(Effect::Glossy, has_share(interface))
        }
        Bsdf::FixedWeight { color: _, reflectivity, transparency, ior: _ } => {
            let refracts = transparency > 0.0;
            diffuse.union(specular(reflectivity > 0.0 || refracts, refracts))
        }
    }
}

fn has_share(interface: Interface) -> bool {
    match interface {
        Interface::Conductor { eta: _, k: _, reflectance } => reflectance.max_element() > 0.0,
        Interface::Dielectric { ior: _ } => true,
    }
}

fn specular(reflects: bool, refracts: bool) -> EffectSet {
    EffectSet::NONE.with(Effect::SpecularReflection, reflects).with(Effect::SpecularTransmission, refracts)
}

/// What a light needs: nothing without power, as [`crate::light::Lights`] leaves it out.
pub fn of_light(light: &Light) -> EffectSet {
    let shines = mean(light.flux()) > 0.0;
    match light {
        Light::Point { .. } | Light::Spot(_) | Light::Distant(_) => {
            EffectSet::NONE.with(Effect::DeltaLight, shines)
        }
        Light::Environment(_) => EffectSet::NONE.with(Effect::Environment, shines),
        Light::Triangle { .. } | Light::Sphere { .. } => EffectSet::NONE.with(Effect::AreaLight, shines),
    }
}

/// What a camera needs: nothing, as a pinhole.
pub fn of_camera(camera: &CameraDesc) -> EffectSet {
    let CameraDesc { position: _, look_at: _, up: _, fov_degrees: _, lens_radius, focus_distance: _ } =
        camera;
    EffectSet::NONE.with(Effect::Lens, *lens_radius > 0.0)
}

/// What a film needs: nothing, as the mean over the samples of each pixel.
pub fn of_film(film: &FilmDesc) -> EffectSet {
    let FilmDesc { width: _, height: _, filter } = film;
    EffectSet::NONE.with(Effect::AreaFilter, *filter != PixelFilter::Points)
}

/// Whether light goes on behind the surface, refracted or through a mask. What does not let it through can part a scene.
pub(super) fn is_clear(material: &Material) -> bool {
    material.transmits()
}

/// Whether paths go on along one direction.
pub(super) fn is_caster(effects: EffectSet) -> bool {
    let casters = [Effect::SpecularReflection, Effect::SpecularTransmission, Effect::Mask];
    casters.into_iter().any(|effect| effects.contains(effect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Event, Ggx, Transport};
    use crate::math::{Rng, Stream, Vec3, warp};

    fn fixed(color: f32, reflectivity: f32, transparency: f32) -> Bsdf {
        Bsdf::FixedWeight { color: Rgb::splat(color), reflectivity, transparency, ior: 1.33 }
    }

    fn materials() -> Vec<Bsdf> {
        let shares = [0.0, 0.3, 1.0];
        let mut all = vec![Bsdf::Dielectric { ior: 1.5 }, Bsdf::Dielectric { ior: 0.5 }];
        all.extend([Bsdf::ThinDielectric { ior: 1.5 }, Bsdf::Plastic(Plastic::new(Rgb::ONE, 1.5, true))]);
        all.push(rough(Interface::Dielectric { ior: 1.5 }));
        for reflectance in [Rgb::ZERO, Rgb::X] {
            let (eta, k) = (Rgb::ONE, Rgb::ONE);
            all.push(Bsdf::Conductor { eta, k, reflectance });
            all.push(rough(Interface::Conductor { eta, k, reflectance }));
        }
        for share in shares.map(Rgb::splat).into_iter().chain([Rgb::Y]) {
            all.extend([Bsdf::Diffuse { albedo: share }, Bsdf::Mirror { reflectance: share }]);
        }
        for reflectivity in shares {
            for transparency in shares.into_iter().filter(|t| reflectivity + t <= 1.0) {
                all.extend([0.0, 0.5].map(|color| fixed(color, reflectivity, transparency)));
            }
        }
        all
    }

    fn rough(interface: Interface) -> Bsdf {
        Bsdf::Rough(RoughSurface { facets: Ggx { alpha: 0.3 }, interface })
    }

    /// Whatever lobe a surface has for any direction was declared, and nothing else was.
    #[test]
    fn surfaces_do_what_they_declare() {
        for bsdf in materials() {
            let mut found = EffectSet::NONE;
            for index in 0..2000 {
                let mut rng = Rng::new(1, Stream::Test, 0, index);
                let wo = warp::square_to_uniform_sphere(rng.next_vec2());
                let scattering = bsdf.scatter_by(wo, Transport::Power, || rng.next_vec2());
                found = found.with(Effect::Diffuse, scattering.albedo != Rgb::ZERO);
                for lobe in scattering.specular() {
                    found = match lobe.event {
                        Event::GlossyReflection | Event::GlossyTransmission => {
                            found.with(Effect::Glossy, true)
                        }
                        Event::Transmission => found.with(Effect::SpecularTransmission, true),
                        Event::Reflection | Event::Diffuse => found.with(Effect::SpecularReflection, true),
                    };
                }
            }
            assert_eq!(of_bsdf(&bsdf), found, "{bsdf:?}");
        }
    }

    #[test]
    fn cameras_need_their_lens_and_films_their_filter() {
        let pinhole = CameraDesc::pinhole(Vec3::ZERO, Vec3::X, 40.0);
        assert_eq!(of_camera(&pinhole), EffectSet::NONE);
        assert!(of_camera(&CameraDesc { lens_radius: 0.1, ..pinhole }).iter().eq([Effect::Lens]));
        for filter in PixelFilter::ALL {
            let needs = of_film(&FilmDesc { filter, ..FilmDesc::new(1, 1) });
            assert_eq!(needs.contains(Effect::AreaFilter), filter != PixelFilter::Points, "{filter}");
        }
    }

    #[test]
    fn lamps_need_emission_and_lights_power() {
        let black = Bsdf::Diffuse { albedo: Rgb::ZERO };
        let lamp = |emission| Material::plain("lamp", black, emission);
        assert!(of_material(&lamp(Rgb::Z)).iter().eq([Effect::Emission]));
        assert_eq!(of_material(&lamp(Rgb::ZERO)), EffectSet::NONE);
        let point = |intensity| of_light(&Light::Point { position: Vec3::ZERO, intensity });
        assert!(point(Rgb::X).iter().eq([Effect::DeltaLight]) && point(Rgb::ZERO) == EffectSet::NONE);
        let triangle = |size: f32| Light::Triangle {
            corners: [Vec3::ZERO, size * Vec3::X, size * Vec3::Z],
            radiance: Rgb::ONE,
        };
        assert!(of_light(&triangle(1.0)).iter().eq([Effect::AreaLight]));
        assert_eq!(of_light(&triangle(0.0)), EffectSet::NONE);
    }
}
