use super::received::MIN_NORMAL_COSINE;
use super::{HitPoint, Photon};
use crate::bsdf::{GlossyLobe, Response};
use crate::math::{Frame, Rgb, Vec3};

/// A point of a rough surface that an eye path met: caustics are collected there, too, since facets never find lights without extent.
#[derive(Clone, Copy, Debug)]
pub struct GlossyPoint {
    /// Where it is; its factor is the weight of the eye path alone.
    pub hit_point: HitPoint,
    /// The shading normal that the lobe is of.
    pub normal: Vec3,
    /// What the surface makes of light.
    pub lobe: GlossyLobe,
}

impl GlossyPoint {
    /// What a photon within the radius adds along the eye path, `f cos θ / |ng·wi| Φ`: over the area of the disc it is radiance (W/sr).
    ///
    /// `None` where no facet sends it there, and where it lies on another wall.
    pub fn reflected(&self, photon: &Photon) -> Option<Rgb> {
        let ng = self.hit_point.receiver.ng;
        if ng.dot(photon.ng).abs() <= MIN_NORMAL_COSINE {
            return None;
        }
        let Response { event, value, .. } =
            self.lobe.respond(Frame::around(self.normal).to_local(photon.wi))?;
        let cos = ng.dot(photon.wi);
        let flux = value / cos.abs() * photon.power;
        (event.crosses() == (cos < 0.0) && flux.is_finite()).then_some(flux)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Coat, Ggx, Interface, RoughSurface, Transport};
    use crate::scene::Receiver;

    fn point(interface: Interface) -> GlossyPoint {
        let receiver = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Z, ns: Vec3::Z, coat: Coat::NONE };
        let hit_point = HitPoint { receiver, reflectance: Rgb::ONE, pixel: 0, footprint: 0.0 };
        let surface = RoughSurface { facets: Ggx { alpha: 0.5 }, interface };
        let lobe = surface.seen_from(Vec3::new(0.6, 0.0, 0.8), Transport::Camera).unwrap();
        GlossyPoint { hit_point, normal: Vec3::Z, lobe }
    }

    const METAL: Interface =
        Interface::Conductor { eta: Rgb::ONE, k: Rgb::splat(3.0), reflectance: Rgb::ONE };

    /// Photons of a parallel beam on a disc: `f cos θ E_beam`, whatever the angle of the beam.
    #[test]
    fn a_beam_gives_the_radiance_of_its_irradiance() {
        let metal = point(METAL);
        for cos in [0.2f32, 0.5, 0.9] {
            let wi = Vec3::new(-(1.0 - cos * cos).sqrt(), 0.0, cos);
            let response = metal.lobe.respond(wi).unwrap();
            let photon = Photon { wi, ng: Vec3::Z, power: Rgb::splat(cos) };
            let radiance = metal.reflected(&photon).unwrap();
            assert!((radiance - response.value).abs().max_element() < 1e-6 * response.value.max_element());
        }
    }

    #[test]
    fn photons_of_other_walls_and_of_sides_that_nothing_passes_do_not_count() {
        let photon = |wi: Vec3, ng: Vec3| Photon { wi: wi.normalize(), ng, power: Rgb::ONE };
        let (above, below) = (Vec3::new(-0.6, 0.0, 0.8), Vec3::new(-0.4, 0.0, -0.9));
        let (metal, glass) = (point(METAL), point(Interface::Dielectric { ior: 1.5 }));
        assert!(metal.reflected(&photon(above, Vec3::Z)).is_some());
        assert_eq!(metal.reflected(&photon(above, Vec3::X)), None);
        assert_eq!(metal.reflected(&photon(below, Vec3::NEG_Z)), None);
        assert!(glass.reflected(&photon(below, Vec3::NEG_Z)).is_some());
        let other_side = GlossyPoint { hit_point: turned(&glass.hit_point), ..glass };
        assert_eq!(other_side.reflected(&photon(above, Vec3::Z)), None, "the true surface lies between");
    }

    fn turned(hit_point: &HitPoint) -> HitPoint {
        let receiver = Receiver { ng: -hit_point.receiver.ng, ..hit_point.receiver };
        HitPoint { receiver, ..*hit_point }
    }
}
