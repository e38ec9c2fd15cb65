/// On which side of a barrier something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Wholly where the barrier winds so often around it; 0 outside.
    Of(i32),
    /// On both, or unknown.
    Either,
}

/// Where something is: its side of every barrier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Region {
    /// By number of the barrier, increasing; outside of those that are not named.
    Known(Vec<(u32, Side)>),
    /// Anywhere.
    Unknown,
}

impl Region {
    /// A barrier between the two: the first on different sides of which they are. `None` if light may go from one to
    /// the other.
    pub fn barrier(&self, other: &Region) -> Option<u32> {
        let (Region::Known(ours), Region::Known(theirs)) = (self, other) else { return None };
        let differs =
            |(barrier, side): &(u32, Side), there: &[(u32, Side)]| match (side, side_of(*barrier, there)) {
                (Side::Of(a), Side::Of(b)) => *a != b,
                _ => false,
            };
        let first = |here: &[(u32, Side)], there: &[(u32, Side)]| {
            here.iter().find(|entry| differs(entry, there)).map(|entry| entry.0)
        };
        [first(ours, theirs), first(theirs, ours)].into_iter().flatten().min()
    }

    /// Whether light may go from one to the other.
    pub fn meets(&self, other: &Region) -> bool {
        self.barrier(other).is_none()
    }

    /// The same on another side of one barrier.
    #[must_use]
    pub fn moved(self, barrier: u32, side: Side) -> Region {
        let Region::Known(mut sides) = self else { return Region::Unknown };
        match sides.binary_search_by_key(&barrier, |entry| entry.0) {
            Ok(at) => sides[at].1 = side,
            Err(at) => sides.insert(at, (barrier, side)),
        }
        Region::Known(sides)
    }
}

fn side_of(barrier: u32, sides: &[(u32, Side)]) -> Side {
    sides.binary_search_by_key(&barrier, |entry| entry.0).map_or(Side::Of(0), |at| sides[at].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_sides_of_one_barrier_are_enough_to_part() {
        let outside = Region::Known(vec![]);
        let at = |barrier, side| outside.clone().moved(barrier, side);
        assert_eq!(outside.barrier(&at(3, Side::Of(1))), Some(3));
        assert_eq!(at(3, Side::Of(1)).barrier(&outside), Some(3));
        assert_eq!(at(3, Side::Of(1)).barrier(&at(2, Side::Of(-1))), Some(2));
        for (a, b) in [
            (outside.clone(), at(1, Side::Of(0))),
            (outside.clone(), at(1, Side::Either)),
            (at(1, Side::Of(1)), at(1, Side::Either)),
            (at(1, Side::Of(1)), at(1, Side::Of(1))),
            (at(1, Side::Of(1)), Region::Unknown),
        ] {
            assert!(a.meets(&b) && b.meets(&a), "{a:?} {b:?}");
        }
    }
}
