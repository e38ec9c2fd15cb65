//! A glTF scene, as text or binary, and the buffer that it may name `b.bin`, parted by a line of `%%`; `p.png` is there, too.
#![no_main]

use caustica_fuzz::{Access, PIXELS, check, files, load_from, parts};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let is_binary = data.starts_with(b"glTF");
    let [scene, buffer, _] = if is_binary { [data, b"", b""] } else { parts(data) };
    let files = files(&[("s.gltf", scene), ("b.bin", buffer), ("p.png", PIXELS)]);
    check(load_from("s.gltf", Access::given(files)));
});
