//! Which passes are there: ranges of numbers from 0, their ends excluded.

use std::fmt;
use std::ops::{Range, RangeInclusive};
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// Passes from `first` on, before `end`: `A..B`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PassRange {
    /// The first of them, from 0.
    pub first: u32,
    /// The first that is none of them.
    pub end: u32,
}

impl PassRange {
    /// How many they are.
    pub fn count(self) -> u32 {
        self.end - self.first
    }

    /// Their numbers.
    pub fn numbers(self) -> Range<u32> {
        self.first..self.end
    }
}

impl fmt::Display for PassRange {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}..{}", self.first, self.end)
    }
}

impl FromStr for PassRange {
    type Err = String;

    fn from_str(text: &str) -> Result<PassRange, String> {
        let wrong =
            || format!("`{text}` is no range of passes A..B, such as 0..100, which is those from 0 to 99");
        let (first, end) = text.split_once("..").ok_or_else(wrong)?;
        let number = |text: &str| text.parse::<u32>().map_err(|_| wrong());
        match (number(first)?, number(end)?) {
            (first, end) if first < end => Ok(PassRange { first, end }),
            _ => Err(format!("`{text}` holds no pass: the first must be below the end")),
        }
    }
}

/// A set of passes, as ranges in order that do not touch.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Vec<PassRange>", into = "Vec<PassRange>")]
pub struct Passes(Vec<PassRange>);

impl Passes {
    /// The ranges in order.
    pub fn ranges(&self) -> &[PassRange] {
        &self.0
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.0.iter().map(|range| range.count()).sum()
    }

    /// The first that is beyond all of them.
    pub fn end(&self) -> u32 {
        self.0.last().map_or(0, |range| range.end)
    }

    /// Those of both.
    pub fn with(&self, other: &Passes) -> Passes {
        let mut ranges = [&self.0[..], &other.0].concat();
        ranges.sort_unstable_by_key(|range| range.first);
        let mut joined: Vec<PassRange> = Vec::new();
        for range in ranges.into_iter().filter(|range| range.first < range.end) {
            match joined.last_mut() {
                Some(last) if last.end >= range.first => last.end = last.end.max(range.end),
                _ => joined.push(range),
            }
        }
        Passes(joined)
    }

    /// Those that are in both.
    pub fn common(&self, other: &Passes) -> Passes {
        let meet =
            |a: PassRange, b: PassRange| PassRange { first: a.first.max(b.first), end: a.end.min(b.end) };
        let all = self.0.iter().flat_map(|&a| other.0.iter().map(move |&b| meet(a, b)));
        Passes(all.filter(|range| range.first < range.end).collect())
    }

    /// Those of `all` that are missing here.
    pub fn gaps(&self, all: PassRange) -> Passes {
        let (mut gaps, mut next) = (Vec::new(), all.first);
        for range in &self.common(&all.into()).0 {
            gaps.push(PassRange { first: next, end: range.first });
            next = range.end;
        }
        gaps.push(PassRange { first: next, end: all.end });
        gaps.retain(|range| range.first < range.end);
        Passes(gaps)
    }

    /// The numbers of the shards of `each` passes that hold any of them, as lists of batch systems have it: `0,3-5`.
    pub fn shards_of(&self, each: u32) -> String {
        let shards =
            |range: &PassRange| PassRange { first: range.first / each, end: (range.end - 1) / each + 1 };
        let joined = self.0.iter().fold(Passes::default(), |all, range| all.with(&shards(range).into()));
        array_list(joined.0.iter().map(|range| range.first..=range.end - 1))
    }
}

/// Runs of numbers as lists of batch systems have them: `0,3-5`.
pub fn array_list(runs: impl Iterator<Item = RangeInclusive<u32>>) -> String {
    let list = |run: RangeInclusive<u32>| match (run.start(), run.end()) {
        (first, last) if first == last => first.to_string(),
        (first, last) => format!("{first}-{last}"),
    };
    runs.map(list).collect::<Vec<_>>().join(",")
}

