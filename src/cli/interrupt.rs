use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user (or the system, by TERM) asked to stop.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on. The first signal is remembered, a second one ends the process at once.
    pub fn listen() -> Interrupt {
        let asked = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&asked);
        let listening = ctrlc::set_handler(move || {
            if seen.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
        });
        if let Err(error) = listening {
            note!("warning: Ctrl-C will not save the picture: {error}");
        }
        Interrupt(asked)
    }

    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
