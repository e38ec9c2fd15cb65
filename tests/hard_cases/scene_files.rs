//! Scene files with mistakes in them.
