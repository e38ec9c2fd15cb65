//! What hit points keep from pass to pass.
