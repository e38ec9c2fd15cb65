//! Where discs lie on a surface as a whole.
//!
//! Theory has the bias of light that is smooth over a disc. Where a disc hangs over an edge or reaches into a corner, half of its photons may be
//! missing however small it is, and what falls is the number of such points.

use crate::math::{Frame, Ray, Vec3};
use crate::ppm::{Settings, camera_pass};
use crate::scene::{Receiver, Scene};

/// Pixels in which all discs of `radius` lie flat, and those of their neighbours; of each, one eye path is looked at.
pub fn flat_pixels(scene: &Scene, settings: &Settings, radius: f64) -> Vec<bool> {
    let (width, height) = (scene.film().width as usize, scene.film().height as usize);
    let points = camera_pass::trace(scene, &Settings { samples: 1, ..*settings }, 0).hit_points;
    let found = points.map(|point| (point.pixel as usize, is_flat(scene, &point.receiver, radius as f32)));
    let mut discs = vec![[0, 0]; width * height];
    found.into_iter().for_each(|(pixel, is_flat)| discs[pixel][usize::from(is_flat)] += 1);
    let is_flat = |pixel: usize| discs[pixel][0] == 0 && discs[pixel][1] > 0;
    let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
    let with_neighbours = |pixel: usize| {
        around(pixel / width, height).all(|y| around(pixel % width, width).all(|x| is_flat(y * width + x)))
    };
    (0..width * height).map(with_neighbours).collect()
}

/// Directions in which a disc is looked at.
const DIRECTIONS: u8 = 16;

/// What rises or falls by less than this share of the radius is flat.
const RELIEF: f32 = 1.0 / 16.0;

/// Whether nothing stands on the disc, and the surface goes on below it.
fn is_flat(scene: &Scene, receiver: &Receiver, radius: f32) -> bool {
    let frame = Frame::around(receiver.ng);
    let above = receiver.p + RELIEF * radius * receiver.ng;
    (0..DIRECTIONS).all(|k| {
        let (sin, cos) = (std::f32::consts::TAU * f32::from(k) / f32::from(DIRECTIONS)).sin_cos();
        let dir = cos * frame.tangent + sin * frame.bitangent;
        let along = Ray { origin: above, dir, t_max: radius };
        let goes_on = |share: f32| lies_below(scene, above + share * radius * dir, receiver.ng, radius);
        !scene.occluded(&along) && goes_on(1.0) && goes_on(0.5)
    })
}

fn lies_below(scene: &Scene, origin: Vec3, normal: Vec3, radius: f32) -> bool {
    let down = Ray { origin, dir: -normal, t_max: 2.0 * RELIEF * radius };
    scene.intersect(&down).is_some_and(|hit| hit.ng.dot(normal).abs() > 0.95)
}

#[cfg(test)]
mod tests {
    use super::super::testing::desc;
    use super::*;

    /// A floor of 4 x 4 that meets a wall at z = -2 and ends at its three other sides.
    #[test]
    fn discs_near_corners_and_edges_are_not_flat() {
        let scene = Scene::new(desc()).unwrap();
        let at = |x: f32, z: f32, radius: f32| {
            let down = Ray::new(Vec3::new(x, 1.0, z), Vec3::NEG_Y);
            let hit = scene.intersect(&down).unwrap();
            is_flat(&scene, &scene.receiver(&hit), radius)
        };
        assert!(at(0.0, 0.0, 1.9) && !at(0.0, 0.0, 2.1));
        assert!(at(0.3, -1.6, 0.39) && !at(0.3, -1.6, 0.41), "the corner");
        assert!(at(0.3, 1.6, 0.39) && !at(0.3, 1.6, 0.41), "the edge");
    }

    #[test]
    fn pixels_are_flat_with_their_neighbours() {
        let scene = Scene::new(desc()).unwrap();
        let settings = Settings::of_scene(scene.render());
        let flat = |radius: f64| flat_pixels(&scene, &settings, radius);
        let count = |flat: &[bool]| flat.iter().filter(|flat| **flat).count();
        let (small, large) = (flat(0.05), flat(0.5));
        assert!(small.iter().zip(&large).all(|(small, large)| *small || !large));
        assert!(count(&large) < count(&small) && count(&small) < 64, "{} {}", count(&large), count(&small));
        assert_eq!(count(&flat(9.0)), 0);
    }

    /// What sees no surface has no disc.
    #[test]
    fn the_sky_is_not_flat() {
        let mut away = desc();
        away.camera.look_at = away.camera.position + Vec3::Z;
        let scene = Scene::new(away).unwrap();
        let flat = flat_pixels(&scene, &Settings::of_scene(scene.render()), 0.1);
        assert!(flat.len() == 64 && flat.iter().all(|flat| !flat));
    }
}
