//! Triangles and normals that are none.
