//! A mesh in a scene that has nothing else, with its own normals and with smooth ones.
#![no_main]

use caustica_fuzz::{MATERIALS, SCENE, check, load};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    check(load(SCENE.as_bytes(), data, MATERIALS.as_bytes()));
    check(load(format!("{SCENE}normals = \"smooth\"\nscale = [-1, 2, 3]\n").as_bytes(), data, b""));
});
