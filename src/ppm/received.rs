//! Which photons bring flux to a receiver.

use super::Photon;
use crate::math::Rgb;
use crate::scene::Receiver;

/// Photons whose surface is turned further than this away from the hit point's lie on another wall.
pub(super) const MIN_NORMAL_COSINE: f32 = 1e-3;

/// The flux (W) that a photon within the radius brings to the side of the surface that is seen.
///
/// `None` unless it arrives on that side, and on a surface that faces the same way (not the back of a thin wall,
/// nor the other wall of a corner).
pub fn received(receiver: &Receiver, photon: &Photon) -> Option<Rgb> {
    let same_wall = receiver.ng.dot(photon.ng) > MIN_NORMAL_COSINE;
    let response = receiver.response(photon.wi).filter(|_| same_wall)?;
    Some(response * photon.power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::Coat;
    use crate::math::Vec3;

    fn photon(wi: Vec3, ng: Vec3) -> Photon {
        Photon { wi, ng, power: Rgb::ONE }
    }

    #[test]
    fn only_the_side_that_is_seen_accepts_photons() {
        let floor = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y, coat: Coat::NONE };
        let slanted = Vec3::new(0.6, 0.8, 0.0);
        assert_eq!(received(&floor, &photon(slanted, Vec3::Y)), Some(Rgb::ONE));
        assert_eq!(received(&floor, &photon(-slanted, Vec3::NEG_Y)), None, "back of a thin wall");
        assert_eq!(received(&floor, &photon(slanted, Vec3::X)), None, "the other wall of a corner");
        assert_eq!(received(&floor, &photon(Vec3::NEG_Y, Vec3::Y)), None, "from below");
    }

    /// Flux counts by the true surface, irradiance by the shading normal.
    #[test]
    fn shading_normal_weighs_the_flux() {
        let tilted = Receiver {
            p: Vec3::ZERO,
            p_error: 0.0,
            ng: Vec3::Y,
            ns: Vec3::new(0.6, 0.8, 0.0),
            coat: Coat::NONE,
        };
        assert_eq!(received(&tilted, &photon(Vec3::Y, Vec3::Y)), Some(Rgb::splat(0.8)));
        let away = Vec3::new(-0.9, 0.43589, 0.0);
        assert_eq!(received(&tilted, &photon(away, Vec3::Y)), None, "it faces away from such light");
    }
}
