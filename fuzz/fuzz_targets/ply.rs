//! A PLY mesh in a scene that has nothing else, with its own normals and coordinates for a picture, and with smooth normals.
#![no_main]

use caustica_fuzz::{Access, PIXELS, PLY_SCENE, check, files, load_from};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let load = |scene: &str| {
        let files = files(&[("s.toml", scene.as_bytes()), ("m.ply", data), ("p.png", PIXELS)]);
        load_from("s.toml", Access::given(files))
    };
    check(load(PLY_SCENE));
    check(load(&format!("{PLY_SCENE}normals = \"smooth\"\nscale = [-1, 2, 3]\n")));
});
