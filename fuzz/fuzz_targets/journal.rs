//! The list of finished runs that a study leaves behind.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok((runs, whole)) = caustica::study::Journal::parse(Path::new("runs.jsonl"), text) {
        assert!(runs.len() <= whole && whole <= text.len());
    }
});
