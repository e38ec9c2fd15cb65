//! A scene file, the mesh that it may name `m.obj`, and the materials that this may name `m.mtl`, parted by lines of `%%`.
#![no_main]

use caustica_fuzz::{check, load, parts};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let [scene, mesh, materials] = parts(data);
    check(load(scene, mesh, materials));
});
