//! Balls around the surfaces that cast caustics.

use super::{Scene, Surface};
use crate::math::{Aabb, BoundingSphere, Vec3};

/// Most balls around the casters of a scene.
const MOST: usize = 16;

/// Slabs of a group along each axis, between which it may be cut.
const BINS: usize = 16;

/// One ball around a group is kept where those around its parts are no smaller than this together, by the square of the
/// radius: flat surfaces lose nothing by being cut, and lights near them gain.
const WHOLE: f64 = 1.2;

impl Scene {
    /// At most 16 balls around all surfaces with a specular lobe and all masks, each of them wholly inside of one: what light must meet
    /// first to cast a caustic. None where there is no such surface.
    ///
    /// They look small from afar: groups are cut where the squares of the parts' radii sum to the least, and joined again where
    /// that does not pay. Linear in the number of triangles.
    pub fn casters(&self) -> Vec<BoundingSphere> {
        let mut items: Vec<Item> =
            self.surfaces.iter().flat_map(|surface| self.casters_of(surface)).collect();
        if items.is_empty() { Vec::new() } else { group(&mut items) }
    }

    fn casters_of<'a>(&'a self, surface: &'a Surface) -> Box<dyn Iterator<Item = Item> + 'a> {
        let casts = |material: u32| {
            let material = &self.materials[material as usize];
            material.bsdf.is_specular() || material.is_mask()
        };
        match surface {
            Surface::Mesh(mesh, _) => Box::new(
                (0..mesh.triangles.len())
                    .filter(move |&k| casts(mesh.materials[k]))
                    .map(|k| Item::new(mesh.corners(k), 0.0)),
            ),
            Surface::Spheres(spheres) => Box::new(
                spheres
                    .iter()
                    .filter(move |sphere| casts(sphere.material))
                    .map(|sphere| Item::new([sphere.center; 3], sphere.radius)),
            ),
        }
    }
}

/// A triangle, or a ball where all corners are its centre.
#[derive(Clone, Copy, Debug)]
struct Item {
    corners: [Vec3; 3],
    radius: f32,
    center: Vec3,
}

impl Item {
    fn new(corners: [Vec3; 3], radius: f32) -> Item {
        Item { corners, radius, center: Aabb::of_points(corners).center() }
    }

    fn bounds(&self) -> Aabb {
        let points = Aabb::of_points(self.corners);
        Aabb { min: points.min - self.radius, max: points.max + self.radius }
    }
}

/// Items that one ball may stand for, or two parts of them.
struct Group<'a> {
    items: &'a mut [Item],
    ball: BoundingSphere,
    /// Around the centres of the items.
    centers: Aabb,
}

fn ball(items: &[Item]) -> BoundingSphere {
    BoundingSphere::around(items.iter().flat_map(|item| item.corners.map(|corner| (corner, item.radius))))
}

fn size(ball: &BoundingSphere) -> f64 {
    f64::from(ball.radius).powi(2)
}

/// A group that was cut, and its parts.
enum Tree {
    Whole(BoundingSphere),
    Cut(BoundingSphere, usize, usize),
}

/// Cuts the largest group until there are enough, then chooses which cuts to keep.
fn group(items: &mut [Item]) -> Vec<BoundingSphere> {
    let whole = Group::new(items);
    let mut tree = vec![Tree::Whole(whole.ball)];
    let mut open = vec![(0, whole)];
    for _ in 1..MOST {
        let largest = open.iter().enumerate().filter(|(_, (_, group))| group.can_be_cut());
        let Some((place, _)) = largest.max_by(|a, b| size(&a.1.1.ball).total_cmp(&size(&b.1.1.ball))) else {
            break;
        };
        let (node, whole) = open.swap_remove(place);
        let parts = tree.len();
        tree[node] = Tree::Cut(whole.ball, parts, parts + 1);
        let (left, right) = whole.cut();
        tree.extend([Tree::Whole(left.ball), Tree::Whole(right.ball)]);
        open.extend([(parts, left), (parts + 1, right)]);
    }
    best(&tree, 0).1
}

/// The balls that stand for a node, and the sum of their squared radii.
fn best(tree: &[Tree], node: usize) -> (f64, Vec<BoundingSphere>) {
    match &tree[node] {
        Tree::Whole(ball) => (size(ball), vec![*ball]),
        Tree::Cut(whole, left, right) => {
            let ((left_size, mut balls), (right_size, others)) = (best(tree, *left), best(tree, *right));
            if WHOLE * size(whole) <= left_size + right_size {
                return (size(whole), vec![*whole]);
            }
            balls.extend(others);
            (left_size + right_size, balls)
        }
    }
}

impl<'a> Group<'a> {
    fn new(items: &'a mut [Item]) -> Group<'a> {
        let (ball, centers) = (ball(items), Aabb::of_points(items.iter().map(|item| item.center)));
        Group { items, ball, centers }
    }

    fn can_be_cut(&self) -> bool {
        self.centers.extent().max_element() > 0.0
    }

    /// Where the boxes of both parts have the least diagonals, by their squares; some item is in each part.
    fn cut(self) -> (Group<'a>, Group<'a>) {
        let bins = Bins::over(&self.centers);
        let costs = bins.costs(self.items);
        let cuts = (0..3).flat_map(|axis| (0..BINS - 1).map(move |last| (axis, last)));
        let cuts = cuts.filter(|&(axis, _)| self.centers.extent()[axis] > 0.0);
        let cheapest = cuts.min_by(|a, b| costs[a.0][a.1].total_cmp(&costs[b.0][b.1]));
        let middle =
            cheapest.map_or(1, |(axis, last)| partition(self.items, |item| bins.of(item)[axis] <= last));
        let (left, right) = self.items.split_at_mut(middle.clamp(1, self.items.len() - 1));
        (Group::new(left), Group::new(right))
    }
}

/// Equally wide slabs across all axes.
struct Bins {
    first: Vec3,
    bins_a_unit: Vec3,
}

impl Bins {
    fn over(centers: &Aabb) -> Bins {
        // Flat boxes have one bin, and infinitely many a unit.
        Bins { first: centers.min, bins_a_unit: BINS as f32 / centers.extent() }
    }

