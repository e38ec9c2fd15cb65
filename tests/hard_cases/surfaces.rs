//! Triangles and normals that are none.

use caustica::bsdf::Bsdf;
use caustica::film::Image;
use caustica::math::{Ray, Rgb, Vec3};
use caustica::ppm::Settings;
use caustica::scene::{Mesh, Scene, SceneDesc, Traversal};
use rayon::ThreadPoolBuilder;

use crate::rooms::{TRAVERSALS, by_both_traversals, dark, floor, lit_box, mesh, quad, rendered};

fn picture_of(scene: &Scene) -> Image {
    rendered(scene, Settings::of_scene(scene.render())).0.picture()
}

fn pictures(desc: &SceneDesc) -> [Image; 2] {
    by_both_traversals(desc).map(|scene| picture_of(&scene))
}

/// Triangles without area (a corner twice, corners on a line, all corners the same) change no bit of the picture, and rays aimed at
/// them meet the wall behind.
///
/// Breaks: hits without a normal, NaN pixels, photons that go nowhere.
/// Mutation: `RayBvhBuilder` keeping triangles without area, and `Sheared::meeting` taking them for met at a corner.
#[test]
fn triangles_without_area_are_not_there() {
    let [a, b, c] = [Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 0.0, -0.5), Vec3::new(0.0, 0.0, -0.5)];
    let nothing = mesh(vec![a, b, c], vec![[0, 1, 1], [0, 1, 2], [2, 2, 2], [0, 2, 1]], 0);
    let mut desc = lit_box();
    let without = pictures(&desc);
    desc.meshes.push(nothing);
    assert_eq!(pictures(&desc), without);
    for scene in by_both_traversals(&desc) {
        for k in 0..=64 {
            let ray =
                Ray::new(Vec3::new(0.0, 0.0, 0.5), a.lerp(b, k as f32 / 64.0) - Vec3::new(0.0, 0.0, 0.5));
            assert!(scene.intersect(&ray).is_some_and(|hit| hit.p.z < -0.9 && hit.ng.is_finite()), "{ray:?}");
        }
    }
}

/// Of two surfaces in the same place one is seen, and always the same on any number of threads.
///
/// Breaks: speckles that change from run to run.
/// Mutation: the thread's number added to the seed of photons.
#[test]
fn one_of_two_coincident_surfaces_wins_on_any_number_of_threads() {
    let mut desc = lit_box();
    desc.materials
        .extend([Rgb::X, Rgb::Z].map(|color| dark("coloured", Bsdf::Diffuse { albedo: 0.7 * color })));
    desc.meshes.extend([floor(-0.5, 0.5, 1), floor(-0.5, 0.5, 2)]);
    for traversal in TRAVERSALS {
        let on_threads = |threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| picture_of(&Scene::with_traversal(desc.clone(), traversal).unwrap()))
        };
        let one = on_threads(1);
        assert!([2, 7].iter().all(|&threads| on_threads(threads) == one), "{traversal}");
    }
}

/// The tree of the project gives a tie to the surface that the scene names first, wherever it is hit.
///
/// Breaks: which of two surfaces is seen hangs on the order in which the tree was walked.
/// Mutation: ties in `RayBvh` go to the later primitive.
#[test]
fn the_first_of_coincident_surfaces_wins() {
    let mut desc = lit_box();
    desc.materials.push(dark("second", Bsdf::Diffuse { albedo: Rgb::Z }));
    desc.meshes = vec![floor(-0.5, 0.5, 0), floor(-0.5, 0.5, 1)];
    let first_alone = SceneDesc { meshes: vec![floor(-0.5, 0.5, 0)], ..desc.clone() };
    let [both, first] =
        [desc, first_alone].map(|desc| picture_of(&Scene::with_traversal(desc, Traversal::Custom).unwrap()));
    assert_eq!(both, first);
}

fn with_normals(mut mesh: Mesh, normal: Vec3) -> Mesh {
    mesh.normals = Some(vec![normal; mesh.vertices.len()]);
    mesh
}

/// Vertex normals that are zero, NaN or infinite leave the flat look: the geometric normal stands in.
///
/// Breaks: NaN pixels, or black ones where a loader wrote `vn 0 0 0`.
/// Mutation: `seen_normal` returning the shading normal, whatever it is.
#[test]
fn normals_that_are_none_give_way_to_the_true_surface() {
    let flat = pictures(&lit_box());
    for normal in [Vec3::ZERO, Vec3::NAN, Vec3::splat(f32::INFINITY)] {
        let mut desc = lit_box();
        desc.meshes = desc.meshes.into_iter().map(|mesh| with_normals(mesh, normal)).collect();
        assert_eq!(pictures(&desc), flat, "{normal}");
    }
}

/// A thin wall whose shading normals point along it, or backwards, lets no light through.
///
/// Breaks: light leaks to the other side of smooth walls, as bright seams at their terminators.
/// Mutation: `SurfaceHit::continue_along` going on whichever side the direction is on.
#[test]
fn no_light_leaks_through_wild_normals() {
    let wall =
        quad([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[y, z]| Vec3::new(0.0, y, z)), 1);
    for bsdf in [Bsdf::Diffuse { albedo: Rgb::splat(0.9) }, Bsdf::Mirror { reflectance: Rgb::ONE }] {
        for normal in [Vec3::new(0.05, 1.0, 0.0), Vec3::NEG_X, Vec3::X, Vec3::new(-0.3, 0.0, 1.0)] {
            let mut desc = lit_box();
            desc.materials.push(dark("wall", bsdf));
            desc.meshes.push(with_normals(wall.clone(), normal.normalize()));
            desc.point_lights[0].position = Vec3::new(-0.5, 0.3, 0.1);
            // At the wall's foot discs would reach beneath it.
            desc.camera.position = Vec3::new(0.3, 0.0, 0.5);
            desc.camera.look_at = Vec3::new(1.0, -0.2, 0.0);
            desc.camera.fov_degrees = 40.0;
            for image in pictures(&desc) {
                assert!(image.pixels().iter().all(|&p| p == Rgb::ZERO), "{bsdf:?} {normal}");
            }
        }
    }
}
