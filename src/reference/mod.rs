//! Independent ground truth inside the project: what photon mapping is checked against.

mod path_tracer;

pub use path_tracer::PathTracer;
