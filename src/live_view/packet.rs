//! The packets that tev takes. Numbers are little-endian; texts end with a zero byte; a packet begins with its length in bytes,
//! which counts itself (u32), and its type (u8).
//!
//! # Source
//! The description "Over the Network" in tev's README, and the packets of its own client.

/// The channels that pictures have there.
pub const CHANNELS: [&str; 3] = ["R", "G", "B"];

const CREATE_IMAGE: u8 = 4;
/// The second version of it, which brings all channels at once, one after the other.
const UPDATE_IMAGE: u8 = 5;

/// A rectangle of a picture, in pixels from the top left corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rectangle {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

/// A black picture, in the place of another of that name: `focus: u8, name, width: i32, height: i32, channels: i32` and the
/// channels' names.
pub fn create_image(name: &str, width: usize, height: usize) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, name);
    packet.number(width);
    packet.number(height);
    packet.channels();
    packet.finished()
}

/// Other values for the pixels of a rectangle: `focus: u8, name, channels: i32`, the channels' names, `x, y, width, height: i32`,
/// and the samples in f32, channel by channel and row by row.
pub fn update_image(name: &str, place: Rectangle, samples: impl Iterator<Item = f32>) -> Vec<u8> {
    let mut packet = Packet::new(UPDATE_IMAGE, name);
    packet.channels();
    [place.x, place.y, place.width, place.height].into_iter().for_each(|number| packet.number(number));
    samples.for_each(|sample| packet.0.extend(sample.to_le_bytes()));
    packet.finished()
}

struct Packet(Vec<u8>);

impl Packet {
    /// None of them moves the viewer to its picture.
    fn new(kind: u8, name: &str) -> Packet {
        const FOCUS: u8 = 0;
        let mut packet = Packet(vec![0, 0, 0, 0, kind, FOCUS]);
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|&byte| byte != 0));
        self.0.push(0);
    }

    fn number(&mut self, number: usize) {
        self.0.extend((number as i32).to_le_bytes());
    }

    fn channels(&mut self) {
        self.number(CHANNELS.len());
        CHANNELS.into_iter().for_each(|name| self.text(name));
    }

    fn finished(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_laid_out_as_described() {
        let create = create_image("a\0b", 300, 2);
        let rest = b"\x04\x00ab\0\x2c\x01\0\0\x02\0\0\0\x03\0\0\0R\0G\0B\0";
        assert_eq!(create, [&[4 + rest.len() as u8, 0, 0, 0], &rest[..]].concat());
        let place = Rectangle { x: 5, y: 6, width: 1, height: 1 };
        let update = update_image("ab", place, [1.0, 2.0, -0.5].into_iter());
        let rest = b"\x05\x00ab\0\x03\0\0\0R\0G\0B\0\x05\0\0\0\x06\0\0\0\x01\0\0\0\x01\0\0\0\
            \0\0\x80\x3f\0\0\0\x40\0\0\0\xbf";
        assert_eq!(update, [&[4 + rest.len() as u8, 0, 0, 0], &rest[..]].concat());
    }
}
