//! A checkpoint without its hash: the right one is added, so that what lies behind it is reached.
#![no_main]

use caustica::checkpoint::{parse, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let signed = [data, blake3::hash(data).as_bytes()].concat();
    if let Ok(checkpoint) = parse(&signed) {
        let mut bytes = Vec::new();
        write(&checkpoint, &mut bytes).expect("a vector takes everything");
        // What two spellings of a number mean is the same, so it is not the bytes that must be.
        parse(&bytes).expect("what was written is read");
    }
});