impl From<PassRange> for Passes {
    fn from(range: PassRange) -> Passes {
        Passes(if range.first < range.end { vec![range] } else { Vec::new() })
    }
}

impl TryFrom<Vec<PassRange>> for Passes {
    type Error = &'static str;

    fn try_from(ranges: Vec<PassRange>) -> Result<Passes, &'static str> {
        let apart = ranges.windows(2).all(|pair| pair[0].end < pair[1].first);
        let filled = ranges.iter().all(|range| range.first < range.end);
        (apart && filled).then_some(Passes(ranges)).ok_or("ranges of passes that are empty, or not in order")
    }
}

impl From<Passes> for Vec<PassRange> {
    fn from(passes: Passes) -> Vec<PassRange> {
        passes.0
    }
}

impl fmt::Display for Passes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ranges: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&ranges.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn range(text: &str) -> PassRange {
        text.parse().unwrap()
    }

    fn passes(text: &str) -> Passes {
        let ranges = text.split(',').filter(|text| !text.is_empty());
        ranges.fold(Passes::default(), |all, text| all.with(&range(text).into()))
    }

    #[test]
    fn ranges_are_read_as_they_are_written() {
        assert_eq!(range("3..10"), PassRange { first: 3, end: 10 });
        assert_eq!((range("3..10").to_string(), range("3..10").count()), ("3..10".into(), 7));
        for wrong in ["", "3", "3..", "..4", "3..3", "4..3", "-1..3", "3..=4", "3..5000000000"] {
            assert!(wrong.parse::<PassRange>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn neighbours_join_and_gaps_are_found() {
        assert_eq!(passes("8..12,0..4,4..6").to_string(), "0..6,8..12");
        assert_eq!(passes("0..6,8..12").gaps(range("0..20")).to_string(), "6..8,12..20");
        assert_eq!(passes("2..6").gaps(range("0..4")).to_string(), "0..2");
        assert_eq!(passes("0..4").gaps(range("0..4")), Passes::default());
        assert_eq!(passes("").gaps(range("3..4")).to_string(), "3..4");
    }

    #[test]
    fn shards_that_miss_a_pass_are_listed_once() {
        assert_eq!(passes("12..20,28..29").shards_of(4), "3-4,7");
        assert_eq!(passes("0..1,2..3,9..10").shards_of(4), "0,2");
        assert_eq!(passes("3..5").shards_of(4), "0-1");
        assert_eq!(passes("").shards_of(4), "");
    }

    fn some() -> impl Strategy<Value = (Passes, BTreeSet<u32>)> {
        prop::collection::vec((0u32..30, 1u32..6), 0..6).prop_map(|ranges| {
            let ranges = ranges.into_iter().map(|(first, count)| PassRange { first, end: first + count });
            let numbers = ranges.clone().flat_map(PassRange::numbers).collect();
            (ranges.fold(Passes::default(), |all, range| all.with(&range.into())), numbers)
        })
    }

    fn numbers(passes: &Passes) -> BTreeSet<u32> {
        passes.ranges().iter().flat_map(|range| range.numbers()).collect()
    }

    proptest! {
        #[test]
        fn they_are_sets_of_numbers((a, a_numbers) in some(), (b, b_numbers) in some(), all in (0u32..20, 1u32..20)) {
            prop_assert_eq!(numbers(&a), a_numbers.clone());
            prop_assert_eq!(a.count() as usize, a_numbers.len());
            prop_assert_eq!(numbers(&a.with(&b)), a_numbers.union(&b_numbers).copied().collect());
            prop_assert_eq!(numbers(&a.common(&b)), a_numbers.intersection(&b_numbers).copied().collect());
            let all = PassRange { first: all.0, end: all.0 + all.1 };
            prop_assert_eq!(numbers(&a.gaps(all)), all.numbers().filter(|k| !a_numbers.contains(k)).collect());
            prop_assert!(Passes::try_from(a.ranges().to_vec()).is_ok());
        }
    }
}
