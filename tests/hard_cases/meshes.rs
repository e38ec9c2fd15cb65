//! Meshes as people have them.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use caustica::math::{DVec3, Rgb, Rng, Stream, Vec3};
use caustica::ppm::{Render, Settings};
use caustica::scene::{FilmDesc, Mesh, PointLightDesc, RenderDesc, Scene, SceneDesc, load};

use super::rooms::TRAVERSALS;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

const SCENE: &str =
    "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n[[mesh]]\nfile = 'm.obj'\n";

/// The scene of one mesh, loaded from a folder that also has `files`.
fn load_beside(files: &[(&str, &[u8])]) -> Result<SceneDesc, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("s.toml");
    fs::write(&path, SCENE).unwrap();
    load(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
}

fn read(mesh: impl AsRef<[u8]>) -> Result<SceneDesc, String> {
    load_beside(&[("m.obj", mesh.as_ref())])
}

fn good(mesh: &str) -> Mesh {
    read(mesh).unwrap().meshes.remove(0)
}

fn told(scene: &SceneDesc, words: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(words))
}

/// An index that is 0, no number, or beyond what there is from either end is refused with its line and the range.
///
/// Breaks: the index wraps, the face joins some other vertices, or the program reads beyond an array.
///
/// Mutation: `Scan::check_furthest` checks vertices alone.
#[test]
fn indices_that_count_nothing_are_refused() {
    for (face, line, words) in [
        ("f 0 1 2", 5, "vertex index 0 is out of range; allowed: 1 to 4 or -4 to -1"),
        ("f 1 2 5", 5, "vertex index 5 is out of range; allowed: 1 to 4"),
        ("f 1 2 -5", 5, "vertex index -5 is out of range"),
        ("f 1 2 -9223372036854775808", 5, "is out of range"),
        ("f 1 2 9223372036854775807", 5, "is out of range"),
        ("f 1 2 18446744073709551616", 5, "is not a whole number"),
        ("f 1/1 2/1 3/1", 5, "texture coordinate index 1 is out of range; allowed: none"),
        ("vn 0 0 1\nf 1//1 2//2 3//1", 6, "normal index 2 is out of range"),
        ("f 1 two 3", 5, "`two` is not a whole number"),
        ("f 1.5 2 3", 5, "`1.5` is not a whole number"),
        ("f 1/2/3/4 2 3", 5, "allowed: v, v/vt, v//vn or v/vt/vn"),
    ] {
        let refusal = read(format!("{SQUARE}{face}\n")).unwrap_err();
        assert!(refusal.starts_with(&format!("m.obj:{line}: ")) && refusal.contains(words), "{refusal}");
    }
    let ends = good(&format!("f 1 2 3\n{SQUARE}f -4 -3 -2\n"));
    assert_eq!(ends.triangles[0], ends.triangles[1], "indices may run ahead, and count from either end");
}

/// Points, lines and faces of one or two vertices are left out and counted; a file of nothing else is refused.
///
/// Breaks: a fan from a face of two vertices takes a third one from nowhere, or a mesh without a face makes an empty tree that is then asked for its root.
///
/// Mutation: `Scan::face` lets faces of 2 corners through.
#[test]
fn faces_without_an_inside_are_left_out() {
    let scene = read(format!("{SQUARE}f 1\nf 1 2\nf\nl 1 2\np 1\nf 1 2 2\nf 1 2 3\n")).unwrap();
    assert_eq!(scene.meshes[0].triangles.len(), 1);
    assert!(told(&scene, "m.obj: ignored points, lines and faces of fewer than 3 vertices: 5"));
    assert!(told(&scene, "m.obj: dropped triangles without area: 1"));
    for empty in ["", "# nothing\n", SQUARE, "v 0 0 0\nf 1 1\np 1\n", "v 0 0 0\nv 1 1 1\nf 1 2 1\n"] {
        assert!(read(empty).unwrap_err().starts_with("m.obj: empty mesh: "), "{empty}");
    }
}

