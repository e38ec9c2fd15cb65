//! By what a checkpoint knows its render again: everything that the picture depends on, by name.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::embree::{Device, EmbreeError};
use crate::math::{Rgb, Vec3};
use crate::ppm::Settings;
use crate::scene::{CameraDesc, FilmDesc, LightDesc, Material, Mesh, SceneDesc, Textures, Traversal};

/// Differences that are told one by one.
const TOLD: usize = 12;

/// Names and values, in order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Facts(Vec<(String, String)>);

impl Facts {
    /// Those of a render: program, settings, and the scene as it was read. Names of files are no part of it, nor are the number of passes
    /// and of threads.
    ///
    /// # Errors
    /// If Embree, where it is used, does not start.
    pub fn of(desc: &SceneDesc, settings: &Settings, traversal: Traversal) -> Result<Facts, EmbreeError> {
        let mut facts = Facts::default();
        facts.add("version", env!("CARGO_PKG_VERSION"));
        facts.add("traversal", traversal);
        if traversal != Traversal::Custom {
            facts.add("embree", Device::new()?.version());
        }
        facts.add_settings(settings);
        facts.add_scene(desc);
        Ok(facts)
    }

    /// What `self`, a checkpoint's, has other than `here`, the render that it is to go on in: a sentence for each, and if there
    /// are many, one for the rest.
    pub fn differences(&self, here: &Facts) -> Vec<String> {
        self.differences_between(here, ["the checkpoint", "this render"])
    }

    /// The same by other names for the two.
    pub fn differences_between(&self, here: &Facts, [self_name, here_name]: [&str; 2]) -> Vec<String> {
        let [theirs, ours] = [self, here].map(Facts::by_name);
        let gone = self.0.iter().filter(|(name, _)| !ours.contains_key(name.as_str()));
        let names = here.0.iter().chain(gone).map(|(name, _)| name.as_str());
        let told = |value: Option<&&str>| value.map_or_else(|| "none".into(), ToString::to_string);
        let mut differences: Vec<String> = names
            .map(|name| (name, theirs.get(name), ours.get(name)))
            .filter(|(_, theirs, ours)| theirs != ours)
            .map(|(name, theirs, ours)| {
                format!("{name}: {self_name} has {}, {here_name} {}", told(theirs), told(ours))
            })
            .collect();
        if differences.len() > TOLD {
            let rest = differences.split_off(TOLD).len();
            differences.push(format!("and {rest} more"));
        }
        differences
    }

    fn by_name(&self) -> BTreeMap<&str, &str> {
        self.0.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect()
    }

    fn add(&mut self, name: impl Into<String>, value: impl ToString) {
        self.0.push((name.into(), value.to_string()));
    }

    /// Named one by one, so that a new setting cannot be forgotten.
    fn add_settings(&mut self, settings: &Settings) {
        let Settings {
            samples,
            depth,
            photons,
            alpha,
            radius,
            policy,
            precision,
            sampling,
            seed,
            eye_seed: _,
            eye_paths,
            error_estimates,
            transport,
            kinds,
            caustic_photons,
            guiding,
            planning,
        } = *settings;
        self.add("samples", samples);
        self.add("depth", depth);
        self.add("photons", photons);
        self.add("alpha", alpha);
        self.add(
            "radius",
            radius.map_or_else(|| "found: two pixels wide".into(), |radius| radius.to_string()),
        );
        self.add("radius policy", policy);
        self.add("precision", lower_case(precision));
        self.add("sampling", lower_case(sampling));
        self.add("seed", seed);
        self.add("eye seed", settings.key_of_eye_paths());
        self.add(
            "eye paths",
            eye_paths.map_or_else(|| "as the scene calls for".into(), |paths| paths.to_string()),
        );
        self.add("error estimates", lower_case(error_estimates));
        self.add("transport", transport);
        self.add("kinds of light", lower_case(kinds));
        self.add("caustic photons", caustic_photons);
        self.add("guiding", guiding);
        self.add("planning", lower_case(planning));
    }

    fn add_scene(&mut self, desc: &SceneDesc) {
        let SceneDesc {
            name: _,
            path: _,
            film: FilmDesc { width, height, filter },
            camera,
            render: _,
            materials,
            spheres,
            meshes,
            point_lights,
            further_lights,
            warnings: _,
            places: _,
        } = desc;
        self.add("size", format!("{width}x{height}"));
        self.add("pixel filter", filter);
        self.add_camera(camera);
        for (material, number) in materials.iter().zip(1..) {
            self.add_material(material, number);
        }
        for (light, number) in point_lights.iter().zip(1..) {
            self.add(format!("point light {number}"), format!("{light:?}"));
        }
        for (light, number) in further_lights.iter().zip(1..) {
            self.add(format!("light {number}"), light_fact(light));
        }
        for (sphere, number) in spheres.iter().zip(1..) {
            self.add(format!("sphere {number}"), format!("{sphere:?}"));
        }
        for (mesh, number) in meshes.iter().zip(1..) {
            self.add(format!("mesh {number} ({})", file_name(&mesh.name)), shape(mesh));
        }
    }

