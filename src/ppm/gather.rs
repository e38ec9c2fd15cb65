//! Gathering: every photon is added to all hit points whose sphere contains it.

use super::{GatherState, HitPoint, Photon, PhotonBatch};
use crate::bvh::SphereBvh;
use crate::math::Rgb;
use crate::scene::Receiver;

/// Photons whose surface is turned further than this away from the hit point's lie on another wall.
const MIN_NORMAL_COSINE: f32 = 1e-3;

/// Adds the photons to the running pass of every hit point; for one hit point always in the order of their paths.
pub fn gather(tree: &SphereBvh, hit_points: &[HitPoint], batch: &PhotonBatch, states: &mut [GatherState]) {
    tree.gather(&batch.positions, states, |state, hit_point, photon| {
        let photon = &batch.photons[photon];
        state.add(received(&hit_points[hit_point].receiver, photon));
    });
}

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
    use crate::math::Vec3;

    fn photon(wi: Vec3, ng: Vec3) -> Photon {
        Photon { wi, ng, power: Rgb::ONE }
    }

    #[test]
    fn only_the_side_that_is_seen_accepts_photons() {
        let floor = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y };
        let slanted = Vec3::new(0.6, 0.8, 0.0);
        assert_eq!(received(&floor, &photon(slanted, Vec3::Y)), Some(Rgb::ONE));
        assert_eq!(received(&floor, &photon(-slanted, Vec3::NEG_Y)), None, "back of a thin wall");
        assert_eq!(received(&floor, &photon(slanted, Vec3::X)), None, "the other wall of a corner");
        assert_eq!(received(&floor, &photon(Vec3::NEG_Y, Vec3::Y)), None, "from below");
    }

    /// Flux counts by the true surface, irradiance by the shading normal.
    #[test]
    fn shading_normal_weighs_the_flux() {
        let tilted = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::new(0.6, 0.8, 0.0) };
        assert_eq!(received(&tilted, &photon(Vec3::Y, Vec3::Y)), Some(Rgb::splat(0.8)));
        let away = Vec3::new(-0.9, 0.43589, 0.0);
        assert_eq!(received(&tilted, &photon(away, Vec3::Y)), None, "it faces away from such light");
    }
}
