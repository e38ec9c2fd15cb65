//! `caustica bench --gather` with one more rival: the k-d tree of the crate kiddo, which the program does not carry.

use caustica::bench::gather::{GatherSettings, Radii, measure};
use caustica::bench::structures::{Built, OneByOne, PhotonOrder, PointSearch, RIVALS, Rival};
use caustica::bvh::Sphere;
use caustica::math::Vec3;
use kiddo::{ImmutableKdTree, SquaredEuclidean};

/// A tree over the centers of equal spheres.
struct Kiddo {
    tree: ImmutableKdTree<f32, 3>,
    spheres: Vec<Sphere>,
    /// A little more than r², since the tree may round otherwise than the test of the sphere.
    squared_reach: f32,
}

impl PointSearch for Kiddo {
    fn for_each_containing(&self, p: Vec3, mut visit: impl FnMut(usize)) {
        let point = p.to_array();
        let near = self.tree.query(&point).within::<SquaredEuclidean<f32>>(self.squared_reach);
        near.unsorted().visit(|found| {
            let index = found.item as usize;
            if self.spheres[index].contains(p) {
                visit(index);
            }
        });
    }

    fn memory_bytes(&self) -> Option<usize> {
        None
    }
}

fn build(spheres: &[Sphere]) -> Built {
    let centers: Vec<[f32; 3]> = spheres.iter().map(|sphere| sphere.center.to_array()).collect();
    let radius = spheres.first().map_or(0.0, |sphere| sphere.radius);
    let tree = ImmutableKdTree::new_from_slice(&centers).unwrap_or_else(|error| {
        eprintln!("kiddo cannot build: {error:?}");
        std::process::exit(1)
    });
    let squared_reach = radius * radius * (1.0 + 1e-5);
    Ok(Box::new(OneByOne(Kiddo { tree, spheres: spheres.to_vec(), squared_reach })))
}

fn main() {
    let settings = GatherSettings {
        points: vec![10_000, 100_000, 1_000_000, 4_000_000],
        radii: Radii::Percent(vec![0.05, 0.1, 0.4, 1.0, 5.0]),
        photons: 100_000,
        repetitions: 5,
    };
    let rivals =
        [RIVALS[0], RIVALS[3], RIVALS[4], Rival { name: "kiddo", photons: PhotonOrder::Sorted, build }];
    match measure(&settings, &rivals, |points, percent| eprintln!("{points} spheres of radius {percent} %")) {
        Ok(report) => print!("{}", report.page().to_text()),
        Err(error) => {
            eprintln!("error: {error}");
            std::process::exit(1);
        }
    }
}
