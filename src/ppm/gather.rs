//! Gathering: every photon is added to all hit points whose sphere contains it; then their radii shrink.

use std::ops::{Add, Range};

use super::{Facets, GatherState, PassSum, Photon, PhotonBatch};
use crate::bvh::{Gatherer, Leaf, Radii, SphereBvh};
use crate::math::{DVec3, Rgb};
use crate::scene::Receiver;
use crate::simd::{Isa, LANES, LaneVec3, Lanes, Mask};

/// Photons whose surface is turned further than this away from the hit point's lie on another wall.
const MIN_NORMAL_COSINE: f32 = 1e-3;

/// The flux (W) that a photon within the radius brings to the side of the surface that is seen.
///
/// `None` unless it arrives on that side, and on a surface that faces the same way (not the back of a thin wall,
/// nor the other wall of a corner).
pub fn received(receiver: &Receiver, photon: &Photon) -> Option<Rgb> {
    let same_wall = receiver.ng.dot(photon.ng) > MIN_NORMAL_COSINE;
    let response = receiver.response(photon.wi).filter(|_| same_wall)?;
    Some(response * photon.power)
}

/// Pairs of a hit point and a photon within its radius, of one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// Those that bring flux.
    pub accepted: u64,
    /// Those that belong to another side.
    pub rejected: u64,
}

impl Add for Found {
    type Output = Found;

    fn add(self, other: Found) -> Found {
        Found { accepted: self.accepted + other.accepted, rejected: self.rejected + other.rejected }
    }
}

/// One pass: adds the photons, shrinks the radii by `alpha` and lets the tree follow, in one walk through it.
///
/// A hit point sums its photons in the order of the batch.
pub(super) fn gather(
    tree: &mut SphereBvh,
    facets: &Facets,
    photons: &PhotonBatch,
    alpha: f64,
    states: &mut [GatherState],
) -> Found {
    let gatherer = PhotonGatherer { facets, photons: &photons.photons, alpha };
    tree.gather_with(Isa::best(), &photons.positions, states, &gatherer)
}

struct PhotonGatherer<'a> {
    facets: &'a Facets,
    photons: &'a [Photon],
    alpha: f64,
}

/// The photons of a task, close together, and what became of them.
struct Task {
    photons: Vec<Photon>,
    found: Found,
}

impl Gatherer for PhotonGatherer<'_> {
    type State = GatherState;
    type Task = Task;
    type Tally = Found;

    fn begin(&self, points: Vec<u32>) -> Task {
        Task {
            photons: points.into_iter().map(|k| self.photons[k as usize]).collect(),
            found: Found::default(),
        }
    }

    #[inline(always)]
    fn meet<L: Lanes>(&self, lanes: L, task: &mut Task, leaf: Leaf<GatherState>) -> Radii {
        let balls = leaf.balls(lanes);
        let facets = LaneFacets::load(lanes, self.facets, leaf.first..leaf.first + leaf.states.len());
        let mut sums = LaneSums::zero(lanes);
        for (p, place) in leaf.points.iter() {
            let around = balls.around(lanes, p);
            let photon = &task.photons[place];
            let (accepted, response) = facets.responses(lanes, photon);
            sums.add(lanes, around & accepted, photon.power, response);
            task.found.accepted += u64::from((around & accepted).count_ones());
            task.found.rejected += u64::from((around & !accepted).count_ones());
        }
        close(leaf.states, leaf.radii, &sums.to_arrays(lanes), self.alpha)
    }

    fn end(&self, task: Task) -> Found {
        task.found
    }
}

/// The normals of up to sixteen hit points.
struct LaneFacets<L: Lanes> {
    ng: LaneVec3<L>,
    /// `None` where they are the geometric ones.
    ns: Option<LaneVec3<L>>,
}

impl<L: Lanes> LaneFacets<L> {
    #[inline(always)]
    fn load(lanes: L, facets: &Facets, positions: Range<usize>) -> LaneFacets<L> {
        let ng = LaneVec3::load(lanes, part(&facets.ng, &positions));
        let Some(ns) = &facets.ns else { return LaneFacets { ng, ns: None } };
        LaneFacets { ng, ns: Some(LaneVec3::load(lanes, part(ns, &positions))) }
    }

    /// [`received`] in lanes: who accepts the photon, and the factor on its power; `None` stands for 1.
    #[inline(always)]
    fn responses(&self, lanes: L, photon: &Photon) -> (Mask, Option<L::F32>) {
        let (zero, infinity) = (lanes.splat(0.0), lanes.splat(f32::INFINITY));
        let alike = self.ng.dot(lanes, LaneVec3::splat(lanes, photon.ng));
        let wi = LaneVec3::splat(lanes, photon.wi);
        let cosine = self.ng.dot(lanes, wi);
        let seen = lanes.lt(lanes.splat(MIN_NORMAL_COSINE), alike) & lanes.lt(zero, cosine);
        let Some(ns) = self.ns else { return (seen, None) };
        let response = lanes.div(ns.dot(lanes, wi), cosine);
        (seen & lanes.lt(zero, response) & lanes.lt(response, infinity), Some(response))
    }
}

fn part<'a>(columns: &'a [Vec<f32>; 3], positions: &Range<usize>) -> [&'a [f32]; 3] {
    columns.each_ref().map(|column| &column[positions.clone()])
}

/// What a pass brings to up to sixteen hit points: red, green, blue, count.
struct LaneSums<L: Lanes>([L::F64; 4]);

impl<L: Lanes> LaneSums<L> {
    #[inline(always)]
    fn zero(lanes: L) -> LaneSums<L> {
        LaneSums([lanes.zero_f64(); 4])
    }

