use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

use proptest::collection::vec;
use proptest::prelude::*;
use tempfile::TempDir;

use super::quads::QUAD_UVS;
use super::*;
use crate::bsdf::{Bsdf, Ggx, Interface, Plastic, RoughSurface};
use crate::camera::PixelFilter;
use crate::film::Image;
use crate::light::{Panorama, Spot};
use crate::math::{Rgb, Vec2, Vec3};
use crate::output::{Display, Metadata, write_exr, write_png};
use crate::scene::{
    CameraDesc, FilmDesc, LightDesc, Material, Mesh, PointLightDesc, RenderDesc, SphereDesc, Textures, load,
};
use crate::texture::{Encoding, Texture};

/// What matters of a scene: all but names of files and meshes, and what was noticed.
fn bare(desc: &SceneDesc) -> SceneDesc {
    let meshes = desc.meshes.iter().map(|mesh| Mesh { name: String::new(), ..mesh.clone() }).collect();
    let (name, path) = (String::new(), PathBuf::new());
    let pixels = |texture: &Arc<Texture>| Arc::new(Texture::new("", texture.image().clone()).unwrap());
    let mut bare = SceneDesc { name, path, meshes, warnings: Vec::new(), ..desc.clone() }.without_places();
    for Textures { color, roughness, .. } in bare.materials.iter_mut().map(|material| &mut material.textures)
    {
        [color, roughness].into_iter().flatten().for_each(|texture| *texture = pixels(texture));
    }
    bare
}

fn written(desc: &SceneDesc, name: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let saved = save(desc, &path, false).unwrap();
    for (file, bytes) in saved.meshes.into_iter().chain(saved.pictures) {
        let file = folder.path().join(file);
        fs::create_dir_all(file.parent().unwrap()).unwrap();
        fs::write(file, bytes).unwrap();
    }
    fs::write(&path, saved.text).unwrap();
    (folder, path)
}

fn there_and_back(desc: &SceneDesc, name: &str) -> SceneDesc {
    let (_folder, path) = written(desc, name);
    load(&path).unwrap_or_else(|e| panic!("{e}\n{}", fs::read_to_string(&path).unwrap()))
}

fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        -10f32..10.0,
        -1e15f32..1e15,
        -1e-20f32..1e-20,
        Just(0.1),
        (-40i32..40).prop_map(|k| k as f32 * 0.5)
    ]
}

fn point() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from)
}

fn share() -> impl Strategy<Value = f32> {
    prop_oneof![0f32..=1.0, Just(0.0), Just(1.0)]
}

fn shares() -> impl Strategy<Value = Rgb> {
    [share(), share(), share()].prop_map(Rgb::from)
}

fn interface() -> impl Strategy<Value = Interface> {
    prop_oneof![
        (shares(), shares(), shares()).prop_map(|(eta, k, reflectance)| Interface::Conductor {
            eta,
            k,
            reflectance
        }),
        (0.2f32..3.0).prop_map(|ior| Interface::Dielectric { ior }),
    ]
}

fn bsdf() -> impl Strategy<Value = Bsdf> {
    prop_oneof![
        shares().prop_map(|albedo| Bsdf::Diffuse { albedo }),
        shares().prop_map(|reflectance| Bsdf::Mirror { reflectance }),
        (0.2f32..3.0).prop_map(|ior| Bsdf::Dielectric { ior }),
        (0.2f32..3.0).prop_map(|ior| Bsdf::ThinDielectric { ior }),
        (shares(), shares(), shares()).prop_map(|(eta, k, reflectance)| Bsdf::Conductor {
            eta,
            k,
            reflectance
        }),
        (0.01f32..1.0, interface())
            .prop_map(|(alpha, interface)| Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface })),
        (shares(), 1.01f32..3.0, any::<bool>())
            .prop_map(|(base, ior, nonlinear)| Bsdf::Plastic(Plastic::new(base, ior, nonlinear))),
    ]
}

