use super::emission::Guided;
use super::mixture::Mixture;
use super::{Settings, Stage};
use crate::simd::Isa;

/// What the photons of a chunk fly through.
#[derive(Clone, Copy)]
pub(super) struct Course<'a> {
    pub isa: Isa,
    pub stage: Stage<'a>,
    pub settings: &'a Settings,
    pub pass: u32,
    /// Of which natural and aimed photons are parts, where there are aimed ones.
    pub mixture: Option<&'a Mixture>,
    /// Where those that are not aimed start, if not by nature.
    pub guided: Option<Guided<'a>>,
    /// Whether it is to be told which paths brought which photons.
    pub names_paths: bool,
}

impl<'a> Course<'a> {
    /// Of natural photons alone, by the best instruction set.
    pub fn natural(stage: Stage<'a>, settings: &'a Settings, pass: u32) -> Course<'a> {
        Course { isa: Isa::best(), stage, settings, pass, mixture: None, guided: None, names_paths: false }
    }
}
