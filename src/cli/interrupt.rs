use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// Whether the user (or the system, by TERM or USR1) asked to stop.
#[derive(Clone, Debug)]
pub struct Interrupt(Arc<AtomicBool>);

/// Those of which a second one ends the process at once.
const URGENT: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
const EXIT_CODE: i32 = 130;

impl Interrupt {
    /// Listens from now on. The first signal is remembered, a second one ends the process at once; USR1, which batch systems send
    /// some time before they end a job, does not count for that.
    pub fn listen() -> Interrupt {
        let asked = Arc::new(AtomicBool::new(false));
        if let Err(error) = register(&asked) {
            note!("warning: Ctrl-C will not save the picture: {error}");
        }
        Interrupt(asked)
    }

    /// As a signal does.
    pub fn ask(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

fn register(asked: &Arc<AtomicBool>) -> io::Result<()> {
    let urged = Arc::new(AtomicBool::new(false));
    for signal in URGENT {
        // In this order, so that the first one does not find itself.
        flag::register_conditional_shutdown(signal, EXIT_CODE, Arc::clone(&urged))?;
        flag::register(signal, Arc::clone(&urged))?;
        flag::register(signal, Arc::clone(asked))?;
    }
    flag::register(SIGUSR1, Arc::clone(asked)).map(drop)
}