fn material() -> impl Strategy<Value = Material> {
    let emission = prop_oneof![3 => Just(Rgb::ZERO), 1 => shares().prop_map(|rgb| 17.3 * rgb)];
    let opacity = prop_oneof![2 => Just(1.0), 1 => share()];
    let name = "[a-c$_.:\" &<>ä\n-]{0,5}";
    let absorption = prop_oneof![2 => Just(Rgb::ZERO), 1 => shares().prop_map(|rgb| 3.7 * rgb)];
    let parts = (name, bsdf(), emission, opacity, absorption);
    parts.prop_map(|(name, bsdf, emission, opacity, absorption)| Material {
        opacity,
        absorption: bsdf.ior().map_or(Rgb::ZERO, |_| absorption),
        textures: Textures::NONE,
        name,
        bsdf,
        emission,
    })
}

/// Corners of a triangle that has an area, and unit normals of its corners.
fn triangle() -> impl Strategy<Value = (Vec<Vec3>, Vec<Vec3>)> {
    let has_area = |p: &Vec<Vec3>| {
        let [a, b, c] = [p[0], p[1], p[2]].map(|p| p.as_dvec3());
        (b - a).cross(c - a).length() > 0.0
    };
    let unit = (-1f32..1.0, -1f32..1.0).prop_map(|(x, y)| Vec3::new(x, y, 1.0).normalize());
    (vec(point(), 3).prop_filter("flat", has_area), vec(unit, 3))
}

/// A mesh of several triangles, which share no vertex.
fn mesh(n_materials: u32) -> impl Strategy<Value = Mesh> {
    let triangles = vec((triangle(), 0..n_materials), 1..5);
    (triangles, any::<bool>()).prop_map(|(triangles, smooth)| Mesh {
        uvs: smooth.then(|| (0..3 * triangles.len()).map(|k| Vec2::new(0.1 * k as f32, -0.3)).collect()),
        name: String::new(),
        vertices: triangles.iter().flat_map(|((corners, _), _)| corners.clone()).collect(),
        normals: smooth.then(|| triangles.iter().flat_map(|((_, normals), _)| normals.clone()).collect()),
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        materials: triangles.iter().map(|(_, material)| *material).collect(),
    })
}

fn quad(n_materials: u32) -> impl Strategy<Value = Mesh> {
    let size = || 0.5f32..9.0;
    let near = [-9f32..9.0, -9f32..9.0, -9f32..9.0].prop_map(Vec3::from);
    (near, size(), size(), 0..n_materials).prop_map(|(at, x, z, material)| Mesh {
        uvs: Some(QUAD_UVS.to_vec()),
        name: String::new(),
        vertices: vec![at, at + z * Vec3::Z, at + Vec3::new(x, 0.0, z), at + x * Vec3::X],
        normals: None,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        materials: vec![material; 2],
    })
}

fn film() -> impl Strategy<Value = FilmDesc> {
    (1u32..300, 1u32..300, 0usize..4).prop_map(|(width, height, filter)| FilmDesc {
        width,
        height,
        filter: PixelFilter::ALL[filter],
    })
}

fn camera() -> impl Strategy<Value = CameraDesc> {
    let up = (-1f32..1.0).prop_map(|x| Vec3::new(x, 0.5, 0.25));
    let lens = prop_oneof![Just(0f32), 0.01f32..2.0];
    (point(), 0.5f32..5.0, up, 1f32..179.0, lens, 0.5f32..50.0).prop_filter_map(
        "lost",
        |(position, far, up, fov, lens, focus)| {
            let look_at = position + far * Vec3::new(0.1, 0.2, -1.0);
            let sees = look_at.distance(position) > 0.2 * far
                && (look_at - position).normalize().cross(up).length() > 0.1;
            let camera = CameraDesc {
                up,
                lens_radius: lens,
                focus_distance: focus,
                ..CameraDesc::pinhole(position, look_at, fov)
            };
            sees.then_some(camera)
        },
    )
}

fn render() -> impl Strategy<Value = RenderDesc> {
    let radius = prop_oneof![Just(None), (1e-9f64..1e9).prop_map(Some)];
    (1u32..99, 1u64..1 << 40, 1u32..4096, 0.01f64..=1.0, radius, 0u32..1024).prop_map(
        |(passes, photons, samples, alpha, radius, depth)| RenderDesc {
            passes,
            photons,
            samples,
            alpha,
            radius,
            depth,
        },
    )
}

