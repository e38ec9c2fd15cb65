use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The kinds of paths between a light and the eye, told apart by what lies between the light and the receiver that the
/// eye sees, directly or through specular events. In Heckbert's letters, with `D` that receiver:
/// every path from a light over a receiver to the eye is of exactly one kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PathClass {
    /// `L D`: nothing. Shadow rays bring it.
    Direct,
    /// `L S+ D`: specular events alone.
    Caustic,
    /// `L S* D (S | D)* D`: some diffuse bounce.
    Indirect,
}

impl PathClass {
    /// All of them, in the order in which a picture adds them up.
    pub const ALL: [PathClass; 3] = [PathClass::Direct, PathClass::Caustic, PathClass::Indirect];

    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            PathClass::Direct => "direct",
            PathClass::Caustic => "caustic",
            PathClass::Indirect => "indirect",
        }
    }
}

impl fmt::Display for PathClass {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name is none of a [`PathClass`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no kind of path; allowed: `direct`, `caustic`, `indirect`")]
pub struct UnknownPathClass(String);

impl FromStr for PathClass {
    type Err = UnknownPathClass;

    fn from_str(name: &str) -> Result<PathClass, UnknownPathClass> {
        let named = PathClass::ALL.into_iter().find(|class| class.name() == name);
        named.ok_or_else(|| UnknownPathClass(name.to_owned()))
    }
}

/// A set of kinds of paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathClasses {
    /// By the place of each in [`PathClass::ALL`].
    members: [bool; 3],
}

impl PathClasses {
    /// All of them.
    pub const ALL: PathClasses = PathClasses { members: [true; 3] };

    /// None of them.
    pub const NONE: PathClasses = PathClasses { members: [false; 3] };

    /// Whether `class` is one of them.
    pub fn contains(self, class: PathClass) -> bool {
        self.members[class as usize]
    }

    /// Whether light of any of them comes by photons.
    pub fn any_photons(self) -> bool {
        self.contains(PathClass::Caustic) || self.contains(PathClass::Indirect)
    }

    /// The same, without `class`.
    pub fn without(mut self, class: PathClass) -> PathClasses {
        self.members[class as usize] = false;
        self
    }

    /// Those in both.
    pub fn and(self, other: PathClasses) -> PathClasses {
        PathClasses { members: std::array::from_fn(|k| self.members[k] && other.members[k]) }
    }

    /// Those that it contains, in the order of [`PathClass::ALL`].
    pub fn iter(self) -> impl Iterator<Item = PathClass> {
        PathClass::ALL.into_iter().filter(move |class| self.contains(*class))
    }
}

impl<'de> Deserialize<'de> for PathClasses {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<PathClasses, D::Error> {
        Ok(Vec::<PathClass>::deserialize(deserializer)?.into_iter().collect())
    }
}

impl Serialize for PathClasses {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter().collect::<Vec<_>>())
    }
}

impl FromIterator<PathClass> for PathClasses {
    fn from_iter<T: IntoIterator<Item = PathClass>>(classes: T) -> PathClasses {
        let mut set = PathClasses::NONE;
        classes.into_iter().for_each(|class| set.members[class as usize] = true);
        set
    }
}

impl fmt::Display for PathClasses {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names: Vec<&str> = self.iter().map(PathClass::name).collect();
        f.write_str(&names.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for class in PathClass::ALL {
            assert_eq!(class.name().parse(), Ok(class));
        }
        let error = "caustics".parse::<PathClass>().unwrap_err().to_string();
        assert_eq!(error, "`caustics` is no kind of path; allowed: `direct`, `caustic`, `indirect`");
    }

    #[test]
    fn sets_hold_what_was_put_in() {
        let set: PathClasses = [PathClass::Indirect, PathClass::Direct].into_iter().collect();
        assert_eq!(set.to_string(), "direct,indirect");
        assert!(set.any_photons() && !set.without(PathClass::Indirect).any_photons());
        assert_eq!(PathClasses::ALL.and(set), set);
        assert_eq!(PathClasses::ALL.without(PathClass::Caustic), set);
    }
}
