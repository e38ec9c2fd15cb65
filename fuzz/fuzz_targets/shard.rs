//! A shard without its hash: the right one is added, so that what lies behind it is reached.
#![no_main]

use std::path::Path;

use caustica::shard::{Merge, Shard, ShardError};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let signed = [data, blake3::hash(data).as_bytes()].concat();
    if let Ok(shard) = parse(&signed) {
        shard.mean();
        shard.standard_error();
        let bytes = bytes_of(&shard);
        let again = parse(&bytes).expect("what was written is read");
        assert!(bytes_of(&again) == bytes, "nothing is lost");
    }
});

fn parse(bytes: &[u8]) -> Result<Shard, ShardError> {
    let mut merge = Merge::default();
    merge.add_bytes(Path::new("a.shard"), bytes)?;
    Ok(merge.finish().expect("one was added"))
}

fn bytes_of(shard: &Shard) -> Vec<u8> {
    let mut bytes = Vec::new();
    shard.write(&mut bytes).expect("a vector takes everything");
    bytes
}
