//! Where the hit points and the photons of a gathering come from: the walls of a box, or a real render.

use super::BenchError;
use crate::effects::PathClass;
use crate::math::{Rng, Stream, Vec3};
use crate::ppm::{HitPoints, PhotonBatch, PhotonPass, Settings, camera_pass};
use crate::scene::Scene;

/// Hit points, and photons among them.
#[derive(Clone, Copy)]
pub enum Source<'s> {
    /// Both uniform on the six walls of the unit box.
    Walls,
    /// Those of the first pass of a render.
    Render(Rendered<'s>),
}

/// A scene to take hit points and photons from.
#[derive(Clone, Copy)]
pub struct Rendered<'s> {
    /// The scene.
    pub scene: &'s Scene,
    /// What reports and errors call it.
    pub name: &'s str,
    /// The render; its samples and its photons are as many as a measurement asks for.
    pub settings: Settings,
}

/// Eye samples a pixel beyond which a picture is too small for the hit points asked for.
const MOST_SAMPLES: usize = 4096;

const POINT_KEY: u32 = 0;
const PHOTON_KEY: u32 = 1;

impl Source<'_> {
    /// What radii are percentages of, in scene units: the longest side of the box, or of the one around the scene.
    pub fn extent(&self) -> f64 {
        match self {
            Source::Walls => 1.0,
            Source::Render(render) => f64::from(render.scene.bounds().extent().max_element()),
        }
    }

    /// `count` hit points, in the order in which an eye pass leaves them.
    ///
    /// # Errors
    /// If the picture has no room for so many.
    pub fn points(&self, count: usize) -> Result<Vec<Vec3>, BenchError> {
        match self {
            Source::Walls => Ok(on_walls(count, POINT_KEY)),
            Source::Render(render) => Ok(evenly(&render.hit_points(count)?, count)),
        }
    }

    /// The photons: `count` of them on walls; in a render those that `count` emitted ones leave.
    ///
    /// # Errors
    /// If there is none.
    pub fn photons(&self, count: usize) -> Result<Vec<Vec3>, BenchError> {
        match self {
            Source::Walls => Ok(on_walls(count, PHOTON_KEY)),
            Source::Render(render) => render.photons(count as u64),
        }
    }
}

impl Rendered<'_> {
    /// At least `count`, by hardly more eye samples a pixel than it takes.
    fn hit_points(&self, count: usize) -> Result<HitPoints, BenchError> {
        let mut samples = 1;
        loop {
            let settings = Settings { samples: samples as u32, ..self.settings };
            let hit_points = camera_pass::trace(self.scene, &settings, 0).hit_points;
            let found = hit_points.len();
            if found >= count {
                return Ok(hit_points);
            }
            if found == 0 || samples == MOST_SAMPLES {
                let scene = self.name.to_owned();
                return Err(BenchError::TooFewHitPoints { scene, samples, found, asked: count });
            }
            samples = (samples * count).div_ceil(found).clamp(samples + 1, MOST_SAMPLES);
        }
    }

    fn photons(&self, emitted: u64) -> Result<Vec<Vec3>, BenchError> {
        let settings = Settings { photons: emitted, ..self.settings };
        let positions = all_positions(PhotonPass::default().trace(self.scene, &settings, 0));
        if positions.is_empty() {
            Err(BenchError::NoPhotons { scene: self.name.into() })
        } else {
            Ok(positions)
        }
    }
}

/// Where photons of all kinds lie.
fn all_positions(batch: &PhotonBatch) -> Vec<Vec3> {
    PathClass::ALL.into_iter().flat_map(|class| batch.of(class).positions().concat()).collect()
}

/// `count` of them at equal distances in their order, which is that of the picture.
fn evenly(hit_points: &HitPoints, count: usize) -> Vec<Vec3> {
    (0..count).map(|k| hit_points.get(k * hit_points.len() / count).receiver.p).collect()
}

