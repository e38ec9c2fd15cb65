//! What several commands take.

use clap::{Args, ValueEnum};

use super::values::{definition, number, size, threads};
use crate::live_view::Address;
use crate::output;
use crate::scene::{self, Access};

/// What every method of rendering takes.
#[derive(Args, Debug)]
pub struct RunArgs {
    /// Who answers what rays hit
    #[arg(long, value_enum, default_value_t = Traversal::Embree)]
    pub traversal: Traversal,
    /// Width and height of the picture in pixels [default: the scene's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<(u32, u32)>,
    /// Key of all random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Threads; the picture does not depend on them [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Stop after the pass or sample in which so many seconds are over
    #[arg(long, allow_negative_numbers = true, value_name = "SECONDS", value_parser = |s: &str| number(s, 0.0..=1e9))]
    pub time: Option<f64>,
    #[command(flatten)]
    pub display: DisplayArgs,
    /// Show the picture under way in the viewer tev that listens there; a PORT alone is of this machine (tev: 14158)
    #[arg(long, value_name = "HOST:PORT")]
    pub display_server: Option<Address>,
    /// Leave command line and measured seconds out of the EXR's header, so that equal pictures are equal files
    #[arg(long)]
    pub reproducible: bool,
    /// Write the picture in 16 bits a sample: larger values than 65504 become that, and are counted
    #[arg(long)]
    pub half: bool,
    #[command(flatten)]
    pub access: AccessArgs,
}

/// What a scene may read and ask for, and how it is read.
#[derive(Args, Clone, Debug)]
pub struct AccessArgs {
    /// Value of a parameter `$NAME` of a Mitsuba scene, before its own <default>; may be given again
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = definition)]
    pub definitions: Vec<(String, String)>,
    /// Leave out what a Mitsuba scene holds that is not supported, and say what the picture lacks, rather than refuse it
    #[arg(long)]
    pub lenient: bool,
    /// Trust the scene with nothing: refuse files outside its folder, and pictures, counts and meshes beyond limits
    /// (docs/scenes.md lists them)
    #[arg(long)]
    pub sandbox: bool,
}

impl From<&AccessArgs> for Access {
    fn from(args: &AccessArgs) -> Access {
        let access = if args.sandbox { Access::sandbox() } else { Access::any() };
        access.defining(args.definitions.iter().cloned().collect()).lenient(args.lenient)
    }
}

#[derive(Args, Debug)]
pub struct DisplayArgs {
    /// Exposure of PNGs in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f32,
    /// How PNGs show what is bright
    #[arg(long, value_enum, default_value_t = Curve::Plain)]
    pub curve: Curve,
    /// Gamma of PNGs
    #[arg(long, value_name = "G", default_value_t = 2.2, value_parser = |s: &str| number(s, 0.01..=100.0).map(|g| g as f32))]
    pub gamma: f32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Curve {
    /// As it is, cut off at white
    Plain,
    /// Highlights fade like those of film (ACES, fitted by Narkowicz)
    Filmic,
}

impl From<Curve> for output::Curve {
    fn from(curve: Curve) -> output::Curve {
        match curve {
            Curve::Plain => output::Curve::Plain,
            Curve::Filmic => output::Curve::Filmic,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Traversal {
    /// Embree 4
    Embree,
    /// Embree 4 that may let a ray slip through between adjacent triangles
    EmbreeFast,
    /// The program's own tree of triangles and spheres
    Custom,
}

impl From<Traversal> for scene::Traversal {
    fn from(traversal: Traversal) -> scene::Traversal {
        match traversal {
            Traversal::Embree => scene::Traversal::Embree,
            Traversal::EmbreeFast => scene::Traversal::EmbreeFast,
            Traversal::Custom => scene::Traversal::Custom,
        }
    }
}
