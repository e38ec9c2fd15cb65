//! What light and the camera can reach: whatever no barrier is known to keep from it.

use std::cell::OnceCell;

use super::barriers::{Barriers, Thing};
use super::faces::Face;
use super::region::{Region, Side};
use super::surfaces::{FreeLights, Object, Shape, Surfaces};
use super::{Effect, EffectSet};
use crate::light::Light;
use crate::math::{Aabb, Vec3};
use crate::scene::{CameraDesc, Item};

/// What something is because of, or why it is not.
pub(super) type Verdict = Result<String, String>;

/// A light with power: one of no surface, the triangles of one piece of surface, or a sphere.
#[derive(Clone, Debug)]
pub(super) struct Source {
    pub item: Item,
    /// Numbers in the order of [`crate::light::Lights::iter`].
    pub lights: Vec<u32>,
    pub effect: Effect,
    region: Region,
}

/// Who can light whom.
pub(super) struct Reach<'s> {
    surfaces: &'s Surfaces<'s>,
    barriers: Barriers<'s>,
    objects: Vec<(Object, OnceCell<Region>)>,
    camera: Region,
    /// The lights that no barrier keeps from the camera's surroundings.
    pub kept: Vec<Source>,
    /// All others, with the reason.
    pub shut_off: Vec<(Source, String)>,
    /// The lights of no surface without power.
    pub dark: Vec<Item>,
}

impl<'s> Reach<'s> {
    pub fn of(surfaces: &'s Surfaces<'s>) -> Reach<'s> {
        let barriers = if surfaces.may_part { Barriers::of(surfaces) } else { Barriers::none(surfaces) };
        let camera = barriers.region(Thing::Box(camera_box(surfaces.scene.view())));
        let objects = surfaces.objects();
        let FreeLights { delta, around, dark } = surfaces.free_lights();
        let source = |(item, light): (Item, Light), rank: u32, effect| {
            let place = light_box(&light, surfaces.scene.bounds());
            Source { item, lights: vec![rank], effect, region: barriers.region(Thing::Box(place)) }
        };
        let first_lamp = delta.len() as u32;
        let points = delta.into_iter().zip(0..);
        let points: Vec<Source> = points.map(|(l, rank)| source(l, rank, Effect::DeltaLight)).collect();
        let mut lamps = lamps(surfaces, &barriers, &objects, first_lamp);
        let first_ball = first_lamp + surfaces.lamps().len() as u32;
        let balls = surfaces.shining_spheres();
        let first_around = first_ball + balls.len() as u32;
        lamps.extend(balls.into_iter().zip(first_ball..).map(|(number, rank)| Source {
            item: Item::Sphere(number),
            lights: vec![rank],
            effect: Effect::AreaLight,
            region: barriers.region(Thing::Sphere(&surfaces.scene.spheres()[number as usize])),
        }));
        let around = around.into_iter().zip(first_around..);
        lamps.extend(around.map(|(l, rank)| source(l, rank, Effect::Environment)));
        let objects = objects.into_iter().map(|object| (object, OnceCell::new())).collect();
        let mut reach =
            Reach { surfaces, barriers, objects, camera, kept: Vec::new(), shut_off: Vec::new(), dark };
        points.into_iter().chain(lamps).for_each(|source| reach.add(source));
        reach
    }

    fn add(&mut self, source: Source) {
        match source.region.barrier(&self.camera) {
            None => self.kept.push(source),
            Some(barrier) => {
                let because = self.shut_off_by(barrier, "from the camera");
                self.shut_off.push((source, because));
            }
        }
    }

    fn shut_off_by(&self, barrier: u32, from: &str) -> String {
        format!("is shut off {from} by {}", self.surfaces.scene.describe(self.barriers.item(barrier)))
    }

    fn region(&self, (object, region): &'s (Object, OnceCell<Region>)) -> &'s Region {
        region.get_or_init(|| {
            self.barriers.region(match object.shape {
                Shape::Sphere(number) => Thing::Sphere(&self.surfaces.scene.spheres()[number]),
                shape => Thing::Faces(self.surfaces.faces(shape)),
            })
        })
    }
}

/// Where a light is that belongs to no surface: from afar, beyond all surfaces.
fn light_box(light: &Light, scene: Aabb) -> Aabb {
    match light {
        Light::Point { position, .. } => Aabb::of_points([*position]),
        Light::Spot(spot) => Aabb::of_points([spot.position]),
        Light::Distant(_) | Light::Environment(_) if scene.is_empty() => Aabb::of_points([Vec3::ZERO]),
        Light::Distant(_) | Light::Environment(_) => {
            let beyond = scene.max + 2.0 * (scene.max - scene.min) + scene.max.abs() + 1.0;
            Aabb::of_points([beyond])
        }
        Light::Triangle { .. } | Light::Sphere { .. } => scene,
    }
}

fn camera_box(camera: &CameraDesc) -> Aabb {
    let CameraDesc { position, look_at: _, up: _, fov_degrees: _, lens_radius, focus_distance: _ } = camera;
    let reach = Vec3::splat(*lens_radius);
    Aabb::of_points([*position - reach, *position + reach])
}

/// The lights with an extent, piece by piece.
fn lamps(surfaces: &Surfaces, barriers: &Barriers, objects: &[Object], first: u32) -> Vec<Source> {
    let all = surfaces.lamps();
    let shining = objects.iter().filter(|object| object.effects.contains(Effect::Emission));
    let source = |object: &Object| {
        let place = |face: &Face| all.binary_search(face).ok();
        let faces: Vec<Face> =
            surfaces.faces(object.shape).iter().copied().filter(|face| place(face).is_some()).collect();
        let region = barriers.region(Thing::Faces(&faces));
        Some(Source {
            item: Item::Mesh(faces.first()?.mesh),
            lights: faces.iter().filter_map(place).map(|place| first + place as u32).collect(),
            effect: Effect::AreaLight,
            region: before_own_barrier(barriers, object, &faces, region),
        })
    };
    shining.filter_map(source).collect()
}

