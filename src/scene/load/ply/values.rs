//! The values of a PLY file, one after the other.

use super::fault::Fault;
use super::header::Kind;
use crate::scene::load::fields::shortened;

/// Where values come from.
pub(super) trait Values {
    /// The next value, rounded to single precision once.
    fn real(&mut self, kind: Kind) -> Result<f32, Fault>;
    /// The next value, which must be a whole number.
    fn whole(&mut self, kind: Kind) -> Result<i64, Fault>;
    /// An error at the value that was read last.
    fn fault(&self, reason: String) -> Fault;
    /// How many values there may still be, at most.
    fn most_left(&self) -> usize;
}

/// Words between blanks.
pub(super) struct Ascii<'a> {
    bytes: &'a [u8],
    /// Where the next word is looked for.
    at: usize,
    /// Lines before `bytes`.
    lines_before: usize,
}

impl<'a> Ascii<'a> {
    pub fn new(bytes: &'a [u8], lines_before: usize) -> Ascii<'a> {
        Ascii { bytes, at: 0, lines_before }
    }

    fn word(&mut self) -> Result<&'a str, Fault> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let length = rest[start..].iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len() - start);
        self.at += start + length;
        if length == 0 {
            return Err(self.fault(ended()));
        }
        std::str::from_utf8(&rest[start..start + length])
            .map_err(|_| self.fault(String::from("a word that is not UTF-8; allowed: a number")))
    }
}

impl Values for Ascii<'_> {
    fn real(&mut self, _: Kind) -> Result<f32, Fault> {
        let word = self.word()?;
        word.parse().map_err(|_| self.fault(format!("`{}` is not a number; allowed: one", shortened(word))))
    }

    fn whole(&mut self, _: Kind) -> Result<i64, Fault> {
        let word = self.word()?;
        word.parse()
            .map_err(|_| self.fault(format!("`{}` is not a whole number; allowed: one", shortened(word))))
    }

    fn fault(&self, reason: String) -> Fault {
        let newlines = self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count();
        Fault { line: Some(self.lines_before + newlines + 1), reason }
    }

    fn most_left(&self) -> usize {
        (self.bytes.len() - self.at).div_ceil(2)
    }
}

/// Values of fixed sizes without anything between them.
pub(super) struct Binary<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<'a, const BIG: bool> Binary<'a, BIG> {
    pub fn new(bytes: &'a [u8]) -> Binary<'a, BIG> {
        Binary { rest: bytes }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        let Some((&first, rest)) = self.rest.split_first_chunk::<N>() else {
            return Err(self.fault(ended()));
        };
        self.rest = rest;
        let mut bytes = first;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    #[inline]
    fn real(&mut self, kind: Kind) -> Result<f32, Fault> {
        Ok(match kind {
            Kind::F32 => f32::from_le_bytes(self.take()?),
            Kind::F64 => f64::from_le_bytes(self.take()?) as f32,
            _ => self.whole(kind)? as f32,
        })
    }

    #[inline]
    fn whole(&mut self, kind: Kind) -> Result<i64, Fault> {
        Ok(match kind {
            Kind::I8 => i8::from_le_bytes(self.take()?).into(),
            Kind::U8 => u8::from_le_bytes(self.take()?).into(),
            Kind::I16 => i16::from_le_bytes(self.take()?).into(),
            Kind::U16 => u16::from_le_bytes(self.take()?).into(),
            Kind::I32 => i32::from_le_bytes(self.take()?).into(),
            Kind::U32 => u32::from_le_bytes(self.take()?).into(),
            Kind::F32 | Kind::F64 => {
                let value = self.real(kind)?;
                if value.fract() != 0.0 {
                    return Err(self.fault(format!("`{value}` is not a whole number; allowed: one")));
                }
                value as i64
            }
        })
    }

    fn fault(&self, reason: String) -> Fault {
        Fault { line: None, reason }
    }

    fn most_left(&self) -> usize {
        self.rest.len()
    }
}

fn ended() -> String {
    String::from("the file ends before the values that its header promises")
}
