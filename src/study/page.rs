//! The study as one page for a browser, on a screen of any width and on paper.

use super::page_convergence::{convergence, duels};
use super::page_words::{Line, digits, section, text};
use super::pictures::{Shown, gradient};
use super::{Axis, Conclusion, Curve, Gallery, SecondsTo, StudyReport};
use crate::report::{Cell, Document, Plot, Scale, Table, escape, facts_to_html};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");

const HOW_TO_READ: &str = "\
*Error* is the relative root-mean-square difference from the reference in percent: the root of the relative mean square \
error that `caustica compare` tells, averaged over the repetitions, which differ in their seeds. *Seconds* are those of the \
set-up (eye paths, tree, first direct light) and of all passes, as medians over the repetitions, with the smallest and \
largest in brackets; loading the scene and comparing pictures are not in them. Repetitions took turns, so that a slow spell \
of the machine hits all configurations alike. A curve that flattens has met what more passes do not mend: eye samples, \
which are taken once (see `samples x4`), a radius that no longer shrinks (`alpha 1`), an effect that is missing, or the \
error of the reference.";

const PRICES: &str = "\
The *exponent* p says how the error falls over the last three octaves of passes, N to the power of -p, with the 95 % interval \
from the repetitions. In theory noise falls with half of alpha and bias with 1 - alpha (Knaus and Zwicker 2011; equal, a \
third, at alpha 2/3). *Half costs* follows from it: so many times the passes, and nearly so many times the seconds, for half the error. The last columns \
are seconds to an error: measured, interpolated between points; or, after \u{2248}, not reached but predicted from the end \
of the curve, which holds only as long as the curve goes on like that. Unless all is opaque and diffuse, no prediction is made for path \
tracing, which never finds a point light through glass, water or masks, nor for light tracing; nor where an effect is left out: such curves end at the light that they lack.";

/// The whole page.
pub fn page(report: &StudyReport, gallery: &Gallery) -> String {
    let size = format!("{} x {} pixels", report.size.0, report.size.1);
    let mut facts = vec![("Scene", report.scene.clone()), ("Pictures", size)];
    facts.push(("Reference", reference(report)));
    facts.push(("Each run", format!("{:.3} s on {} threads", report.seconds_per_run, report.threads)));
    facts.push(("Repetitions", report.repetitions.to_string()));
    facts.push(("Made by", report.command.clone()));
    let body = [
        warnings(report),
        format!("<p>{}</p>\n", text(HOW_TO_READ)),
        section("What accuracy costs", PRICES, &prices(report).to_html()),
        section(
            "The best for its time",
            "No other point is both faster and nearer to the reference.",
            &front(report),
        ),
        convergence(report),
        Axis::ALL.iter().map(|&axis| of_axis(report, axis)).collect(),
        pictures(report, gallery),
        format!("<h2>The machine</h2>\n{}", facts_to_html(&report.machine.lines())),
        format!(
            "<h2>All points</h2>\n<details><summary>Show the table</summary>\n{}</details>\n",
            report.points().to_html()
        ),
    ];
    let title = format!("What accuracy costs: {}", report.scene);
    Document { title, facts, style: STYLE, body: body.concat(), script: SCRIPT }.to_html()
}

fn reference(report: &StudyReport) -> String {
    match &report.reference_made {
        Some(made) => format!(
            "{}: mean of {} renders of {} passes; its halves differ by {:.2} %, so noise leaves it off by about {:.2} %; the \
             first: {}",
            report.reference,
            made.renders,
            made.passes,
            made.halves_differ_percent,
            made.error_percent,
            made.command
        ),
        None => format!("{}, whose own error is not known", report.reference),
    }
}

fn warnings(report: &StudyReport) -> String {
    let mut warnings = Vec::new();
    if !report.complete {
        warnings.push(
            "The study was interrupted or its time was over: the same command goes on with it.".to_owned(),
        );
    }
    let smallest = report.front.last().map_or(f64::INFINITY, |row| row.error_percent);
    let own = report.reference_made.as_ref().map_or(0.0, |made| made.error_percent);
    if smallest < 2.0 * own {
        warnings.push(format!(
            "The smallest errors are less than twice the reference's own {own:.2} %: there curves flatten for its sake. \
             A longer budget makes a better reference."
        ));
    }
    warnings.iter().map(|warning| format!("<p class=\"warning\">{}</p>\n", escape(warning))).collect()
}

