use serde::Serialize;

use crate::compare::{Comparison, MetricName};
use crate::report::{Cell, Table};

/// How a pair of pictures fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "verdict", content = "because", rename_all = "snake_case")]
pub enum Verdict {
    /// No channel of any pixel differs.
    Equal,
    /// They differ, and all bounds hold.
    Within,
    /// Bounds that do not hold, each as it is to be read.
    Beyond(Vec<String>),
    /// The first folder has no such file.
    NoImage,
    /// The second folder has no such file.
    NoReference,
    /// They cannot be compared, and why.
    Failed(String),
}

impl Verdict {
    /// That of pictures that were compared, with the bounds that do not hold.
    pub fn of(comparison: &Comparison, broken: Vec<String>) -> Verdict {
        match comparison.value(MetricName::Max) {
            _ if !broken.is_empty() => Verdict::Beyond(broken),
            Some(0.0) => Verdict::Equal,
            _ => Verdict::Within,
        }
    }

    /// Whether nothing speaks against the pair.
    pub fn is_good(&self) -> bool {
        matches!(self, Verdict::Equal | Verdict::Within)
    }

    /// In a word or two, for a table.
    pub fn word(&self) -> &'static str {
        match self {
            Verdict::Equal => "equal",
            Verdict::Within => "within",
            Verdict::Beyond(_) => "BEYOND",
            Verdict::NoImage => "NO IMAGE",
            Verdict::NoReference => "NO REFERENCE",
            Verdict::Failed(_) => "FAILED",
        }
    }

    /// What is behind the word, if anything.
    pub fn because(&self) -> String {
        match self {
            Verdict::Beyond(bounds) => bounds.join("; "),
            Verdict::Failed(why) => why.clone(),
            _ => String::new(),
        }
    }
}

/// Pictures of a pair for a page, as `data:` addresses.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The picture that is judged.
    pub image: String,
    /// What it is held against.
    pub reference: String,
    /// Its relative errors in false colours.
    pub errors: String,
}

/// A pair of pictures and how they fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The path below both folders.
    pub name: String,
    /// How the pair fared.
    #[serde(flatten)]
    pub verdict: Verdict,
    /// What was measured, where they could be compared.
    pub comparison: Option<Comparison>,
    /// Small pictures, where they differ.
    #[serde(skip)]
    pub shown: Option<Shown>,
}

/// The metrics that stand in the table; JSON has all.
const COLUMNS: [MetricName; 8] = [
    MetricName::Rmse,
    MetricName::RelMse,
    MetricName::Smape,
    MetricName::Psnr,
    MetricName::Max,
    MetricName::P99,
    MetricName::MeanRatio,
    MetricName::Flip,
];
const TITLES: [&str; COLUMNS.len()] = ["rmse", "relmse", "smape", "psnr", "max", "p99", "mean-ratio", "flip"];

/// One line a pair.
pub fn table(rows: &[Row]) -> Table {
    let columns = [&["picture", "verdict"][..], &TITLES, &["because"]].concat();
    Table { columns, rows: rows.iter().map(cells).collect() }
}

fn cells(row: &Row) -> Vec<Cell> {
    let value = |metric| row.comparison.as_ref().and_then(|c| c.value(metric)).unwrap_or(f64::NAN);
    let mut cells = vec![Cell::Text(row.name.clone()), Cell::Text(row.verdict.word().into())];
    cells.extend(COLUMNS.map(|metric| Cell::Number(value(metric))));
    cells.push(Cell::Text(row.verdict.because()));
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{BlockCriterion, Estimate, Inputs, Region};
    use crate::film::Image;
    use crate::math::Rgb;

    fn comparison(a: f32, b: f32) -> Comparison {
        let image = |x| Image::from_pixels(1, 1, vec![Rgb::splat(x)]).unwrap();
        let (a, b) = (image(a), image(b));
        Comparison::of(&Inputs {
            image: Estimate::exact(&a),
            reference: Estimate::exact(&b),
            bound: None,
            region: &Region::of(&a),
            blocks: BlockCriterion::new(0.1, 0.0),
        })
        .unwrap()
    }

    /// NaN is never equal to NaN.
    #[test]
    fn only_pictures_without_any_difference_are_equal() {
        assert_eq!(Verdict::of(&comparison(1.0, 1.0), vec![]), Verdict::Equal);
        assert_eq!(Verdict::of(&comparison(1.0, 1.000_000_1), vec![]), Verdict::Within);
        assert_eq!(Verdict::of(&comparison(f32::NAN, f32::NAN), vec![]), Verdict::Within);
        let broken = vec![String::from("mse=1 with 2")];
        assert_eq!(Verdict::of(&comparison(1.0, 1.0), broken.clone()), Verdict::Beyond(broken));
    }

    #[test]
    fn titles_are_those_of_the_metrics() {
        assert_eq!(TITLES.map(str::to_owned), COLUMNS.map(|metric| metric.to_string()));
    }
}
