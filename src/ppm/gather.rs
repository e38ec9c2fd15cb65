//! Gathering: every photon is added to all hit points whose sphere contains it.

use super::{GatherState, HitPoint, Photon, PhotonBatch};
use crate::bvh::SphereBvh;
use crate::scene::Receiver;

/// Photons whose surface is turned further than this away from the hit point's lie on another wall.
const MIN_NORMAL_COSINE: f32 = 1e-3;

/// Adds the photons to the running pass of every hit point; for one hit point always in the order of their paths.
pub fn gather(tree: &SphereBvh, hit_points: &[HitPoint], batch: &PhotonBatch, states: &mut [GatherState]) {
    tree.gather(&batch.positions, states, |state, hit_point, photon| {
        let photon = &batch.photons[photon];
        state.add(accepts(&hit_points[hit_point].receiver, photon), photon.power);
    });
}

/// Whether a photon within the radius lights the side of the surface that is seen: it must arrive on that side,
/// and on a surface that faces the same way (not the back of a thin wall, nor the other wall of a corner).
pub fn accepts(receiver: &Receiver, photon: &Photon) -> bool {
    receiver.ng.dot(photon.wi) > 0.0 && receiver.ng.dot(photon.ng) > MIN_NORMAL_COSINE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rgb, Vec3};

    fn photon(wi: Vec3, ng: Vec3) -> Photon {
        Photon { wi, ng, power: Rgb::ONE }
    }

    #[test]
    fn only_the_side_that_is_seen_accepts_photons() {
        let floor = Receiver { p: Vec3::ZERO, p_error: 0.0, ng: Vec3::Y, ns: Vec3::Y };
        let slanted = Vec3::new(0.6, 0.8, 0.0);
        assert!(accepts(&floor, &photon(slanted, Vec3::Y)));
        assert!(!accepts(&floor, &photon(-slanted, Vec3::NEG_Y)), "back of a thin wall");
        assert!(!accepts(&floor, &photon(slanted, Vec3::X)), "the other wall of a corner");
        assert!(!accepts(&floor, &photon(Vec3::NEG_Y, Vec3::Y)), "from below");
    }
}
