//! Scenes of any size, anywhere.