/// Lamps shine from their front alone: those on a barrier to one of its sides.
fn before_own_barrier(barriers: &Barriers, object: &Object, lamps: &[Face], region: Region) -> Region {
    let own = match object.shape {
        Shape::Opaque(part) => barriers.of_part(part),
        Shape::Clear(_) | Shape::Sphere(_) => None,
    };
    match own.map(|barrier| (barrier, barriers.front(barrier, lamps))) {
        Some((barrier, side @ Side::Of(_))) => region.moved(barrier, side),
        _ => region,
    }
}

/// What is asked of a piece of surface, and what there is not if no piece has it.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// Any of these.
    pub effects: &'static [Effect],
    pub absent: &'static str,
}

impl Wanted {
    /// The first of the effects that is there.
    fn found_in(&self, effects: EffectSet) -> Option<Effect> {
        self.effects.iter().copied().find(|effect| effects.contains(*effect))
    }
}

impl Reach<'_> {
    /// The first surface that the camera may see, directly or not.
    pub fn seen(&self, wanted: Wanted) -> Verdict {
        self.first(wanted, |region| match region.barrier(&self.camera) {
            None => Ok(()),
            Some(barrier) => Err(self.shut_off_by(barrier, "from the camera")),
        })
    }

    /// The first surface that the camera may see and that a light reaches which it may see, too.
    pub fn lit(&self, wanted: Wanted) -> Verdict {
        self.first(wanted, |region| {
            if let Some(barrier) = region.barrier(&self.camera) {
                return Err(self.shut_off_by(barrier, "from the camera"));
            }
            let mut between = self.kept.iter().map(|source| source.region.barrier(region));
            match between.next() {
                None => Err("no light reaches it".into()),
                Some(None) => Ok(()),
                Some(Some(_)) if between.any(|barrier| barrier.is_none()) => Ok(()),
                Some(Some(barrier)) => Err(self.shut_off_by(barrier, "from all light")),
            }
        })
    }

    /// The first surface that the camera may see or that a light reaches.
    pub fn reached(&self, wanted: Wanted) -> Verdict {
        let is_lit = |region: &Region| self.kept.iter().any(|source| source.region.meets(region));
        self.first(wanted, |region| match region.barrier(&self.camera) {
            Some(barrier) if !is_lit(region) => Err(self.shut_off_by(barrier, "from camera and light")),
            _ => Ok(()),
        })
    }

    /// The first light of a kind that the camera's surroundings may get light from.
    pub fn light(&self, effects: &[Effect], absent: &str) -> Verdict {
        let describe = |source: &Source| self.surfaces.scene.describe(source.item);
        if let Some(source) = self.kept.iter().find(|source| effects.contains(&source.effect)) {
            return Ok(describe(source));
        }
        let shut_off = self.shut_off.iter().find(|(source, _)| effects.contains(&source.effect));
        Err(shut_off
            .map_or_else(|| absent.into(), |(source, because)| format!("{} {because}", describe(source))))
    }

    /// The first wanted surface that `is_there`; else why the first of them is not.
    fn first(&self, wanted: Wanted, is_there: impl Fn(&Region) -> Result<(), String>) -> Verdict {
        let mut why_not = None;
        for entry in &self.objects {
            let Some(effect) = wanted.found_in(entry.0.effects) else { continue };
            match is_there(self.region(entry)) {
                Ok(()) => return Ok(self.surfaces.describe(&entry.0, effect)),
                Err(reason) => {
                    why_not.get_or_insert_with(|| {
                        format!("{} {reason}", self.surfaces.describe(&entry.0, effect))
                    });
                }
            }
        }
        Err(why_not.unwrap_or_else(|| wanted.absent.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Distant;
    use crate::math::{BoundingSphere, Rgb};

    /// On all axes by more than the scene is wide, also where it lies far from the origin.
    #[test]
    fn light_from_afar_is_outside_of_all_surfaces() {
        let ball = BoundingSphere { center: Vec3::ZERO, radius: 1.0 };
        let light = Light::Distant(Distant { direction: Vec3::X, irradiance: Rgb::ONE, ball });
        for (min, max) in [
            (Vec3::new(-3.0, -2.0, 1.0), Vec3::new(-1.0, 4.0, 2.0)),
            (Vec3::splat(1e6), Vec3::splat(1e6 + 1.0)),
            (Vec3::splat(-1e6), Vec3::splat(-1e6 + 1.0)),
        ] {
            let afar = light_box(&light, Aabb { min, max });
            assert!(afar.min == afar.max && afar.min.cmpgt(max + 2.0 * (max - min)).all(), "{afar:?}");
            assert!((afar.min - max).cmpge(max.abs()).all(), "{afar:?}");
        }
        assert_eq!(light_box(&light, Aabb::EMPTY), Aabb::of_points([Vec3::ZERO]));
    }

    #[test]
    fn a_camera_is_as_large_as_its_lens() {
        let pinhole = CameraDesc::pinhole(Vec3::new(1.0, 2.0, 3.0), Vec3::ZERO, 40.0);
        let Aabb { min, max } = camera_box(&CameraDesc { lens_radius: 0.5, ..pinhole });
        assert_eq!((min, max), (Vec3::new(0.5, 1.5, 2.5), Vec3::new(1.5, 2.5, 3.5)));
    }
}
