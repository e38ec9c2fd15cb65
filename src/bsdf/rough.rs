use super::fresnel::{conductor_reflectance, cos_transmitted, fresnel_reflectance};
use super::ggx::Ggx;
use super::{Event, SpecularLobe, Transport};
use crate::math::{Rgb, Vec2, Vec3};

/// A surface of small facets, each a mirror or an interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughSurface {
    /// How the facets lie.
    pub facets: Ggx,
    /// What a facet is.
    pub interface: Interface,
}

/// What a facet is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface {
    /// Metal, on both sides.
    Conductor {
        /// Real part of the index.
        eta: Rgb,
        /// Imaginary part of the index, above 0 where light is absorbed.
        k: Rgb,
        /// Factor on what is reflected.
        reflectance: Rgb,
    },
    /// A lossless interface.
    Dielectric {
        /// Index of refraction inside (behind the geometric normal) over outside.
        ior: f32,
    },
}

/// The rough share of a surface, for a path that arrives along one direction.
///
/// Light that a facet sends to another one is lost. With the normal `m` of a facet that is drawn as it is seen from `wo`, a path
/// goes on along `wi` by the weight `F G1(wi)`, and
///
/// ```text
/// reflection    f |cos θ_wi| = F G1(wi) pdf_w              pdf_w = D_wo(m) / (4 wo·m)
/// transmission  f |cos θ_wi| = (1 - F) G1(wi) s pdf_w      pdf_w = D_wo(m) eta² |wi·m| / (wo·m + eta wi·m)²
/// ```
/// `eta` is the index on the side of `wi` over that of `wo`; `s` is `1 / eta²` for radiance and 1 for power.
///
/// # Source
/// Walter, Marschner, Li and Torrance, "Microfacet Models for Refraction through Rough Surfaces", EGSR 2007, equations 20 and 21.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlossyLobe {
    surface: RoughSurface,
    /// Turned to the upper side.
    wo: Vec3,
    /// Whether `wo` was below.
    turned: bool,
    transport: Transport,
}

/// What a rough surface does with light from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Reflection or transmission by a facet.
    pub event: Event,
    /// `f |cos θ_wi|` (1/sr).
    pub value: Rgb,
    /// The density by which a path goes on along that direction, both lobes of a facet being followed (1/sr).
    pub pdf_w: f32,
}

impl RoughSurface {
    /// For a path that arrives along `wo`, unit and local. `None` along the surface, where no facet is seen.
    pub fn seen_from(self, wo: Vec3, transport: Transport) -> Option<GlossyLobe> {
        let turned = wo.z < 0.0;
        let upper = if turned { -wo } else { wo };
        (wo.z != 0.0).then_some(GlossyLobe { surface: self, wo: upper, turned, transport })
    }
}

impl GlossyLobe {
    /// What the path goes on by, for a facet drawn by `u` in the unit square.
    pub(super) fn facet(&self, u: Vec2) -> [Option<SpecularLobe>; 2] {
        let m = self.surface.facets.sample(self.wo, u);
        let reflected = 2.0 * self.wo.dot(m) * m - self.wo;
        [Some(reflected).filter(|wi| wi.z > 0.0), self.refracted(m).filter(|wi| wi.z < 0.0)]
            .map(|wi| self.lobe(wi?, m))
    }

    /// What of light from `wi`, unit and local, goes on along `wo`. `None` where no facet sends it there.
    pub fn respond(&self, wi: Vec3) -> Option<Response> {
        let wi = self.turned(wi);
        let between = if wi.z > 0.0 { self.wo + wi } else { self.wo + self.eta()? * wi };
        let m = between.try_normalize()?;
        let lobe = self.lobe(wi, if m.z < 0.0 { -m } else { m })?;
        let value = lobe.weight() * lobe.pdf_w;
        value.is_finite().then_some(Response { event: lobe.event, value, pdf_w: lobe.pdf_w })
    }

    fn turned(&self, w: Vec3) -> Vec3 {
        if self.turned { -w } else { w }
    }

    /// The index below over that above; `None` of metal.
    fn eta(&self) -> Option<f32> {
        match self.surface.interface {
            Interface::Conductor { .. } => None,
            Interface::Dielectric { ior } => Some(if self.turned { ior.recip() } else { ior }),
        }
    }

