//! Scene files with mistakes in them.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command as Program;
use std::time::Duration;

use assert_cmd::Command;
use caustica::checkpoint;
use caustica::math::{Rng, Stream};
use caustica::output::{read_exr_bytes, read_png_bytes};
use caustica::scene::{Access, Limits, load, load_with};
use caustica::shard::Merge;
use caustica::study::Journal;

/// Every field that there is, one a line.
const COMPLETE: &str = "\
[film]
width = 4
height = 3
[camera]
position = [0, 0, 5]
look_at = [0.0, 0, -1e-3]
up = [0, 1, 0]
fov = 40.5
[render]
passes = 2
photons = 1_000
samples = 1
alpha = 0.7
radius = 0.5
depth = 3
[material.wall]
emission = [1, 0, 0]
[material.wall.diffuse]
albedo = [0.7, 0.7, 0.7]
[material.silver.mirror]
reflectance = [1, 1, 1]
[material.glass.dielectric]
ior = 1.5
[material.water.fixed_weight]
color = [0.6, 0.6, 0.7]
reflectivity = 0.2
transparency = 0.7
ior = 1.33
[[point_light]]
position = [0, 3, 0]
intensity = [1, 1, 1]
[[sphere]]
center = [1, 1, 1]
radius = 0.5
material = \"glass\"
[[quad]]
corners = [[0, 0, 0], [0, 0, 9], [9, 0, 9], [9, 0, 0]]
material = \"wall\"
[[mesh]]
file = \"m.obj\"
scale = [1, -2, 3]
translate = [0, 50, 0]
normals = \"smooth\"
material = \"water\"
[mesh.rotate]
axis = [0, 1, 0]
degrees = 30
";

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The tables and fields that may be left out.
const OPTIONAL: &str = "film.width film.height camera.up render.passes render.photons render.samples render.alpha \
    render.radius render.depth material.wall.emission mesh.scale mesh.translate mesh.normals mesh.material";

/// What comes of a scene beside a triangle: nothing, or the words of the refusal.
fn refusal(text: &str) -> Option<String> {
    let files = [("s.toml", text), ("m.obj", TRIANGLE)];
    let files = files.into_iter().map(|(name, text)| (PathBuf::from(name), text.as_bytes().to_vec()));
    let loaded = load_with(Path::new("s.toml"), &Access::given(files.collect()));
    loaded.err().map(|error| error.to_string())
}

/// A line `key = value` of [`COMPLETE`].
struct Entry {
    /// From 1.
    line: usize,
    table: &'static str,
    key: &'static str,
    value: &'static str,
}

fn entries() -> Vec<Entry> {
    let mut table = "";
    let mut entries = Vec::new();
    for (text, line) in COMPLETE.lines().zip(1..) {
        match text.split_once(" = ") {
            Some((key, value)) => entries.push(Entry { line, table, key, value }),
            None => table = text.trim_matches(['[', ']']),
        }
    }
    entries
}

/// [`COMPLETE`] with other words in a line.
fn with_line(line: usize, words: &str) -> String {
    let lines = COMPLETE.lines().zip(1..);
    lines.map(|(text, n)| if n == line { format!("{words}\n") } else { format!("{text}\n") }).collect()
}

fn assert_refused(text: &str, place: &str, words: &[&str]) {
    let refusal = refusal(text).unwrap_or_else(|| panic!("this loads:\n{text}"));
    assert!(refusal.starts_with(place), "{refusal}\nis not at {place}");
    assert!(words.iter().all(|word| refusal.contains(word)), "{refusal}\nlacks one of {words:?}");
}

/// A field that is left out is either optional, or its absence is told with the table's line and what is allowed.
///
/// Breaks: a camera without `fov` gets some angle, and nobody knows why the picture is what it is.
///
/// Mutation: `camera` reads `fov` by `optional` with a default of 40.
#[test]
fn every_missing_field_is_told_or_optional() {
    for Entry { line, table, key, .. } in entries() {
        let text = with_line(line, "");
        let optional = OPTIONAL.split_whitespace().any(|name| name == format!("{table}.{key}"));
        match refusal(&text) {
            None => assert!(optional, "{table}.{key} may be left out"),
            Some(words) => {
                assert!(!optional && words.starts_with("s.toml:"), "{words}");
                assert!(words.contains(&format!("field `{key}` is missing; allowed: ")), "{words}");
            }
        }
    }
}

