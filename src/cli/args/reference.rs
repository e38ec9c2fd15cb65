use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::RunArgs;
use crate::reference;

#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  caustica reference data/cornell_a.toml --spp 1024 -o out/cornell_a_reference.exr
  caustica reference data/cornell_b.toml --method light --spp 256 -o out/cornell_b_light.exr

Path tracing misses point lights through glass, water and masks, light tracing what is seen in mirrors or
through them; elsewhere both tend to the same picture, and light tracing has far less noise in caustics.
Beside FILE.exr and FILE.png it writes FILE_stderr.exr: the standard error of every pixel and channel.

A flag --some-name may be given as the variable CAUSTICA_SOME_NAME, too. Flags win over variables, those over the
scene file; docs/configuration.md tells more.")]
pub struct ReferenceArgs {
    /// The scene (TOML, or XML of Mitsuba 3)
    pub scene: PathBuf,
    /// Where paths start
    #[arg(long, value_enum, default_value_t = Method::Path)]
    pub method: Method,
    /// Samples a pixel; one of light tracing is as many light paths as there are pixels
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// The picture [default: out/SCENE_reference.exr, with --method light out/SCENE_reference_light.exr]
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub run: RunArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Method {
    /// At the camera: path tracing with shadow rays
    Path,
    /// At the lights: every diffuse bounce is connected to the camera
    Light,
}

impl From<Method> for reference::Method {
    fn from(method: Method) -> reference::Method {
        match method {
            Method::Path => reference::Method::Path,
            Method::Light => reference::Method::Light,
        }
    }
}
