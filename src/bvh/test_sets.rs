//! Spheres and points that the tests share, from kindly to degenerate.

use proptest::prelude::*;

use super::Sphere;
use super::sphere_bvh::LEAF_SIZE;
use crate::math::{Rng, Stream, Vec3};

/// Where centres lie.
#[derive(Clone, Copy, Debug)]
pub(super) enum Layout {
    Cube,
    Clusters,
    Plane,
    Line,
    Point,
}

/// How large spheres are; centres spread over about one unit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Radii {
    Equal(f32),
    Mixed,
}

fn random_vec3(rng: &mut Rng) -> Vec3 {
    Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32())
}

impl Layout {
    fn center(self, rng: &mut Rng) -> Vec3 {
        let p = random_vec3(rng);
        match self {
            Layout::Cube => p,
            Layout::Clusters => {
                let corner = rng.next_u32() % 8;
                0.003 * p + Vec3::new((corner & 1) as f32, (corner & 2) as f32, (corner & 4) as f32)
            }
            Layout::Plane => p.with_y(0.7),
            Layout::Line => Vec3::new(p.x, 0.2, -0.4),
            Layout::Point => Vec3::new(0.3, 0.6, 0.1),
        }
    }
}

impl Radii {
    fn radius(self, rng: &mut Rng) -> f32 {
        match self {
            Radii::Equal(radius) => radius,
            Radii::Mixed => match rng.next_u32() % 256 {
                0 => 1e-30,
                1 => 0.0,
                2 => 10.0,
                3 => 1e25,
                k => 0.2 * (k as f32 / 256.0).powi(6),
            },
        }
    }
}

/// `n` spheres, a pure function of the arguments.
pub(super) fn spheres(layout: Layout, radii: Radii, n: usize, seed: u64) -> Vec<Sphere> {
    let sphere = |index| {
        let mut rng = Rng::new(seed, Stream::Test, 0, index);
        Sphere { center: layout.center(&mut rng), radius: radii.radius(&mut rng) }
    };
    (0..n as u64).map(sphere).collect()
}

/// `n` points: centres, points on and near the surfaces, points anywhere, and a NaN now and then.
pub(super) fn points_around(spheres: &[Sphere], n: usize, seed: u64) -> Vec<Vec3> {
    let point = |index| {
        let mut rng = Rng::new(seed, Stream::Test, 1, index);
        let anywhere = 2.0 * random_vec3(&mut rng) - 0.5;
        let Some(sphere) = spheres.get(rng.next_u32() as usize % spheres.len().max(1)) else {
            return anywhere;
        };
        match rng.next_u32() % 8 {
            0 => sphere.center,
            1 => sphere.center + sphere.radius * Vec3::X,
            2 => sphere.center - sphere.radius * Vec3::Z,
            3 if index % 16 == 0 => Vec3::new(0.5, f32::NAN, 0.5),
            3..6 => sphere.center + 2.0 * sphere.radius.min(1.0) * (random_vec3(&mut rng) - 0.5),
            _ => anywhere,
        }
    };
    (0..n as u64).map(point).collect()
}

/// Spheres of any layout and size, in numbers around those where leaves and levels begin.
pub(super) fn sphere_set() -> impl Strategy<Value = Vec<Sphere>> {
    let layouts = [Layout::Cube, Layout::Clusters, Layout::Plane, Layout::Line, Layout::Point];
    let radii = [1e-30, 0.0, 0.003, 0.1, 3.0].map(Radii::Equal);
    let radii = prop::sample::select([radii.as_slice(), &[Radii::Mixed; 5]].concat());
    let edges =
        prop::sample::select(vec![0, 1, 2, LEAF_SIZE - 1, LEAF_SIZE, LEAF_SIZE + 1, 2 * LEAF_SIZE + 1]);
    let n = prop_oneof![edges, 0usize..300];
    (prop::sample::select(layouts.to_vec()), radii, n, any::<u64>())
        .prop_map(|(layout, radii, n, seed)| spheres(layout, radii, n, seed))
}

/// Runs `work` in a pool of its own.
pub(super) fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}
