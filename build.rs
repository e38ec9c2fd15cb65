//! Finds Embree 4, links it and generates its bindings.
//!
//! The first of these that holds Embree counts: the prefix that `EMBREE_DIR` names, the project's private prefix
//! `.embree` (made by `make setup`), the system.

use std::env;
use std::error::Error;
use std::fs;
use std::io;
use std::os::unix::fs::symlink;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Command, exit};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

const REMEDY: &str = "run `make setup`, or install libembree-dev 4.3 or newer, or set EMBREE_DIR to a prefix that holds \
                      include/embree4 and lib";

/// Where one Embree lives.
struct Embree {
    include: PathBuf,
    lib: PathBuf,
    /// Whether the dynamic linker finds `lib` by itself.
    system: bool,
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        exit(1);
    }
}

fn run() -> Result<()> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let root = PathBuf::from(env::var("CARGO_MANIFEST_DIR")?);
    let embree = find_embree(&root)?;
    check_version(&embree)?;
    link(&embree, &out.join("embree"))?;
    generate_bindings(&embree, &out.join("embree4.rs"))?;
    find_denoiser_at_run_time();
    tell_compiler()?;
    watch(&root, &embree);
    Ok(())
}

/// Open Image Denoise is linked by its crate, from the prefix that `OIDN_DIR` names.
fn find_denoiser_at_run_time() {
    println!("cargo:rerun-if-env-changed=OIDN_DIR");
    if let (Some(_), Ok(prefix)) = (env::var_os("CARGO_FEATURE_OIDN"), env::var("OIDN_DIR")) {
        println!("cargo:rustc-link-arg=-Wl,-rpath,{prefix}/lib");
    }
}

/// What the measurements say about how the program was built.
fn tell_compiler() -> Result<()> {
    let version = Command::new(env::var("RUSTC")?).arg("--version").output()?.stdout;
    println!("cargo:rustc-env=BUILT_BY_RUSTC={}", String::from_utf8(version)?.trim());
    let features = env::var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    println!("cargo:rustc-env=BUILT_FOR_FEATURES={features}");
    Ok(())
}

fn find_embree(root: &Path) -> Result<Embree> {
    if let Some(prefix) = env::var_os("EMBREE_DIR").filter(|prefix| !prefix.is_empty()) {
        return embree_in(Path::new(&prefix), false)
            .ok_or_else(|| format!("EMBREE_DIR={} holds no Embree 4: {REMEDY}", prefix.display()).into());
    }
    let system = ["/usr/local", "/usr"].into_iter().find_map(|prefix| embree_in(Path::new(prefix), true));
    embree_in(&root.join(".embree"), false)
        .or(system)
        .ok_or_else(|| format!("Embree 4 is missing: {REMEDY}").into())
}

/// The Embree below `prefix`, if both its headers and its library are there.
fn embree_in(prefix: &Path, system: bool) -> Option<Embree> {
    let prefix = fs::canonicalize(prefix).ok()?;
    let include = prefix.join("include");
    let multiarch = format!("lib/{}-linux-gnu", env::var("CARGO_CFG_TARGET_ARCH").ok()?);
    let lib = ["lib", "lib64", &multiarch]
        .iter()
        .map(|dir| prefix.join(dir))
        .find(|dir| dir.join("libembree4.so").exists())?;
    config_header(&include).exists().then_some(Embree { include, lib, system })
}

fn config_header(include: &Path) -> PathBuf {
    include.join("embree4/rtcore_config.h")
}

/// Rays have another layout before 4.3, and who knows which from 5 on.
fn check_version(embree: &Embree) -> Result<()> {
    let header = config_header(&embree.include);
    let text = fs::read_to_string(&header).map_err(|error| format!("{}: {error}", header.display()))?;
    let value = |name| text.lines().find_map(|line| line.strip_prefix(name)).map(str::trim);
    let number = value("#define RTC_VERSION ").and_then(|number| number.parse().ok());
    if number.is_some_and(|number: u32| (40_300..50_000).contains(&number)) {
        return Ok(());
    }
    let found =
        value("#define RTC_VERSION_STRING ").map_or("of unknown version", |text| text.trim_matches('"'));
    Err(format!("{}: Embree {found} is not 4.3 or a newer 4: {REMEDY}", header.display()).into())
}

