//! The objects of a scene and their properties: whatever no one asks for is refused by name.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::DAffine2;

use super::super::super::{SceneError, Textures};
use super::super::access::Reader;
use super::super::affine::Affine;
use super::super::fields::{Allowed, unknown_name};
use super::element::Element;
use super::transform;
use crate::math::{DVec3, Rgb, Vec3};
use crate::texture::Texture;

/// The tags of objects; all others are properties.
const OBJECTS: [&str; 13] = [
    "scene",
    "integrator",
    "sensor",
    "sampler",
    "film",
    "rfilter",
    "bsdf",
    "shape",
    "emitter",
    "texture",
    "medium",
    "phase",
    "volume",
];

/// What reading an XML scene takes everywhere.
pub(super) struct Context<'a> {
    pub reader: &'a Reader<'a>,
    ids: BTreeMap<&'a str, &'a Element>,
    warnings: RefCell<Vec<String>>,
    /// What files say that a picture here does not depend on.
    unused: RefCell<BTreeSet<String>>,
}

impl<'a> Context<'a> {
    pub fn new(reader: &'a Reader<'a>, scene: &'a Element) -> Result<Context<'a>, SceneError> {
        let mut ids = BTreeMap::new();
        collect_ids(scene, &mut ids)?;
        Ok(Context { reader, ids, warnings: RefCell::default(), unused: RefCell::default() })
    }

    pub fn warn(&self, element: &Element, text: &str) {
        self.warnings.borrow_mut().push(element.place.told(text));
    }

    /// Adds lines that name their place themselves.
    pub fn warn_all(&self, lines: impl IntoIterator<Item = String>) {
        self.warnings.borrow_mut().extend(lines);
    }

    /// Notes that a part of the file is of no use here.
    pub fn has_no_use(&self, what: String) {
        self.unused.borrow_mut().insert(what);
    }

    /// All warnings; the last of them lists what was of no use.
    pub fn into_warnings(self, scene: &Element) -> Vec<String> {
        let mut warnings = self.warnings.into_inner();
        let unused = Vec::from_iter(self.unused.into_inner());
        if !unused.is_empty() {
            warnings.push(scene.place.told(&format!("read, but of no use here: {}", unused.join(", "))));
        }
        warnings
    }

    /// Refuses what the core has no counterpart for; a lenient reader goes on without, and says what the picture `lacks`.
    pub fn unsupported(&self, element: &Element, reason: &str, lacks: &str) -> Result<(), SceneError> {
        if !self.reader.lenient() {
            return Err(element.error(reason));
        }
        self.warn(element, &format!("{reason}; {lacks}"));
        Ok(())
    }

    /// The object that an element is or refers to.
    pub fn resolved(&self, element: &'a Element) -> Result<&'a Element, SceneError> {
        if element.tag != "ref" {
            return Ok(element);
        }
        element.only(&["name", "id"])?;
        let id = element.required("id", "the id of an object")?;
        let known = || self.ids.keys().copied().collect::<Vec<_>>();
        self.ids
            .get(id)
            .copied()
            .ok_or_else(|| element.error(format!("ref: unknown id {}", unknown_name(id, &known()))))
    }
}

fn collect_ids<'a>(element: &'a Element, ids: &mut BTreeMap<&'a str, &'a Element>) -> Result<(), SceneError> {
    for child in element.children.iter().filter(|child| OBJECTS.contains(&child.tag.as_str())) {
        if let Some(id) = child.attribute("id")
            && let Some(first) = ids.insert(id, child)
        {
            let reason =
                format!("id `{id}` is that of line {}, too; allowed: each id once", first.place.line);
            return Err(child.error(reason));
        }
        collect_ids(child, ids)?;
    }
    Ok(())
}

/// An object whose properties are asked for by name; [`Object::finish`] refuses the rest.
pub(super) struct Object<'a> {
    pub element: &'a Element,
    pub context: &'a Context<'a>,
    used: Vec<Cell<bool>>,
    /// Pictures that properties had.
    textures: RefCell<Textures>,
    pub to_uv: Cell<Option<DAffine2>>,
}

