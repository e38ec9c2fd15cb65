use std::fmt;

use serde::{Serialize, Serializer};

use crate::report::{Cell, Table};

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// As it should be.
    Fine,
    /// Right if it is meant.
    Note,
    /// Probably a mistake: the picture is not what one would expect.
    Warning,
    /// There will be no picture, or a wrong one.
    Fault,
}

/// What was looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Whether the files can be read.
    Loading,
    /// What the loader repaired.
    Repairs,
    /// Numbers that are not finite, or too large for their squares.
    Numbers,
    /// Triangles without area.
    Areas,
    /// Triangles too thin for the errors of points on them.
    Needles,
    /// Surfaces in the same place.
    Duplicates,
    /// The scene's size and place against single precision.
    Extent,
    /// Triangles and spheres too small for the errors of points on them.
    SmallParts,
    /// Whether anything shines.
    Lights,
    /// Point lights inside and on surfaces.
    LightPlaces,
    /// Lamps inside and behind surfaces.
    LampPlaces,
    /// How the photons are shared among the lights.
    LightShares,
    /// Holes in glass.
    OpenGlass,
    /// Which side of glass is its inside.
    Winding,
    /// Glass in glass.
    NestedGlass,
    /// Materials that hardly can be meant.
    Materials,
    /// Where the camera is.
    Camera,
    /// What the camera sees.
    View,
    /// What the depth limit cuts.
    Depth,
    /// What becomes of photons.
    Photons,
    /// The first gather radius.
    Radius,
    /// The radius at which discs stop shrinking.
    RadiusFloor,
    /// Built-in scenes.
    Stability,
}

impl Check {
    /// Its name in tables and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Check::Loading => "loading",
            Check::Repairs => "repairs",
            Check::Numbers => "numbers",
            Check::Areas => "areas",
            Check::Needles => "needles",
            Check::Duplicates => "duplicates",
            Check::Extent => "extent",
            Check::SmallParts => "small parts",
            Check::Lights => "lights",
            Check::LightPlaces => "light places",
            Check::LampPlaces => "lamp places",
            Check::LightShares => "light shares",
            Check::OpenGlass => "open glass",
            Check::Winding => "winding",
            Check::NestedGlass => "nested glass",
            Check::Materials => "materials",
            Check::Camera => "camera",
            Check::View => "view",
            Check::Depth => "depth",
            Check::Photons => "photons",
            Check::Radius => "radius",
            Check::RadiusFloor => "radius floor",
            Check::Stability => "stability",
        }
    }
}

impl Serialize for Check {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What one check found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub check: Check,
    /// How much it matters.
    pub severity: Severity,
    /// Counts and first places.
    pub found: String,
    /// What the render will therefore do: the sentence goes on after "the render".
    pub therefore: String,
}

impl Finding {
    pub(super) fn new(
        check: Check,
        severity: Severity,
        found: impl Into<String>,
        therefore: impl Into<String>,
    ) -> Finding {
        Finding { check, severity, found: found.into(), therefore: therefore.into() }
    }

    pub(super) fn fine(check: Check, found: impl Into<String>) -> Finding {
        Finding::new(check, Severity::Fine, found, "")
    }
}

/// All findings about one scene, or about the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Diagnosis {
    /// What was examined.
    pub subject: String,
    /// In the order of the checks.
    pub findings: Vec<Finding>,
}

/// Widths of the columns of text, so that a row has at most 100 characters.
const FOUND: usize = 36;
const THEREFORE: usize = 36;

impl Diagnosis {
    /// How many findings are of this severity.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }

    /// The worst of all findings; [`Severity::Fine`] of none.
    pub fn severity(&self) -> Severity {
        self.findings.iter().map(|finding| finding.severity).max().unwrap_or(Severity::Fine)
    }

