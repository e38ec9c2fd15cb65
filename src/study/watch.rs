/// What the measurement asks and tells those who started it.
pub trait Watch {
    /// Whether to stop now; what is unfinished is dropped.
    fn is_over(&self) -> bool;
    /// A run begins.
    fn begins(&self, configuration: &str, repetition: u32);
    /// A run is finished, or was before.
    fn is_done(&self);
}
