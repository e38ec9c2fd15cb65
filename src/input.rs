//! Files that others wrote: opened without hanging, read without taking more memory than there is.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file for reading and tells how many bytes it holds.
///
/// # Errors
/// When there is no such file, it may not be read, or it is a folder, a device, a pipe or a socket: those may have no
/// end, or wait for one who never writes.
pub fn open_file(path: &Path) -> io::Result<(File, u64)> {
    // Before it is opened too, since opening a pipe waits for its other end.
    check_kind(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    check_kind(&metadata)?;
    Ok((file, metadata.len()))
}

fn check_kind(metadata: &fs::Metadata) -> io::Result<()> {
    let refused = |kind, reason| Err(io::Error::new(kind, reason));
    match metadata {
        folder if folder.is_dir() => refused(io::ErrorKind::IsADirectory, "it is a folder, not a file"),
        file if file.is_file() => Ok(()),
        _ => refused(io::ErrorKind::InvalidInput, "it is a device, a pipe or a socket, not a regular file"),
    }
}

/// The contents of a regular file, as long as it says to be.
///
/// `cost` is the memory that will be needed for each of its bytes, by this function and by whatever is made of them.
///
/// # Errors
/// As [`open_file`], and when the memory that is available does not suffice.
pub fn read_file(path: &Path, cost: u64) -> io::Result<Vec<u8>> {
    let (file, length) = open_file(path)?;
    check_memory(length.saturating_mul(cost))?;
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// # Errors
/// When `bytes` are more than the memory that is available, with both in the text.
pub fn check_memory(bytes: u64) -> io::Result<()> {
    match available_memory() {
        Some(available) if bytes > available => {
            let text = format!("it takes about {} of memory, {} are available", size(bytes), size(available));
            Err(io::Error::new(io::ErrorKind::OutOfMemory, text))
        }
        _ => Ok(()),
    }
}

/// The bytes that may still be allocated without swapping, by the system's own estimate; `None` where it makes none.
fn available_memory() -> Option<u64> {
    let memory = fs::read_to_string("/proc/meminfo").ok()?;
    let line = memory.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes.saturating_mul(1024))
}

/// A number of bytes for people, such as `1.5 GB`.
pub fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000 => format!("{bytes} bytes"),
        1_000_000..1_000_000_000 => format!("{:.1} MB", bytes as f64 / 1e6),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_opened() {
        let folder = tempfile::tempdir().unwrap();
        let told = |path: &Path| open_file(path).unwrap_err().to_string();
        assert!(told(folder.path()).contains("a folder"));
        assert!(told(Path::new("/dev/zero")).contains("a device, a pipe or a socket"));
        assert_eq!(open_file(&folder.path().join("no")).unwrap_err().kind(), io::ErrorKind::NotFound);
        let path = folder.path().join("a");
        fs::write(&path, "abc").unwrap();
        assert_eq!(open_file(&path).unwrap().1, 3);
        assert_eq!(read_file(&path, 1).unwrap(), b"abc");
    }

    #[test]
    fn a_file_that_memory_does_not_suffice_for_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sparse");
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let error = read_file(&path, 8).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::OutOfMemory);
        assert!(error.to_string().starts_with("it takes about 8796.1 GB of memory, "), "{error}");
    }

    #[test]
    fn sizes_are_told_with_a_unit() {
        assert_eq!([size(999), size(2_500_000), size(24_680_000_000)], ["999 bytes", "2.5 MB", "24.7 GB"]);
    }
}