fn light() -> impl Strategy<Value = PointLightDesc> {
    (point(), shares()).prop_map(|(position, rgb)| PointLightDesc { position, intensity: 1e4 * rgb })
}

/// Scenes of all that both formats hold.
fn scene() -> impl Strategy<Value = SceneDesc> {
    let sky = prop_oneof![Just(Vec::new()), shares().prop_map(|radiance| vec![LightDesc::Sky(radiance)])];
    (vec(material(), 1..5), sky).prop_flat_map(move |(mut materials, sky)| {
        let n = materials.len() as u32;
        // Spheres have the last material, which emits nothing.
        materials.last_mut().unwrap().emission = Rgb::ZERO;
        let sphere = (point(), 0.01f32..9.0).prop_map(move |(center, radius)| SphereDesc {
            center,
            radius,
            material: n - 1,
        });
        let shapes = (vec(mesh(n), 0..4), vec(quad(n), 0..4), vec(sphere, 0..3), vec(light(), 0..3));
        (shapes, film(), camera(), render()).prop_map(
            move |((meshes, quads, spheres, point_lights), film, camera, render)| SceneDesc {
                name: String::new(),
                path: PathBuf::new(),
                film,
                camera,
                render,
                materials: materials.clone(),
                spheres,
                meshes: [meshes, quads].concat(),
                point_lights,
                further_lights: sky.clone(),
                warnings: Vec::new(),
                places: Default::default(),
            },
        )
    })
}

/// The scene with emission and absorption of materials that no mesh has taken away: XML has no place for them.
fn lit_by_shapes(mut desc: SceneDesc) -> SceneDesc {
    let used: Vec<u32> = desc.meshes.iter().flat_map(|mesh| mesh.materials.clone()).collect();
    for (material, number) in desc.materials.iter_mut().zip(0..) {
        if !used.contains(&number) {
            (material.emission, material.absorption) = (Rgb::ZERO, Rgb::ZERO);
        }
    }
    desc
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn scenes_come_back_from_toml_as_they_were(desc in scene()) {
        let normal = normal_form(desc.clone());
        prop_assert_eq!(bare(&there_and_back(&desc, "s.toml")), bare(&normal));
        prop_assert_eq!(normal_form(normal.clone()), normal);
    }

    #[test]
    fn scenes_come_back_from_xml_as_they_were(desc in scene()) {
        let desc = lit_by_shapes(desc);
        let from_xml = there_and_back(&desc, "s.xml");
        prop_assert_eq!(bare(&from_xml), bare(&normal_form(desc)));
        prop_assert_eq!(bare(&there_and_back(&from_xml, "s.toml")), bare(&from_xml));
    }
}

fn one_material(bsdf: Bsdf) -> SceneDesc {
    let text = "<scene version='3.0.0'><sensor type='perspective'/><shape type='rectangle'/><shape type='cube'/></scene>";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.xml");
    fs::write(&path, text).unwrap();
    let mut desc = load(&path).unwrap();
    desc.materials[0].bsdf = bsdf;
    desc
}

#[test]
fn lights_come_back() {
    let mut desc = one_material(Bsdf::Mirror { reflectance: Rgb::ONE });
    let axis = Vec3::new(0.6, 0.0, 0.8);
    let (inner, outer) = (20f32.to_radians(), 33.3f32.to_radians());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sky.exr");
    let pixels = (0..8).map(|k| Rgb::splat(k as f32)).collect();
    let picture = Image::from_pixels(4, 2, pixels).unwrap();
    write_exr(&file, &picture, &Metadata::default()).unwrap();
    let sky = Arc::new(Panorama::new(picture, 2.0, 0.5).unwrap());
    desc.further_lights = vec![
        LightDesc::Spot(Spot {
            position: Vec3::new(1.0, 2.0, 3.0),
            axis,
            intensity: Rgb::new(4.0, 5.0, 6.0),
            inner,
            outer,
        }),
        LightDesc::Distant { direction: axis, irradiance: Rgb::ONE },
        LightDesc::Panorama { file, panorama: Arc::clone(&sky) },
    ];
    for name in ["s.toml", "s.xml"] {
        let lights = there_and_back(&desc, name).further_lights;
        assert_eq!(lights[..2], desc.further_lights[..2], "{name}");
        let LightDesc::Panorama { panorama, .. } = &lights[2] else { panic!("{lights:?}") };
        assert!(
            (panorama.turn() - 0.5).abs() < 1e-6 && panorama.scale() == 2.0,
            "{name}: {}",
            panorama.turn()
        );
        assert_eq!(panorama.picture(), sky.picture());
    }
}

