//! Pictures under way in the viewer [tev](https://github.com/Tom94/tev), over TCP.
//!
//! A thread of its own sends what has changed, so that a slow viewer does not slow the render; one that is absent or vanishes
//! costs a warning and nothing else.

mod address;
mod error;
mod packet;
mod tiles;
mod viewer;

pub use address::{Address, NoAddress};
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
        self.is_due_at(Instant::now())
    }

    fn is_due_at(&self, now: Instant) -> bool {
        self.idle.load(Ordering::Relaxed) && self.shown.is_none_or(|shown| now >= shown + INTERVAL)
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
        self.finish_within(FAREWELL)
    }

    fn finish_within(self, patience: Duration) -> Result<(), LiveViewError> {
        drop(self.pictures);
        match self.ended.recv_timeout(patience) {
            Err(RecvTimeoutError::Timeout) => Err(LiveViewError::Slow { seconds: patience.as_secs() }),
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    fn listener() -> (TcpListener, Address) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().into();
        (listener, address)
    }

    #[test]
    fn pictures_are_due_four_times_a_second_while_the_viewer_keeps_up() {
        let (_listener, address) = listener();
        let mut view = LiveView::start(address, "a".into(), |_| ());
        let shown = Instant::now();
        view.shown = Some(shown);
        assert!(!view.is_due_at(shown + INTERVAL - Duration::from_nanos(1)));
        assert!(view.is_due_at(shown + INTERVAL));
        view.idle.store(false, Ordering::Relaxed);
        assert!(!view.is_due_at(shown + 100 * INTERVAL));
    }

    /// It has more to take than the buffers of a connection hold.
    #[test]
    fn the_end_does_not_wait_forever() {
        let (_listener, address) = listener();
        let mut view = LiveView::start(address, "a".into(), |_| ());
        view.show(Image::new(2000, 2000));
        let told = view.finish_within(Duration::from_millis(1)).unwrap_err().to_string();
        assert_eq!(told, "the viewer did not take the last picture within 0 s");
    }
}