    fn refracted(&self, m: Vec3) -> Option<Vec3> {
        let (eta, cos) = (self.eta()?, self.wo.dot(m));
        let cos_t = cos_transmitted(cos, eta)?;
        Some(((cos / eta - cos_t) * m - self.wo / eta).normalize())
    }

    /// From `wo` to `wi` by the facet of the normal `m`. `None` where that faces away from either.
    fn lobe(&self, wi: Vec3, m: Vec3) -> Option<SpecularLobe> {
        let RoughSurface { facets, interface } = self.surface;
        let (cos_o, cos_i) = (self.wo.dot(m), wi.dot(m));
        let reflects = wi.z > 0.0;
        if cos_o <= 0.0 || wi.z == 0.0 || (cos_i > 0.0) != reflects {
            return None;
        }
        let visible = facets.visible_density(self.wo, m);
        let (event, fresnel, pdf_w) = if reflects {
            (Event::GlossyReflection, interface.reflectance(cos_o, self.eta()), visible / (4.0 * cos_o))
        } else {
            let eta = self.eta()?;
            let transmittance = Rgb::ONE - interface.reflectance(cos_o, Some(eta));
            let denominator = cos_o + eta * cos_i;
            let jacobian = eta * eta * -cos_i / (denominator * denominator);
            (Event::GlossyTransmission, transmittance, visible * jacobian)
        };
        let share = fresnel * facets.masking(wi);
        Some(SpecularLobe { event, wi: self.turned(wi), share, scale: self.scale(reflects), pdf_w })
    }

    fn scale(&self, reflects: bool) -> f32 {
        match (self.transport, self.eta()) {
            (Transport::Camera | Transport::Radiance, Some(eta)) if !reflects => eta.powi(-2),
            _ => 1.0,
        }
    }
}

