use std::fmt;

/// A version of Embree, ordered by age; displayed as `4.4.0`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Version {
    major: u32,
    minor: u32,
    patch: u32,
}

impl Version {
    /// From Embree's own notation, `10000 major + 100 minor + patch`.
    pub(super) fn from_number(number: u32) -> Version {
        Version { major: number / 10_000, minor: number / 100 % 100, patch: number % 100 }
    }

    /// The first of the three numbers: interfaces change with it.
    pub fn major(self) -> u32 {
        self.major
    }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_read_and_order_as_embree_numbers_them() {
        assert_eq!(Version::from_number(40_303).to_string(), "4.3.3");
        assert!(Version::from_number(40_400) > Version::from_number(40_399));
    }
}
