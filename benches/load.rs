//! Seconds to load 1,000,000 triangles of OBJ and PLY, against reading the OBJ and `tobj`'s parse alone, and the peak of memory; and
//! what is left of it for the next frame of an animation, which moves the camera alone.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use caustica::bench::timing::{Spread, interleaved, timed};
use caustica::scene::{Access, MeshMemory, Scene, load, load_with};

/// Two triangles each.
const CELLS: u32 = 708;
const ROUNDS: usize = 7;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// What is measured: the yardstick, and scenes that name a file.
const RIVALS: [&str; 7] = [
    "tobj",
    "mesh.obj",
    "mesh_vn.obj",
    "ascii.ply",
    "binary.ply",
    "next frame of mesh.obj",
    "next frame of binary.ply",
];
const NEXT_FRAME: &str = "next frame of ";

fn main() -> Outcome<()> {
    let folder = tempfile::tempdir()?;
    write_meshes(folder.path())?;
    let samples = interleaved(ROUNDS, &RIVALS, |rival| sample(folder.path(), rival))?;
    let yardstick = Spread::of(samples[0].iter().map(|sample| sample.load)).median;
    println!(
        "| what | MB | seconds to load | of tobj's | seconds of Embree's build | peak in MB |\n|---|---|---|---|---|---|"
    );
    for (rival, samples) in RIVALS.iter().zip(&samples) {
        let load = Spread::of(samples.iter().map(|sample| sample.load));
        let build = Spread::of(samples.iter().map(|sample| sample.build));
        let peak = Spread::of(samples.iter().map(|sample| sample.peak));
        println!(
            "| {rival} | {:.1} | {:.3} ({:.3} to {:.3}) | {:.2} | {:.3} | {:.0} |",
            samples[0].megabytes,
            load.median,
            load.min,
            load.max,
            load.median / yardstick,
            build.median,
            peak.max
        );
    }
    Ok(())
}

struct Sample {
    megabytes: f64,
    load: f64,
    build: f64,
    /// Of the memory of the process while it loads and builds, beyond what it had before.
    peak: f64,
}

fn sample(folder: &Path, rival: &str) -> Outcome<Sample> {
    if let Some(file) = rival.strip_prefix(NEXT_FRAME) {
        return next_frame(folder, file);
    }
    let file = if rival == "tobj" { "mesh.obj" } else { rival };
    let megabytes = fs::metadata(folder.join(file))?.len() as f64 / 1e6;
    let before = forget_peak()?;
    if rival == "tobj" {
        let (read, load) = timed(|| parse_alone(&folder.join(file)));
        read?;
        return Ok(Sample { megabytes, load, build: 0.0, peak: peak_megabytes()? - before });
    }
    let scene = folder.join("scene.toml");
    fs::write(&scene, scene_of(file))?;
    let (desc, load) = timed(|| load(&scene));
    let desc = desc?;
    assert_eq!(desc.meshes[0].triangles.len(), 2 * (CELLS * CELLS) as usize);
    let (built, build) = timed(|| Scene::new(desc));
    built?;
    Ok(Sample { megabytes, load, build, peak: peak_megabytes()? - before })
}

/// The second of two scenes that differ in their cameras.
fn next_frame(folder: &Path, file: &str) -> Outcome<Sample> {
    let megabytes = fs::metadata(folder.join(file))?.len() as f64 / 1e6;
    let access = Access::any().remembering(Arc::new(MeshMemory::default()));
    let path = folder.join("scene.toml");
    fs::write(&path, scene_of(file))?;
    let first = Scene::new(load_with(&path, &access)?)?;
    fs::write(&path, scene_of(file).replace("fov = 40", "fov = 41"))?;
    let before = forget_peak()?;
    let (desc, load) = timed(|| load_with(&path, &access));
    let (second, build) = timed(|| first.successor(desc?).map_err(Box::<dyn Error>::from));
    assert!(second?.shares_tree(&first));
    Ok(Sample { megabytes, load, build, peak: peak_megabytes()? - before })
}

fn parse_alone(path: &Path) -> Outcome<usize> {
    let bytes = fs::read(path)?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    let (models, _) =
        tobj::load_obj_buf(&mut &bytes[..], &options, |_| Err(tobj::LoadError::OpenFileFailed))?;
    Ok(models.len())
}

