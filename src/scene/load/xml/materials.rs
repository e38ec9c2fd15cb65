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

struct Known {
    surface: Surface,
    /// Its materials by their emission, in the order in which shapes asked for them. None of them before the first shape.
    emitting: Vec<(Rgb, u32)>,
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
        self.known.insert(number, Known { surface, emitting: Vec::new(), first });
    }

    fn push(&mut self, material: Material, line: u32) -> u32 {
        self.list.push(material);
        self.lines.push(line);
        self.list.len() as u32 - 1
    }

    /// The material of a shape of this bsdf and emission. The bsdf's first emission is that of the material of its name.
    pub fn of_shape<'a>(
        &mut self,
        bsdf: Option<&'a Element>,
        emission: Rgb,
        context: &'a Context<'a>,
    ) -> Result<(u32, Surface), SceneError> {
        // As Mitsuba has it, what shines reflects nothing unless it says so.
        let is_black = bsdf.is_none() && emission != Rgb::ZERO;
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
        if let Some((_, material)) = known.emitting.iter().find(|(radiance, _)| *radiance == emission) {
            return Ok((*material, surface));
        }
        let (n, first) = (known.emitting.len(), known.first);
        let material = if n == 0 {
            self.list[first as usize].emission = emission;
            first
        } else {
            let like = &self.list[first as usize];
            let name = format!("{} ({})", like.name, n + 1);
            let line = self.lines[first as usize];
            self.push(Material { name, emission, ..like.clone() }, line)
        };
        if let Some(known) = self.known.get_mut(&number) {
            known.emitting.push((emission, material));
        }
        Ok((material, surface))
    }

    /// The materials and their lines.
    pub fn into_parts(self) -> (Vec<Material>, Vec<u32>) {
        (self.list, self.lines)
    }
}
