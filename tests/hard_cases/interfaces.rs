//! Glass, water and what light does at them.
