//! Lights where they should not be, and none at all.
