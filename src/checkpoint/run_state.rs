use serde::{Deserialize, Serialize};

use crate::ppm::{Forecast, PictureError};

/// What a run knows beside the render itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunState {
    /// Seconds spent on the render, all processes together.
    pub seconds: f64,
    /// How its error was followed.
    pub errors: ErrorHistory,
}

/// The errors that a run saw, which decide when it looks again, and so when it stops.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorHistory {
    /// The error that the run was to stop at.
    pub target: Option<f64>,
    /// The confidence that errors were told with.
    pub confidence: f64,
    /// All looks.
    pub forecast: Forecast,
    /// The last look.
    pub latest: Option<PictureError>,
    /// The pass after which to look again.
    pub next: u32,
}