fn doubled_area(mesh: &Mesh) -> Vec3 {
    let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
    corners.map(|[a, b, c]| (b - a).cross(c - a)).sum()
}

/// A polygon through these points of a plane.
fn polygon(points: impl Iterator<Item = (f32, f32)>) -> String {
    let points: Vec<String> = points.map(|(x, y)| format!("v {x} {y} 0\n")).collect();
    let face: Vec<String> = (1..=points.len()).map(|i| i.to_string()).collect();
    format!("{}f {}\n", points.concat(), face.join(" "))
}

fn star(n: usize, inner: f32) -> impl Iterator<Item = (f32, f32)> {
    (0..n).map(move |i| {
        let (sin, cos) = (std::f32::consts::TAU * i as f32 / n as f32).sin_cos();
        let r = if i % 2 == 0 { 1.0 } else { inner };
        (r * cos, r * sin)
    })
}

/// A concave face is cut so that its triangles cover it, all turned the same way.
///
/// Breaks: a fan covers the notch of an arrow twice, once from behind.
///
/// Mutation: `triangulate` makes a fan of every polygon.
#[test]
fn concave_faces_are_covered_once() {
    let comb = [(0., 0.), (5., 0.), (5., 3.), (4., 3.), (4., 1.), (3., 1.), (2., 3.), (1., 1.), (0., 3.)];
    let n = 1000.0;
    let star_area = n * 0.2 * f64::sin(std::f64::consts::TAU / n);
    for (mesh, area) in [
        (polygon([(2., 1.), (0., 2.), (1., 1.), (0., 0.)].into_iter()), 2.0),
        (polygon(comb.into_iter()), 20.0),
        (polygon(star(1000, 0.2)), star_area),
    ] {
        let mesh = good(&mesh);
        let unsigned: f32 = (0..mesh.triangles.len())
            .map(|t| mesh.corners(t))
            .map(|[a, b, c]| (b - a).cross(c - a).length())
            .sum();
        assert!((doubled_area(&mesh).z / unsigned - 1.0).abs() < 1e-4, "some triangles are turned over");
        assert!((f64::from(unsigned) / area - 1.0).abs() < 1e-4, "{unsigned} is not {area}");
    }
}

/// Faces of very many corners end: convex ones as a fan, large concave ones in a refusal with their line, those that cross themselves in some triangles.
///
/// Breaks: ears are clipped in cubic time, and one line of a file keeps a processor busy for hours.
///
/// Mutation: `MAX_CONCAVE` is a million, so that no size is refused.
#[test]
fn faces_of_many_corners_end() {
    let circle = good(&polygon(star(100_000, 1.0)));
    assert!(
        circle.triangles.len() > 99_000
            && (doubled_area(&circle).z / std::f32::consts::TAU - 1.0).abs() < 1e-3
    );
    let refusal = read(polygon(star(1026, 0.5))).unwrap_err();
    assert!(refusal.starts_with("m.obj:1027: concave face of more than 1024 vertices; allowed"), "{refusal}");
    let mut rng = Rng::new(1, Stream::Eye, 0, 0);
    let tangle = good(&polygon((0..1024).map(|_| rng.next_vec2().into())));
    assert!(tangle.triangles.len() <= 1022);
}

