use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::super::load;
use super::*;
use crate::bsdf::Bsdf;

/// Three positions, three normals, three indices of two bytes.
fn buffer() -> Vec<u8> {
    let floats = [[0f32, 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0., 0., 1.], [0., 0., 1.]];
    let mut bytes: Vec<u8> = floats.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// A triangle in a node that is moved by 2 along x, a camera, and a lamp.
pub(super) fn scene() -> Value {
    let vectors = |view| json!({ "bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1] });
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point", "intensity": 3.0, "color": [1, 0.5, 0] }] } },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [
            { "translation": [2, 0, 0], "children": [1, 2, 3] },
            { "mesh": 0 },
            { "camera": 0, "translation": [0, 0, 5] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [0, 4, 0] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "aspectRatio": 2.0, "znear": 0.1 } }],
        "materials": [{ "name": "m", "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 1, 1], "metallicFactor": 0 } }],
        "meshes": [{ "name": "t", "primitives": [{ "attributes": { "POSITION": 0, "NORMAL": 1 }, "indices": 2, "material": 0 }] }],
        "accessors": [vectors(0), vectors(1), { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 72, "byteLength": 6 },
        ],
        "buffers": [{ "byteLength": 78, "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(buffer())) }],
    })
}

pub(super) fn read(value: &Value) -> Result<SceneDesc, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.gltf");
    fs::write(&path, value.to_string()).unwrap();
    fs::write(folder.path().join("a b.bin"), buffer()).unwrap();
    let shorten = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let scene = load(&path).map_err(|e| shorten(e.to_string()))?;
    Ok(SceneDesc { warnings: scene.warnings.iter().cloned().map(shorten).collect(), ..scene })
}

fn changed(pointer: &str, to: Value) -> Value {
    let mut value = scene();
    *value.pointer_mut(pointer).unwrap() = to;
    value
}

#[test]
fn a_scene_arrives() {
    let scene = read(&scene()).unwrap();
    assert_eq!(
        scene.meshes[0].vertices,
        [Vec3::new(2., 0., 0.), Vec3::new(3., 0., 0.), Vec3::new(2., 1., 0.)]
    );
    assert_eq!(scene.meshes[0].normals, Some(vec![Vec3::Z; 3]));
    assert_eq!(
        (scene.materials[0].name.as_str(), scene.materials[0].bsdf),
        ("m", Bsdf::Diffuse { albedo: Rgb::new(0.5, 0.25, 1.0) })
    );
    assert_eq!(
        scene.point_lights,
        [PointLightDesc { position: Vec3::new(2., 4., 0.), intensity: Rgb::new(3., 1.5, 0.) }]
    );
    assert_eq!((scene.film.width, scene.film.height), (1024, 512));
    assert_eq!(
        (scene.camera.position, scene.camera.look_at, scene.camera.up),
        (Vec3::new(2., 0., 5.), Vec3::new(2., 0., 4.), Vec3::Y)
    );
    let expected = (2.0 * (2.0 * 0.25f64.tan()).atan()).to_degrees();
    assert!((f64::from(scene.camera.fov_degrees) - expected).abs() < 1e-5);
    assert_eq!(scene.warnings, Vec::<String>::new());
}

#[test]
fn buffers_lie_in_files_or_behind_the_text() {
    assert!(read(&changed("/buffers/0/uri", json!("a%20b.bin"))).is_ok());
    let mut value = scene();
    value["buffers"][0].as_object_mut().unwrap().remove("uri");
    let mut text = value.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut data = buffer();
    data.resize(80, 0);
    let mut bytes = b"glTF".to_vec();
    let parts = [(text, b"JSON"), (data, b"BIN\0")];
    let length = 12 + parts.iter().map(|(part, _)| 8 + part.len() as u32).sum::<u32>();
    bytes.extend([2, length].iter().flat_map(|word: &u32| word.to_le_bytes()));
    for (part, kind) in parts {
        bytes.extend((part.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(part);
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.glb");
    fs::write(&path, bytes).unwrap();
    assert_eq!(load(&path).unwrap().meshes[0].triangles, [[0, 1, 2]]);
}

#[test]
fn materials_become_the_nearest_surfaces() {
    let bsdf = |material: Value| {
        let mut value = changed("/materials/0", material);
        value["extensionsUsed"] = json!([
            "KHR_lights_punctual",
            "KHR_materials_transmission",
            "KHR_materials_ior",
            "KHR_materials_emissive_strength"
        ]);
        let scene = read(&value).unwrap();
        (scene.materials[0].bsdf, scene.materials[0].emission)
    };
    let metal = bsdf(json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.5 } })).0;
    assert!(matches!(metal, Bsdf::Rough(surface) if surface.facets.alpha == 0.25), "{metal:?}");
    assert_eq!(
        bsdf(json!({ "pbrMetallicRoughness": { "roughnessFactor": 0 } })).0,
        Bsdf::Mirror { reflectance: Rgb::ONE }
    );
    assert!(matches!(
        bsdf(json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.1, "metallicFactor": 0 } })).0,
        Bsdf::Plastic(_)
    ));
    let glass = json!({ "pbrMetallicRoughness": { "roughnessFactor": 0 }, "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_ior": { "ior": 1.25 } } });
    assert_eq!(bsdf(glass).0, Bsdf::ThinDielectric { ior: 1.25 });
    let lamp = json!({ "emissiveFactor": [1, 0.5, 0], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8 } } });
    assert_eq!(bsdf(lamp).1, Rgb::new(8.0, 4.0, 0.0));
}

