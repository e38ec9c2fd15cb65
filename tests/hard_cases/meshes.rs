//! Meshes as people have them.
