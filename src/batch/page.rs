//! The batch as one page for a browser.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use super::{Attempt, BatchError, Ledger, Row, State};
use crate::compare::thumbnail;
use crate::output::{Display, read_png};
use crate::report::{Document, escape};

const STYLE: &str = include_str!("page.css");

/// The widest thumbnail in pixels; larger pictures are shown by the means of their blocks.
const WIDEST: usize = 160;

/// The whole page: failures with their reasons, thumbnails, and a table of all jobs with the settings that differ.
///
/// # Errors
/// When the ledger cannot be read.
pub fn page(ledger: &Ledger, folder: &Path) -> Result<String, BatchError> {
    let rows: Vec<Row> = ledger.rows()?.into_iter().filter(|row| row.is_listed).collect();
    let mut attempts = BTreeMap::new();
    for row in &rows {
        attempts.insert(row.job.name.clone(), ledger.attempts(&row.job.name)?);
    }
    let facts = facts(&rows, ledger.measured()?, folder);
    let shown = rows.iter().filter(|row| row.state == State::Done).map(|row| figure(row, folder));
    let body = [
        troubles(&rows, &attempts),
        format!("<h2>Pictures</h2>\n<div class=\"gallery\">\n{}</div>\n", shown.collect::<String>()),
        format!("<h2>All jobs</h2>\n{}", table(&rows, &attempts)),
    ];
    let title = format!("Batch {}", folder.display());
    Ok(Document { title, facts, style: STYLE, body: body.concat(), script: "" }.to_html())
}

fn facts(rows: &[Row], measured: Option<String>, folder: &Path) -> Vec<(&'static str, String)> {
    let count = |state| rows.iter().filter(|row| row.state == state).count();
    let states = State::ALL.iter().map(|&state| format!("{} {}", count(state), state.name()));
    let seconds: f64 = rows.iter().filter(|row| row.state == State::Done).filter_map(|row| row.seconds).sum();
    let programs: BTreeSet<&str> = rows.iter().filter_map(|row| row.program.as_deref()).collect();
    let mut facts = vec![
        ("Folder", folder.display().to_string()),
        ("Jobs", format!("{}: {}", rows.len(), states.collect::<Vec<_>>().join(", "))),
        ("Render seconds", format!("{seconds:.1} of all jobs together")),
        ("Programs", programs.into_iter().collect::<Vec<_>>().join(", ")),
    ];
    facts.extend(measured.map(|measured| ("Jobs x threads", measured)));
    facts
}

