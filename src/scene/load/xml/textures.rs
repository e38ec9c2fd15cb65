//! `<texture type="bitmap">`: pictures on surfaces.

use super::super::super::SceneError;
use super::super::pictures::Encoding;
use super::element::Element;
use super::object::{Context, Object};
use crate::texture::Texture;

/// The picture of a texture; none where it is of another kind and the reader is lenient.
pub(super) fn bitmap<'a>(
    element: &'a Element,
    context: &'a Context<'a>,
) -> Result<Option<Texture>, SceneError> {
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
    object.finish()?;
    let path = context.reader.beside_scene(name);
    let picture = context.reader.picture_at(&path, encoding);
    let picture = picture.map_err(|reason| object.error(format!("`{name}`: {reason}")))?;
    let texture = Texture::new(path.display().to_string(), picture);
    let texture = texture
        .ok_or_else(|| object.error(format!("`{name}` holds what is no number; allowed: finite values")))?;
    if texture.max().max_element() > 1.0 || texture.min().min_element() < 0.0 {
        return Err(object.error(format!("`{name}` reaches {}; allowed: values from 0 to 1", texture.max())));
    }
    Ok(Some(texture))
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
                "<texture name='reflectance' type='bitmap'><string name='filename' value='a'/><transform name='to_uv'/></texture>",
                "<transform> `to_uv` is not supported",
            ),
        ] {
            fails(&textured(texture), 8, words);
        }
    }
}
