//! Pictures under way in the viewer [tev](https://github.com/Tom94/tev), over TCP.
//!
//! A thread of its own sends what has changed, so that a slow viewer does not slow the render; one that is absent or vanishes
//! costs a warning and nothing else.

mod address;
mod error;
mod packet;
mod tiles;
mod viewer;

pub use address::Address;
pub use error::LiveViewError;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use crate::film::Image;
use viewer::Viewer;

/// Between two pictures.
const INTERVAL: Duration = Duration::from_millis(250);

/// How long the end waits for the last picture to arrive.
const FAREWELL: Duration = Duration::from_secs(5);

/// A viewer that follows a render.
pub struct LiveView {
    pictures: Sender<Image>,
    ended: Receiver<()>,
    idle: Arc<AtomicBool>,
    shown: Option<Instant>,
}

impl LiveView {
    /// Connects to the viewer in the background, where the picture is to be called `name`. `warn` is told at most once what
    /// went wrong; from then on nothing is shown any more.
    pub fn start(
        address: Address,
        name: String,
        warn: impl FnOnce(LiveViewError) + Send + 'static,
    ) -> LiveView {
        let (pictures, to_show) = mpsc::channel();
        let (alive, ended) = mpsc::channel();
        let idle = Arc::new(AtomicBool::new(true));
        let is_idle = Arc::clone(&idle);
        thread::spawn(move || {
            if let Err(error) = follow(&address, name, &to_show, &is_idle) {
                is_idle.store(false, Ordering::Relaxed);
                warn(error);
            }
            drop::<Sender<()>>(alive);
        });
        LiveView { pictures, ended, idle, shown: None }
    }

    /// Whether a picture is worth making: a quarter of a second after the last, if the viewer has taken that.
    pub fn is_due(&self) -> bool {
        self.idle.load(Ordering::Relaxed) && self.shown.is_none_or(|shown| shown.elapsed() >= INTERVAL)
    }

    /// Hands over a picture of always the same size and returns at once. Pictures that the viewer is too slow for are
    /// skipped, but not the last.
    pub fn show(&mut self, picture: Image) {
        self.shown = Some(Instant::now());
        // Whoever has ended has said why.
        drop(self.pictures.send(picture));
    }

    /// Waits some seconds for the viewer to take the last picture.
    ///
    /// # Errors
    /// When it does not.
    pub fn finish(self) -> Result<(), LiveViewError> {
        drop(self.pictures);
        match self.ended.recv_timeout(FAREWELL) {
            Err(RecvTimeoutError::Timeout) => Err(LiveViewError::Slow { seconds: FAREWELL.as_secs() }),
            Ok(()) | Err(RecvTimeoutError::Disconnected) => Ok(()),
        }
    }
}

/// Shows the newest picture, again and again, until there will be none.
fn follow(
    address: &Address,
    name: String,
    pictures: &Receiver<Image>,
    idle: &AtomicBool,
) -> Result<(), LiveViewError> {
    let mut viewer = Viewer::connect(address, name)?;
    while let Ok(picture) = pictures.recv() {
        idle.store(false, Ordering::Relaxed);
        viewer.show(pictures.try_iter().last().unwrap_or(picture))?;
        idle.store(true, Ordering::Relaxed);
    }
    Ok(())
}