#[test]
fn attenuation_is_absorption() {
    let glass = |volume: Value| {
        let mut value = changed(
            "/materials/0",
            json!({ "pbrMetallicRoughness": { "roughnessFactor": 0 }, "extensions": {
                "KHR_materials_transmission": { "transmissionFactor": 1 }, "KHR_materials_volume": volume } }),
        );
        value["extensionsUsed"] =
            json!(["KHR_lights_punctual", "KHR_materials_transmission", "KHR_materials_volume"]);
        let scene = read(&value).unwrap();
        (scene.materials[0].absorption, scene.warnings.join("; "))
    };
    let tint = json!({ "thicknessFactor": 1, "attenuationColor": [1, 0.5, 0.25], "attenuationDistance": 2 });
    let expected = Rgb::new(0.0, 0.5f32.ln() / -2.0, 0.5f32.ln() / -1.0);
    assert!((glass(tint).0 - expected).length() < 1e-6);
    assert_eq!(glass(json!({ "thicknessFactor": 1 })), (Rgb::ZERO, String::new()));
    let (clear, told) = glass(json!({ "attenuationColor": [0, 0.5, 1], "attenuationDistance": 1 }));
    assert!(clear == Rgb::ZERO && told.contains("attenuation without a thickness"), "{told}");
}