/// Faces whose materials cannot be had are grey, with a warning that says why.
///
/// Breaks: a mesh without its MTL file does not load at all, or is black without a word.
///
/// Mutation: `Entry::library` returns an error for every file that cannot be read.
#[test]
fn faces_without_a_material_are_grey() {
    let with_library = |name: &str| format!("mtllib {name}\n{SQUARE}usemtl red\nf 1 2 3\nf 1 3 4\n");
    for (mesh, files, words) in [
        (with_library("no.mtl"), vec![], "no.mtl: cannot be read: "),
        (with_library("."), vec![], "is a folder; an MTL file is expected; its materials become grey 0.5"),
        (
            with_library("b.mtl"),
            vec![("b.mtl", &b"\0\xff\xfe\0"[..])],
            "unknown material `red` becomes diffuse grey",
        ),
        (with_library("b.mtl"), vec![("b.mtl", b"newmtl blue\nKd 0 0 1\n")], "unknown material `red`"),
        (with_library("m.obj"), vec![], "unknown material `red`"),
        (format!("{SQUARE}f 1 2 3\n"), vec![], "faces without a material become diffuse grey 0.5"),
    ] {
        let files = [vec![("m.obj", mesh.as_bytes())], files].concat();
        let scene = load_beside(&files).unwrap();
        assert!(told(&scene, words), "{:?} lack {words}", scene.warnings);
        assert_eq!(scene.materials.len(), 1);
        let grey = caustica::bsdf::Bsdf::Diffuse { albedo: Rgb::splat(0.5) };
        assert_eq!((scene.materials[0].bsdf, scene.materials[0].emission), (grey, Rgb::ZERO));
    }
    let many: String = (0..100).map(|i| format!("mtllib {i}.mtl\n")).collect();
    assert!(told(&read(format!("{many}{SQUARE}f 1 2 3\n")).unwrap(), "more than 64 MTL files"));
}

/// A byte order mark, other line ends, a missing last one, blanks, comments and continued lines change nothing; UTF-16 and binary files are refused.
///
/// Breaks: the last face is lost with its line end, or the first vertex with the mark before it.
///
/// Mutation: `statements` leaves the byte order mark in its place.
#[test]
fn the_way_a_text_is_stored_changes_nothing() {
    let plain = format!("{SQUARE}f 1 2 3 4\n");
    let expected = good(&plain);
    let crlf = plain.replace('\n', "\r\n");
    for same in [
        crlf.clone(),
        format!("\u{feff}{crlf}"),
        format!("\u{feff}{plain}"),
        plain.trim_end().to_owned(),
        plain.replace("1 2 3 4", "1 2 \\\n 3 \\\n4 # four"),
        plain.replace(' ', " \t ").replace("v", "  v"),
        format!("# caf\u{e9}\no x\ng\ns off\nunknown 7\n{plain}"),
    ] {
        assert_eq!(good(&same), expected, "{same}");
    }
    let latin = [b"# caf\xe9\n", plain.as_bytes()].concat();
    assert_eq!(read(latin).unwrap().meshes[0], expected);
    let wide = |mark: &[u8], bytes: fn(u16) -> [u8; 2]| {
        [mark.to_vec(), plain.encode_utf16().flat_map(bytes).collect()].concat()
    };
    for (bytes, words) in [
        (wide(b"\xff\xfe", u16::to_le_bytes), "m.obj: is UTF-16; allowed: "),
        (wide(b"\xfe\xff", u16::to_be_bytes), "m.obj: is UTF-16; allowed: "),
        (wide(b"", u16::to_le_bytes), "m.obj:1: holds a NUL byte, so it is binary or UTF-16; allowed: "),
    ] {
        let refusal = read(&bytes).unwrap_err();
        assert!(refusal.starts_with(words), "{refusal}");
    }
}

/// Corners of all forms may stand in one file and even in one face; where a normal is missing, zero or not finite, that of the faces around stands in, with a count.
///
/// Breaks: `v//n` is read as `v/t`, normals shift to other corners, or a missing normal is a NaN that blackens the picture.
///
/// Mutation: `Entry::repaired` keeps normals that have no direction as zero.
#[test]
fn corners_of_all_forms_may_be_mixed() {
    let normals = "vt 0 0\nvt 1 0\nvn 1 0 0\nvn 0 0 0\nvn nan 1 0\nvn 1e38 1e38 1e38\n";
    let scene =
        read(format!("{SQUARE}{normals}f 1/1/1 2//1 3\nf 1/2 3//2 4//3\nf 1//4 2/1/4 4/2/4\n")).unwrap();
    let mesh = &scene.meshes[0];
    let of_corner = |t: usize| mesh.triangles[t].map(|i| mesh.normals.as_ref().unwrap()[i as usize]);
    assert_eq!(of_corner(0), [Vec3::X, Vec3::X, Vec3::Z]);
    assert_eq!(of_corner(1), [Vec3::Z; 3]);
    assert!(of_corner(2).iter().all(|n| (*n - Vec3::ONE.normalize()).length() < 1e-6), "{:?}", of_corner(2));
    assert!(told(&scene, "missing or zero vertex normals replaced by those of the faces around: "));
    assert!(mesh.normals.iter().flatten().all(|n| n.is_normalized()));
}