#[test]
fn parallelograms_are_rectangles_and_other_meshes_files() {
    let desc = one_material(Bsdf::Mirror { reflectance: Rgb::ONE });
    let xml = save(&desc, Path::new("a/s.xml"), false).unwrap();
    assert!(
        xml.text.contains("<shape type=\"rectangle\">")
            && xml.text.contains("value=\"s_meshes/mesh_0001.ply\"")
    );
    assert_eq!(
        xml.meshes.iter().map(|(path, _)| path.as_path()).collect::<Vec<_>>(),
        [Path::new("s_meshes/mesh_0001.ply")]
    );
    let toml = save(&desc, Path::new("s.TOML"), false).unwrap();
    assert!(toml.text.contains("[[quad]]") && toml.text.contains("[[mesh]]"));
}

#[test]
fn what_has_no_word_is_refused_or_replaced() {
    let weights = Bsdf::FixedWeight { color: Rgb::ONE, reflectivity: 0.25, transparency: 0.25, ior: 1.5 };
    let desc = one_material(weights);
    let error = save(&desc, Path::new("s.xml"), false).unwrap_err().to_string();
    assert!(
        error.starts_with(
            "material `(none)` of fixed weights cannot be written as Mitsuba's XML; allowed: diffuse"
        ),
        "{error}"
    );
    let lenient = save(&desc, Path::new("s.xml"), true).unwrap();
    assert!(
        lenient.text.contains("value=\"0.5, 0.5, 0.5\"")
            && lenient.warnings[0].contains("diffuse share alone")
    );
    assert_eq!(bare(&there_and_back(&desc, "s.toml")), bare(&normal_form(desc.clone())));
    let error = save(&desc, Path::new("s.yaml"), false).unwrap_err().to_string();
    assert!(error.starts_with("s.yaml: unknown kind of scene file; allowed:"), "{error}");
}

/// A picture of 4 x 2 numbers in a file.
fn picture(folder: &TempDir, name: &str, encoding: Encoding) -> Arc<Texture> {
    let value = |k: i32| {
        if name.starts_with("grey") {
            Rgb::splat(0.1 * k as f32)
        } else {
            Rgb::new(0.1 * k as f32, 0.5, 0.25)
        }
    };
    let image = Image::from_pixels(4, 2, (1..9).map(value).collect()).unwrap();
    let path = folder.path().join(name);
    if name.ends_with("exr") {
        write_exr(&path, &image, &Metadata::default()).unwrap();
    } else {
        write_png(&path, &image, &Display::default()).unwrap();
    }
    let text = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><bsdf type='diffuse'><texture name='reflectance' type='bitmap'>\
         <string name='filename' value='{name}'/><boolean name='raw' value='{}'/></texture></bsdf></scene>",
        encoding == Encoding::Plain
    );
    let scene = folder.path().join("picture.xml");
    fs::write(&scene, text).unwrap();
    load(&scene).unwrap().materials[0].textures.color.clone().unwrap()
}

/// A quad, a mesh with and one without texture coordinates, and a sphere.
fn pictured(bsdf: Bsdf, textures: Textures, with_sphere: bool) -> SceneDesc {
    let largest = textures.color.as_ref().map(|texture| texture.max());
    let mut desc = one_material(largest.map_or(bsdf, |color| bsdf.with_color(color)));
    desc.materials[0].textures = textures;
    let mut smooth = desc.meshes[0].clone();
    smooth.normals = Some(vec![Vec3::Z; 4]);
    smooth.uvs = Some([(0.1, 1e-9), (0.7, -3.3), (0.0, 1.0), (7.5, 0.3)].map(Vec2::from).to_vec());
    desc.meshes.push(smooth);
    let (center, radius, material) = (Vec3::new(0.1, 2.0, -3.7), 0.3, 0);
    desc.spheres = if with_sphere { vec![SphereDesc { center, radius, material }] } else { Vec::new() };
    desc
}