/// A field of the wrong type is refused at its own line, with its value and what is allowed.
///
/// Breaks: `fov = "40"` counts as 0 or as the default, or the message names no line.
///
/// Mutation: `Field::string` takes whole numbers for text.
#[test]
fn every_field_of_the_wrong_type_is_told() {
    for Entry { line, key, value, .. } in entries() {
        let wrong = if value.starts_with('"') { "17" } else { "\"text\"" };
        for wrong in [wrong, "true", "1979-05-27", "{ a = 1 }"] {
            let place = format!("s.toml:{line}:");
            assert_refused(&with_line(line, &format!("{key} = {wrong}")), &place, &[key, "allowed: "]);
        }
    }
}

/// NaN, infinities and numbers far out of range are refused at their own line, wherever a number may stand.
///
/// Breaks: a NaN radius passes `radius <= 0`, and every comparison after it goes the wrong way.
///
/// Mutation: `POSITIVE` holds for everything that is not `x <= 0`.
#[test]
fn every_number_that_is_not_finite_or_out_of_range_is_told() {
    let numeric = entries().into_iter().filter(|entry| !entry.value.starts_with('"'));
    for Entry { line, key, value, .. } in numeric {
        let first = value.trim_start_matches('[');
        let number = first.split([',', ']']).next().unwrap();
        for wrong in ["nan", "inf", "-inf", "1e999", "-1e30"] {
            let text = with_line(line, &format!("{key} = {}", value.replacen(number, wrong, 1)));
            match (key, wrong) {
                // An angle may be any finite number; a scale is judged by where it takes the vertices.
                ("degrees", "-1e30") => assert_eq!(refusal(&text), None),
                ("scale", "-1e30") => assert_refused(&text, "s.toml:", &["allowed: coordinates"]),
                _ => assert_refused(&text, &format!("s.toml:{line}:"), &[key, "allowed: "]),
            }
        }
    }
}

/// A field that is unknown or given twice is refused at its own line, and a slip of the pen is recognised.
///
/// Breaks: `raduis = 2` is silently ignored, and the render takes the default radius.
///
/// Mutation: `Fields::only` returns without looking at the keys.
#[test]
fn every_misspelt_or_doubled_field_is_told() {
    for Entry { line, key, value, .. } in entries() {
        let meant = format!("did you mean `{key}`?");
        let place = format!("s.toml:{line}:");
        assert_refused(&with_line(line, &format!("{key}e = {value}")), &place, &[&meant, "allowed: "]);
        let twice = with_line(line, &format!("{key} = {value}\n{key} = {value}"));
        let place = format!("s.toml:{}:", line + 1);
        assert_refused(&twice, &place, &[&format!("duplicate key `{key}`"), "allowed: "]);
    }
    for table in ["film", "camera", "render", "point_light", "sphere", "quad", "mesh"] {
        let misspelt = COMPLETE.replace(&format!("[{table}"), &format!("[{table}e"));
        assert_refused(&misspelt, "s.toml:", &[&format!("did you mean `{table}`?"), "allowed: `film`"]);
    }
}

/// What is no scene file at all is refused at once: a folder, a device without end, a pipe that nobody writes to, bytes that are not text, tables without end.
///
/// Breaks: the loader waits for the pipe for ever, reads zeros until memory is gone, or overflows its stack.
///
/// Mutation: `input::open_file` does not ask for the kind of the file (the test waits at the pipe for ever).
#[test]
fn what_is_no_scene_file_is_refused_without_waiting() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    assert!(Program::new("mkfifo").arg(&pipe).status().unwrap().success());
    let told = |path: &Path| load(path).unwrap_err().to_string();
    for odd in [&pipe, Path::new("/dev/zero")] {
        let words = told(odd);
        assert!(words.contains("a device, a pipe or a socket") && words.contains("a scene file"), "{words}");
    }
    assert!(told(folder.path()).contains("is a folder; a scene file"));
    let mesh = format!("{COMPLETE}[[mesh]]\nfile = \"{}\"\n", pipe.display());
    let path = folder.path().join("s.toml");
    fs::write(folder.path().join("m.obj"), TRIANGLE).unwrap();
    for (text, words) in [
        (mesh.as_bytes(), "a device, a pipe or a socket, not a regular file; an OBJ mesh is expected"),
        (b"fov = 1\n# caf\xe9", "s.toml: is not UTF-8 (line 2)"),
        (b"", "s.toml: is empty"),
        (b"a = 1\0", "s.toml:1:"),
        (format!("a = {}", "[".repeat(100_000)).as_bytes(), "s.toml:1:"),
        (format!("a = {}", "{a=".repeat(100_000)).as_bytes(), "s.toml:1:"),
        (format!("[film{}]", ".a".repeat(100_000)).as_bytes(), "s.toml:1:"),
    ] {
        fs::write(&path, text).unwrap();
        let told = told(&path);
        assert!(told.contains(words) && told.len() < 1000, "{told}");
    }
    assert_refused(
        &format!("{COMPLETE}[[mesh]]\nfile = \"s.toml\"\n"),
        "s.toml: empty mesh",
        &["at least one"],
    );
}

