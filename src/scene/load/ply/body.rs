//! The elements of a PLY file: vertices and faces; what others there are is passed over.

use super::fault::Fault;
use super::header::{Element, Header, Property};
use super::values::Values;
use crate::math::{Vec2, Vec3};
use crate::scene::load::fields::COORDINATE;
use crate::scene::load::geometry::{Geometry, is_traceable};
use crate::scene::load::polygon::{too_concave, triangulate};

/// What a property of a vertex or a face is read for.
#[derive(Clone, Copy)]
enum Column {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Corners,
    Unused,
}

pub(super) struct Body<'h, V> {
    header: &'h Header,
    values: V,
    geometry: Geometry,
    /// The corners of the face that is being read.
    ring: Vec<u32>,
}

impl<'h, V: Values> Body<'h, V> {
    pub fn new(header: &'h Header, values: V) -> Body<'h, V> {
        Body { header, values, geometry: Geometry::default(), ring: Vec::new() }
    }

    pub fn read(mut self) -> Result<Geometry, Fault> {
        let named = |name: &str| self.header.elements.iter().position(|element| element.name == name);
        let (Some(vertices), faces) = (named("vertex"), named("face")) else {
            return Err(whole("no element `vertex`; allowed: a mesh of vertices and faces"));
        };
        if named("tristrips").is_some() {
            return Err(whole("`tristrips` are not supported; allowed: an element `face`"));
        }
        if faces.is_some_and(|faces| faces < vertices) {
            return Err(whole("faces stand before the vertices; allowed: behind them"));
        }
        for (number, element) in self.header.elements.iter().enumerate() {
            match number {
                n if n == vertices => self.vertices(element)?,
                n if Some(n) == faces => self.faces(element)?,
                _ => self.pass_over(element)?,
            }
        }
        Ok(self.geometry)
    }

    /// How many items are worth making room for: never more than the file can hold.
    fn room(&self, element: &Element) -> usize {
        let most = self.values.most_left() / element.properties.len().max(1);
        usize::try_from(element.count).unwrap_or(usize::MAX).min(most)
    }

    fn vertices(&mut self, element: &Element) -> Result<(), Fault> {
        let columns: Vec<Column> = element.properties.iter().map(vertex_column).collect();
        let has = |name: &str| element.properties.iter().any(|p| p.name == name && p.count.is_none());
        if let Some(missing) = ["x", "y", "z"].into_iter().find(|name| !has(name)) {
            return Err(whole(&format!("vertices have no `{missing}`; allowed: `x`, `y` and `z`")));
        }
        let has_normals = ["nx", "ny", "nz"].into_iter().all(has);
        self.geometry.vertices.reserve_exact(self.room(element));
        let has_uvs =
            element.properties.iter().filter(|p| matches!(vertex_column(p), Column::Uv(_))).count() == 2;
        let mut uvs = Vec::with_capacity(if has_uvs { self.room(element) } else { 0 });
        let mut normals = Vec::with_capacity(if has_normals { self.room(element) } else { 0 });
        for _ in 0..element.count {
            let (mut position, mut normal, mut uv) = (Vec3::ZERO, Vec3::ZERO, Vec2::ZERO);
            for (property, column) in element.properties.iter().zip(&columns) {
                match *column {
                    Column::Position(axis) => position[axis] = self.values.real(property.kind)?,
                    Column::Normal(axis) => normal[axis] = self.values.real(property.kind)?,
                    Column::Uv(axis) => uv[axis] = self.values.real(property.kind)?,
                    Column::Corners | Column::Unused => self.pass_over_one(property)?,
                }
            }
            if !is_traceable(position) {
                let outside = position.to_array().into_iter().find(|x| !(COORDINATE.holds)(f64::from(*x)));
                let reason = format!(
                    "vertex coordinate {}; allowed: {}",
                    outside.unwrap_or(f32::NAN),
                    COORDINATE.text
                );
                return Err(self.values.fault(reason));
            }
            self.geometry.vertices.push(position);
            if has_normals {
                normals.push(normal);
            }
            if has_uvs {
                uvs.push(uv);
            }
        }
        self.geometry.normals = has_normals.then_some(normals);
        self.geometry.uvs = has_uvs.then_some(uvs);
        Ok(())
    }

    fn faces(&mut self, element: &Element) -> Result<(), Fault> {
        let columns: Vec<Column> = element.properties.iter().map(face_column).collect();
        if !columns.iter().any(|column| matches!(column, Column::Corners)) {
            return Err(whole("faces have no list `vertex_indices` or `vertex_index`; allowed: one of them"));
        }
        self.geometry.triangles.reserve_exact(self.room(element));
        for _ in 0..element.count {
            for (property, column) in element.properties.iter().zip(&columns) {
                match column {
                    Column::Corners => self.face(property)?,
                    _ => self.pass_over_one(property)?,
                }
            }
        }
        Ok(())
    }

    fn face(&mut self, property: &Property) -> Result<(), Fault> {
        let n_vertices = self.geometry.vertices.len();
        self.ring.clear();
        for _ in 0..self.length(property)? {
            let index = self.values.whole(property.kind)?;
            let valid = u32::try_from(index).ok().filter(|&index| (index as usize) < n_vertices);
            let Some(valid) = valid else {
                let most = n_vertices.saturating_sub(1);
                let reason = format!("vertex index {index} is out of range; allowed: 0 to {most}");
                return Err(self.values.fault(reason));
            };
            self.ring.push(valid);
        }
        match self.ring[..] {
            [a, b, c] => self.geometry.triangles.push([a, b, c]),
            [_, _, _, _, ..] => self.polygon()?,
            _ => self.geometry.ignored += 1,
        }
        Ok(())
    }

    fn polygon(&mut self) -> Result<(), Fault> {
        let corners: Vec<Vec3> = self.ring.iter().map(|&i| self.geometry.vertices[i as usize]).collect();
        let Some(cut) = triangulate(&corners) else {
            return Err(self.values.fault(too_concave()));
        };
        self.geometry.triangles.extend(cut.into_iter().map(|triangle| triangle.map(|i| self.ring[i])));
        Ok(())
    }

    /// How many values a list has.
    fn length(&mut self, list: &Property) -> Result<u64, Fault> {
        let Some(kind) = list.count else { return Ok(1) };
        let length = self.values.whole(kind)?;
        u64::try_from(length)
            .map_err(|_| self.values.fault(format!("list of {length} values; allowed: 0 or more")))
    }

    fn pass_over(&mut self, element: &Element) -> Result<(), Fault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for _ in 0..element.count {
            element.properties.iter().try_for_each(|property| self.pass_over_one(property))?;
        }
        Ok(())
    }

    fn pass_over_one(&mut self, property: &Property) -> Result<(), Fault> {
        for _ in 0..self.length(property)? {
            self.values.real(property.kind)?;
        }
        Ok(())
    }
}

fn vertex_column(property: &Property) -> Column {
    match property.name.as_str() {
        _ if property.count.is_some() => Column::Unused,
        "x" => Column::Position(0),
        "y" => Column::Position(1),
        "z" => Column::Position(2),
        "nx" => Column::Normal(0),
        "ny" => Column::Normal(1),
        "nz" => Column::Normal(2),
        "u" | "s" | "texture_u" => Column::Uv(0),
        "v" | "t" | "texture_v" => Column::Uv(1),
        _ => Column::Unused,
    }
}

fn face_column(property: &Property) -> Column {
    match property.name.as_str() {
        "vertex_indices" | "vertex_index" if property.count.is_some() => Column::Corners,
        _ => Column::Unused,
    }
}

fn whole(reason: &str) -> Fault {
    Fault { line: None, reason: reason.to_owned() }
}