    fn add_camera(&mut self, camera: &CameraDesc) {
        let CameraDesc { position, look_at, up, fov_degrees, lens_radius, focus_distance } = camera;
        for (name, value) in [("position", position), ("look_at", look_at), ("up", up)] {
            self.add(format!("camera {name}"), value);
        }
        self.add("camera fov", fov_degrees);
        self.add("camera lens_radius", lens_radius);
        if *lens_radius > 0.0 {
            self.add("camera focus_distance", focus_distance);
        }
    }

    fn add_material(&mut self, material: &Material, number: u32) {
        let Material { name, bsdf, emission, opacity, absorption, textures } = material;
        let name = format!("material {number} ({})", file_name(name));
        self.add(name.clone(), format!("{bsdf:?}, emission {emission}"));
        if *absorption != Rgb::ZERO {
            self.add(format!("{name} absorption"), absorption);
        }
        if *opacity != 1.0 {
            self.add(format!("{name} opacity"), opacity);
        }
        let Textures { color, roughness, opacity } = textures;
        for (slot, texture) in [("color", color), ("roughness", roughness), ("picture of opacity", opacity)] {
            if let Some(texture) = texture {
                self.add(format!("{name} {slot}"), content(texture.image().pixels()));
            }
        }
    }
}

fn lower_case(value: impl std::fmt::Debug) -> String {
    format!("{value:?}").to_lowercase()
}

/// Scenes may be moved to another folder.
fn file_name(name: &str) -> String {
    Path::new(name).file_name().map_or_else(|| name.into(), |name| name.to_string_lossy().into_owned())
}

/// Of a picture all around its content.
fn light_fact(light: &LightDesc) -> String {
    match light {
        LightDesc::Panorama { file: _, panorama } => {
            let content = content(panorama.picture().pixels());
            format!("panorama x {} turned {}, {content}", panorama.scale(), panorama.turn())
        }
        other => format!("{other:?}"),
    }
}

fn content(pixels: &[Vec3]) -> String {
    let mut hasher = blake3::Hasher::new();
    hash_vectors(&mut hasher, pixels);
    let hash = hasher.finalize().to_hex();
    format!("content {}", &hash[..16])
}

/// The size of a mesh, and a hash of all its numbers.
fn shape(mesh: &Mesh) -> String {
    let Mesh { name: _, vertices, normals, uvs, triangles, materials } = mesh;
    let mut hasher = blake3::Hasher::new();
    hash_vectors(&mut hasher, vertices);
    hash_vectors(&mut hasher, normals.as_deref().unwrap_or_default());
    let uvs = uvs.as_deref().unwrap_or_default();
    hash_numbers(&mut hasher, uvs.iter().flat_map(|uv| uv.to_array().map(f32::to_bits)));
    hash_numbers(&mut hasher, triangles.iter().flatten().copied());
    hash_numbers(&mut hasher, materials.iter().copied());
    let hash = hasher.finalize().to_hex();
    format!("{} vertices, {} triangles, content {}", vertices.len(), triangles.len(), &hash[..16])
}

fn hash_vectors(hasher: &mut blake3::Hasher, vectors: &[Vec3]) {
    hash_numbers(hasher, vectors.iter().flat_map(|v| v.to_array().map(f32::to_bits)));
}

