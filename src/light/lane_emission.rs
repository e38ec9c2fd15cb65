use super::Lights;
use super::choice::choice;
use super::emitter::{Emitter, Kind};
use crate::math::Vec2;
use crate::simd::{LANES, LaneFrame, LaneVec3, Lanes, Mask, warp};

/// Sixteen [`super::EmissionSample`]s.
#[derive(Clone, Copy)]
pub struct LaneEmission<L: Lanes> {
    /// Where the photons start.
    pub origin: LaneVec3<L>,
    /// Where they go.
    pub dir: LaneVec3<L>,
    /// What they carry.
    pub power: LaneVec3<L>,
}

/// A number of each photon's light.
type Row = [f32; LANES];

/// The lights that sixteen photons leave, in columns.
#[repr(C, align(64))]
struct Sources {
    corners: [[Row; 3]; 3],
    normal: [Row; 3],
    p_error: Row,
    power: [Row; 3],
    points: Mask,
    others: Mask,
}

impl Lights {
    /// [`Lights::sample_emission`] of sixteen photons by the numbers that each draws: two choose the light, coarsely and
    /// finely. Lanes without a light carry no power.
    #[inline(always)]
    pub(crate) fn sample_emissions<L: Lanes>(
        &self,
        lanes: L,
        choice: [L::F32; 2],
        [a, b, c, d]: [L::F32; 4],
    ) -> LaneEmission<L> {
        let [mut coarse, mut fine] = [[0.0; LANES]; 2];
        lanes.store(choice[0], &mut coarse);
        lanes.store(choice[1], &mut fine);
        let sources = self.sources(&coarse, &fine);
        let from_point = warp::square_to_uniform_sphere(lanes, a, b);
        let frame = LaneFrame::around(lanes, LaneVec3::from_arrays(lanes, &sources.normal));
        let from_triangle = frame.to_world(lanes, warp::square_to_cosine_hemisphere(lanes, c, d));
        let emission = LaneEmission {
            origin: sources.origin(lanes, [a, b], from_triangle),
            dir: from_point.or(lanes, sources.points, from_triangle),
            power: LaneVec3::from_arrays(lanes, &sources.power),
        };
        if sources.others == 0 {
            return emission;
        }
        self.with_others(lanes, [coarse, fine], [a, b, c, d], sources.others, emission)
    }

    /// The same with the photons of other lights in their lanes, one by one.
    #[inline(always)]
    fn with_others<L: Lanes>(
        &self,
        lanes: L,
        [coarse, fine]: [Row; 2],
        numbers: [L::F32; 4],
        others: Mask,
        emission: LaneEmission<L>,
    ) -> LaneEmission<L> {
        let [a, b, c, d] = numbers.map(|number| {
            let mut row = [0.0; LANES];
            lanes.store(number, &mut row);
            row
        });
        let (mut origin, mut dir, mut power) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for lane in (0..LANES).filter(|lane| others >> lane & 1 != 0) {
            let chosen = self.choose_emitter(choice(coarse[lane], fine[lane]));
            let Some((emitter @ Emitter { kind: Kind::Other(light), .. }, p)) = chosen else { continue };
            let (place, u) = (Vec2::new(a[lane], b[lane]), Vec2::new(c[lane], d[lane]));
            let photon = emitter.other(light, place, u);
            for axis in 0..3 {
                origin[axis][lane] = photon.origin[axis];
                dir[axis][lane] = photon.dir[axis];
                power[axis][lane] = photon.power[axis] / p;
            }
        }
        LaneEmission {
            origin: LaneVec3::from_arrays(lanes, &origin).or(lanes, others, emission.origin),
            dir: LaneVec3::from_arrays(lanes, &dir).or(lanes, others, emission.dir),
            power: LaneVec3::from_arrays(lanes, &power).or(lanes, others, emission.power),
        }
    }

    fn sources(&self, coarse: &Row, fine: &Row) -> Sources {
        let mut sources = Sources::NONE;
        for (lane, (&coarse, &fine)) in coarse.iter().zip(fine).enumerate() {
            if let Some((emitter, p)) = self.choose_emitter(choice(coarse, fine)) {
                sources.set(lane, emitter, p);
            }
        }
        sources
    }
}

impl Sources {
    const NONE: Sources = Sources {
        corners: [[[0.0; LANES]; 3]; 3],
        normal: [[0.0; LANES]; 3],
        p_error: [0.0; LANES],
        power: [[0.0; LANES]; 3],
        points: 0,
        others: 0,
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, emitter: &Emitter, p: f32) {
        let power = emitter.flux / p;
        for axis in 0..3 {
            for (column, corner) in self.corners.iter_mut().zip(&emitter.corners) {
                column[axis][lane] = corner[axis];
            }
            self.normal[axis][lane] = emitter.frame.normal[axis];
            self.power[axis][lane] = power[axis];
        }
        self.p_error[lane] = emitter.p_error;
        self.points |= Mask::from(matches!(emitter.kind, Kind::Point)) << lane;
        self.others |= Mask::from(matches!(emitter.kind, Kind::Other(_))) << lane;
    }