#[test]
fn pictures_come_back_with_the_places_that_show_them() {
    let folder = tempfile::tempdir().unwrap();
    let color = |name, encoding| Some(picture(&folder, name, encoding));
    let (eta, k, reflectance) = (Rgb::ONE, Rgb::ONE, Rgb::ONE);
    let rough = |interface| {
        let alpha = picture(&folder, "grey.png", Encoding::Plain).max().x;
        Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface })
    };
    let kinds = [
        (Bsdf::Diffuse { albedo: Rgb::ONE }, color("a.png", Encoding::Colour)),
        (Bsdf::Diffuse { albedo: Rgb::ONE }, color("a.png", Encoding::Plain)),
        (Bsdf::Mirror { reflectance }, color("a.exr", Encoding::Plain)),
        (Bsdf::Conductor { eta, k, reflectance }, color("a.exr", Encoding::Colour)),
        (Bsdf::Plastic(Plastic::new(Rgb::ONE, 1.5, true)), color("a.png", Encoding::Colour)),
        (rough(Interface::Conductor { eta, k, reflectance }), color("a.exr", Encoding::Colour)),
        (rough(Interface::Dielectric { ior: 1.5 }), None),
    ];
    for ((bsdf, color), with_sphere) in
        kinds.into_iter().flat_map(|kind| [(kind.clone(), false), (kind, true)])
    {
        let grey = Some(picture(&folder, "grey.png", Encoding::Plain));
        let roughness = if matches!(bsdf, Bsdf::Rough(_)) { grey } else { None };
        let textures = Textures { color, ..Textures::NONE };
        let desc = pictured(bsdf, Textures { roughness, ..textures }, with_sphere);
        for name in ["s.toml", "s.xml"] {
            let back = there_and_back(&desc, name);
            assert_eq!(bare(&back), bare(&normal_form(desc.clone())), "{name} {bsdf:?} {with_sphere}");
        }
    }
}

#[test]
fn pictures_are_rectangles_in_xml_but_beside_spheres() {
    let folder = tempfile::tempdir().unwrap();
    let color = Some(picture(&folder, "a.png", Encoding::Colour));
    let text = |with_sphere| {
        let desc = pictured(
            Bsdf::Diffuse { albedo: Rgb::ONE },
            Textures { color: color.clone(), ..Textures::NONE },
            with_sphere,
        );
        let saved = save(&desc, Path::new("x/s.xml"), false).unwrap();
        assert_eq!(saved.pictures.len(), 1);
        assert_eq!(saved.pictures[0].0, Path::new("s_pictures/a.png"));
        saved.text
    };
    let (flat, round) = (text(false), text(true));
    assert!(flat.contains("type=\"rectangle\"") && flat.contains("value=\"s_pictures/a.png\""), "{flat}");
    assert!(
        flat.contains("<scale x=\"1\" y=\"-1\"/>") && round.contains("<scale x=\"-1\" y=\"-1\"/>"),
        "{round}"
    );
    assert!(!round.contains("type=\"rectangle\""), "{round}");
}

#[test]
fn roughness_by_colours_is_refused_in_xml() {
    let folder = tempfile::tempdir().unwrap();
    let roughness = Some(picture(&folder, "a.png", Encoding::Plain));
    let facets = Ggx { alpha: 1.0 };
    let bsdf = Bsdf::Rough(RoughSurface { facets, interface: Interface::Dielectric { ior: 1.5 } });
    let desc = pictured(bsdf, Textures { roughness, ..Textures::NONE }, false);
    let error = save(&desc, Path::new("s.xml"), false).unwrap_err().to_string();
    assert!(error.contains("picture of colours") && error.contains("allowed: grey pictures"), "{error}");
    assert!(save(&desc, Path::new("s.xml"), true).unwrap().warnings[0].contains("luminance"));
}
