//! What values on the command line may look like.

use std::fmt::Debug;
use std::ops::RangeBounds;
use std::str::FromStr;

use crate::ppm;
use crate::shard::PassRange;

pub fn number(text: &str, range: impl RangeBounds<f64> + Debug) -> Result<f64, String> {
    within(f64::from_str(text).map_err(|_| format!("`{text}` is not a number"))?, range)
}

fn within(value: f64, range: impl RangeBounds<f64> + Debug) -> Result<f64, String> {
    if range.contains(&value) { Ok(value) } else { Err(format!("{value} is outside {range:?}")) }
}

/// `NAME=VALUE`.
pub fn definition(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.is_empty() => Ok((name.to_owned(), value.to_owned())),
        _ => Err(format!("`{text}` is no NAME=VALUE")),
    }
}

/// A share, which may be written in percent.
pub fn share(text: &str, range: impl RangeBounds<f64> + Debug) -> Result<f64, String> {
    match text.strip_suffix('%') {
        Some(percent) => within(number(percent.trim(), ..)? / 100.0, range),
        None => number(text, range),
    }
}

/// A positive whole number, which may be written with an exponent.
pub fn count(text: &str) -> Result<u64, String> {
    if let Ok(value) = text.parse::<u64>() {
        return if value > 0 { Ok(value) } else { Err("at least 1 is needed".into()) };
    }
    let value = number(text, 1.0..=1e15)?;
    if value.fract() == 0.0 { Ok(value as u64) } else { Err(format!("`{text}` is not a whole number")) }
}

/// `auto` or a count, which may be 0.
pub fn aiming(text: &str) -> Result<ppm::Aiming, String> {
    match text {
        "auto" => Ok(ppm::Aiming::Auto),
        "0" => Ok(ppm::Aiming::Photons(0)),
        _ => count(text).map(ppm::Aiming::Photons).map_err(|reason| format!("{reason}; or write `auto`")),
    }
}

pub fn count_up_to(most: u64, text: &str) -> Result<u64, String> {
    match count(text)? {
        n if n <= most => Ok(n),
        n => Err(format!("{n} is more than {most}")),
    }
}

/// How many passes, or which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassesArg {
    /// So many from the first.
    Count(u32),
    /// `A..B`.
    Range(PassRange),
}

pub fn passes(text: &str) -> Result<PassesArg, String> {
    match text.contains("..") {
        true => text.parse().map(PassesArg::Range),
        false => text.parse().map(PassesArg::Count).map_err(|error| format!("{error}")),
    }
}

/// Two sides from 1 to 16384 pixels, such as 640x480.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=16384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some((side(width)?, side(height)?)));
    sides.ok_or_else(|| "write WIDTHxHEIGHT, such as 640x480, with sides from 1 to 16384".into())
}

pub fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(n @ 1..=1024) => Ok(n),
        _ => Err("allowed: 1 to 1024".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_may_have_exponents_but_no_fraction() {
        assert_eq!(count("100000"), Ok(100_000));
        assert_eq!(count("1e6"), Ok(1_000_000));
        for wrong in ["0", "-1", "1.5", "nan", "inf", "many", "1e300"] {
            assert!(count(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn photons_are_aimed_by_a_trial_or_by_number() {
        assert_eq!(aiming("auto"), Ok(ppm::Aiming::Auto));
        assert_eq!(aiming("0"), Ok(ppm::Aiming::Photons(0)));
        assert_eq!(aiming("1e3"), Ok(ppm::Aiming::Photons(1000)));
        assert_eq!(aiming("some").unwrap_err(), "`some` is not a number; or write `auto`");
    }

    #[test]
    fn shares_may_be_percentages() {
        assert_eq!(share("2%", 0.0..=1.0), Ok(0.02));
        assert_eq!(share("0.5 %", 0.0..=1.0), Ok(0.005));
        assert_eq!(share("0.02", 0.0..=1.0), Ok(0.02));
        for wrong in ["200%", "%", "two%", "nan%", "-1%", "2"] {
            assert!(share(wrong, 0.0..=1.0).is_err(), "{wrong}");
        }
    }

    #[test]
    fn numbers_outside_their_range_are_refused() {
        assert_eq!(number("0.5", 0.0..=1.0), Ok(0.5));
        for wrong in ["1.5", "nan", "x", "-inf"] {
            assert!(number(wrong, 0.0..=1.0).is_err(), "{wrong}");
        }
    }
}
