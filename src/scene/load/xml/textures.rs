//! `<texture type="bitmap">`: pictures on surfaces, and where on them they lie.

use std::sync::Arc;

use glam::DAffine2;

use super::super::super::SceneError;
use super::element::Element;
use super::object::{Context, Object};
use crate::texture::{Encoding, Texture};

/// A picture, and the map of texture coordinates before it is looked up.
struct Bitmap {
    texture: Texture,
    to_uv: DAffine2,
}

impl Object<'_> {
    /// The picture in the place of a property, which counts as read; none where there is a constant or nothing.
    pub fn picture(&self, name: &str) -> Result<Option<Arc<Texture>>, SceneError> {
        let given = self.element.children.iter().find(|child| child.attribute("name") == Some(name));
        let picture = given.map(|given| self.context.resolved(given)).transpose()?;
        let Some(picture) = picture.filter(|picture| picture.tag == "texture") else { return Ok(None) };
        let Some(Bitmap { texture, to_uv }) = bitmap(picture, self.context)? else {
            return Ok(None);
        };
        self.take(name);
        if self.to_uv.replace(Some(to_uv)).is_some_and(|other| other != to_uv) {
            return Err(self.error("its pictures have different `to_uv`; allowed: the same of all"));
        }
        Ok(Some(Arc::new(texture)))
    }
}

/// The picture of a texture; none where it is of another kind and the reader is lenient.
fn bitmap<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<Option<Bitmap>, SceneError> {
    let object = Object::new(element, context)?;
    let kind = object.kind()?;
    if kind != "bitmap" {
        let reason = format!("texture `{kind}` is not supported; allowed: `bitmap`");
        context.unsupported(element, &reason, "the picture has a constant instead")?;
        return Ok(None);
    }
    let missing = || object.error("`filename` is missing; allowed: the path of an EXR, PNG or JPEG");
    let name = object.string("filename")?.ok_or_else(missing)?;
    for (name, only) in [("filter_type", "bilinear"), ("wrap_mode", "repeat")] {
        object.choice(name, only, &[only])?;
    }
    let encoding = if object.boolean("raw")? { Encoding::Plain } else { Encoding::Colour };
    let to_uv = flat_map(&object)?;
    object.finish()?;
    let path = context.reader.beside_scene(name);
    let picture = context.reader.picture_at(&path, encoding);
    let picture = picture.map_err(|reason| object.error(format!("`{name}`: {reason}")))?;
    let texture = Texture::new(path.display().to_string(), picture).map(|new| new.of_file(path, encoding));
    let texture = texture
        .ok_or_else(|| object.error(format!("`{name}` holds what is no number; allowed: finite values")))?;
    if texture.max().max_element() > 1.0 || texture.min().min_element() < 0.0 {
        return Err(object.error(format!("`{name}` reaches {}; allowed: values from 0 to 1", texture.max())));
    }
    Ok(Some(Bitmap { texture, to_uv }))
}

/// `to_uv`, as far as it keeps to the plane of texture coordinates.
fn flat_map(object: &Object) -> Result<DAffine2, SceneError> {
    let map = object.transform("to_uv")?.0;
    let [x, y] = [map.matrix3.x_axis, map.matrix3.y_axis];
    let flat = DAffine2::from_cols(x.truncate(), y.truncate(), map.translation.truncate());
    if x.z != 0.0 || y.z != 0.0 || flat.matrix2.determinant() == 0.0 {
        return Err(object.error("`to_uv` leaves the plane of x and y or flattens it; allowed: <scale> and <translate> in x and y, <rotate z=\"1\" .../>"));
    }
    Ok(flat)
}

#[cfg(test)]
mod tests {
    use super::super::testing::fails;

    #[test]
    fn what_is_no_bitmap_of_ours_is_refused() {
        let textured = |texture: &str| format!("<bsdf type='diffuse'>\n{texture}</bsdf>");
        for (texture, words) in [
            (
                "<texture name='reflectance' type='checkerboard'/>",
                "texture `checkerboard` is not supported; allowed: `bitmap`",
            ),
            ("<texture name='reflectance' type='bitmap'/>", "`filename` is missing"),
            (
                "<texture name='reflectance' type='bitmap'><string name='filename' value='no.png'/></texture>",
                "`no.png`: cannot be read",
            ),
            (
                "<texture name='reflectance' type='bitmap'><string name='filename' value='a'/><string name='wrap_mode' value='clamp'/></texture>",
                "`wrap_mode`: unknown name `clamp`;",
            ),
            (
                "<texture name='reflectance' type='bitmap'><string name='filename' value='a'/><transform name='to_uv'><rotate x='1' angle='40'/></transform></texture>",
                "`to_uv` leaves the plane of x and y",
            ),
        ] {
            fails(&textured(texture), 8, words);
        }
    }
}
