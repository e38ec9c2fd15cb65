//! The pictures of a glTF file: inside of it, in its text, or in files beside it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DAffine2;
use gltf::image::Source;
use gltf::texture::{Info, MagFilter, WrappingMode};

use super::super::access::Reader;
use super::super::pictures::{self, Kind};
use super::buffers::{self, Buffers};
use crate::film::Image;
use crate::math::Rgb;
use crate::texture::{Encoding, Texture};

/// What reading pictures takes.
#[derive(Clone, Copy)]
pub(super) struct Pictures<'a> {
    pub path: &'a Path,
    pub reader: &'a Reader<'a>,
    pub buffers: &'a Buffers,
}

/// A picture, and the map of texture coordinates before it is looked up.
pub(super) struct Picture {
    pub texture: Texture,
    pub to_uv: DAffine2,
}

impl Pictures<'_> {
    /// The picture of a texture; none, with a warning, where it cannot be read or lies by other coordinates than the first. `tell` is
    /// called with what is left out.
    pub fn read(&self, info: &Info, encoding: Encoding, tell: &mut dyn FnMut(String)) -> Option<Picture> {
        let transform = info.texture_transform();
        let set = transform.as_ref().and_then(|transform| transform.tex_coord()).unwrap_or(info.tex_coord());
        if set != 0 {
            tell(format!(
                "lies by TEXCOORD_{set}, which is not supported (allowed: TEXCOORD_0); the factor counts"
            ));
            return None;
        }
        let mut to_uv = DAffine2::IDENTITY;
        if let Some(transform) = transform {
            let [scale, offset] =
                [transform.scale(), transform.offset()].map(|v| glam::Vec2::from(v).as_dvec2());
            to_uv = DAffine2::from_scale_angle_translation(scale, 0.0, offset);
            if transform.rotation() != 0.0 {
                tell(String::from(
                    "is rotated by KHR_texture_transform, which is not supported; it is not turned",
                ));
            }
        }
        if !to_uv.is_finite() {
            tell(String::from("is moved beyond all numbers; the factor counts"));
            return None;
        }
        tell_of_the_sampler(info, tell);
        match self.texture(&info.texture().source(), encoding) {
            Ok(texture) => Some(Picture { texture, to_uv }),
            Err(reason) => {
                tell(format!("{reason}; the factor counts"));
                None
            }
        }
    }

    fn texture(&self, image: &gltf::Image, encoding: Encoding) -> Result<Texture, String> {
        let (bytes, file) = self.bytes(image)?;
        let kind =
            Kind::of_content(&bytes).ok_or("its picture is neither PNG nor JPEG, which are allowed")?;
        let label = format!("image {}", image.index());
        let shown = file.clone().unwrap_or_else(|| self.path.to_owned());
        let pixels = pictures::decode(kind, &shown, &bytes, encoding)?;
        let texture = Texture::new(image.name().unwrap_or(&label), pixels).ok_or("its picture is empty")?;
        Ok(match file {
            Some(file) => texture.of_file(file, encoding),
            None => texture,
        })
    }

    /// The bytes of a picture, and the file that holds nothing else.
    fn bytes(&self, image: &gltf::Image) -> Result<(Vec<u8>, Option<PathBuf>), String> {
        match image.source() {
            Source::View { view, .. } => {
                let part = self.buffers.part(view.buffer().index(), view.offset(), view.length());
                Ok((part.ok_or("its picture reaches beyond its buffer")?.to_vec(), None))
            }
            Source::Uri { uri, .. } => {
                let bytes = buffers::content(uri, self.path, self.reader, "a picture of a glTF scene")?;
                Ok((bytes, buffers::file(uri, self.path)))
            }
        }
    }
}

fn tell_of_the_sampler(info: &Info, tell: &mut dyn FnMut(String)) {
    let sampler = info.texture().sampler();
    for (axis, mode) in [("u", sampler.wrap_s()), ("v", sampler.wrap_t())] {
        match mode {
            WrappingMode::Repeat => {}
            WrappingMode::ClampToEdge => {
                tell(format!("ends at its edges in {axis}, which is not supported; it repeats"))
            }
            WrappingMode::MirroredRepeat => {
                tell(format!("is mirrored in {axis}, which is not supported; it repeats"))
            }
        }
    }
    if sampler.mag_filter() == Some(MagFilter::Nearest) {
        tell(String::from("shows its pixels as squares, which is not supported; it is bilinear"));
    }
}

/// The picture times a factor; itself where that is 1.
pub(super) fn scaled(texture: Texture, factor: Rgb) -> Option<Arc<Texture>> {
    if factor == Rgb::ONE {
        return Some(Arc::new(texture));
    }
    changed(&texture, |pixel| (pixel * factor).clamp(Rgb::ZERO, Rgb::ONE))
}