fn link(embree: &Embree, near: &Path) -> Result<()> {
    println!("cargo:rustc-link-lib=dylib=embree4");
    if embree.system {
        println!("cargo:rustc-link-search=native={}", embree.lib.display());
        return Ok(());
    }
    // Documentation tests take no linker arguments, hence no rpath; but cargo lets them load what a build script
    // keeps in its own folder.
    link_shared_libraries(&embree.lib, near)
        .map_err(|error| format!("cannot link {} into {}: {error}", embree.lib.display(), near.display()))?;
    println!("cargo:rustc-link-search=native={}", near.display());
    // An installed tree carries its own copy, and may be moved.
    println!("cargo:rustc-link-arg=-Wl,-rpath,$ORIGIN/../lib");
    println!("cargo:rustc-link-arg=-Wl,-rpath,{}", embree.lib.display());
    Ok(())
}

/// Fills the folder `to` with links to Embree and to TBB, which Embree looks for beside itself.
fn link_shared_libraries(from: &Path, to: &Path) -> io::Result<()> {
    if to.exists() {
        fs::remove_dir_all(to)?;
    }
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let name = entry?.file_name();
        let text = name.to_string_lossy();
        if (text.starts_with("libembree4") || text.starts_with("libtbb")) && text.contains(".so") {
            symlink(from.join(&name), to.join(&name))?;
        }
    }
    Ok(())
}

fn generate_bindings(embree: &Embree, file: &Path) -> Result<()> {
    let builder = bindgen::Builder::default()
        .header("wrapper.h")
        .clang_arg(format!("-I{}", embree.include.display()))
        .allowlist_function("rtc(New|Release)(Device|Scene|Geometry)|rtcRetainDevice")
        .allowlist_function("rtcGetDevice(Error|Property)|rtcSetDeviceErrorFunction")
        .allowlist_function("rtcSet(NewGeometryBuffer|SceneFlags|SceneBuildQuality)")
        .allowlist_function("rtc(CommitGeometry|AttachGeometry|CommitScene|GetSceneBounds)")
        .allowlist_function("rtc(Intersect(1|8|16)|Occluded1|PointQuery)")
        .allowlist_function("rtcSetGeometry(BuildQuality|UserPrimitiveCount|UserData|BoundsFunction)")
        .allowlist_function("rtcSetDeviceMemoryMonitorFunction")
        .allowlist_type("RTC(RayHit|Ray|Hit|Bounds|RayHit8|RayHit16|RayQueryFlags|FeatureFlags)")
        .allowlist_var("RTC_VERSION")
        .opaque_type("RTCOccludedArguments|RTCRayQueryContext")
        .rust_edition(bindgen::RustEdition::Edition2024)
        .prepend_enum_name(false)
        .generate_comments(false);
    // Without libclang bindgen panics instead of returning an error.
    let bindings = catch_unwind(AssertUnwindSafe(|| builder.generate())).map_err(|_| {
        "the Embree bindings need libclang: run `make setup`, or install libclang-dev, or set LIBCLANG_PATH"
    })?;
    bindings
        .map_err(|error| format!("the Embree headers do not parse: {error}"))?
        .write_to_file(file)
        .map_err(|error| format!("cannot write {}: {error}", file.display()))?;
    Ok(())
}

fn watch(root: &Path, embree: &Embree) {
    for file in ["build.rs", "wrapper.h"] {
        println!("cargo:rerun-if-changed={}", root.join(file).display());
    }
    println!("cargo:rerun-if-changed={}", config_header(&embree.include).display());
    println!("cargo:rerun-if-changed={}", embree.lib.join("libembree4.so").display());
    for variable in ["EMBREE_DIR", "LIBCLANG_PATH"] {
        println!("cargo:rerun-if-env-changed={variable}");
    }
}
