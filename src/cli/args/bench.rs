use std::path::PathBuf;

use clap::{ArgGroup, Args};

use super::values::{count, count_up_to, number, threads};

/// The questions of which none is about the photon pass, and those of which none is about gathering.
const NO_PASS: [&str; 6] = ["gather", "rays", "leaks", "numerics", "aim", "guide"];
const NO_GATHERING: [&str; 6] = ["pass", "rays", "leaks", "numerics", "aim", "guide"];

#[derive(Args, Debug)]
#[command(group(ArgGroup::new("question").required(true).args(["pass", "gather", "rays", "leaks", "numerics", "aim", "guide"])), after_help = "\
Examples:
  caustica bench --pass data/course_diffuse.toml --json -
  caustica bench --pass data/cornell_b.toml --radius 10 --samples 1 --photons 1e5 --html out/pass.html
  caustica bench --gather --points 1e5,1e6 --radii 0.1,1,5 --csv out/gather.csv --html out/gather.html
  caustica bench --gather --scene data/cornell_b.toml --points 1e5,1e6 --radii 0.1,1 --photons 1e5
  caustica bench --rays --triangles 36,1e6 --html out/rays.html
  caustica bench --leaks 1e7
  caustica bench --numerics
  caustica bench --aim data/glass_bead.toml --passes 20
  caustica bench --guide data/keyhole.toml --passes 20

Times depend on what else the machine does: look at the smallest and largest beside the medians.")]
pub struct BenchArgs {
    /// Measure the photon pass of this scene (TOML, or XML of Mitsuba 3) against tracing its rays and nothing else
    #[arg(long, value_name = "SCENE")]
    pub pass: Option<PathBuf>,
    /// Measure the sphere tree against Embree's point query, a hash grid and a k-d tree, on the walls of a box
    #[arg(long)]
    pub gather: bool,
    /// Gather the photons of a pass through this scene (TOML, or XML of Mitsuba 3) at its hit points, rather than on walls
    #[arg(long, conflicts_with_all = NO_GATHERING, value_name = "SCENE")]
    pub scene: Option<PathBuf>,
    /// Measure rays of real renders: Embree in all its ways, and the program's own tree
    #[arg(long)]
    pub rays: bool,
    /// Count how many of N rays, aimed at their edges and vertices, slip out of closed meshes
    #[arg(long, value_name = "N", value_parser = count)]
    pub leaks: Option<u64>,
    /// Measure what precision buys, in renders of PASSES passes
    #[arg(long, value_name = "PASSES", num_args = 0..=1, default_missing_value = "20000", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub numerics: Option<u32>,
    /// Measure what photons aimed at mirrors and glass gain in this scene (TOML, or XML of Mitsuba 3)
    #[arg(long, value_name = "SCENE")]
    pub aim: Option<PathBuf>,
    /// Measure what photons guided to what is seen gain in this scene (TOML, or XML of Mitsuba 3)
    #[arg(long, value_name = "SCENE")]
    pub guide: Option<PathBuf>,
    /// Passes of every run with --aim and --guide
    #[arg(long, conflicts_with_all = ["pass", "gather", "rays", "leaks", "numerics"], allow_negative_numbers = true, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub passes: u32,
    /// Gather radius of the pass in scene units [default: the scene's, or two pixels wide]
    #[arg(long, conflicts_with_all = NO_PASS, allow_negative_numbers = true, value_name = "R", value_parser = |s: &str| number(s, 1e-30..=1e30))]
    pub radius: Option<f64>,
    /// Eye samples a pixel of the pass, 1 to 4096 [default: the scene's]
    #[arg(long, conflicts_with_all = NO_PASS, allow_negative_numbers = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub samples: Option<u32>,
    /// Trace the eye paths and build the tree anew in every pass
    #[arg(long, conflicts_with_all = NO_PASS)]
    pub retrace: bool,
    /// Keep caustics and indirect light apart in the pass
    #[arg(long, conflicts_with_all = NO_PASS)]
    pub apart: bool,
    /// Numbers of spheres to gather among [default: 1e4,1e5,1e6,4e6]
    #[arg(long, conflicts_with_all = NO_GATHERING, value_name = "N,..", value_delimiter = ',', value_parser = points)]
    pub points: Vec<u64>,
    /// Their radii in percent of the longest side of box or scene [default: 0.05,0.1,0.4,1, and 5 without --scene]
    #[arg(long, conflicts_with_all = NO_GATHERING, value_name = "PERCENT,..", value_delimiter = ',', value_parser = |s: &str| number(s, 1e-3..=100.0))]
    pub radii: Vec<f64>,
    /// Choose the radius for each number of spheres so that a photon lies in about so many
    #[arg(long, conflicts_with_all = ["radii", "scene", "pass", "rays", "leaks", "numerics", "aim", "guide"], value_name = "K", value_parser = |s: &str| number(s, 1e-3..=1e6))]
    pub overlaps: Option<f64>,
    /// Also measure other sphere trees: costs by volume, smaller leaves, lanes of each instruction set
    #[arg(long, conflicts_with_all = NO_GATHERING)]
    pub variants: bool,
    /// Numbers of triangles, at least, to trace rays among [default: 36,2e4,131072,1e6]
    #[arg(long, conflicts_with_all = ["pass", "gather", "leaks", "numerics", "aim", "guide"], value_name = "N,..", value_delimiter = ',', value_parser = triangles)]
    pub triangles: Vec<u64>,
    /// Photons, and of rays about as many eye paths [default: the scene's, or 100000]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = count)]
    pub photons: Option<u64>,
    /// Rounds to measure
    #[arg(long, value_name = "K", default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repetitions: u32,
    /// Threads [default: all]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    /// Write everything as JSON; - is standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the table as CSV; - is standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with plots and table, for a browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// So many spheres that a 32-bit number still counts the cells of a grid that each of them touches.
fn points(text: &str) -> Result<u64, String> {
    count_up_to(100_000_000, text)
}

/// So many triangles that seven trees over them fit into the memory of most machines.
fn triangles(text: &str) -> Result<u64, String> {
    count_up_to(20_000_000, text)
}