impl Interface {
    /// `F` of a facet at the cosine `cos`; `eta` is the index behind over that before it, of a dielectric.
    fn reflectance(self, cos: f32, eta: Option<f32>) -> Rgb {
        match (self, eta) {
            (Interface::Conductor { eta, k, reflectance }, _) => {
                reflectance * conductor_reflectance(cos, eta, k)
            }
            (Interface::Dielectric { .. }, None) => Rgb::ZERO,
            (Interface::Dielectric { .. }, Some(eta)) => Rgb::splat(
                cos_transmitted(cos, eta).map_or(1.0, |cos_t| fresnel_reflectance(cos, cos_t, eta)),
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream, warp};

    const METAL: Interface = Interface::Conductor {
        eta: Rgb::new(0.2, 0.9, 1.1),
        k: Rgb::new(3.9, 2.4, 2.1),
        reflectance: Rgb::ONE,
    };
    const GLASS: Interface = Interface::Dielectric { ior: 1.5 };

    fn surfaces() -> impl Iterator<Item = RoughSurface> {
        let kinds = [METAL, GLASS, Interface::Dielectric { ior: 0.6 }];
        kinds.into_iter().flat_map(|interface| {
            [0.1, 0.4, 1.0].map(|alpha| RoughSurface { facets: Ggx { alpha }, interface })
        })
    }

    fn direction(cos: f32) -> Vec3 {
        Vec3::new(0.8 * (1.0 - cos * cos).sqrt(), 0.6 * (1.0 - cos * cos).sqrt(), cos)
    }

    const VIEWS: [f32; 4] = [0.95, 0.3, -0.2, -0.9];

    /// A facet that was drawn and the response to light from where it sends the path agree: `f cos = weight · pdf_w`. Catches a
    /// half vector on the wrong side, a wrong Jacobian, an index upside down.
    #[test]
    fn a_path_by_a_facet_is_what_the_surface_makes_of_light_from_there() {
        for surface in surfaces() {
            for (cos, transport) in
                VIEWS.into_iter().zip([Transport::Camera, Transport::Power].into_iter().cycle())
            {
                let lobe = surface.seen_from(direction(cos), transport).unwrap();
                let mut rng = Rng::new(2, Stream::Test, 0, 0);
                for drawn in (0..200).flat_map(|_| lobe.facet(rng.next_vec2())).flatten() {
                    let Some(found) = lobe.respond(drawn.wi) else { continue };
                    // Where directions are nearly parallel to facets, f32 tells little of them.
                    let near = |a: f32, b: f32| (a - b).abs() <= 0.02 * a.abs().max(b.abs());
                    assert_eq!(found.event, drawn.event);
                    assert!(near(found.pdf_w, drawn.pdf_w), "{surface:?} {cos}: {found:?} {drawn:?}");
                    assert!(near(found.value.y, drawn.weight().y * drawn.pdf_w), "{found:?} {drawn:?}");
                }
            }
        }
    }

    /// What paths by facets carry on average is the integral of the response over all directions, and densities integrate to the
    /// share of facets that send a path anywhere, each lobe of them.
    #[test]
    fn facets_carry_the_integral_of_the_response() {
        const N: u64 = 60_000;
        const ON_SPHERE: f64 = 4.0 * std::f64::consts::PI / N as f64;
        for surface in surfaces().filter(|surface| surface.facets.alpha >= 0.4) {
            for cos in VIEWS {
                let lobe = surface.seen_from(direction(cos), Transport::Power).unwrap();
                let (mut rng, mut carried, mut ways) = (Rng::new(3, Stream::Test, 0, 0), 0.0, 0.0);
                let (mut integral, mut density) = (0.0, 0.0);
                for _ in 0..N {
                    for drawn in lobe.facet(rng.next_vec2()).into_iter().flatten() {
                        carried += f64::from(drawn.weight().y) / N as f64;
                        ways += 1.0 / N as f64;
                    }
                    let wi = warp::square_to_uniform_sphere(rng.next_vec2());
                    if let Some(found) = lobe.respond(wi) {
                        integral += ON_SPHERE * f64::from(found.value.y);
                        density += ON_SPHERE * f64::from(found.pdf_w);
                    }
                }
                assert!((carried - integral).abs() < 0.04, "{surface:?} {cos}: {carried} {integral}");
                assert!((ways - density).abs() < 0.08, "{surface:?} {cos}: {ways} {density}");
                assert!(carried <= 1.0 + 1e-6, "{surface:?} {cos}: {carried}");
            }
        }
    }

    /// A smooth limit loses nothing: what facets of glass mirror and refract sums to 1 (white furnace), and what metal
    /// reflects head-on is its reflectance.
    #[test]
    fn nearly_smooth_surfaces_keep_all_light() {
        for cos in [0.9f32, 0.5, -0.9] {
            let of = |interface| {
                let surface = RoughSurface { facets: Ggx { alpha: 0.01 }, interface };
                let lobe = surface.seen_from(direction(cos), Transport::Power).unwrap();
                let lobes = lobe.facet(Vec2::new(0.4, 0.7)).into_iter().flatten();
                lobes.map(|lobe| lobe.weight()).sum::<Rgb>()
            };
            assert!((of(GLASS) - Rgb::ONE).abs().max_element() < 2e-3, "{cos}: {}", of(GLASS));
            let Interface::Conductor { eta, k, .. } = METAL else { return };
            let smooth = conductor_reflectance(cos.abs(), eta, k);
            assert!((of(METAL) - smooth).abs().max_element() < 5e-3, "{cos}: {} {smooth}", of(METAL));
        }
    }

    /// Light and sensor may be swapped: what radiance makes of `wo -> wi` power makes of `wi -> wo`, by `f`. Catches a scale of
    /// radiance on the wrong side or in power.
    #[test]
    fn power_goes_the_way_of_radiance_backwards() {
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        for surface in surfaces() {
            let mut compared = 0;
            for _ in 0..400 {
                let [wo, wi] = [(); 2].map(|()| warp::square_to_uniform_sphere(rng.next_vec2()));
                let f = |wo: Vec3, wi: Vec3, transport| {
                    let response = surface.seen_from(wo, transport)?.respond(wi)?;
                    Some(response.value.y / wi.z.abs())
                };
                let pair = (f(wo, wi, Transport::Radiance), f(wi, wo, Transport::Power));
                let (Some(forth), Some(back)) = pair else {
                    assert_eq!(pair.0.unwrap_or(0.0).max(pair.1.unwrap_or(0.0)), 0.0, "{pair:?}");
                    continue;
                };
                assert!((forth - back).abs() <= 1e-3 * forth.max(back) + 1e-6, "{surface:?}: {forth} {back}");
                compared += 1;
            }
            assert!(compared > 30, "{surface:?}: {compared}");
        }
    }
}
