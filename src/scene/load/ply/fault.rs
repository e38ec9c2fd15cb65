/// What is wrong in the body, and in which line of an ASCII file.
#[derive(Debug)]
pub(super) struct Fault {
    pub line: Option<usize>,
    pub reason: String,
}