    /// A line that sums it up.
    pub fn verdict(&self) -> String {
        let counted = |severity, name: &str| match self.count(severity) {
            0 => None,
            1 => Some(format!("1 {name}")),
            n => Some(format!("{n} {name}s")),
        };
        let kinds = [(Severity::Fault, "fault"), (Severity::Warning, "warning"), (Severity::Note, "note")];
        let counts: Vec<String> = kinds.into_iter().filter_map(|(kind, name)| counted(kind, name)).collect();
        let word = match self.severity() {
            Severity::Fine | Severity::Note => "sound",
            Severity::Warning => "doubtful",
            Severity::Fault => "not sound",
        };
        let counts = if counts.is_empty() { String::from("nothing to note") } else { counts.join(", ") };
        format!("{}: {word}; {counts}", self.subject)
    }

    /// A row for each finding, whose long texts run on in rows below it.
    pub fn table(&self) -> Table {
        let columns = vec!["", "check", "found", "therefore the render"];
        Table { columns, rows: self.findings.iter().flat_map(rows).collect() }
    }
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Severity::Fine => "fine",
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Fault => "fault",
        })
    }
}

fn rows(finding: &Finding) -> Vec<Vec<Cell>> {
    let (found, therefore) = (wrap(&finding.found, FOUND), wrap(&finding.therefore, THEREFORE));
    let line = |lines: &[String], k: usize| lines.get(k).cloned().unwrap_or_default();
    (0..found.len().max(therefore.len()).max(1))
        .map(|k| {
            let (severity, check) = match k {
                0 => (finding.severity.to_string(), finding.check.name().to_owned()),
                _ => (String::new(), String::new()),
            };
            [severity, check, line(&found, k), line(&therefore, k)].map(Cell::Text).to_vec()
        })
        .collect()
}

/// Lines of at most `width` characters, broken at blanks; a longer word has a line of its own.
fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagnosis(severities: &[Severity]) -> Diagnosis {
        let finding = |&severity| Finding::new(Check::Extent, severity, "found", "does");
        Diagnosis { subject: "s.toml".into(), findings: severities.iter().map(finding).collect() }
    }

    #[test]
    fn lines_break_at_blanks() {
        assert_eq!(wrap("one two  three", 7), ["one two", "three"]);
        assert_eq!(wrap("a much-longer-word b", 4), ["a", "much-longer-word", "b"]);
        assert_eq!(wrap("äöü äöü", 7), ["äöü äöü"]);
        assert!(wrap("", 7).is_empty());
    }

    #[test]
    fn the_worst_finding_makes_the_verdict() {
        use Severity::{Fault, Fine, Note, Warning};
        let verdict = |severities: &[Severity]| diagnosis(severities).verdict();
        assert_eq!(verdict(&[Fine, Fine]), "s.toml: sound; nothing to note");
        assert_eq!(verdict(&[Note, Fine, Note]), "s.toml: sound; 2 notes");
        assert_eq!(verdict(&[Warning, Note]), "s.toml: doubtful; 1 warning, 1 note");
        assert_eq!(verdict(&[Warning, Fault, Warning]), "s.toml: not sound; 1 fault, 2 warnings");
        assert_eq!(diagnosis(&[]).severity(), Fine);
    }

    #[test]
    fn long_texts_run_on_below() {
        let finding = Finding::new(Check::OpenGlass, Severity::Note, "word ".repeat(20), "does");
        let text = Diagnosis { subject: "s".into(), findings: vec![finding] }.table().to_text();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].starts_with("note  open glass  word"), "{text}");
        assert!(lines[2].ends_with("does") && lines[3].trim_start().starts_with("word"), "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 100), "{text}");
    }

    #[test]
    fn json_names_checks_as_tables_do() {
        let json = serde_json::json!(Finding::new(Check::OpenGlass, Severity::Note, "f", "t"));
        let expected =
            serde_json::json!({"check": "open glass", "severity": "note", "found": "f", "therefore": "t"});
        assert_eq!(json, expected);
    }
}
