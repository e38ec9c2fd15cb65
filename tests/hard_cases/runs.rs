//! Long renders, and what ends them.
