//! Closed surfaces that no light passes, and on which side of them things are.
//!
//! A barrier is a sphere, or triangles that hang together by edges of which each belongs to exactly two of them, all of
//! materials that do not refract. Turned to face alike, such triangles are a cycle, and the winding number of a cycle is
//! constant on each connected part of the space around it. Paths of light end at such surfaces or turn back, so light
//! never goes from where the winding number is one to where it is another.
//!
//! Whatever is not known for certain counts as being on either side: things whose boxes come near a triangle of the
//! barrier, winding numbers that are no whole ones, and everything when the [`EFFORT`] is spent.

use std::cell::{Cell, OnceCell};

use rayon::prelude::*;

use super::contacts::{are_in_one_place, is_clear_of, touches};
use super::faces::{Face, grown};
use super::region::{Region, Side};
use super::sphere_sides::{error_of, side_of_box, side_of_sphere};
use super::surfaces::Surfaces;
use crate::math::{Aabb, Vec3, solid_angle};
use crate::scene::{Item, SphereDesc};

/// Boxes that are looked at before all else counts as unknown: a second's worth.
const EFFORT: u64 = 1 << 27;

/// What a solid angle costs, in boxes.
const ANGLE_EFFORT: u64 = 8;

/// Winding numbers that are no nearer to whole ones are not believed.
const WINDING_ERROR: f64 = 0.01;

/// Faces that one task sums; fixed, so that the order of the sum is.
const CHUNK: usize = 1 << 12;

#[derive(Clone, Copy, PartialEq)]
enum Wall {
    /// One of the opaque parts, which is closed.
    Part(usize),
    Sphere(u32),
}

struct Barrier {
    wall: Wall,
    bounds: Aabb,
    /// Whether nothing that refracts lies in the very same place, so that a ray might meet that instead.
    is_bare: OnceCell<bool>,
}

/// Something that is to be placed among the barriers.
#[derive(Clone, Copy)]
pub(super) enum Thing<'t> {
    /// All of a box.
    Box(Aabb),
    /// The surface of a sphere.
    Sphere(&'t SphereDesc),
    /// Triangles.
    Faces(&'t [Face]),
}

/// All barriers of a scene.
pub(super) struct Barriers<'s> {
    surfaces: &'s Surfaces<'s>,
    all: Vec<Barrier>,
    clear_bounds: Vec<Aabb>,
    effort: Cell<u64>,
}