/// Numbers behind a vertex are a colour where there are three of them or more, and a weight where there is one.
///
/// Breaks: the red of a vertex becomes its weight, and the mesh is torn apart.
///
/// Mutation: `Scan::vertex` takes the fourth of any number of words for a weight.
#[test]
fn vertex_colours_are_no_weights() {
    let expected = good(&format!("{SQUARE}f 1 2 3 4\n")).vertices;
    let coloured = SQUARE.replace(" 0\n", " 0 0.25 0.5 1\n");
    assert_eq!(good(&format!("{coloured}f 1 2 3 4\n")).vertices, expected);
    assert_eq!(good(&format!("{}f 1 2 3 4\n", coloured.replace(" 1\n", " 1 0.5\n"))).vertices, expected);
    let weighted = "v 0 0 0 3\nv 2 0 0 2\nv 1 1 0 1\nv 0 -1 0 -1\n";
    assert_eq!(good(&format!("{weighted}f 1 2 3 4\n")).vertices, expected);
    assert!(
        read(format!("v 0 0 0 0\n{SQUARE}f 1 2 3\n")).unwrap_err().starts_with("m.obj:1: vertex of weight 0")
    );
}

/// A vertex that is not finite, or lies beyond 1.8e18 where Embree stops tracing, is refused with its file and line.
///
/// Breaks: Embree drops its triangles without a word, and a bounding box with a NaN in it holds nothing or everything.
///
/// Mutation: `COORDINATE` holds for every finite number.
#[test]
fn vertices_that_no_ray_reaches_are_refused() {
    for vertex in
        ["nan 0 0", "0 inf 0", "0 0 -inf", "1.9e18 0 0", "0 -1e39 0", "0 1e18 0 0.5", "1e-400 0 1e400"]
    {
        let refusal = read(format!("{SQUARE}v {vertex}\nf 1 2 5\n")).unwrap_err();
        assert!(refusal.starts_with("m.obj:5: vertex coordinate "), "{refusal}");
        assert!(refusal.contains("allowed: a number from -1.8e18 to 1.8e18"), "{refusal}");
    }
    assert_eq!(good("v 0 0 0\nv 1.8e18 0 0\nv 0 -1.8e18 0\nf 1 2 3\n").triangles.len(), 1);
}

/// Loading takes memory in proportion to the file: at most sixteen bytes for each of its own, by which files too large for the machine are refused beforehand.
///
/// Breaks: a mesh of ten million triangles takes all memory of a machine that could render it.
///
/// Mutation: `Scan::hand_on` writes sixty lines of comment for every vertex.
#[test]
fn a_large_mesh_takes_memory_in_proportion() {
    const SIDE: usize = 317;
    let folder = tempfile::tempdir().unwrap();
    let peak = |name: &str, mesh: &str| {
        let path = folder.path().join(format!("{name}.toml"));
        fs::write(folder.path().join("m.obj"), mesh).unwrap();
        let small = "film = { width = 4, height = 4 }\nrender = { radius = 1 }\n";
        fs::write(&path, format!("{small}{SCENE}")).unwrap();
        let output =
            Command::cargo_bin("caustica").unwrap().args(["info", "--json"]).arg(&path).output().unwrap();
        let info: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (info["triangles"].as_u64().unwrap(), info["peak_memory_bytes"].as_u64().unwrap())
    };
    let vertex = |i: usize| format!("v {} {} {}\n", i % SIDE, i / SIDE, (i * 7919 % 1000) as f32 * 1e-3);
    let corner = |i: usize| (i / (SIDE - 1)) * SIDE + i % (SIDE - 1) + 1;
    let square = |i: usize| {
        let a = corner(i);
        format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + SIDE + 1, a + SIDE + 1, a + SIDE)
    };
    let vertices: String = (0..SIDE * SIDE).map(vertex).collect();
    let mesh = vertices + &(0..(SIDE - 1) * (SIDE - 1)).map(square).collect::<String>();
    let (_, little) = peak("small", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let (triangles, much) = peak("large", &mesh);
    assert_eq!(triangles, 199_712);
    // Embree and its tree come on top of what the loader takes.
    let of_tree = 200 * triangles;
    let per_byte = (much - little).saturating_sub(of_tree) as f64 / mesh.len() as f64;
    assert!(per_byte < 16.0, "{per_byte} bytes of memory for a byte of the file");
}

