//! The tree over hit points, at its limits.
