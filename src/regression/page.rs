use super::{Row, Shown, table};
use crate::report::{Document, escape};

const STYLE: &str = "\
td.words { white-space: normal }
td:first-child { white-space: nowrap }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(34em, 100%), 1fr)); gap: 1em }
.pictures figure { margin: 0; break-inside: avoid; display: grid; grid-template-columns: 1fr 1fr 1fr; gap: 2px; align-content: start }
.pictures img { width: 100%; image-rendering: pixelated; vertical-align: top }
.pictures figcaption { grid-column: 1 / -1; font-size: 13px; overflow-wrap: anywhere }
.bad { border-left: 4px solid #d62728; padding-left: .5em }";

/// The rows as one HTML document that needs nothing beside itself: what speaks against the pictures first, then what differs.
pub fn page(title: &str, facts: Vec<(&'static str, String)>, rows: &[Row]) -> String {
    let mut ordered: Vec<Row> = rows.to_vec();
    ordered.sort_by_key(|row| (row.verdict.is_good(), row.shown.is_none()));
    let figures: String = ordered.iter().filter_map(|row| Some(figure(row, row.shown.as_ref()?))).collect();
    let pictures = if figures.is_empty() {
        String::new()
    } else {
        format!(
            "<h2>What differs</h2>\n<p>Picture, reference, relative error.</p>\n<div class=\"pictures\">\n{figures}</div>\n"
        )
    };
    let body = format!("{}{pictures}", table(&ordered).to_html());
    Document { title: title.into(), facts, style: STYLE, body, script: "" }.to_html()
}

fn figure(row: &Row, shown: &Shown) -> String {
    let class = if row.verdict.is_good() { "" } else { " class=\"bad\"" };
    let image = |address: &String, what| format!("<img src=\"{address}\" alt=\"{what}\">");
    format!(
        "<figure>{}{}{}<figcaption{class}>{} {} {}</figcaption></figure>\n",
        image(&shown.image, "picture"),
        image(&shown.reference, "reference"),
        image(&shown.errors, "relative error"),
        escape(&row.name),
        row.verdict.word(),
        escape(&row.verdict.because())
    )
}

#[cfg(test)]
mod tests {
    use super::super::Verdict;
    use super::*;

    fn row(name: &str, verdict: Verdict, shown: bool) -> Row {
        let shown = shown.then(|| Shown { image: "i".into(), reference: "r".into(), errors: "e".into() });
        Row { name: name.into(), verdict, comparison: None, shown }
    }

    #[test]
    fn what_is_wrong_stands_first() {
        let rows = [
            row("equal.exr", Verdict::Equal, false),
            row("near.exr", Verdict::Within, true),
            row("a<b.exr", Verdict::Beyond(vec!["mse=1 with 2".into()]), true),
            row("gone.exr", Verdict::NoImage, false),
        ];
        let html = page("Pictures", vec![("Bounds", "mse=1".into())], &rows);
        let places = ["a&lt;b.exr", "gone.exr", "near.exr", "equal.exr"].map(|name| html.find(name).unwrap());
        assert!(places.is_sorted(), "{places:?}");
        assert_eq!(html.matches("<figure>").count(), 2);
        assert_eq!(html.matches("class=\"bad\"").count(), 1);
        assert!(!html.contains("a<b"));
    }

    #[test]
    fn pages_without_differences_have_no_pictures() {
        let html = page("Pictures", vec![], &[row("equal.exr", Verdict::Equal, false)]);
        assert!(!html.contains("What differs") && html.contains("equal.exr"));
    }
}
