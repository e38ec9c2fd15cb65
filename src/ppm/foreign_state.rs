/// Why a state cannot go on in a render: it comes from another one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("its {part} do not belong to this render")]
pub struct ForeignState {
    /// What does not fit.
    pub(super) part: &'static str,
}

impl ForeignState {
    pub(super) fn in_its(part: &'static str) -> ForeignState {
        ForeignState { part }
    }
}
