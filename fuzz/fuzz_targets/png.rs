//! A PNG picture.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Ok(image) = caustica::output::read_png_bytes(Path::new("a.png"), data) {
        assert_eq!(image.pixels().len(), image.width() * image.height());
    }
});
