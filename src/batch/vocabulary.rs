//! What a job may be told: the flags of `caustica render`, as whoever knows the command line lists them.

use std::collections::BTreeMap;

/// The flags that a job may set, and who checks their values.
pub struct Vocabulary<'a> {
    /// Flags without their dashes.
    pub flags: BTreeMap<String, Kind>,
    /// Flags that are the batch's own business, and why.
    pub barred: &'a [(&'a str, &'a str)],
    /// Whether these are arguments of `caustica render`; otherwise what is wrong with them.
    pub check: &'a dyn Fn(&[String]) -> Result<(), String>,
}

/// What a flag takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: it is on or off.
    Switch,
    /// One value.
    Value,
    /// Several values between commas.
    Commas,
    /// A value each time that it is given.
    Repeated,
}

impl Vocabulary<'_> {
    /// What the flag takes.
    ///
    /// # Errors
    /// That it is no flag, or is barred, and what is allowed.
    pub(super) fn kind(&self, flag: &str) -> Result<Kind, String> {
        if let Some((_, why)) = self.barred.iter().find(|(barred, _)| *barred == flag) {
            return Err(format!("`{flag}` is not for jobs: {why}"));
        }
        self.flags.get(flag).copied().ok_or_else(|| {
            let names: Vec<&str> = self.flags.keys().map(String::as_str).collect();
            format!(
                "unknown key `{flag}`; allowed: {} and flags of `caustica render`: {}",
                OWN.join(", "),
                names.join(", ")
            )
        })
    }
}

/// Keys of a job that are no flags.
pub(super) const OWN: [&str; 6] = ["scene", "name", "priority", "retries", "memory-limit", "sweep"];