/// What failed, and what took more than one attempt.
fn troubles(rows: &[Row], attempts: &BTreeMap<String, Vec<Attempt>>) -> String {
    let of = |row: &Row| attempts.get(&row.job.name).map_or(&[][..], Vec::as_slice).iter();
    let died = |row: &&Row| of(row).any(|attempt| attempt.outcome.as_deref() == Some("died"));
    let troubled: Vec<&Row> = rows.iter().filter(|row| row.state == State::Failed || died(row)).collect();
    if troubled.is_empty() {
        return String::new();
    }
    let attempt = |attempt: &Attempt| {
        let [outcome, reason, words] = [&attempt.outcome, &attempt.reason, &attempt.last_words]
            .map(|text| escape(text.as_deref().unwrap_or_default()));
        let words = if words.is_empty() { words } else { format!("<pre>{words}</pre>") };
        format!(
            "<li value=\"{}\">{outcome}{} {reason}{words}</li>",
            attempt.number,
            if reason.is_empty() { "" } else { ":" }
        )
    };
    let row = |row: &&Row| {
        let attempts: String = of(row).map(attempt).collect();
        let (name, state) = (escape(&row.job.name), row.state.name());
        format!(
            "<tr class=\"{state}\"><td class=\"words\">{name}</td><td class=\"words\">{state}</td><td class=\"words\"><ol>{attempts}</ol></td></tr>\n"
        )
    };
    let rows: String = troubled.iter().map(row).collect();
    format!(
        "<h2>Failures</h2>\n<div class=\"scroll\"><table>\n<thead><tr><th class=\"words\">job</th><th class=\"words\">state</th>\
         <th class=\"words\">attempts</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

fn figure(row: &Row, folder: &Path) -> String {
    let name = escape(&row.job.name);
    let picture = match small(&row.job.picture(folder).with_extension("png")) {
        Some(address) => format!("<img alt=\"{name}\" src=\"{address}\">"),
        None => "<p class=\"gone\">the picture is gone</p>".to_owned(),
    };
    let seconds = row.seconds.map_or(String::new(), |seconds| format!("{seconds:.1} s"));
    let error = row.error.map_or(String::new(), |error| format!(", error {}", percent(error)));
    format!("<figure>{picture}<figcaption>{name}<br>{seconds}{error}</figcaption></figure>\n")
}

/// As a `data:` address.
fn small(path: &Path) -> Option<String> {
    thumbnail(&read_png(path).ok()?, WIDEST, &Display::default()).ok()
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

/// Flags that not all jobs have alike: what was swept.
fn varying(rows: &[Row]) -> Vec<String> {
    let flags: BTreeSet<&str> =
        rows.iter().flat_map(|row| row.job.settings.iter().map(|(flag, _)| flag)).collect();
    let differs = |flag: &&str| rows.iter().any(|row| setting(row, flag) != setting(&rows[0], flag));
    flags.into_iter().filter(differs).map(str::to_owned).collect()
}

fn setting(row: &Row, flag: &str) -> Option<String> {
    let (_, values) = row.job.settings.iter().find(|(name, _)| *name == flag)?;
    Some(if values.is_empty() { "yes".to_owned() } else { values.join(", ") })
}

fn table(rows: &[Row], attempts: &BTreeMap<String, Vec<Attempt>>) -> String {
    let varying = varying(rows);
    let title = |title: &str| format!("<th>{}</th>", escape(title));
    let titles: String = ["job", "scene"]
        .into_iter()
        .chain(varying.iter().map(String::as_str))
        .chain([
            "state",
            "passes",
            "load (s)",
            "render (s)",
            "error",
            "error at most",
            "attempts",
            "reason or warnings",
        ])
        .map(title)
        .collect();
    let body: String = rows.iter().map(|row| table_row(row, &varying, attempts)).collect();
    format!(
        "<div class=\"scroll\"><table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{body}</tbody>\n</table></div>\n"
    )
}

fn table_row(row: &Row, varying: &[String], attempts: &BTreeMap<String, Vec<Attempt>>) -> String {
    let attempts = attempts.get(&row.job.name).map_or(&[][..], Vec::as_slice);
    let load = attempts.last().and_then(|attempt| attempt.load_seconds);
    let warnings = attempts.last().and_then(|attempt| attempt.last_words.as_deref()).unwrap_or_default();
    let word = |text: &str| format!("<td class=\"words\">{}</td>", escape(text));
    let number = |text: Option<String>| format!("<td>{}</td>", text.unwrap_or_else(|| "-".into()));
    let seconds = |seconds: Option<f64>| number(seconds.map(|seconds| format!("{seconds:.3}")));
    let is_done = row.state == State::Done;
    let mut cells = vec![word(&row.job.name), word(&row.job.scene.to_string_lossy())];
    cells.extend(varying.iter().map(|flag| word(&setting(row, flag).unwrap_or_default())));
    cells.extend([
        word(row.state.name()),
        number(row.passes.filter(|_| is_done).map(|passes| passes.to_string())),
        seconds(load),
        seconds(row.seconds.filter(|_| is_done)),
        number(row.error.filter(|_| is_done).map(percent)),
        number(row.error_bound.filter(|_| is_done).map(percent)),
        number(Some(attempts.len().to_string())),
        word(row.reason.as_deref().unwrap_or(warnings)),
    ]);
    format!("<tr class=\"{}\">{}</tr>\n", row.state.name(), cells.concat())
}

#[cfg(test)]
mod tests {
    use super::super::{Change, Done, FileHash, Job, Settings, Verdict};
    use super::*;
    use crate::film::Image;
    use crate::math::Rgb;
    use crate::output::write_png;
    use base64::Engine;
    use base64::engine::general_purpose::STANDARD;

    fn job(name: &str, alpha: &str) -> Job {
        let mut settings = Settings::default();
        settings.set("alpha", Some(vec![alpha.into()]));
        settings.set("passes", Some(vec!["4".into()]));
        Job {
            name: name.into(),
            scene: "s.toml".into(),
            settings,
            priority: 0,
            retries: 0,
            memory_limit: None,
        }
    }

    fn ended(job: &str, verdict: Verdict) -> Change {
        Change::Ended { job: job.into(), verdict, last_words: "last <words>".into() }
    }

    /// A folder with a picture and a failure.
    fn html() -> String {
        let folder = tempfile::tempdir().unwrap();
        let mut ledger = Ledger::open(folder.path()).unwrap();
        ledger.enlist(&[job("good", "0.5"), job("bad", "0.7")], folder.path()).unwrap();
        let began = |job: &str| Change::Began { job: job.into(), process: 7, threads: 1 };
        let outputs = vec![FileHash { path: "good.exr".into(), hash: Some("0".into()) }];
        let done = Done {
            passes: 4,
            seconds: 1.25,
            error: Some(0.021),
            error_bound: Some(0.03),
            peak_memory: None,
            outputs,
        };
        let reason = "s.toml:3: <material> is & missing".to_owned();
        let changes = [
            began("good"),
            ended("good", Verdict::Done(done)),
            began("bad"),
            ended("bad", Verdict::Failed { reason }),
        ];
        ledger.note(&changes, "0.1.0").unwrap();
        let mut image = Image::new(400, 2);
        image.pixels_mut().fill(Rgb::ONE);
        write_png(&folder.path().join("good.png"), &image, &Display::default()).unwrap();
        page(&ledger, folder.path()).unwrap()
    }

    #[test]
    fn pictures_numbers_and_failures_are_there() {
        let html = html();
        for words in [
            "1 done, 1 failed",
            "<td>1.250</td>",
            "<td>2.100 %</td>",
            "<td>3.000 %</td>",
            "s.toml:3: &lt;material&gt; is &amp; missing",
            "last &lt;words&gt;",
        ] {
            assert!(html.contains(words), "{words}: {html}");
        }
        assert_eq!(html.matches("<img ").count(), 1);
    }

    #[test]
    fn what_was_swept_is_a_column_and_the_rest_is_not() {
        let html = html();
        assert!(html.contains("<th>alpha</th>") && html.contains("<td class=\"words\">0.7</td>"));
        assert!(!html.contains("<th>passes</th><th>state") && !html.contains("<th>scene</th><th>passes"));
    }

    #[test]
    fn the_page_needs_nothing_beside_itself() {
        let html = html().replace("src=\"data:image/png;base64,", "");
        for reference in ["http:", "https:", "src=", "href=", "url(", "@import", "<script"] {
            assert!(!html.contains(reference), "{reference}");
        }
    }

    #[test]
    fn thumbnails_are_small() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        for (width, shown) in [(100, 100), (160, 160), (161, 81), (1600, 160)] {
            write_png(&path, &Image::new(width, 3), &Display::default()).unwrap();
            let address = small(&path).unwrap();
            let png = STANDARD.decode(address.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
            assert_eq!(u32::from_be_bytes(png[16..20].try_into().unwrap()), shown, "{width}");
        }
        assert_eq!(small(&folder.path().join("none.png")), None);
    }
}