/// Makes the peak of the process what it holds now, and tells it.
fn forget_peak() -> Outcome<f64> {
    fs::write("/proc/self/clear_refs", "5")?;
    peak_megabytes()
}

fn peak_megabytes() -> Outcome<f64> {
    let status = fs::read_to_string("/proc/self/status")?;
    let line =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")).ok_or("the system tells no peak")?;
    let kibibytes: f64 = line.trim().trim_end_matches("kB").trim().parse()?;
    Ok(kibibytes * 1024.0 / 1e6)
}

fn scene_of(file: &str) -> String {
    format!(
        "[camera]\nposition = [0, 5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, 1]\nfov = 40\n\
         [material.a]\ndiffuse = {{ albedo = [0.5, 0.5, 0.5] }}\n[[mesh]]\nfile = \"{file}\"\nmaterial = \"a\"\n"
    )
}

/// A sheet of waves, with normals or without.
fn write_meshes(folder: &Path) -> Outcome<()> {
    let side = CELLS + 1;
    let points: Vec<[f32; 6]> = (0..side * side).map(|k| point(k % side, k / side)).collect();
    let corner = |x: u32, z: u32| z * side + x;
    let cells = (0..CELLS * CELLS).map(|k| (k % CELLS, k / CELLS));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(x, z)| {
            let [a, b, c, d] = [corner(x, z), corner(x, z + 1), corner(x + 1, z + 1), corner(x + 1, z)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    fs::write(folder.join("mesh.obj"), obj(&points, &triangles, false)?)?;
    fs::write(folder.join("mesh_vn.obj"), obj(&points, &triangles, true)?)?;
    fs::write(folder.join("ascii.ply"), ascii_ply(&points, &triangles)?)?;
    fs::write(folder.join("binary.ply"), binary_ply(&points, &triangles))?;
    Ok(())
}

fn point(x: u32, z: u32) -> [f32; 6] {
    let [x, z] = [x, z].map(|k| k as f32 / CELLS as f32 - 0.5);
    let [slope_x, slope_z] = [0.3 * (9.0 * x).cos(), -0.2 * (7.0 * z).sin()];
    let length = (slope_x * slope_x + slope_z * slope_z + 1.0).sqrt();
    let height = 0.3 / 9.0 * (9.0 * x).sin() + 0.2 / 7.0 * (7.0 * z).cos();
    [x, height, z, -slope_x / length, 1.0 / length, -slope_z / length]
}

fn obj(points: &[[f32; 6]], triangles: &[[u32; 3]], normals: bool) -> Outcome<String> {
    let mut text = String::new();
    for [x, y, z, nx, ny, nz] in points {
        writeln!(text, "v {x:.6} {y:.6} {z:.6}")?;
        if normals {
            writeln!(text, "vn {nx:.4} {ny:.4} {nz:.4}")?;
        }
    }
    for [a, b, c] in triangles.iter().map(|triangle| triangle.map(|index| index + 1)) {
        match normals {
            true => writeln!(text, "f {a}//{a} {b}//{b} {c}//{c}")?,
            false => writeln!(text, "f {a} {b} {c}")?,
        }
    }
    Ok(text)
}

fn header(format: &str, points: usize, triangles: usize) -> String {
    let floats: String =
        ["x", "y", "z", "nx", "ny", "nz"].iter().map(|name| format!("property float {name}\n")).collect();
    format!(
        "ply\nformat {format} 1.0\nelement vertex {points}\n{floats}element face {triangles}\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

fn ascii_ply(points: &[[f32; 6]], triangles: &[[u32; 3]]) -> Outcome<String> {
    let mut text = header("ascii", points.len(), triangles.len());
    for [x, y, z, nx, ny, nz] in points {
        writeln!(text, "{x:.6} {y:.6} {z:.6} {nx:.4} {ny:.4} {nz:.4}")?;
    }
    for [a, b, c] in triangles {
        writeln!(text, "3 {a} {b} {c}")?;
    }
    Ok(text)
}

fn binary_ply(points: &[[f32; 6]], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut bytes = header("binary_little_endian", points.len(), triangles.len()).into_bytes();
    points.iter().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
    for triangle in triangles {
        bytes.push(3);
        triangle.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    bytes
}