/// A folder `scene` with a scene and a mesh, beside files that do not belong to it.
struct Guest {
    folder: tempfile::TempDir,
}

impl Guest {
    fn new() -> Guest {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        fs::create_dir_all(folder.path().join("scene/parts")).unwrap();
        write("private.obj", TRIANGLE);
        write("private.mtl", "newmtl secret\nKd 1 0 0\n");
        write("scene/m.obj", TRIANGLE);
        write("scene/parts/m.obj", TRIANGLE);
        write("scene/library.obj", &format!("{TRIANGLE}mtllib ../private.mtl\n"));
        symlink("../private.obj", folder.path().join("scene/link.obj")).unwrap();
        symlink("m.obj", folder.path().join("scene/fine.obj")).unwrap();
        symlink("..", folder.path().join("scene/up")).unwrap();
        Guest { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The refusal of the scene with `more`, with and without a sandbox.
    fn refusals(&self, more: &str) -> [Option<String>; 2] {
        let path = self.path("scene/s.toml");
        fs::write(&path, format!("{CAMERA}{more}")).unwrap();
        [Access::sandbox(), Access::any()].map(|access| Some(load_with(&path, &access).err()?.to_string()))
    }
}

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n";

/// In a sandbox a scene reads nothing outside its folder, by whatever path it tries; without one, paths work as users expect.
///
/// Breaks: a scene from a stranger reads private files, and prints them line by line in its error messages.
///
/// Mutation: `Reader::check_place` compares the path as written instead of the real one (links get through).
#[test]
fn a_sandboxed_scene_reads_nothing_outside_its_folder() {
    let guest = Guest::new();
    let mesh = |file: &str| format!("[[mesh]]\nfile = \"{file}\"\n");
    let (private, inside) = (guest.path("private.obj"), guest.path("scene/m.obj"));
    for file in
        ["../private.obj", "parts/../../private.obj", "link.obj", "up/private.obj", private.to_str().unwrap()]
    {
        let [sandboxed, free] = guest.refusals(&mesh(file));
        let told = sandboxed.unwrap_or_else(|| panic!("{file} is read"));
        assert!(told.contains("s.toml:3:") && told.contains("outside the scene's folder; allowed"), "{told}");
        assert_eq!(free, None, "{file}");
    }
    for file in ["m.obj", "./m.obj", "parts/m.obj", "parts/../m.obj", "fine.obj", inside.to_str().unwrap()] {
        assert_eq!(guest.refusals(&mesh(file)), [None, None], "{file}");
    }
    let [library, free] = guest.refusals(&mesh("library.obj"));
    let told = library.unwrap();
    assert!(told.contains("library.obj:5: mtllib") && told.contains("outside the scene's folder"), "{told}");
    assert_eq!(free, None);
    symlink("../private.mtl", guest.path("scene/t.toml")).unwrap();
    let told = load_with(&guest.path("scene/t.toml"), &Access::sandbox()).unwrap_err().to_string();
    assert!(told.contains("t.toml: lies outside the scene's folder") && !told.contains("secret"), "{told}");
}

/// Every command that loads a scene takes `--sandbox`, and refuses with exit code 2 before it writes anything.
///
/// Breaks: `info` is safe, and `study` of the same scene is not.
///
/// Mutation: `study::run` loads with `Access::any()`.
#[test]
fn every_command_that_loads_a_scene_takes_a_sandbox() {
    let guest = Guest::new();
    guest.refusals("[[mesh]]\nfile = \"../private.obj\"\n");
    for command in [
        &["info"][..],
        &["render", "-o", "a.exr"],
        &["reference", "-o", "a.exr"],
        &["study", "--list"],
        &["doctor", "--json"],
    ] {
        let mut program = Command::cargo_bin("caustica").unwrap();
        let program = program.current_dir(guest.path("scene")).args(command).args(["--sandbox", "s.toml"]);
        let output = program.timeout(Duration::from_secs(60)).output().unwrap();
        let told = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert_eq!(output.status.code(), Some(2), "{command:?}: {told}");
        assert!(told.contains("s.toml:3:") && told.contains("outside the scene's folder"), "{told}");
        assert!(!guest.path("scene/a.exr").exists());
    }
}

/// In a sandbox a scene asks for no more pixels, samples, passes, photons, bounces, triangles and bytes than the limits allow, each told with its place and limit.
///
/// Breaks: a scene of 16384 x 16384 pixels with 4096 samples each keeps a render farm busy until somebody looks.
///
/// Mutation: `settings::whole` knows the format's bounds alone.
#[test]
fn a_sandboxed_scene_asks_for_no_more_than_its_limits() {
    let guest = Guest::new();
    for (table, line, limit) in [
        ("[film]\nwidth = 8193", 3, "8193; allowed: up to 8192 in the sandbox"),
        ("[film]\nheight = 16384", 3, "16384; allowed: up to 8192"),
        (
            "[film]\nwidth = 8192\nheight = 8192",
            2,
            "8192 x 8192 pixels of 4 samples are 268435456 eye samples; allowed",
        ),
        ("[render]\nsamples = 257", 3, "up to 256"),
        ("[render]\npasses = 100001", 3, "up to 100000"),
        ("[render]\nphotons = 9223372036854775807", 3, "up to 10000000"),
        ("[render]\ndepth = 33", 3, "up to 32"),
    ] {
        let [sandboxed, free] = guest.refusals(table);
        let told = sandboxed.unwrap_or_else(|| panic!("{table} loads"));
        assert!(told.contains(&format!("s.toml:{line}:")) && told.contains(limit), "{told}");
        assert_eq!(free, None, "{table}");
    }
    assert_eq!(guest.refusals("[[mesh]]\nfile = \"m.obj\"\n")[0], None);
    let refused = |limits: Limits| {
        let access = Access::sandbox().limited(limits);
        load_with(&guest.path("scene/s.toml"), &access).unwrap_err().to_string()
    };
    let told = refused(Limits { triangles: 0, ..Limits::SANDBOX });
    assert!(told.contains("m.obj: ") && told.contains("1 triangles; allowed in the sandbox: 0"), "{told}");
    let told = refused(Limits { bytes: 120, ..Limits::SANDBOX });
    assert!(
        told.contains("s.toml:3:") && told.contains("allowed in the sandbox: 120 bytes together"),
        "{told}"
    );
    let told = refused(Limits { scene_bytes: 9, ..Limits::SANDBOX });
    assert!(told.contains("s.toml: holds ") && told.contains("allowed in the sandbox: 9 bytes"), "{told}");
}

/// A picture or a number of photons that memory does not suffice for is refused by every command before it is begun, with what it takes, what there is and what helps.
///
/// Breaks: the process is killed for its memory after minutes, without a word.
///
/// Mutation: `memory::check_render` returns before it asks.
#[test]
fn a_render_beyond_memory_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.toml");
    let commands = [&["info"][..], &["render", "-o", "a.exr"], &["study", "--list"]];
    // A study makes its pictures smaller by itself.
    for (settings, commands) in [
        ("film = { width = 16384, height = 16384 }\nrender = { samples = 4096 }\n", &commands[..2]),
        ("render = { photons = 9223372036854775807 }\n", &commands),
    ] {
        fs::write(&path, format!("{CAMERA}{settings}")).unwrap();
        for command in commands {
            let mut program = Command::cargo_bin("caustica").unwrap();
            let program = program.current_dir(folder.path()).args(*command).arg("s.toml");
            let output = program.timeout(Duration::from_secs(60)).output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(2), "{command:?}: {told}");
            assert!(told.contains("of memory") && told.contains("available; ask for fewer"), "{told}");
            assert!(!folder.path().join("a.exr").exists());
        }
    }
}