#[test]
fn alpha_is_opacity_where_the_mode_says_so() {
    for (mode, cutoff, alpha, expected) in [
        ("OPAQUE", None, 0.25, 1.0),
        ("BLEND", None, 0.25, 0.25),
        ("MASK", None, 0.25, 0.0),
        ("MASK", None, 0.5, 1.0),
        ("MASK", Some(0.75), 0.5, 0.0),
    ] {
        let mut material =
            json!({ "alphaMode": mode, "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, alpha] } });
        if let Some(cutoff) = cutoff {
            material["alphaCutoff"] = json!(cutoff);
        }
        let scene = read(&changed("/materials/0", material)).unwrap();
        assert_eq!((scene.materials[0].opacity, scene.warnings.len()), (expected, 0), "{mode} {alpha}");
    }
}

#[test]
fn lights_of_all_kinds_shine() {
    let light = |light: Value| {
        read(&changed("/extensions/KHR_lights_punctual/lights/0", light)).unwrap().further_lights[0].clone()
    };
    let sun = light(json!({ "type": "directional", "intensity": 2 }));
    assert_eq!(sun, LightDesc::Distant { direction: Vec3::NEG_Z, irradiance: Rgb::splat(2.0) });
    let spot = light(json!({ "type": "spot", "spot": { "innerConeAngle": 0.25, "outerConeAngle": 0.5 } }));
    let expected = Spot {
        position: Vec3::new(2.0, 4.0, 0.0),
        axis: Vec3::NEG_Z,
        intensity: Rgb::ONE,
        inner: 0.25,
        outer: 0.5,
    };
    assert_eq!(spot, LightDesc::Spot(expected));
}

#[test]
fn unsound_files_are_refused() {
    for (pointer, to, words) in [
        ("/asset/version", json!("1.0"), "s.gltf: is glTF 1.0; allowed: 2.0"),
        ("/nodes/0/children", json!([0]), "node 0 is nested in itself"),
        ("/nodes/0/children", json!([1, 1]), "node 1 is nested in itself, in two nodes"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(3),
            "has positions in accessor 3; allowed: less than 3",
        ),
        ("/accessors/0/count", json!(4), "accessor 0 reaches beyond its buffer"),
        ("/accessors/0/count", json!(u64::MAX), "accessor 0 reaches beyond its buffer"),
        ("/accessors/1/count", json!(2), "not as many normals as positions"),
        ("/accessors/2/componentType", json!(5126), "accessor 2 holds no indices"),
        ("/accessors/0/type", json!("VEC2"), "accessor 0 holds no vectors of three floats"),
        ("/bufferViews/0/byteOffset", json!(u64::MAX), ""),
        ("/bufferViews/2/byteOffset", json!(44), "vertex index"),
        ("/buffers/0/uri", json!("no.bin"), "buffer 0: `no.bin` cannot be read"),
        ("/buffers/0/uri", json!("data:text/plain,abc"), "buffer 0: its data are not base64"),
        ("/buffers/0/uri", json!("https://x/y.bin"), "buffer 0: lies in a network"),
        ("/buffers/0/byteLength", json!(99), "buffer 0: holds 78 bytes; allowed: 99"),
        ("/cameras/0/perspective/yfov", json!(0), "camera 0 sees nothing"),
        ("/scenes", json!([]), ""),
    ] {
        let mut value = scene();
        match value.pointer_mut(pointer) {
            Some(place) => *place = to,
            None => value["bufferViews"][0]["byteOffset"] = to,
        }
        let error = read(&value).unwrap_err();
        assert!(error.starts_with("s.gltf: ") && error.contains(words), "{pointer}: {error}");
    }
}

/// The parser panics on such files.
#[test]
fn images_without_a_source_are_refused() {
    for images in [json!([{}]), json!([{ "uri": "a.png" }, { "bufferView": 0 }])] {
        let mut value = scene();
        value["images"] = images.clone();
        let error = read(&value).unwrap_err();
        let last = images.as_array().unwrap().len() - 1;
        assert!(error.contains(&format!("has image {last} without a source")), "{error}");
    }
}

#[test]
fn what_is_left_out_is_told() {
    let told = |pointer: &str, to: Value| read(&changed(pointer, to)).unwrap().warnings.join("\n");
    assert!(
        told("/extensions/KHR_lights_punctual/lights/0", json!({ "type": "point", "range": 3 }))
            .contains("a range is not supported")
    );
    assert!(
        told(
            "/cameras/0",
            json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 1, "zfar": 9, "znear": 0 } })
        )
        .contains("orthographic")
    );
    assert!(
        told("/extensionsUsed", json!(["KHR_lights_punctual", "EXT_x"])).contains("not supported: EXT_x")
    );
    assert!(
        told("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "mode": 1 }))
            .contains("points and lines are not supported")
    );
}

#[test]
fn strips_and_fans_keep_their_side() {
    assert_eq!(triangles(Mode::TriangleStrip, &[0, 1, 2, 3]), [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(triangles(Mode::TriangleFan, &[0, 1, 2, 3]), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(triangles(Mode::Triangles, &[0, 1, 2, 3]), [[0, 1, 2]]);
}
