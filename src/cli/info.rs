use std::fmt;

use serde::Serialize;

use super::args::InfoArgs;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use super::loading::load;
use super::memory;
use crate::bsdf::{Bsdf, Ggx, Interface, Plastic, RoughSurface};
use crate::embree::Device;
use crate::ppm::{Render, Settings, SetupStatistics, camera_pass};
use crate::scene::{Material, Scene, SceneDesc};

/// Says what a scene holds, and what its eye pass finds.
pub fn run(args: &InfoArgs) -> Result<Outcome, CliError> {
    let desc = load(&args.scene, &args.access)?;
    let contents = Contents::of(&desc)?;
    let settings = Settings::of_scene(&desc.render);
    memory::check_render(&desc, &settings)?;
    let scene = Scene::with_traversal(desc, args.traversal.into())?;
    let render = Render::new(&scene, settings);
    let info = Info {
        contents,
        traversal: scene.traversal().to_string(),
        lights: scene.lights().len(),
        flux_watts: scene.lights().flux().to_array(),
        extent: scene.bounds().extent().to_array(),
        setup: *render.setup(),
        radius_found: settings.radius.is_none(),
        depth: settings.depth,
        cuts: cuts(&scene, &settings),
        memory_bytes: render.memory_bytes(),
        peak_memory_bytes: memory::peak_bytes(),
    };
    if args.json {
        print_json(&info)?;
    } else {
        print(info)?;
    }
    Ok(Outcome::Done)
}

#[derive(Serialize)]
struct Info {
    #[serde(flatten)]
    contents: Contents,
    traversal: String,
    lights: usize,
    flux_watts: [f32; 3],
    extent: [f32; 3],
    setup: SetupStatistics,
    radius_found: bool,
    depth: u32,
    cuts: Vec<Cut>,
    memory_bytes: usize,
    peak_memory_bytes: Option<u64>,
}

/// What the scene file says.
#[derive(Serialize)]
struct Contents {
    scene: String,
    embree: String,
    resolution: [u32; 2],
    filter: String,
    lens_radius: f32,
    focus_distance: f32,
    samples: u32,
    passes: u32,
    photons: u64,
    alpha: f64,
    materials: Vec<String>,
    meshes: usize,
    triangles: usize,
    spheres: usize,
}

impl Contents {
    fn of(desc: &SceneDesc) -> Result<Contents, CliError> {
        let embree = Device::new()?.version().to_string();
        Ok(Contents {
            scene: desc.path.display().to_string(),
            embree,
            resolution: [desc.film.width, desc.film.height],
            filter: desc.film.filter.to_string(),
            lens_radius: desc.camera.lens_radius,
            focus_distance: desc.camera.focus_distance,
            samples: desc.render.samples,
            passes: desc.render.passes,
            photons: desc.render.photons,
            alpha: desc.render.alpha,
            materials: desc.materials.iter().map(describe).collect(),
            meshes: desc.meshes.len(),
            triangles: desc.meshes.iter().map(|m| m.triangles.len()).sum(),
            spheres: desc.spheres.len(),
        })
    }
}

fn describe(material: &Material) -> String {
    let kind = match material.bsdf {
        Bsdf::Diffuse { albedo } => format!("diffuse, albedo {albedo}"),
        Bsdf::Mirror { reflectance } => format!("mirror, reflectance {reflectance}"),
        Bsdf::Dielectric { ior } => format!("dielectric, ior {ior}"),
        Bsdf::ThinDielectric { ior } => format!("pane, ior {ior}"),
        Bsdf::Conductor { eta, k, reflectance } => {
            format!("conductor, eta {eta}, k {k}, reflectance {reflectance}")
        }
        Bsdf::Plastic(Plastic { base, ior, .. }) => format!("plastic, base {base}, ior {ior}"),
        Bsdf::Rough(RoughSurface { facets: Ggx { alpha }, interface }) => match interface {
            Interface::Conductor { eta, k, reflectance } => {
                format!("rough conductor, alpha {alpha}, eta {eta}, k {k}, reflectance {reflectance}")
            }
            Interface::Dielectric { ior } => format!("rough dielectric, alpha {alpha}, ior {ior}"),
        },
        Bsdf::FixedWeight { color, reflectivity, transparency, ior } => format!(
            "fixed weights, color {color}, reflectivity {reflectivity}, transparency {transparency}, ior {ior}"
        ),
    };
    let emission = material.emission;
    let light = if emission.max_element() > 0.0 { format!(", emits {emission}") } else { String::new() };
    format!("{}: {kind}{light}", material.name)
}

/// The share of the picture's weight that a depth limit loses.
#[derive(Serialize)]
struct Cut {
    depth: u32,
    lost_share: f64,
}

/// Measured with one eye sample a pixel.
fn cuts(scene: &Scene, settings: &Settings) -> Vec<Cut> {
    let cut = |depth| {
        let eye = camera_pass::trace(scene, &Settings { depth, samples: 1, ..*settings }, 0);
        Cut { depth, lost_share: eye.cut_weight }
    };
    [0, 1, 2, 4, 8].into_iter().filter(|&d| d < settings.depth).chain([settings.depth]).map(cut).collect()
}

impl fmt::Display for Info {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Info { contents: c, setup, .. } = self;
        writeln!(f, "scene        {} (Embree {})", c.scene, c.embree)?;
        writeln!(
            f,
            "picture      {} x {}, {} eye samples a pixel, filter {}",
            c.resolution[0], c.resolution[1], c.samples, c.filter
        )?;
        if c.lens_radius > 0.0 {
            writeln!(f, "lens         of radius {}, sharp at {}", c.lens_radius, c.focus_distance)?;
        }
        writeln!(f, "passes       {} of {} photons, alpha {}", c.passes, c.photons, c.alpha)?;
        writeln!(f, "geometry     {} triangles in {} meshes, {} spheres", c.triangles, c.meshes, c.spheres)?;
        writeln!(f, "traversal    {}", self.traversal)?;
        writeln!(f, "extent       {:?}", self.extent)?;
        writeln!(f, "lights       {} with power, flux {:?} W", self.lights, self.flux_watts)?;
        for material in &c.materials {
            writeln!(f, "material     {material}")?;
        }
        writeln!(f, "hit points   {} from {} eye rays", setup.hit_points, setup.eye_rays)?;
        let origin = if self.radius_found { "found: two pixels wide" } else { "the scene's" };
        writeln!(f, "radius       {:.5} ({origin})", setup.radius)?;
        for Cut { depth, lost_share } in &self.cuts {
            writeln!(f, "depth {depth:<3}    loses {:.5} % of the picture's weight", 100.0 * lost_share)?;
        }
        writeln!(f, "memory       {:.1} MB for the render's data", self.memory_bytes as f64 / 1e6)?;
        let peak = self.peak_memory_bytes.map_or("unknown".into(), |b| format!("{:.1} MB", b as f64 / 1e6));
        writeln!(f, "peak memory  {peak}")
    }
}