    #[inline(always)]
    fn add(&mut self, lanes: L, accepted: Mask, power: Rgb, response: Option<L::F32>) {
        let [red, green, blue, count] = self.0;
        let flux = LaneVec3::splat(lanes, power);
        let flux = match response {
            Some(response) => LaneVec3 {
                x: lanes.mul(response, flux.x),
                y: lanes.mul(response, flux.y),
                z: lanes.mul(response, flux.z),
            },
            None => flux,
        };
        self.0 = [
            lanes.add_where(accepted, red, flux.x),
            lanes.add_where(accepted, green, flux.y),
            lanes.add_where(accepted, blue, flux.z),
            lanes.add_where(accepted, count, lanes.splat(1.0)),
        ];
    }

    #[inline(always)]
    fn to_arrays(&self, lanes: L) -> [[f64; LANES]; 4] {
        let [red, green, blue, count] = self.0;
        [
            lanes.to_array_f64(red),
            lanes.to_array_f64(green),
            lanes.to_array_f64(blue),
            lanes.to_array_f64(count),
        ]
    }
}

/// Closes the pass for the hit points of a leaf.
fn close(
    states: &mut [GatherState],
    radii: &mut [f32],
    [red, green, blue, count]: &[[f64; LANES]; 4],
    alpha: f64,
) -> Radii {
    let mut changed = Radii::Kept;
    for (lane, (state, radius)) in states.iter_mut().zip(radii).enumerate().take(LANES) {
        if count[lane] > 0.0 {
            let flux = DVec3::new(red[lane], green[lane], blue[lane]);
            state.after_pass(&PassSum { flux, accepted: count[lane] as u32 }, alpha);
            *radius = state.radius() as f32;
            changed = Radii::Changed;
        }
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::super::HitPoint;
    use super::*;
    use crate::bvh::Sphere;
    use crate::math::{Rng, Stream, Vec3, warp};

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

    fn vector(rng: &mut Rng) -> Vec3 {
        warp::square_to_uniform_sphere(rng.next_vec2())
    }

    /// Hit points with normals of all kinds: alike, leaning, opposite.
    fn hit_point(rng: &mut Rng, smooth: bool) -> HitPoint {
        let ng = if rng.next_f32() < 0.5 { Vec3::Y } else { vector(rng) };
        let ns = if smooth { (ng + 1.5 * rng.next_f32() * vector(rng)).normalize() } else { ng };
        let p = Vec3::new(rng.next_f32(), 0.0, rng.next_f32());
        let receiver = Receiver { p, p_error: 0.0, ng, ns };
        HitPoint { receiver, weight: Rgb::ONE, pixel: 0, material: 0, footprint: 0.0 }
    }

    fn photon_batch(rng: &mut Rng, n: usize) -> PhotonBatch {
        let mut batch = PhotonBatch::default();
        for _ in 0..n {
            let ng = if rng.next_f32() < 0.8 { Vec3::Y } else { vector(rng) };
            let wi = vector(rng);
            batch.positions.push(Vec3::new(rng.next_f32(), 0.01 * rng.next_f32(), rng.next_f32()));
            batch.photons.push(Photon { wi, ng, power: Rgb::new(rng.next_f32(), 1e-9, 3e4) });
        }
        batch
    }

    /// What a pass must leave in a hit point: one photon after the other, in f64.
    fn naive(hit_point: &HitPoint, sphere: &Sphere, batch: &PhotonBatch, alpha: f64) -> GatherState {
        let mut sum = PassSum::default();
        for (p, photon) in batch.positions.iter().zip(&batch.photons) {
            if let Some(flux) = received(&hit_point.receiver, photon).filter(|_| sphere.contains(*p)) {
                sum.flux += flux.as_dvec3();
                sum.accepted += 1;
            }
        }
        let mut state = GatherState::new(f64::from(sphere.radius));
        state.after_pass(&sum, alpha);
        state
    }

    /// Every instruction set against the definition, bit by bit.
    #[test]
    fn lanes_gather_what_the_definition_says() {
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        for smooth in [false, true] {
            let hit_points: Vec<HitPoint> = (0..500).map(|_| hit_point(&mut rng, smooth)).collect();
            let sphere = |h: &HitPoint| Sphere { center: h.receiver.p, radius: 0.125 };
            let spheres: Vec<Sphere> = hit_points.iter().map(sphere).collect();
            let batch = photon_batch(&mut rng, 1000);
            let (tree, order) = SphereBvh::build(&spheres);
            let ordered: Vec<HitPoint> = order.iter().map(|&k| hit_points[k as usize]).collect();
            let expected: Vec<GatherState> =
                ordered.iter().map(|h| naive(h, &sphere(h), &batch, 0.7)).collect();
            assert!(expected.iter().filter(|state| state.photons > 2.0).count() > 100);
            for isa in Isa::available() {
                let (mut tree, mut states) = (tree.clone(), vec![GatherState::new(0.125); 500]);
                let facets = Facets::of(&ordered);
                let gatherer = PhotonGatherer { facets: &facets, photons: &batch.photons, alpha: 0.7 };
                let found = tree.gather_with(isa, &batch.positions, &mut states, &gatherer);
                assert!(states == expected, "{isa}, smooth: {smooth}");
                let radii = states.iter().map(|state| state.radius() as f32);
                assert!(radii.eq(tree.radii().iter().copied()), "{isa}");
                assert!(found.accepted > 1000 && found.rejected > 1000, "{found:?}");
            }
        }
    }
}