const PRICE_COLUMNS: [&str; 12] = [
    "configuration",
    "steps",
    "seconds",
    "error (%)",
    "exponent",
    "theory: noise",
    "theory: bias",
    "half costs",
    "s to 10 %",
    "s to 5 %",
    "s to 2 %",
    "s to 1 %",
];

/// The price list, which is also what a terminal is shown.
pub fn prices(report: &StudyReport) -> Table {
    let columns = PRICE_COLUMNS.into_iter().chain(["command"]).collect();
    Table { columns, rows: report.curves.iter().filter_map(price).collect() }
}

fn price(curve: &Curve) -> Option<Vec<Cell>> {
    let end = curve.end()?;
    let exponent = match (curve.exponent, curve.exponent_half_width) {
        (Some(p), Some(half)) => format!("{p:.3} \u{b1} {half:.3}"),
        (Some(p), None) => format!("{p:.3}"),
        _ => "-".into(),
    };
    let exact = |x: f64| Cell::Text(format!("{x:.3}"));
    let mut cells = vec![
        Cell::Text(curve.name.into()),
        Cell::Count(end.steps.into()),
        Cell::Text(spread(end.seconds.median, end.seconds.min, end.seconds.max)),
        Cell::Text(spread(end.error_percent.mean, end.error_percent.min, end.error_percent.max)),
        Cell::Text(exponent),
        exact(curve.theory.noise),
        curve.theory.bias.map_or(Cell::Text("none".into()), exact),
        Cell::Text(half_costs(curve)),
    ];
    cells.extend(curve.seconds_to.iter().map(conclusion));
    cells.push(Cell::Code(curve.command.clone()));
    Some(cells)
}

fn half_costs(curve: &Curve) -> String {
    match (curve.price_of_half, curve.exponent) {
        (Some(times), _) => format!("x {times:.1}"),
        (None, Some(_)) => "cannot be had".into(),
        (None, None) => "-".into(),
    }
}

fn spread(middle: f64, min: f64, max: f64) -> String {
    let [middle, min, max] = [middle, min, max].map(|x| digits(x, 3));
    format!("{middle} ({min}\u{a0}to\u{a0}{max})")
}

fn conclusion(to: &SecondsTo) -> Cell {
    Cell::Text(match to.seconds {
        Conclusion::Measured(seconds) => spread(seconds.median, seconds.min, seconds.max),
        Conclusion::Predicted(seconds) => format!("\u{2248}\u{a0}{} predicted", digits(seconds, 2)),
        Conclusion::OutOfReach => "not reached".into(),
    })
}

fn front(report: &StudyReport) -> String {
    let points = |curve: &Curve| (curve.name.to_owned(), measured(curve));
    let ends = report.front.iter().map(|row| (row.seconds, row.error_percent)).collect();
    let mut series = vec![("the best of all".to_owned(), ends)];
    series.extend(
        report
            .curves
            .iter()
            .filter(|curve| report.front.iter().any(|row| row.name == curve.name))
            .map(points),
    );
    let columns = vec!["configuration", "steps", "seconds", "error (%)", "command"];
    let row = |row: &super::FrontRow| {
        vec![
            Cell::Text(row.name.into()),
            Cell::Count(row.steps.into()),
            Cell::Number(row.seconds),
            Cell::Number(row.error_percent),
            Cell::Code(row.command.clone()),
        ]
    };
    let rows = report.front.iter().map(row).collect();
    plot("Configurations on the front", series, Vec::new()).to_figure() + &Table { columns, rows }.to_html()
}

fn measured(curve: &Curve) -> Vec<(f64, f64)> {
    curve.points.iter().map(|p| (p.seconds.median, p.error_percent.mean)).collect()
}

fn plot(title: &str, series: Vec<(String, Vec<(f64, f64)>)>, guides: Vec<(String, Vec<(f64, f64)>)>) -> Plot {
    Plot {
        title: title.into(),
        x_label: "seconds".into(),
        y_label: "error (%)".into(),
        scale: Scale::Logarithmic,
        series,
        guides,
    }
}

/// The curves along an axis beside the baseline, with the slopes that theory has for noise.
fn of_axis(report: &StudyReport, axis: Axis) -> String {
    let of_it = |curve: &&Curve| curve.axis == axis.to_string();
    if axis == Axis::Baseline || !report.curves.iter().any(|curve| of_it(&curve)) {
        return String::new();
    }
    let is_shown = |curve: &&Curve| of_it(curve) || curve.axis == Axis::Baseline.to_string();
    let shown: Vec<&Curve> = report.curves.iter().filter(is_shown).collect();
    let series = shown.iter().map(|curve| (curve.name.to_owned(), measured(curve))).collect();
    let guides = shown.first().map_or(Vec::new(), |baseline| guides(axis, baseline, &shown));
    let plot = plot("Error against time", series, guides).to_figure();
    let words = if axis == Axis::Method { duels(report) } else { String::new() };
    format!("<h2>{}</h2>\n{plot}{words}", escape(axis.question()))
}

