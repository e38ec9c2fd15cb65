//! The materials of a scene: bsdfs together with the light that shapes give them.

use std::collections::BTreeMap;

use super::super::super::{Material, SceneError};
use super::bsdfs::{self, Surface};
use super::element::Element;
use super::object::Context;
use crate::math::Rgb;

/// The number of the bsdf of shapes that shine and have none.
const BLACK: usize = usize::MAX;

/// In the order of the file: top-level bsdfs, then what shapes bring along.
#[derive(Default)]
pub(super) struct Materials {
    list: Vec<Material>,
    lines: Vec<u32>,
    /// Of each bsdf that was read, by its number; 0 is that of shapes without one.
    known: BTreeMap<usize, Known>,
}

/// What a shape adds to its bsdf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Added {
    pub emission: Rgb,
    /// Of what lies inside.
    pub absorption: Rgb,
}

struct Known {
    surface: Surface,
    /// Its materials by what shapes add, in the order in which they asked for them. None of them before the first shape.
    of_shapes: Vec<(Added, u32)>,
    /// The material that waits for the first shape.
    first: u32,
}

impl Materials {
    /// Reads a bsdf of the scene that shapes may refer to.
    pub fn declare<'a>(&mut self, element: &'a Element, context: &'a Context<'a>) -> Result<(), SceneError> {
        let surface = bsdfs::read(element, context)?;
        let noted =
            element.children.iter().find(|child| child.is_own()).and_then(|note| note.attribute("name"));
        let nameless = || format!("{} in line {}", element.label(), element.place.line);
        let name = noted.or(element.attribute("id")).map_or_else(nameless, str::to_owned);
        self.add(element.number, name, surface, element.place.main_line);
        Ok(())
    }

    fn add(&mut self, number: usize, name: String, surface: Surface, line: usize) {
        let first = self.push(
            Material {
                textures: surface.textures.clone(),
                opacity: surface.opacity,
                ..Material::plain(name, surface.bsdf, Rgb::ZERO)
            },
            line as u32,
        );
        self.known.insert(number, Known { surface, of_shapes: Vec::new(), first });
    }

    fn push(&mut self, material: Material, line: u32) -> u32 {
        self.list.push(material);
        self.lines.push(line);
        self.list.len() as u32 - 1
    }

    /// The material of a shape of this bsdf, with what the shape adds. What the first one adds is that of the material of its name.
    pub fn of_shape<'a>(
        &mut self,
        bsdf: Option<&'a Element>,
        added: Added,
        context: &'a Context<'a>,
    ) -> Result<(u32, Surface), SceneError> {
        // As Mitsuba has it, what shines reflects nothing unless it says so.
        let is_black = bsdf.is_none() && added.emission != Rgb::ZERO;
        let number = bsdf.map_or(if is_black { BLACK } else { 0 }, |bsdf| bsdf.number);
        if !self.known.contains_key(&number) {
            match bsdf {
                Some(bsdf) => self.declare(bsdf, context)?,
                None if is_black => self.add(number, String::from("(black)"), Surface::black(), 0),
                None => self.add(number, String::from("(none)"), Surface::DEFAULT, 0),
            }
        }
        let Some(known) = self.known.get_mut(&number) else { return Ok((0, Surface::DEFAULT)) };
        let surface = known.surface.clone();
        if let Some((_, material)) = known.of_shapes.iter().find(|(of_shape, _)| *of_shape == added) {
            return Ok((*material, surface));
        }
        let (n, first) = (known.of_shapes.len(), known.first);
        let Added { emission, absorption } = added;
        let material = if n == 0 {
            let material = &mut self.list[first as usize];
            (material.emission, material.absorption) = (emission, absorption);
            first
        } else {
            let like = &self.list[first as usize];
            let name = format!("{} ({})", like.name, n + 1);
            let line = self.lines[first as usize];
            self.push(Material { name, emission, absorption, ..like.clone() }, line)
        };
        if let Some(known) = self.known.get_mut(&number) {
            known.of_shapes.push((added, material));
        }
        Ok((material, surface))
    }

    /// The materials and their lines.
    pub fn into_parts(self) -> (Vec<Material>, Vec<u32>) {
        (self.list, self.lines)
    }
}