/// Points on the walls of the unit box, uniform in area; every `key` gives others.
pub fn on_walls(count: usize, key: u32) -> Vec<Vec3> {
    let point = |index| {
        let mut rng = Rng::new(1, Stream::Test, key, index);
        let mut p = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
        let wall = rng.next_u32() % 6;
        p[wall as usize / 2] = (wall % 2) as f32;
        Vec3::from_array(p)
    };
    (0..count as u64).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::super::ray_scenes::room;
    use super::*;
    use crate::math::Rgb;
    use crate::scene::SceneDesc;

    fn with_room(edit: impl Fn(&mut SceneDesc), look: impl Fn(Rendered)) {
        let mut desc = room(500, 100);
        (desc.film.width, desc.film.height) = (16, 12);
        edit(&mut desc);
        let scene = Scene::new(desc).unwrap();
        let settings = Settings::of_scene(scene.render());
        look(Rendered { scene: &scene, name: "room", settings });
    }

    #[test]
    fn hit_points_come_from_hardly_more_samples_than_it_takes() {
        with_room(
            |_| (),
            |render| {
                let of_one_sample = render.hit_points(1).unwrap().len();
                for count in [1, of_one_sample, of_one_sample + 1, 2000] {
                    let found = render.hit_points(count).unwrap();
                    assert!((count..count + 2 * of_one_sample).contains(&found.len()), "{}", found.len());
                    let points = Source::Render(render).points(count).unwrap();
                    assert_eq!((points.len(), points[0]), (count, found.get(0).receiver.p));
                }
            },
        );
    }

    #[test]
    fn a_subset_is_even_in_the_order_of_the_picture() {
        with_room(
            |_| (),
            |render| {
                let all = render.hit_points(192).unwrap();
                let third: Vec<usize> = evenly(&all, all.len() / 3)
                    .iter()
                    .map(|&p| all.iter().position(|h| h.receiver.p == p).unwrap())
                    .collect();
                assert!(third.windows(2).all(|pair| (3..=4).contains(&(pair[1] - pair[0]))), "{third:?}");
                assert_eq!(evenly(&all, all.len()).len(), all.len());
            },
        );
    }

    #[test]
    fn photons_are_those_of_the_first_pass() {
        with_room(
            |_| (),
            |render| {
                let mut pass = PhotonPass::default();
                let settings = Settings { photons: 300, ..render.settings };
                let batch = pass.trace(render.scene, &settings, 0);
                assert_eq!(batch.ledger.emitted, 300);
                assert_eq!(Source::Render(render).photons(300).unwrap(), all_positions(batch));
            },
        );
    }

    #[test]
    fn radii_are_percentages_of_the_longest_side() {
        assert_eq!(Source::Walls.extent(), 1.0);
        with_room(
            |desc| desc.meshes[0].vertices[0].y -= 5.0,
            |render| {
                assert_eq!(Source::Render(render).extent(), 7.0);
            },
        );
    }

    #[test]
    fn a_picture_without_hit_points_says_so() {
        with_room(
            |desc| desc.camera.look_at.z = 100.0,
            |render| {
                let text = Source::Render(render).points(10).unwrap_err().to_string();
                assert!(text.starts_with("room: 1 eye samples a pixel leave 0 of 10 hit points"), "{text}");
            },
        );
    }

    #[test]
    fn a_picture_too_small_for_the_points_says_so() {
        with_room(
            |desc| (desc.film.width, desc.film.height) = (1, 1),
            |render| {
                let text = Source::Render(render).points(100_000).unwrap_err().to_string();
                assert!(text.starts_with("room: 4096 eye samples a pixel leave "), "{text}");
            },
        );
    }

    #[test]
    fn darkness_has_no_photons() {
        with_room(
            |desc| desc.materials.iter_mut().for_each(|material| material.emission = Rgb::ZERO),
            |render| {
                let error = Source::Render(render).photons(10).unwrap_err();
                assert_eq!(error, BenchError::NoPhotons { scene: "room".into() });
            },
        );
    }
}