impl<'s> Barriers<'s> {
    pub fn of(surfaces: &'s Surfaces<'s>) -> Barriers<'s> {
        let Surfaces { scene, triangles, opaque, clear, may_part: _ } = surfaces;
        let barrier = |wall, bounds| Barrier { wall, bounds, is_bare: OnceCell::new() };
        let parts = opaque.parts.iter().enumerate().filter(|(_, part)| part.is_closed);
        let parts = parts
            .map(|(k, part)| barrier(Wall::Part(k), triangles.bounds_of(&opaque.faces[part.faces.clone()])));
        let spheres = scene.spheres().iter().zip(0..).filter(|(sphere, _)| !surfaces.is_clear(sphere));
        let spheres = spheres.map(|(sphere, k)| {
            barrier(Wall::Sphere(k), grown(Aabb::of_sphere(sphere.center, sphere.radius)))
        });
        let clear_bounds =
            clear.parts.iter().map(|part| triangles.bounds_of(&clear.faces[part.faces.clone()])).collect();
        Barriers { surfaces, all: parts.chain(spheres).collect(), clear_bounds, effort: Cell::new(EFFORT) }
    }

    /// As if nothing parted anything.
    pub fn none(surfaces: &'s Surfaces<'s>) -> Barriers<'s> {
        Barriers { surfaces, all: Vec::new(), clear_bounds: Vec::new(), effort: Cell::new(0) }
    }

    /// What a barrier is, or begins with.
    pub fn item(&self, barrier: u32) -> Item {
        match self.all[barrier as usize].wall {
            Wall::Part(_) => Item::Mesh(self.faces(barrier)[0].mesh),
            Wall::Sphere(number) => Item::Sphere(number),
        }
    }

    /// The barrier that an opaque part is, if it is one.
    pub fn of_part(&self, part: usize) -> Option<u32> {
        let number = |barrier: &Barrier| match barrier.wall {
            Wall::Part(number) => number,
            Wall::Sphere(_) => usize::MAX,
        };
        let found = self.all.binary_search_by_key(&part, number).ok()?;
        u32::try_from(found).ok()
    }

    /// Where all of a thing is.
    pub fn region(&self, thing: Thing) -> Region {
        let bounds = grown(match thing {
            Thing::Box(bounds) => bounds,
            Thing::Sphere(sphere) => Aabb::of_sphere(sphere.center, sphere.radius),
            Thing::Faces(faces) => self.surfaces.triangles.bounds_of(faces),
        });
        let mut sides = Vec::new();
        for (barrier, number) in self.all.iter().zip(0..) {
            let Some(side) = self.side(number, barrier, thing, &bounds) else { return Region::Unknown };
            if side != Side::Of(0) {
                sides.push((number, side));
            }
        }
        Region::Known(sides)
    }

    /// `None` when the effort is spent.
    fn side(&self, number: u32, barrier: &Barrier, thing: Thing, bounds: &Aabb) -> Option<Side> {
        self.spend(1)?;
        if !barrier.bounds.overlaps(bounds) {
            return Some(Side::Of(0));
        }
        let side = match (barrier.wall, thing) {
            (Wall::Part(_), _) => self.side_of_part(number, &barrier.bounds, bounds)?,
            (Wall::Sphere(wall), Thing::Sphere(sphere)) => side_of_sphere(self.sphere(wall), sphere),
            (Wall::Sphere(wall), _) => side_of_box(self.sphere(wall), bounds),
        };
        match (side, thing) {
            (Side::Of(0), _) => Some(side),
            (Side::Of(_), _) => Some(if self.is_bare(number) { side } else { Side::Of(0) }),
            (Side::Either, Thing::Faces(faces)) if self.are_outside(faces, &barrier.bounds)? => {
                Some(Side::Of(0))
            }
            (Side::Either, _) => Some(side),
        }
    }

    fn sphere(&self, number: u32) -> &SphereDesc {
        &self.surfaces.scene.spheres()[number as usize]
    }

    /// Whether none comes near the box around a barrier.
    fn are_outside(&self, faces: &[Face], barrier: &Aabb) -> Option<bool> {
        self.spend(faces.len() as u64)?;
        let triangles = &self.surfaces.triangles;
        Some(!faces.par_iter().any(|face| touches(triangles, *face, barrier)))
    }

    /// The winding number is the same in the whole box, where no face comes near it.
    fn side_of_part(&self, number: u32, bounds: &Aabb, thing: &Aabb) -> Option<Side> {
        let (triangles, faces) = (&self.surfaces.triangles, self.faces(number));
        self.spend(faces.len() as u64)?;
        if faces.par_iter().any(|face| touches(triangles, *face, thing)) {
            return Some(Side::Either);
        }
        if !bounds.contains_box(thing) {
            return Some(Side::Of(0));
        }
        Some(whole(self.winding(number, thing.center(), None)?).map_or(Side::Either, Side::Of))
    }

    fn range(&self, barrier: u32) -> std::ops::Range<usize> {
        match self.all[barrier as usize].wall {
            Wall::Part(part) => self.surfaces.opaque.parts[part].faces.clone(),
            Wall::Sphere(_) => 0..0,
        }
    }

    fn faces(&self, barrier: u32) -> &[Face] {
        &self.surfaces.opaque.faces[self.range(barrier)]
    }

    /// How often a part winds around `p`, without one of its faces.
    fn winding(&self, barrier: u32, p: Vec3, without: Option<Face>) -> Option<f64> {
        let (range, opaque) = (self.range(barrier), &self.surfaces.opaque);
        let (faces, turned) = (&opaque.faces[range.clone()], &opaque.turned[range]);
        self.spend(ANGLE_EFFORT * faces.len() as u64)?;
        let angle = |(face, turned): (&Face, &bool)| {
            let angle = solid_angle(self.surfaces.triangles.corners(*face), p);
            if Some(*face) == without {
                0.0
            } else if *turned {
                -angle
            } else {
                angle
            }
        };
        let sum = |(faces, turned): (&[Face], &[bool])| faces.iter().zip(turned).map(angle).sum::<f64>();
        let sums: Vec<f64> = faces.par_chunks(CHUNK).zip(turned.par_chunks(CHUNK)).map(sum).collect();
        Some(sums.iter().sum::<f64>() / (4.0 * std::f64::consts::PI))
    }

    /// The side of its own part to which all of these faces shine: each by its middle, where the winding number is halfway
    /// between those of its sides; if nothing else of the part is before it.
    pub fn front(&self, barrier: u32, lamps: &[Face]) -> Side {
        const MOST: usize = 64;
        let front = || {
            let mut fronts = lamps.iter().map(|lamp| self.front_of(barrier, *lamp));
            let first = fronts.next()??;
            fronts.all(|front| front == Some(first)).then_some(first)
        };
        let known = if lamps.len() <= MOST && self.is_bare(barrier) { front() } else { None };
        known.map_or(Side::Either, Side::Of)
    }

    fn front_of(&self, barrier: u32, lamp: Face) -> Option<i32> {
        let (triangles, faces) = (&self.surfaces.triangles, self.faces(barrier));
        let corners = triangles.corners(lamp);
        self.spend(faces.len() as u64)?;
        let near = triangles.bounds(lamp);
        let mut others =
            faces.iter().filter(|face| **face != lamp && triangles.bounds(**face).overlaps(&near));
        if !others.all(|other| is_clear_of(corners, triangles.corners(*other))) {
            return None;
        }
        let at = faces.iter().position(|face| *face == lamp)?;
        let turned = self.surfaces.opaque.turned[self.range(barrier).start + at];
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let halfway = self.winding(barrier, middle, Some(lamp))?;
        whole(if turned { halfway + 0.5 } else { halfway - 0.5 })
    }

    fn is_bare(&self, barrier: u32) -> bool {
        let Barrier { wall, bounds, is_bare } = &self.all[barrier as usize];
        *is_bare.get_or_init(|| match wall {
            Wall::Sphere(number) => !self.is_doubled(self.sphere(*number)),
            Wall::Part(_) => self.has_no_glass_in_it(barrier, bounds).unwrap_or(false),
        })
    }

    fn is_doubled(&self, wall: &SphereDesc) -> bool {
        let error = 2.0 * error_of(wall);
        let is_there = |sphere: &SphereDesc| {
            let apart = sphere.center.as_dvec3().distance(wall.center.as_dvec3());
            apart <= error && (f64::from(sphere.radius) - f64::from(wall.radius)).abs() <= error
        };
        self.surfaces.scene.spheres().iter().any(|sphere| self.surfaces.is_clear(sphere) && is_there(sphere))
    }

    /// Whether no triangle that refracts lies flat on one of the barrier; `None` when the effort is spent.
    fn has_no_glass_in_it(&self, barrier: u32, bounds: &Aabb) -> Option<bool> {
        let Surfaces { triangles, clear, .. } = self.surfaces;
        self.spend(self.clear_bounds.len() as u64)?;
        for (part, glass) in
            clear.parts.iter().zip(&self.clear_bounds).filter(|(_, glass)| glass.overlaps(bounds))
        {
            let faces = self.faces(barrier);
            self.spend(faces.len() as u64)?;
            let near: Vec<Face> =
                faces.iter().copied().filter(|face| triangles.bounds(*face).overlaps(glass)).collect();
            let panes = &clear.faces[part.faces.clone()];
            self.spend(near.len() as u64 * panes.len() as u64)?;
            let lies_flat = |pane: &Face| near.iter().any(|face| are_in_one_place(triangles, *pane, *face));
            if panes.par_iter().any(lies_flat) {
                return Some(false);
            }
        }
        Some(true)
    }

    fn spend(&self, boxes: u64) -> Option<()> {
        let left = self.effort.get().checked_sub(boxes);
        self.effort.set(left.unwrap_or(0));
        left.map(|_| ())
    }
}

fn whole(winding: f64) -> Option<i32> {
    let nearest = winding.round();
    ((winding - nearest).abs() < WINDING_ERROR).then_some(nearest as i32)
}

#[cfg(test)]
mod tests;
