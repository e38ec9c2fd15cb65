//! What goes wrong in renderers, case by case.
//!
//! Every test's comment is three paragraphs, which `make hard-cases` turns into the table of `docs/hard-cases.md`:
//!
//! - what must hold, in the first sentence;
//! - `Breaks:` what a renderer that gets it wrong does;
//! - `Mutation:` the change of this code with which the test was seen to fail.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

#[path = "../common/mod.rs"]
mod common;
mod rooms;

mod furnace;
mod glass;
mod interfaces;
mod lights;
mod meshes;
mod outputs;
mod rays;
mod runs;
mod samplers;
mod scale;
mod scene_files;
mod statistics;
mod surfaces;
mod transport;
mod tree;
