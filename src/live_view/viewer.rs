use std::io::{self, Write};
use std::net::TcpStream;

use super::packet::{create_image, update_image};
use super::tiles::{changed, samples};
use super::{Address, LiveViewError};
use crate::film::Image;

/// A connection to a viewer, and what it shows.
pub struct Viewer {
    address: String,
    name: String,
    stream: TcpStream,
    shown: Option<Image>,
}

impl Viewer {
    pub fn connect(address: &Address, name: String) -> Result<Viewer, LiveViewError> {
        let refused = |source| LiveViewError::Connect { address: address.to_string(), source };
        let stream = address.connect().map_err(refused)?;
        Ok(Viewer { address: address.to_string(), name, stream, shown: None })
    }

    /// Shows a picture as large as the one before; the first one makes room for all.
    pub fn show(&mut self, picture: Image) -> Result<(), LiveViewError> {
        self.send(&picture)
            .map_err(|source| LiveViewError::Lost { address: self.address.clone(), source })?;
        self.shown = Some(picture);
        Ok(())
    }

    fn send(&mut self, picture: &Image) -> io::Result<()> {
        if self.shown.is_none() {
            self.stream.write_all(&create_image(&self.name, picture.width(), picture.height()))?;
        }
        for tile in changed(picture, self.shown.as_ref()) {
            self.stream.write_all(&update_image(&self.name, tile, samples(picture, tile)))?;
        }
        Ok(())
    }
}
