//! Pictures inside a page: small PNGs as `data:` addresses.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::block_means;
use crate::film::Image;
use crate::output::{Display, encode_png};

/// `image` as PNG in a `data:` address, by the means of its blocks where it is wider than `widest` pixels (at least 1).
///
/// # Errors
/// When a side of the picture is 0 or too long for PNG.
///
/// ```
/// use caustica::{compare::thumbnail, film::Image, output::Display};
/// let address = thumbnail(&Image::new(640, 480), 160, &Display::default())?;
/// assert!(address.starts_with("data:image/png;base64,"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn thumbnail(image: &Image, widest: usize, display: &Display) -> io::Result<String> {
    let mut png = Vec::new();
    encode_png(&mut png, &block_means(image, image.width().div_ceil(widest)), display)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wide_pictures_are_shown_smaller() {
        let bytes = |address: String| {
            STANDARD.decode(address.strip_prefix("data:image/png;base64,").unwrap()).unwrap()
        };
        let shown = |width| bytes(thumbnail(&Image::new(width, 8), 320, &Display::default()).unwrap());
        let width_of = |png: Vec<u8>| u32::from_be_bytes(png[16..20].try_into().unwrap());
        assert_eq!([64, 320, 640, 1000].map(|width| width_of(shown(width))), [64, 320, 320, 250]);
    }
}
