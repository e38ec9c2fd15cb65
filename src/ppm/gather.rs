//! Gathering: every photon is added to all hit points whose sphere contains it; then their radii shrink.

use std::marker::PhantomData;
use std::ops::Range;

use super::gather_glossy::GlossyGatherer;
use super::gather_task::{Task, close};
use super::lane_parts::LaneParts;
use super::received::MIN_NORMAL_COSINE;
use super::statistic::{Gathers, Statistics};
use super::{Facets, Found, GlossyPoint, Photon, Photons};
use crate::bvh::{Gatherer, Leaf, Radii, SphereBvh};
use crate::math::Rgb;
use crate::simd::{Isa, LANES, LaneVec3, Lanes, Mask};

/// What photons arrive at, in the order of the tree.
#[derive(Clone, Copy)]
pub(super) enum Receivers<'a> {
    /// The Lambertian share of surfaces.
    Diffuse(&'a Facets),
    /// Rough surfaces.
    Glossy(&'a [GlossyPoint]),
}

/// One pass: adds the photons, shrinks the radii by `alpha` and lets the tree follow, in one walk through it.
///
/// A hit point sums its photons by their numbers.
pub(super) fn gather(
    tree: &mut SphereBvh,
    receivers: Receivers,
    photons: &Photons,
    alpha: f64,
    statistics: &mut Statistics,
) -> Found {
    match statistics {
        Statistics::Double(states) => gather_into(tree, receivers, photons, alpha, states),
        Statistics::Single(states) => gather_into(tree, receivers, photons, alpha, states),
        Statistics::Tested(states) => gather_into(tree, receivers, photons, alpha, states),
    }
}

/// The same for states of one kind.
pub(super) fn gather_into<S: Gathers>(
    tree: &mut SphereBvh,
    receivers: Receivers,
    photons: &Photons,
    alpha: f64,
    states: &mut [S],
) -> Found {
    let (isa, positions, state) = (Isa::best(), photons.positions(), PhantomData);
    match receivers {
        Receivers::Diffuse(facets) => {
            tree.gather_with(isa, &positions, states, &PhotonGatherer { facets, photons, alpha, state })
        }
        Receivers::Glossy(points) => {
            tree.gather_with(isa, &positions, states, &GlossyGatherer { points, photons, alpha, state })
        }
    }
}

struct PhotonGatherer<'a, S> {
    facets: &'a Facets,
    photons: &'a Photons<'a>,
    alpha: f64,
    state: PhantomData<fn(S)>,
}