    /// 0/0 is in the first.
    fn of(&self, item: &Item) -> [usize; 3] {
        let bins = (item.center - self.first) * self.bins_a_unit;
        bins.to_array().map(|bin| (bin as usize).min(BINS - 1))
    }

    /// Of a cut behind each bin of each axis.
    fn costs(&self, items: &[Item]) -> [[f32; BINS]; 3] {
        let mut boxes = [[Aabb::EMPTY; BINS]; 3];
        for item in items {
            let bounds = item.bounds();
            for (bins, bin) in boxes.iter_mut().zip(self.of(item)) {
                bins[bin] = bins[bin].union(bounds);
            }
        }
        boxes.each_ref().map(costs)
    }
}

fn costs(boxes: &[Aabb; BINS]) -> [f32; BINS] {
    let (mut left, mut right, mut costs) = (Aabb::EMPTY, Aabb::EMPTY, [0.0; BINS]);
    for (k, bin) in boxes.iter().enumerate() {
        left = left.union(*bin);
        costs[k] += left.extent().length_squared();
    }
    for k in (1..BINS).rev() {
        right = right.union(boxes[k]);
        costs[k - 1] += right.extent().length_squared();
    }
    costs
}

/// Moves those for which `first` holds to the front, and tells how many they are.
fn partition(items: &mut [Item], first: impl Fn(&Item) -> bool) -> usize {
    let mut count = 0;
    for k in 0..items.len() {
        if first(&items[k]) {
            items.swap(k, count);
            count += 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, SceneDesc};
    use std::path::Path;

    fn desc(name: &str) -> SceneDesc {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
        scene::load(&path).unwrap()
    }

    fn scene(name: &str) -> Scene {
        Scene::new(desc(name)).unwrap()
    }

    /// Every item is inside of some ball wholly: a triangle is where its corners are, since balls are convex.
    fn assert_covered(scene: &Scene, balls: &[BoundingSphere]) {
        let items = scene.surfaces.iter().flat_map(|surface| scene.casters_of(surface));
        for item in items {
            let inside = |ball: &BoundingSphere| {
                let reach = |corner: Vec3| {
                    corner.as_dvec3().distance(ball.center.as_dvec3()) + f64::from(item.radius)
                };
                item.corners.iter().all(|&corner| reach(corner) <= f64::from(ball.radius))
            };
            assert!(balls.iter().any(inside), "{item:?}");
        }
    }

    #[test]
    fn balls_are_bounded_one_by_one() {
        let scene = scene("course_balls.toml");
        let mut balls = scene.casters();
        assert_covered(&scene, &balls);
        balls.sort_by(|a, b| a.center.x.total_cmp(&b.center.x));
        assert_eq!(balls.len(), 2, "{balls:?}");
        assert!((balls[0].center - Vec3::new(-22.5, 16.5, 0.0)).length() < 1e-3);
        assert!((16.5..16.51).contains(&balls[0].radius));
    }

    #[test]
    fn water_is_cut_into_patches() {
        // As in the course's water scene.
        let mut desc = desc("course_balls.toml");
        let refracting = desc.spheres[1].material;
        let mut water = scene::water::surface_mesh(64);
        water.vertices.iter_mut().for_each(|p| *p = 120.0 * *p + 50.0 * Vec3::Y);
        water.materials.fill(refracting);
        desc.meshes.push(water);
        let scene = Scene::new(desc).unwrap();
        let balls = scene.casters();
        assert_covered(&scene, &balls);
        assert!((8..=MOST).contains(&balls.len()), "{balls:?}");
        let light = Vec3::new(0.0, 108.0, 0.0);
        assert!(balls.iter().all(|ball| !ball.contains(light)), "{balls:?}");
    }

    /// Cutting the mesh of a ball would only leave larger balls around its parts.
    #[test]
    fn a_tessellated_ball_stays_whole() {
        let mut rng = crate::math::Rng::new(1, crate::math::Stream::Test, 0, 0);
        let mut on_ball = || crate::math::warp::square_to_uniform_sphere(rng.next_vec2());
        let mut items: Vec<Item> = (0..500)
            .map(|_| {
                let p = on_ball();
                let corners = [0, 1, 2].map(|_| (p + 0.05 * on_ball()).normalize());
                Item::new(corners, 0.0)
            })
            .collect();
        let balls = group(&mut items);
        assert!(balls.len() == 1 && balls[0].radius < 1.05, "{balls:?}");
    }

    #[test]
    fn equal_items_cannot_be_cut() {
        let item = Item::new([Vec3::ONE; 3], 0.5);
        assert_eq!(group(&mut [item; 3]).len(), 1);
        assert!(scene("course_diffuse.toml").casters().is_empty());
    }
}