/// With their number, so that one list cannot pass for the beginning of the next.
fn hash_numbers(hasher: &mut blake3::Hasher, numbers: impl Iterator<Item = u32>) {
    let bytes: Vec<u8> = numbers.flat_map(u32::to_le_bytes).collect();
    hasher.update(&(bytes.len() as u64).to_le_bytes());
    hasher.update(&bytes);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::EyePaths;
    use crate::ppm::{ErrorEstimates, Precision, RadiusPolicy};
    use crate::scene;

    fn desc() -> SceneDesc {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cornell_b.toml");
        scene::load(&path).unwrap()
    }

    fn facts(desc: &SceneDesc, settings: &Settings) -> Facts {
        Facts::of(desc, settings, Traversal::Custom).unwrap()
    }

    #[test]
    fn every_setting_is_named() {
        let desc = desc();
        let ours = Settings { alpha: 0.5, ..Settings::of_scene(&desc.render) };
        for (name, theirs) in [
            ("samples", Settings { samples: 17, ..ours }),
            ("depth", Settings { depth: 3, ..ours }),
            ("photons", Settings { photons: 3, ..ours }),
            ("alpha", Settings { alpha: 0.7, ..ours }),
            ("radius", Settings { radius: Some(17.0), ..ours }),
            ("radius policy", Settings { policy: RadiusPolicy::Shared, ..ours }),
            ("precision", Settings { precision: Precision::Single, ..ours }),
            ("sampling", Settings { sampling: crate::bsdf::DiffuseSampling::Uniform, ..ours }),
            ("seed", Settings { seed: 1, eye_seed: Some(0), ..ours }),
            ("eye seed", Settings { eye_seed: Some(4), ..ours }),
            ("eye paths", Settings { eye_paths: Some(EyePaths::Retraced), ..ours }),
            ("error estimates", Settings { error_estimates: ErrorEstimates::Pixels, ..ours }),
            ("guiding", Settings { guiding: crate::ppm::Guiding::Off, ..ours }),
        ] {
            let differences = facts(&desc, &theirs).differences(&facts(&desc, &ours));
            assert!(
                differences.len() == 1 && differences[0].starts_with(&format!("{name}: ")),
                "{differences:?}"
            );
        }
        let theirs = facts(&desc, &Settings { alpha: 0.7, ..ours });
        assert_eq!(
            theirs.differences(&facts(&desc, &ours)),
            ["alpha: the checkpoint has 0.7, this render 0.5"]
        );
        let embree = Facts::of(&desc, &ours, Traversal::Embree).unwrap();
        let names = embree.differences(&facts(&desc, &ours)).join("\n");
        assert!(names.contains("traversal: ") && names.contains("embree: "), "{names}");
    }

    type Change = fn(&mut SceneDesc);

    #[test]
    fn every_part_of_the_scene_is_named() {
        let mut ours = desc();
        ours.camera.lens_radius = 0.1;
        let settings = Settings::of_scene(&ours.render);
        let changes: [(&str, Change); 12] = [
            ("size", |desc| desc.film.width = 7),
            ("pixel filter", |desc| desc.film.filter = scene::PixelFilter::Box),
            ("camera lens_radius", |desc| desc.camera.lens_radius = 0.2),
            ("camera focus_distance", |desc| {
                (desc.camera.lens_radius, desc.camera.focus_distance) = (0.1, 7.0);
            }),
            ("camera look_at", |desc| desc.camera.look_at.x += 1e-3),
            ("camera fov", |desc| desc.camera.fov_degrees += 0.1),
            ("material 1 ", |desc| desc.materials[0].emission.y += 1.0),
            ("mesh 1 ", |desc| desc.meshes[0].vertices[2].z += 1e-3),
            ("mesh 1 ", |desc| desc.meshes[0].triangles[0].reverse()),
            ("mesh 1 ", |desc| desc.meshes[0].materials[0] += 1),
            ("mesh 2 ", |desc| desc.meshes[1].normals = Some(desc.meshes[1].vertices.clone())),
            ("sphere 1", |desc| {
                desc.spheres.insert(0, scene::SphereDesc { center: Vec3::ONE, radius: 1.0, material: 0 })
            }),
        ];
        for (name, change) in changes {
            let mut theirs = ours.clone();
            change(&mut theirs);
            let differences = facts(&theirs, &settings).differences(&facts(&ours, &settings));
            assert!(differences[0].starts_with(name), "{name}: {differences:?}");
        }
    }

    #[test]
    fn names_of_folders_and_the_passes_do_not_matter() {
        let ours = desc();
        let settings = Settings::of_scene(&ours.render);
        let mut moved = ours.clone();
        moved.path = "elsewhere/scene.toml".into();
        moved.name = "scene".into();
        moved.render.passes += 1;
        moved.meshes.iter_mut().for_each(|mesh| mesh.name = format!("elsewhere/{}", mesh.name));
        assert_eq!(facts(&moved, &settings), facts(&ours, &settings));
    }

    #[test]
    fn many_differences_are_summed_up() {
        let many = Facts((0..40).map(|k| (format!("light {k}"), String::new())).collect());
        let differences = many.differences(&Facts::default());
        assert_eq!(differences.len(), TOLD + 1);
        assert_eq!(
            (differences[0].as_str(), differences[TOLD].as_str()),
            ("light 0: the checkpoint has , this render none", "and 28 more")
        );
    }
}