impl<'a> Object<'a> {
    pub fn new(element: &'a Element, context: &'a Context<'a>) -> Result<Object<'a>, SceneError> {
        element.only(&["type", "id", "name"])?;
        let mut names: Vec<&str> =
            element.children.iter().filter_map(|child| child.attribute("name")).collect();
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(element.error(format!(
                "{}: `{}` is given twice; allowed: once",
                element.label(),
                twice[0]
            )));
        }
        Ok(Object {
            element,
            context,
            used: vec![Cell::new(false); element.children.len()],
            textures: RefCell::default(),
            to_uv: Cell::default(),
        })
    }

    /// The kind of object: its attribute `type`.
    pub fn kind(&self) -> Result<&'a str, SceneError> {
        self.element.required("type", "the kind of the object")
    }

    pub fn error(&self, reason: impl std::fmt::Display) -> SceneError {
        self.element.error(format!("{}: {reason}", self.element.label()))
    }

    /// The child of that name, which counts as read from here on.
    pub fn take(&self, name: &str) -> Option<&'a Element> {
        let at = self.element.children.iter().position(|child| child.attribute("name") == Some(name))?;
        self.used[at].set(true);
        Some(&self.element.children[at])
    }

    /// The children that are objects of this tag, by reference or in place, which count as read.
    pub fn objects(&self, tag: &str) -> Result<Vec<&'a Element>, SceneError> {
        let mut found = Vec::new();
        for (child, used) in self.element.children.iter().zip(&self.used) {
            let object = self.context.resolved(child)?;
            if object.tag == tag && OBJECTS.contains(&tag) {
                used.set(true);
                found.push(object);
            }
        }
        Ok(found)
    }

    /// The one child object of this tag, if there is one.
    pub fn object(&self, tag: &str) -> Result<Option<&'a Element>, SceneError> {
        match self.objects(tag)?[..] {
            [] => Ok(None),
            [one] => Ok(Some(one)),
            [_, second, ..] => {
                Err(second.error(format!("{}: a second <{tag}>; allowed: one", self.element.label())))
            }
        }
    }

    /// This program's own note in the object, if there is one.
    pub fn own_note(&self) -> Option<&'a Element> {
        let at = self.element.children.iter().position(Element::is_own)?;
        self.used[at].set(true);
        Some(&self.element.children[at])
    }

    /// Passes over properties that say nothing about the scene, and notes them.
    pub fn has_no_use_for(&self, names: &[&str]) {
        for name in names.iter().filter(|name| self.take(name).is_some()) {
            self.context.has_no_use(format!("{} `{name}`", self.element.tag));
        }
    }

    /// The pictures that were met so far.
    pub fn textures(&self) -> Textures {
        self.textures.borrow().clone()
    }

    /// The map of texture coordinates that all pictures share.
    pub fn to_uv(&self) -> DAffine2 {
        self.to_uv.get().unwrap_or(DAffine2::IDENTITY)
    }

    /// Notes the picture in the place of the object's colour, and gives its largest value.
    pub fn color_picture(&self, texture: Arc<Texture>) -> Rgb {
        let largest = texture.max();
        self.textures.borrow_mut().color = Some(texture);
        largest
    }

    /// Notes the picture in the place of the object's roughness, and gives its largest value.
    pub fn roughness_picture(&self, texture: Arc<Texture>) -> f32 {
        let largest = texture.max().x;
        self.textures.borrow_mut().roughness = Some(texture);
        largest
    }

    /// Refuses the first child that no one asked for.
    pub fn finish(&self) -> Result<(), SceneError> {
        for (child, _) in self.element.children.iter().zip(&self.used).filter(|(_, used)| !used.get()) {
            let what = match child.attribute("name") {
                Some(name) => format!("<{}> `{name}`", child.tag),
                None => child.label(),
            };
            let reason = format!("{}: {what} is not supported", self.element.label());
            self.context.unsupported(child, &reason, "the picture lacks what it would change")?;
        }
        Ok(())
    }

    fn wrong(&self, property: &Element, allowed: &str) -> SceneError {
        let name = property.attribute("name").unwrap_or_default();
        let value = property.attribute("value").map_or(String::new(), |value| format!(" of value `{value}`"));
        property.error(format!(
            "{}: `{name}` is a <{}>{value}; allowed: {allowed}",
            self.element.label(),
            property.tag
        ))
    }

    /// The value of a property of one of the tags.
    fn value(
        &self,
        name: &str,
        tags: &[&str],
        allowed: &str,
    ) -> Result<Option<(&'a Element, &'a str)>, SceneError> {
        let Some(property) = self.take(name) else { return Ok(None) };
        if !tags.contains(&property.tag.as_str()) {
            return Err(self.wrong(property, allowed));
        }
        property.only(&["name", "value"])?;
        Ok(Some((property, property.required("value", allowed)?)))
    }

    pub fn optional_f64(&self, name: &str, allowed: &Allowed) -> Result<Option<f64>, SceneError> {
        let words = format!("<float>, {}", allowed.text);
        let Some((property, value)) = self.value(name, &["float", "integer"], &words)? else {
            return Ok(None);
        };
        let number = value.trim().parse::<f64>().ok().filter(|&x| (allowed.holds)(x));
        number.map(Some).ok_or_else(|| self.wrong(property, &words))
    }

    pub fn f64(&self, name: &str, default: f64, allowed: &Allowed) -> Result<f64, SceneError> {
        Ok(self.optional_f64(name, allowed)?.unwrap_or(default))
    }

    pub fn integer(&self, name: &str, (low, high): (u64, u64)) -> Result<Option<u64>, SceneError> {
        let words = format!("<integer>, from {low} to {high}");
        let Some((property, value)) = self.value(name, &["integer"], &words)? else { return Ok(None) };
        let number = value.trim().parse::<u64>().ok().filter(|n| (low..=high).contains(n));
        number.map(Some).ok_or_else(|| self.wrong(property, &words))
    }

    pub fn boolean(&self, name: &str) -> Result<bool, SceneError> {
        const WORDS: &str = "<boolean>, true or false";
        let Some((property, value)) = self.value(name, &["boolean"], WORDS)? else { return Ok(false) };
        match value.trim().to_lowercase().as_str() {
            "true" => Ok(true),
            "false" => Ok(false),
            _ => Err(self.wrong(property, WORDS)),
        }
    }

    pub fn string(&self, name: &str) -> Result<Option<&'a str>, SceneError> {
        Ok(self.value(name, &["string"], "<string>")?.map(|(_, value)| value))
    }

    /// One of the words, `default` where there is none.
    pub fn choice<'w>(&self, name: &str, default: &'w str, words: &[&'w str]) -> Result<&'w str, SceneError> {
        let Some(value) = self.string(name)? else { return Ok(default) };
        let lower = value.to_lowercase();
        words
            .iter()
            .find(|word| **word == lower)
            .copied()
            .ok_or_else(|| self.error(format!("`{name}`: unknown name {}", unknown_name(value, words))))
    }

    /// A <point> or <vector>.
    pub fn vector(&self, name: &str, allowed: &Allowed) -> Result<Option<DVec3>, SceneError> {
        let Some(property) = self.take(name) else { return Ok(None) };
        if !["point", "vector"].contains(&property.tag.as_str()) {
            return Err(self.wrong(property, "<point> or <vector>"));
        }
        property.only(&["name", "value", "x", "y", "z"])?;
        let vector = transform::components(property, DVec3::ZERO)?;
        if !vector.to_array().into_iter().all(|x| (allowed.holds)(x)) {
            return Err(property.error(format!("`{name}` is {vector}; allowed: each {}", allowed.text)));
        }
        Ok(Some(vector))
    }

    /// The <transform> of that name; identity without one.
    pub fn transform(&self, name: &str) -> Result<Affine, SceneError> {
        let Some(property) = self.take(name) else { return Ok(Affine::IDENTITY) };
        if property.tag != "transform" {
            return Err(self.wrong(property, "<transform>"));
        }
        transform::read(property)
    }

    /// A point in the world that is traced: within the bounds of coordinates.
    pub fn placed(&self, p: DVec3) -> Result<Vec3, SceneError> {
        let placed = p.as_vec3();
        if super::super::geometry::is_traceable(placed) {
            return Ok(placed);
        }
        Err(self.error(format!("stands at {p}; allowed: coordinates from -1.8e18 to 1.8e18")))
    }
}