    /// A point itself, or one of a triangle by the numbers `u`, moved off it to the side of `dir`.
    #[inline(always)]
    fn origin<L: Lanes>(&self, lanes: L, u: [L::F32; 2], dir: LaneVec3<L>) -> LaneVec3<L> {
        let [first, second, third] = &self.corners;
        let (first, second, third) = (
            LaneVec3::from_arrays(lanes, first),
            LaneVec3::from_arrays(lanes, second),
            LaneVec3::from_arrays(lanes, third),
        );
        let (b, c) = warp::square_to_triangle(lanes, u[0], u[1]);
        let a = lanes.sub(lanes.sub(lanes.splat(1.0), b), c);
        let p = first.scaled(lanes, a).add(lanes, second.scaled(lanes, b));
        let p = p.add(lanes, third.scaled(lanes, c));
        let normal = LaneVec3::from_arrays(lanes, &self.normal);
        let offset = lanes.copysign(lanes.load(&self.p_error), normal.dot(lanes, dir));
        let off_surface = p.add(lanes, normal.scaled(lanes, offset));
        first.or(lanes, self.points, off_surface)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Light;
    use super::*;
    use crate::light::{Distant, Environment, Spot};
    use crate::math::{BoundingSphere, Rgb, Rng, Stream, Vec3};
    use crate::simd::{Isa, Kernel};

    struct Emit<'a>(&'a Lights, [Row; 6]);

    impl Kernel for Emit<'_> {
        type Output = [[Row; 3]; 3];

        #[inline(always)]
        fn run<L: Lanes>(self, lanes: L) -> Self::Output {
            let [coarse, a, b, c, d, fine] = &self.1;
            let choice = [lanes.load(coarse), lanes.load(fine)];
            let numbers = [lanes.load(a), lanes.load(b), lanes.load(c), lanes.load(d)];
            let LaneEmission { origin, dir, power } = self.0.sample_emissions(lanes, choice, numbers);
            [origin.to_arrays(lanes), dir.to_arrays(lanes), power.to_arrays(lanes)]
        }
    }

    fn lights() -> Vec<Lights> {
        let point = Light::Point { position: Vec3::new(1.0, -2.0, 3.0), intensity: Rgb::new(5.0, 1.0, 0.0) };
        let corners = [Vec3::ZERO, Vec3::new(2.0, 0.1, 0.0), Vec3::new(0.3, 0.0, 2.0)];
        let triangle = Light::Triangle { corners, radiance: Rgb::new(1.0, 7.0, 3.0) };
        let flipped = Light::Triangle { corners: [corners[0], corners[2], corners[1]], radiance: Rgb::ONE };
        let two = [point.clone(), triangle.clone()];
        let further = further();
        let all: Vec<Light> = two.iter().chain(&further).cloned().chain([flipped.clone()]).collect();
        [vec![], vec![point], vec![triangle, flipped], further, all].into_iter().map(Lights::new).collect()
    }

    fn further() -> Vec<Light> {
        let ball = BoundingSphere { center: Vec3::X, radius: 2.0 };
        let (axis, position) = (Vec3::Y, Vec3::Z);
        let spot = Spot { position, axis, intensity: Rgb::splat(30.0), inner: 0.1, outer: 0.9 };
        vec![
            Light::Spot(spot),
            Light::Distant(Distant { direction: Vec3::NEG_Y, irradiance: Rgb::ONE, ball }),
            Light::Sphere { center: position, radius: 0.7, radiance: Rgb::new(1.0, 3.0, 2.0) },
            Light::Environment(Environment::constant(Rgb::ONE, ball).into()),
        ]
    }

    /// Every instruction set against single photons, bit by bit.
    #[test]
    fn lanes_emit_what_single_photons_are() {
        let rng = |index| Rng::new(8, Stream::Test, 0, index);
        for (lights, isa) in lights().iter().flat_map(|lights| Isa::available().map(move |isa| (lights, isa)))
        {
            for first in (0..3200).step_by(LANES) {
                let mut numbers = [[0.0; LANES]; 6];
                for lane in 0..LANES {
                    let mut rng = rng(first + lane as u64);
                    numbers.iter_mut().for_each(|column| column[lane] = rng.next_f32());
                }
                let columns = isa.run(Emit(lights, numbers));
                for lane in 0..LANES {
                    let at = |column: usize| Vec3::from(columns[column].map(|row| row[lane]));
                    match lights.sample_emission(&mut rng(first + lane as u64)) {
                        Some(e) => assert_eq!([at(0), at(1), at(2)], [e.origin, e.dir, e.power], "{isa}"),
                        None => assert_eq!(at(2), Rgb::ZERO, "{isa}"),
                    }
                }
            }
        }
    }
}