/// A loader under the name of its fuzz target.
type Loader = fn(&[u8]);

/// What the fuzz targets do, by their names; a panic is what they must not do.
const LOADERS: [(&str, Loader); 11] = [
    ("scene", |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let parts: Vec<&str> = text.splitn(3, "\n%%\n").collect();
        let part = |i: usize| parts.get(i).map_or(&b""[..], |part| part.as_bytes());
        load_in_memory(part(0), part(1), part(2));
    }),
    ("obj", |bytes| load_in_memory(MESH_SCENE.as_bytes(), bytes, b"newmtl a\nKd 1 0 0\n")),
    ("mtl", |bytes| load_in_memory(MESH_SCENE.as_bytes(), MESH_WITH_LIBRARY.as_bytes(), bytes)),
    ("xml", |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let parts: Vec<&str> = text.splitn(3, "\n%%\n").collect();
        let part = |i: usize| parts.get(i).map_or(&b""[..], |part| part.as_bytes());
        load_files("s.xml", &[("s.xml", part(0)), ("m.obj", part(1)), ("i.xml", part(2))]);
    }),
    ("ply", |bytes| load_files("s.toml", &[("s.toml", PLY_SCENE.as_bytes()), ("m.ply", bytes)])),
    ("gltf", |bytes| {
        let line = bytes.windows(4).position(|window| window == b"\n%%\n");
        let (scene, buffer) = line.map_or((bytes, &b""[..]), |at| (&bytes[..=at], &bytes[at + 4..]));
        load_files("s.gltf", &[("s.gltf", scene), ("b.bin", buffer)]);
    }),
    ("exr", |bytes| drop(read_exr_bytes(Path::new("a.exr"), bytes))),
    ("png", |bytes| drop(read_png_bytes(Path::new("a.png"), bytes))),
    ("journal", |bytes| drop(Journal::parse(Path::new("a.jsonl"), &String::from_utf8_lossy(bytes)))),
    ("checkpoint", |bytes| drop(checkpoint::parse(&signed(bytes)))),
    ("shard", |bytes| drop(Merge::default().add_bytes(Path::new("a.shard"), &signed(bytes)))),
];