/// All OBJ files of the folders, those beside the project as far as they are there.
fn dirty_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let beside =
        ["assimp-OBJ", "tinyobjloader", "tobj"].map(|name| format!("../shared/scenes/dirty-obj/{name}"));
    let mut paths = Vec::new();
    for folder in beside.iter().map(String::as_str).chain(["fuzz/seeds/obj"]) {
        match fs::read_dir(root.join(folder)) {
            Ok(entries) => paths.extend(entries.map(|entry| entry.unwrap().path())),
            Err(_) => eprintln!("skipped: {folder} is absent"),
        }
    }
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "obj"));
    paths.sort();
    paths
}

/// A tiny picture of a mesh from outside, by one pass of few photons.
fn rendered(mut desc: SceneDesc) {
    let vertices = || desc.meshes[0].vertices.iter().map(|v| v.as_dvec3());
    let low = vertices().reduce(|a, b| a.min(b)).unwrap();
    let high = vertices().reduce(|a, b| a.max(b)).unwrap();
    let middle = 0.5 * (low + high);
    // Off the planes in which flat meshes lie.
    let eye = (middle + (high - low).length() * DVec3::new(0.7, 0.8, 1.2)).as_vec3();
    desc.camera.look_at = middle.as_vec3();
    desc.camera.position = eye;
    desc.film = FilmDesc::new(6, 5);
    desc.render = RenderDesc { passes: 1, photons: 500, samples: 1, alpha: 0.7, radius: None, depth: 4 };
    let power = eye.distance_squared(desc.camera.look_at).max(1e-6);
    desc.point_lights = vec![PointLightDesc { position: eye, intensity: Rgb::splat(power) }];
    for traversal in TRAVERSALS {
        let scene = Scene::with_traversal(desc.clone(), traversal).unwrap();
        let mut render = Render::new(&scene, Settings::of_scene(&desc.render));
        assert!(render.pass().photons.is_balanced());
        assert_eq!(render.picture().count_non_finite(), 0, "{}", desc.path.display());
    }
}

/// Every dirty file ends in a picture without a NaN, or in a refusal that names the file.
///
/// Breaks: one file of a hundred crashes the program, hangs it, or turns the picture black with a NaN.
///
/// Mutation: `mtl::surface` does not clamp colours.
#[test]
fn every_dirty_file_ends_in_a_picture_or_a_refusal() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("s.toml");
    let (mut pictures, mut refusals) = (0, 0);
    for path in dirty_files() {
        let name = path.file_name().unwrap().to_str().unwrap();
        for normals in ["", "normals = 'smooth'\n"] {
            fs::write(&scene, SCENE.replace("m.obj", path.to_str().unwrap()) + normals).unwrap();
            match load(&scene) {
                Ok(desc) => {
                    pictures += 1;
                    rendered(desc);
                }
                Err(error) => {
                    refusals += 1;
                    assert!(error.to_string().contains(name), "{error}");
                }
            }
        }
    }
    assert!(pictures >= 20 && refusals >= 20, "{pictures} pictures, {refusals} refusals");
}
