use super::args::RunArgs;
use crate::film::Image;
use crate::live_view::LiveView;

/// The viewer that follows a render, if the user has asked for one; what is wrong with it is told and changes nothing.
pub struct Live(Option<LiveView>);

impl Live {
    pub fn start(args: &RunArgs, scene: &str) -> Live {
        let address = args.display_server.clone();
        let warn = |error| note!("warning: {error}; the render goes on");
        Live(address.map(|address| LiveView::start(address, format!("caustica {scene}"), warn)))
    }

    /// Shows a picture, if it is time for one.
    pub fn follow(&mut self, picture: impl FnOnce() -> Image) {
        if let Some(view) = self.0.as_mut().filter(|view| view.is_due()) {
            view.show(picture());
        }
    }

    /// Shows the last picture.
    pub fn finish(&mut self, picture: impl FnOnce() -> Image) {
        let Some(mut view) = self.0.take() else { return };
        view.show(picture());
        if let Err(error) = view.finish() {
            note!("warning: {error}");
        }
    }
}