/// With the hash that whole files end in.
fn signed(bytes: &[u8]) -> Vec<u8> {
    [bytes, blake3::hash(bytes).as_bytes()].concat()
}

const MESH_SCENE: &str =
    "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n[[mesh]]\nfile = \"m.obj\"\n";
const PLY_SCENE: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0], fov = 40 }\n\
    material.a.mirror.reflectance = [1, 1, 1]\n[[mesh]]\nfile = \"m.ply\"\nmaterial = \"a\"\n";
const MESH_WITH_LIBRARY: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

fn load_in_memory(scene: &[u8], mesh: &[u8], materials: &[u8]) {
    load_files("s.toml", &[("s.toml", scene), ("m.obj", mesh), ("m.mtl", materials)]);
}

fn load_files(scene: &str, files: &[(&str, &[u8])]) {
    let files: BTreeMap<PathBuf, Vec<u8>> =
        files.iter().map(|(name, bytes)| (name.into(), bytes.to_vec())).collect();
    if let Ok(scene) = load_with(Path::new(scene), &Access::given(files)) {
        let in_range = |i: &u32, n: usize| (*i as usize) < n;
        for mesh in &scene.meshes {
            assert!(mesh.triangles.iter().flatten().all(|i| in_range(i, mesh.vertices.len())));
            assert!(mesh.materials.iter().all(|m| in_range(m, scene.materials.len())));
            assert!(mesh.vertices.iter().all(|v| v.is_finite()));
        }
    }
}

/// One to four bytes or stretches of `bytes` replaced, removed or repeated.
fn damaged(bytes: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=rng.next_u32() % 4 {
        let mut below = |n: usize| rng.next_u32() as usize % n.max(1);
        let at = below(bytes.len());
        let end = (at + below(9)).min(bytes.len());
        match below(4) {
            0 => bytes[at..end].iter_mut().for_each(|byte| *byte = below(256) as u8),
            1 => drop(bytes.drain(at..end)),
            2 => bytes.extend_from_within(at..end),
            _ => bytes.truncate(at.max(1)),
        }
    }
    bytes
}

/// Every seed of the fuzzers, and a hundred damaged copies of each, ends in data or in an error value.
///
/// Breaks: a bit that fell over in a file brings the program down with a backtrace.
///
/// Mutation: `mtl::color` hands a colour of a single number on to the parser, which panics.
#[test]
fn no_seed_of_the_fuzzers_and_no_damage_to_it_makes_a_loader_panic() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds");
    let mut tried = 0;
    for (target, load) in LOADERS {
        let mut seeds: Vec<PathBuf> =
            fs::read_dir(root.join(target)).unwrap().map(|entry| entry.unwrap().path()).collect();
        seeds.sort();
        for (seed, number) in seeds.iter().zip(0..) {
            let bytes = fs::read(seed).unwrap();
            load(&bytes);
            let mut rng = Rng::new(1, Stream::Eye, 0, number);
            (0..100).for_each(|_| load(&damaged(&bytes, &mut rng)));
            tried += 101;
        }
    }
    assert!(tried > 9000, "only {tried} files were tried");
}
