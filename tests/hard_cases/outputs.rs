//! Pictures on their way to the disk.
