//! The materials of a mesh that uses two of them.
#![no_main]

use caustica_fuzz::{MESH, SCENE, check, load};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| check(load(SCENE.as_bytes(), MESH.as_bytes(), data)));