/// A picture made of another one, pixel by pixel.
pub(super) fn changed(texture: &Texture, of: impl Fn(Rgb) -> Rgb) -> Option<Arc<Texture>> {
    let image = texture.image();
    let pixels = image.pixels().iter().map(|pixel| of(*pixel)).collect();
    let image = Image::from_pixels(image.width(), image.height(), pixels)?;
    Texture::new(texture.name.clone(), image).map(Arc::new)
}

/// The mean of all pixels.
pub(super) fn mean(texture: &Texture) -> Rgb {
    let pixels = texture.image().pixels();
    let sum: crate::math::DVec3 = pixels.iter().map(|pixel| pixel.as_dvec3()).sum();
    (sum / pixels.len() as f64).as_vec3()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;
    use serde_json::{Value, json};

    use super::super::super::super::{SceneDesc, load};
    use super::super::tests;
    use super::*;
    use crate::bsdf::Bsdf;
    use crate::math::Vec2;

    /// Two pixels beside each other.
    fn png(pixels: [[u8; 3]; 2]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(png::ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(pixels.as_flattened()).unwrap();
        bytes
    }

    fn data_uri(bytes: &[u8]) -> Value {
        json!(format!("data:image/png;base64,{}", STANDARD.encode(bytes)))
    }

    /// The scene of the other tests with texture coordinates, a picture and a material of it.
    fn scene(picture: &[u8], pbr: Value) -> Value {
        let mut scene = tests::scene();
        let uvs: Vec<u8> =
            [[0f32, 0.], [1., 0.], [0.5, 0.25]].as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let push = |list: &mut Value, what: Value| list.as_array_mut().unwrap().push(what);
        push(&mut scene["buffers"], json!({ "byteLength": uvs.len(), "uri": data_uri(&uvs) }));
        push(&mut scene["bufferViews"], json!({ "buffer": 1, "byteLength": uvs.len() }));
        push(
            &mut scene["accessors"],
            json!({ "bufferView": 3, "componentType": 5126, "count": 3, "type": "VEC2" }),
        );
        scene["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(3);
        scene["images"] = json!([{ "uri": data_uri(picture), "name": "p" }]);
        scene["samplers"] = json!([{}]);
        scene["textures"] = json!([{ "source": 0, "sampler": 0 }]);
        scene["materials"][0] = json!({ "name": "m", "pbrMetallicRoughness": pbr });
        scene
    }

    fn read(scene: &Value) -> SceneDesc {
        tests::read(scene).unwrap()
    }

    fn color() -> Value {
        json!({ "baseColorTexture": { "index": 0 }, "metallicFactor": 0 })
    }

    #[test]
    fn colours_are_those_of_pictures_times_a_factor() {
        let picture = png([[255, 0, 0], [0, 255, 188]]);
        let plain = read(&scene(&picture, color()));
        let texture = plain.materials[0].textures.color.clone().unwrap();
        assert_eq!((texture.name.as_str(), texture.image().get(0, 0)), ("p", Rgb::X));
        assert!((texture.image().get(1, 0) - Rgb::new(0.0, 1.0, 0.5029)).abs().max_element() < 1e-3, "sRGB");
        assert_eq!(plain.materials[0].bsdf, Bsdf::Diffuse { albedo: texture.max() });
        assert_eq!(plain.warnings, Vec::<String>::new());
        // The first row is at the top: v grows downward in the file and upward here.
        let places = vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(0.5, 0.75)];
        assert_eq!(plain.meshes[0].uvs, Some(places));
        let mut half = color();
        half["baseColorFactor"] = json!([0.5, 1, 1, 1]);
        let half = read(&scene(&picture, half)).materials[0].textures.color.clone().unwrap();
        assert_eq!((half.image().get(0, 0), &half.file), (Rgb::new(0.5, 0.0, 0.0), &None));
    }

    #[test]
    fn pictures_lie_in_buffers_and_files_too() {
        let picture = png([[255, 255, 255], [0, 0, 0]]);
        let mut inside = scene(&picture, color());
        let at = inside["bufferViews"].as_array().unwrap().len();
        inside["buffers"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "byteLength": picture.len(), "uri": data_uri(&picture) }));
        inside["bufferViews"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "buffer": 2, "byteLength": picture.len() }));
        inside["images"] = json!([{ "bufferView": at, "mimeType": "image/png" }]);
        assert_eq!(read(&inside).materials[0].textures.color.as_ref().unwrap().max(), Rgb::ONE);
        let mut beside = scene(&picture, color());
        beside["images"] = json!([{ "uri": "a%20b.png" }]);
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a b.png"), &picture).unwrap();
        fs::write(folder.path().join("s.gltf"), beside.to_string()).unwrap();
        let read = load(&folder.path().join("s.gltf")).unwrap();
        let file = read.materials[0].textures.color.as_ref().unwrap().file.clone().unwrap();
        assert_eq!((file.path, file.encoding), (folder.path().join("a b.png"), Encoding::Colour));
    }

    /// Green is the root of the facets' roughness, blue says what is metal.
    #[test]
    fn roughness_is_squared() {
        let pbr = json!({ "metallicRoughnessTexture": { "index": 0 }, "roughnessFactor": 0.5 });
        let metal = read(&scene(&png([[9, 255, 255], [9, 51, 255]]), pbr.clone()));
        let roughness = metal.materials[0].textures.roughness.clone().unwrap();
        let expected = [0.25, 0.01].map(Rgb::splat);
        assert!((roughness.image().get(0, 0) - expected[0]).length() < 1e-6);
        assert!((roughness.image().get(1, 0) - expected[1]).length() < 1e-6);
        assert!(matches!(metal.materials[0].bsdf, Bsdf::Rough(surface) if surface.facets.alpha == 0.25));
        assert_eq!(metal.warnings, Vec::<String>::new());
        let even = read(&scene(&png([[9, 255, 255], [9, 255, 255]]), pbr.clone()));
        assert!(even.materials[0].textures.roughness.is_none(), "the same everywhere");
        let wood = read(&scene(&png([[9, 255, 0], [9, 51, 0]]), pbr));
        assert!(matches!(wood.materials[0].bsdf, Bsdf::Diffuse { .. }));
        assert!(
            wood.warnings[0].contains("a roughness by a picture, of what is no metal or glass"),
            "{:?}",
            wood.warnings
        );
    }

    #[test]
    fn coordinates_may_be_moved() {
        let mut moved = color();
        let transform = json!({ "offset": [0.5, 0.25], "scale": [2, 4] });
        moved["baseColorTexture"]["extensions"] = json!({ "KHR_texture_transform": transform });
        let mut value = scene(&png([[255; 3]; 2]), moved);
        value["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_texture_transform"]);
        let scene = read(&value);
        assert_eq!(scene.meshes[0].uvs.as_ref().unwrap()[2], Vec2::new(1.5, 1.0 - 1.25));
        assert_eq!(scene.warnings, Vec::<String>::new());
    }

    #[test]
    fn what_shines_by_a_picture_shines_by_its_mean() {
        let mut value = scene(&png([[255, 0, 0], [0, 0, 0]]), json!({}));
        value["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        value["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
        let scene = read(&value);
        assert_eq!(scene.materials[0].emission, Rgb::new(0.5, 0.0, 0.0));
        assert!(
            scene.warnings[0].contains("emissiveTexture is not supported; its mean"),
            "{:?}",
            scene.warnings
        );
    }

    #[test]
    fn what_is_left_out_is_told_by_name() {
        let told = |pointer: &str, to: Value| {
            let mut value = scene(&png([[255; 3]; 2]), color());
            *value.pointer_mut(pointer).unwrap() = to;
            read(&value).warnings.join("\n")
        };
        let index = "/materials/0/pbrMetallicRoughness/baseColorTexture";
        for (pointer, to, words) in [
            (
                index,
                json!({ "index": 0, "texCoord": 1 }),
                "baseColorTexture lies by TEXCOORD_1, which is not supported",
            ),
            (
                index,
                json!({ "index": 0, "extensions": { "KHR_texture_transform": { "rotation": 1 } } }),
                "baseColorTexture is rotated",
            ),
            (
                "/samplers/0",
                json!({ "wrapS": 33071, "wrapT": 33648 }),
                "is mirrored in v, which is not supported; it repeats",
            ),
            ("/samplers/0", json!({ "wrapS": 33071 }), "ends at its edges in u"),
            ("/samplers/0", json!({ "magFilter": 9728 }), "shows its pixels as squares"),
            (
                "/images/0",
                json!({ "uri": "no.png" }),
                "s.gltf: material `m`: baseColorTexture `no.png` cannot be read",
            ),
            ("/images/0", json!({ "uri": "data:image/png;base64,AAAA" }), "is neither PNG nor JPEG"),
            ("/images/0", json!({ "uri": "https://x/y.png" }), "lies in a network"),
            (
                "/materials/0",
                json!({ "name": "m", "normalTexture": { "index": 0 } }),
                "not supported: normalTexture",
            ),
        ] {
            let told = told(pointer, to);
            assert!(told.contains(words), "{told}\nlacks {words}");
        }
        let mut bare = scene(&png([[255; 3]; 2]), color());
        bare["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("TEXCOORD_0");
        assert!(read(&bare).warnings[0].contains("has no TEXCOORD_0"));
        let mut short = scene(&png([[255; 3]; 2]), color());
        short["accessors"][3]["count"] = json!(2);
        assert!(tests::read(&short).unwrap_err().contains("not as many texture coordinates as positions"));
    }
}