/// The slopes of theory, all through one point of the baseline: its own, or those that the axis tells apart.
fn guides(axis: Axis, baseline: &Curve, shown: &[&Curve]) -> Vec<Line> {
    let noise = |curve: &Curve, name: &str| (curve.theory.noise, format!("noise in theory, {name}"));
    let slopes: Vec<(f64, String)> = match axis {
        Axis::Alpha => {
            let of = |name| shown.iter().find(|curve| curve.name == name).map(|curve| noise(curve, name));
            ["alpha 1/2", "alpha 2/3", "alpha 1"].into_iter().filter_map(of).collect()
        }
        Axis::Method => shown.iter().map(|curve| noise(curve, curve.name)).collect(),
        _ => {
            let bias = baseline.theory.bias.filter(|bias| *bias > 0.0);
            let bias = bias.map(|exponent| (exponent, "bias in theory".to_owned()));
            [(baseline.theory.noise, "noise in theory".to_owned())].into_iter().chain(bias).collect()
        }
    };
    let line = |(exponent, name): (f64, String)| guide(baseline, exponent, format!("{name}: -{exponent:.2}"));
    slopes.into_iter().filter_map(line).collect()
}

/// A line of the slope through the middle point of the curve, as long as the curve.
fn guide(curve: &Curve, exponent: f64, name: String) -> Option<Line> {
    let points = measured(curve);
    let (x, y) = *points.get(points.len() / 2)?;
    let on_line = |at: f64| (at, y * (at / x).powf(-exponent));
    Some((name, vec![on_line(points.first()?.0), on_line(points.last()?.0)]))
}

fn pictures(report: &StudyReport, gallery: &Gallery) -> String {
    let options = |chosen: usize| -> String {
        let names = ["reference"].into_iter().chain(gallery.shown.iter().map(|shown| shown.name));
        let option = |(index, name): (usize, &str)| {
            let selected = if index == chosen { " selected" } else { "" };
            format!("<option value=\"picture-{index}\"{selected}>{}</option>", escape(name))
        };
        names.enumerate().map(option).collect()
    };
    let viewer = format!(
        "<div class=\"viewer\">\n<div class=\"controls\">\n<select id=\"left\" aria-label=\"Left picture\">{}</select>\n\
         <input id=\"slider\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" aria-label=\"Where the pictures meet\">\n\
         <select id=\"right\" aria-label=\"Right picture\">{}</select>\n</div>\n<div class=\"stage\">\
         <img id=\"under\" alt=\"Right picture\"><img id=\"over\" class=\"over\" alt=\"Left picture\">\
         <div id=\"edge\" class=\"edge\"></div></div>\n</div>\n",
        options(1),
        options(0)
    );
    let scale = format!(
        "<p>Errors of single pixels, relative to the reference:</p>\n<div class=\"scale\" style=\"background:{}\"></div>\n\
         <div class=\"marks\"><span>1 % or less</span><span>10 %</span><span>100 % or more</span></div>\n",
        gradient()
    );
    let reference = format!(
        "<figure><img id=\"picture-0\" src=\"{}\" alt=\"The reference\"><figcaption>reference</figcaption></figure>\n",
        gallery.reference
    );
    let shown: String =
        gallery.shown.iter().zip(1..).map(|(shown, index)| figure(report, shown, index)).collect();
    let note =
        "Move the slider to compare two pictures; below, each stands beside its errors in false colours.";
    section("Pictures", note, &format!("{viewer}{scale}<div class=\"gallery\">\n{reference}{shown}</div>\n"))
}

fn figure(report: &StudyReport, shown: &Shown, index: usize) -> String {
    let name = escape(shown.name);
    let end = report.curves.iter().find(|curve| curve.name == shown.name).and_then(Curve::end);
    let caption = end.map_or(String::new(), |end| {
        let (seconds, error) = (Cell::Number(end.seconds.median), Cell::Number(end.error_percent.mean));
        format!(": {error} % after {seconds} s")
    });
    format!(
        "<figure><img id=\"picture-{index}\" src=\"{}\" alt=\"{name}\"> <img src=\"{}\" alt=\"Errors of {name}\">\
         <figcaption>{name}{caption}</figcaption></figure>\n",
        shown.picture, shown.errors
    )
}
