//! Rays at edges, vertices and ends.