impl<S: Gathers> Gatherer for PhotonGatherer<'_, S> {
    type State = S;
    type Task = Task;
    type Tally = Found;

    fn begin(&self, points: Vec<u32>) -> Task {
        Task::of(self.photons, &points)
    }

    #[inline(always)]
    fn meet<L: Lanes>(&self, lanes: L, task: &mut Task, leaf: Leaf<S>) -> Radii {
        let balls = leaf.balls(lanes);
        let facets = LaneFacets::load(lanes, self.facets, leaf.first..leaf.first + leaf.states.len());
        let mut sums = LaneSums::zero(lanes);
        let mut parts = LaneParts::zero(lanes, facets.ng);
        let (mut touched, mut met) = (0, 0);
        for (p, place) in leaf.points.iter() {
            let around = balls.around(lanes, p);
            let photon = &task.photons[place];
            let (accepted, response) = facets.responses(lanes, photon);
            sums.add(lanes, around & accepted, photon.power, response);
            if S::WANTS_PARTS {
                let offset = balls.offset(lanes, p);
                let inner = balls.around_half(lanes, offset);
                parts.add(lanes, around & accepted, offset, inner, photon.power, response);
            }
            touched |= around & accepted;
            met += u64::from(around.count_ones());
        }
        let parts = if S::WANTS_PARTS { Some(parts.to_arrays(lanes)) } else { None };
        let closed =
            close(leaf.states, leaf.radii, touched, &sums.to_arrays(lanes), parts.as_ref(), self.alpha);
        task.found.accepted += closed.accepted;
        task.found.rejected += met - closed.accepted;
        closed.radii
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
        let [red, green, blue] = match response {
            Some(response) => {
                let power = LaneVec3::splat(lanes, power);
                [
                    lanes.add_where(accepted, red, lanes.mul(response, power.x)),
                    lanes.add_where(accepted, green, lanes.mul(response, power.y)),
                    lanes.add_where(accepted, blue, lanes.mul(response, power.z)),
                ]
            }
            None => [
                lanes.add_same_where(accepted, red, power.x),
                lanes.add_same_where(accepted, green, power.y),
                lanes.add_same_where(accepted, blue, power.z),
            ],
        };
        self.0 = [red, green, blue, lanes.add_same_where(accepted, count, 1.0)];
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

#[cfg(test)]
mod tests {
    use super::super::evenness::{PartSums, TestedState};
    use super::super::photons::Deposits;
    use super::super::statistic::{SingleState, Statistic};
    use super::super::{GatherState, HitPoint, PassSum, received};
    use super::*;
    use crate::bsdf::Coat;
    use crate::bvh::Sphere;
    use crate::math::{Frame, Rng, Stream, Vec3, mean, warp};
    use crate::scene::Receiver;

    fn vector(rng: &mut Rng) -> Vec3 {
        warp::square_to_uniform_sphere(rng.next_vec2())
    }

    /// Hit points with normals of all kinds: alike, leaning, opposite.
    fn hit_point(rng: &mut Rng, smooth: bool) -> HitPoint {
        let ng = if rng.next_f32() < 0.5 { Vec3::Y } else { vector(rng) };
        let ns = if smooth { (ng + 1.5 * rng.next_f32() * vector(rng)).normalize() } else { ng };
        let p = Vec3::new(rng.next_f32(), 0.0, rng.next_f32());
        let receiver = Receiver { p, p_error: 0.0, ng, ns, coat: Coat::NONE };
        HitPoint { receiver, reflectance: Rgb::ONE, pixel: 0, footprint: 0.0 }
    }

    fn deposits(rng: &mut Rng, n: usize) -> Vec<Deposits> {
        let mut chunks: Vec<Deposits> = Vec::new();
        for number in 0..n {
            if number % 300 == 0 {
                chunks.extend([Deposits::default(), Deposits::default()]);
            }
            let Some(chunk) = chunks.last_mut() else { continue };
            let ng = if rng.next_f32() < 0.8 { Vec3::Y } else { vector(rng) };
            let wi = vector(rng);
            let position = Vec3::new(rng.next_f32(), 0.01 * rng.next_f32(), rng.next_f32());
            chunk.positions.push(position);
            chunk.photons.push(Photon { wi, ng, power: Rgb::new(rng.next_f32(), 1e-9, 3e4) });
        }
        chunks
    }

    /// The part of its disc that a photon lies in: the half of the area, and the quadrant.
    fn part(hit_point: &HitPoint, sphere: &Sphere, p: Vec3) -> usize {
        let offset = sphere.center - p;
        let frame = Frame::around(hit_point.receiver.ng);
        let outer = offset.dot(offset) > 0.5 * (sphere.radius * sphere.radius);
        let sides = [outer, offset.dot(frame.tangent) >= 0.0, offset.dot(frame.bitangent) >= 0.0];
        sides.into_iter().fold(0, |part, side| 2 * part + usize::from(side))
    }

    /// What a pass must leave in a hit point: one photon after the other, in f64.
    fn naive<S: Statistic>(hit_point: &HitPoint, sphere: &Sphere, photons: &Photons, alpha: f64) -> S {
        let (mut sum, mut parts) = (PassSum::default(), PartSums::default());
        for (p, photon) in photons.positions().concat().iter().zip(photons.iter()) {
            if let Some(flux) = received(&hit_point.receiver, photon).filter(|_| sphere.contains(*p)) {
                sum.flux += flux.as_dvec3();
                sum.accepted += 1;
                let response = hit_point.receiver.response(photon.wi).unwrap();
                let flux = if hit_point.receiver.ns == hit_point.receiver.ng { 1.0 } else { response }
                    * mean(photon.power);
                parts.flux[part(hit_point, sphere, *p)] += f64::from(flux);
                parts.squares += f64::from(flux * flux);
            }
        }
        let mut state = S::new(f64::from(sphere.radius));
        if sum.accepted > 0 {
            state.after_pass(&sum, &parts, alpha);
        }
        state
    }

    /// Every instruction set against the definition, bit by bit.
    fn assert_lanes_gather_as_defined<S: Statistic + PartialEq>() {
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        for smooth in [false, true] {
            let hit_points: Vec<HitPoint> = (0..500).map(|_| hit_point(&mut rng, smooth)).collect();
            let sphere = |h: &HitPoint| Sphere { center: h.receiver.p, radius: 0.125 };
            let spheres: Vec<Sphere> = hit_points.iter().map(sphere).collect();
            let deposits = deposits(&mut rng, 1000);
            let photons = Photons(deposits.iter().collect());
            let (tree, order) = SphereBvh::build(&spheres);
            let ordered: Vec<HitPoint> = order.iter().map(|&k| hit_points[k as usize]).collect();
            let expected: Vec<S> = ordered.iter().map(|h| naive(h, &sphere(h), &photons, 0.7)).collect();
            assert!(expected.iter().filter(|state| state.state().photons > 2.0).count() > 100);
            for isa in Isa::available() {
                let (mut tree, mut states) = (tree.clone(), vec![S::new(0.125); 500]);
                let facets = Facets::of(&ordered);
                let gatherer =
                    PhotonGatherer { facets: &facets, photons: &photons, alpha: 0.7, state: PhantomData };
                let found = tree.gather_with(isa, &photons.positions(), &mut states, &gatherer);
                assert!(states == expected, "{isa}, smooth: {smooth}");
                let radii = states.iter().map(|state| state.state().radius() as f32);
                assert!(radii.eq(tree.radii().iter().copied()), "{isa}");
                assert!(found.accepted > 1000 && found.rejected > 1000, "{found:?}");
            }
        }
    }

    #[test]
    fn lanes_gather_what_the_definition_says() {
        assert_lanes_gather_as_defined::<GatherState>();
        assert_lanes_gather_as_defined::<SingleState>();
        assert_lanes_gather_as_defined::<TestedState>();
    }
}
