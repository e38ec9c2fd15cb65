//! What a render costs, phase by phase, before it is rendered and after; and what each of its effects costs and brings.

mod ablation;
mod seconds;

pub use ablation::{Ablation, ablate};
pub use seconds::{Seconds, measured, predicted};
