use std::io;

use thiserror::Error;

/// Why a picture is no longer shown.
#[derive(Debug, Error)]
pub enum LiveViewError {
    /// There is no viewer.
    #[error("no viewer answers at {address}: {source}; start tev, or give the address that its --host has")]
    Connect {
        /// Where it should be.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// There was one.
    #[error("the viewer at {address} takes no more pictures: {source}")]
    Lost {
        /// Where it was.
        address: String,
        /// What the system says.
        source: io::Error,
    },
    /// It is there, but does not take the last picture.
    #[error("the viewer did not take the last picture within {seconds} s")]
    Slow {
        /// How long it had for that.
        seconds: u64,
    },
}
