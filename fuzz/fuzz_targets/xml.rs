//! A scene in the XML of Mitsuba, the mesh that it may name `m.obj`, and what it may include as `i.xml`, parted by lines of `%%`;
//! `m.ply` and `p.png` are there, too. Read strictly and leniently.
#![no_main]

use caustica_fuzz::{Access, PIXELS, PLY, check, files, load_from, parts};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let [scene, mesh, included] = parts(data);
    let files = || files(&[("s.xml", scene), ("m.obj", mesh), ("i.xml", included), ("m.ply", PLY), ("p.png", PIXELS)]);
    check(load_from("s.xml", Access::given(files())));
    check(load_from("s.xml", Access::given(files()).lenient(true)));
});
