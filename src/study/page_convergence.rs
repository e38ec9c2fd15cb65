//! Of the page: how variance and squared bias fall, each beside its theory; and who is ahead in equal time.

use super::convergence::Rate;
use super::page_words::{Line, digits, section, text};
use super::{Axis, Curve, CurvePoint, Duel, Parts, StudyReport};
use crate::report::{Cell, Plot, Scale, Table, escape};

const NOTE: &str = "\
The mean square error of a picture is the *variance* of one render plus the *squared bias* of the mean over many; both are told here as \
the error is, weighed by 1 / (L\u{b2} + 0.01) and averaged over pixels and channels, but neither in percent nor as a root. The variance is that across \
the repetitions at equal passes; squared bias is what is left of their mean error without the variance and the reference's own. It is unbiased, so it comes out \
negative at times: what is less than two standard errors (after \u{b1}) above 0 is *not told apart from 0*, and no slope is fitted to it. \
Repetitions share no random number. Where eye paths are traced once, each repetition has its own, and what these differ by stays in the variance however many \
passes follow; in the shared schedules of the axis `convergence` every pass traces its own, so that falls, too, as 1 / N.";

const THEORY: &str = "\
In theory (Knaus and Zwicker 2011) variance falls as N to the power of -alpha and, where light is smooth, squared bias as N to the power of -2 (1 - alpha). \
A disc that hangs over an edge or reaches into a corner is wrong by a fixed share however small it is: there the zone shrinks, not the \
error in it, and squared bias falls as the radius does, as N to the power of -(1 - alpha) / 2, as long as discs are wider than pixels. Edges govern the squared bias of whole pictures; \
so it stands once more for *flat* pixels alone, whose first discs, and their neighbours', lie on one surface. Slopes are fitted over the \
last three octaves of passes; in brackets stands what the schedule's radii make of these very passes, in which the first, large discs still are.";

/// The section of variance and bias; empty for a single repetition.
pub(super) fn convergence(report: &StudyReport) -> String {
    let rows: Vec<Vec<Cell>> = report.curves.iter().filter_map(row).collect();
    if rows.is_empty() {
        return String::new();
    }
    let table = Table { columns: COLUMNS.to_vec(), rows }.to_html();
    let note = format!("{NOTE} {}", reference(report));
    let theory = format!("<p>{}</p>\n", text(THEORY));
    section("Variance and bias", &note, &(theory + &plots(report) + &table))
}

fn reference(report: &StudyReport) -> &'static str {
    match (report.reference_noise_is_known, &report.reference_made) {
        (true, Some(_)) => {
            "The reference's variance is known by its halves. It is photon-mapped, too, and what it blurs itself is missing \
             from the squared bias: slopes of that are too steep in long runs. One by `caustica reference` (`--reference`, \
             `--reference-stderr`) blurs nothing."
        }
        (true, None) => "The reference's variance is that of its standard error.",
        (false, _) => {
            "The reference's standard error was not given (`--reference-stderr`): its variance is in the squared bias."
        }
    }
}

const COLUMNS: [&str; 12] = [
    "configuration",
    "passes",
    "variance",
    "slope",
    "theory",
    "squared bias",
    "slope",
    "theory, edges",
    "flat pixels (%)",
    "squared bias, flat",
    "slope",
    "theory, smooth",
];

fn row(curve: &Curve) -> Option<Vec<Cell>> {
    let rates = curve.convergence?;
    let (end, separation) = curve.points.iter().rev().find_map(|point| Some((point, point.separation?)))?;
    let mut cells = vec![
        Cell::Text(curve.name.into()),
        Cell::Count(end.steps.into()),
        Cell::Text(scientific(separation.all.variance)),
    ];
    cells.extend(slopes(&rates.variance));
    cells.push(bias2(Some(separation.all)));
    cells.extend(slopes(&rates.bias2));
    let share = separation.flat.map_or(f64::NAN, |flat| 100.0 * flat.share);
    cells.extend([Cell::Number(share), bias2(separation.flat)]);
    cells.extend(slopes(&rates.flat_bias2));
    Some(cells)
}

fn scientific(x: f64) -> String {
    format!("{x:.2e}")
}

fn bias2(parts: Option<Parts>) -> Cell {
    Cell::Text(match parts {
        None => "-".into(),
        Some(parts) if parts.has_bias() => {
            format!("{} \u{b1}\u{a0}{:.1e}", scientific(parts.bias2), parts.bias2_error)
        }
        Some(parts) => format!("not told apart from 0 (\u{b1}\u{a0}{:.1e})", parts.bias2_error),
    })
}

/// What was measured, and what theory has.
fn slopes(rate: &Rate) -> [Cell; 2] {
    let slope = |exponent: f64| format!("{:.2}", -exponent);
    let error = rate.standard_error.map(|error| format!(" \u{b1}\u{a0}{error:.2}")).unwrap_or_default();
    let here = rate.of_schedule.map(|exponent| format!(" ({})", slope(exponent))).unwrap_or_default();
    [
        rate.measured.map_or("-".into(), |exponent| slope(exponent) + &error),
        rate.theory.map_or("none".into(), |exponent| slope(exponent) + &here),
    ]
    .map(Cell::Text)
}

/// Of the shared schedules, or of the baseline where they were not asked for.
fn plots(report: &StudyReport) -> String {
    let on = |axis: Axis| -> Vec<&Curve> {
        report.curves.iter().filter(|curve| curve.axis == axis.to_string()).collect()
    };
    let schedules = on(Axis::Convergence);
    let shown = if schedules.is_empty() { on(Axis::Baseline) } else { schedules };
    let biased = |parts: Option<Parts>| parts.filter(Parts::has_bias).map(|parts| parts.bias2);
    let all = |point: &CurvePoint| Some(point.separation?.all);
    let flat = |point: &CurvePoint| point.separation?.flat;
    [
        plot(
            "Variance",
            &shown,
            |point| Some(all(point)?.variance),
            |curve| curve.convergence?.variance.theory,
        ),
        plot("Squared bias", &shown, |point| biased(all(point)), |curve| curve.convergence?.bias2.theory),
        plot(
            "Squared bias of flat pixels",
            &shown,
            |point| biased(flat(point)),
            |curve| curve.convergence?.flat_bias2.theory,
        ),
    ]
    .concat()
}

fn plot(
    title: &str,
    shown: &[&Curve],
    value: impl Fn(&CurvePoint) -> Option<f64>,
    theory: impl Fn(&Curve) -> Option<f64>,
) -> String {
    let points = |curve: &Curve| -> Vec<(f64, f64)> {
        curve.points.iter().filter_map(|point| Some((f64::from(point.steps), value(point)?))).collect()
    };
    let series: Vec<Line> = shown.iter().map(|curve| (curve.name.to_owned(), points(curve))).collect();
    if series.iter().all(|(_, points)| points.is_empty()) {
        return String::new();
    }
    let guide = |(curve, (name, points)): (&&Curve, &Line)| slope(name, points, theory(curve)?);
    let plot = Plot {
        title: title.into(),
        x_label: "passes".into(),
        y_label: title.to_lowercase(),
        scale: Scale::Logarithmic,
        guides: shown.iter().zip(&series).filter_map(guide).collect(),
        series,
    };
    plot.to_figure()
}

/// The slope of theory through the last point, as long as the curve.
fn slope(name: &str, points: &[(f64, f64)], exponent: f64) -> Option<Line> {
    let (&(first, _), &(x, y)) = (points.first()?, points.last()?);
    let line = vec![(first, y * (first / x).powf(-exponent)), (x, y)];
    Some((format!("theory, {name}: -{exponent:.2}"), line))
}

/// Who is ahead, in words.
pub(super) fn duels(report: &StudyReport) -> String {
    let sentence = |duel: &Duel| format!("<p class=\"duel\">{}</p>\n", escape(&sentence(duel)));
    report.duels.iter().map(sentence).collect()
}

fn sentence(duel: &Duel) -> String {
    let Duel { rival, seconds, baseline_percent, rival_percent, .. } = *duel;
    let leads = duel.baseline_leads();
    let (ahead, behind) = if leads { ("photon mapping", rival) } else { (rival, "photon mapping") };
    let mut text = format!(
        "Measured: at {} s, the last time in both curves, {ahead} is ahead: photon mapping (the baseline) is {} % off, {rival} {} %; ",
        digits(seconds, 3),
        digits(baseline_percent, 3),
        digits(rival_percent, 3)
    );
    text += &match duel.changed {
        Some(changed) => format!("it is from {} s on.", digits(changed, 2)),
        None => "it was from the beginning.".into(),
    };
    let Some([a, b]) = duel.exponents else { return text };
    text += &format!(" The errors fall with time to the power of -{a:.2} and -{b:.2}.");
    text += &match duel.predicted {
        Some((seconds, percent)) => format!(
            " Predicted, if they go on so: {behind} is ahead from about {} s on, at {} %.",
            digits(seconds, 2),
            digits(percent, 2)
        ),
        None if duel.may_lack_light => {
            " Nothing is predicted: in this scene one of them may lack light for ever.".to_owned()
        }
        None => format!(" If they go on so, {ahead} stays ahead."),
    };
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_told_apart_is_no_number() {
        let parts = Parts { share: 1.0, variance: 0.1, bias2: 3e-3, bias2_error: 1e-3 };
        assert_eq!(bias2(Some(parts)), Cell::Text("3.00e-3 \u{b1}\u{a0}1.0e-3".into()));
        for hidden in [1.9e-3, -3e-3] {
            let Cell::Text(text) = bias2(Some(Parts { bias2: hidden, ..parts })) else { panic!() };
            assert_eq!(text, "not told apart from 0 (\u{b1}\u{a0}1.0e-3)");
        }
    }

    #[test]
    fn slopes_stand_beside_theory() {
        let rate = Rate {
            measured: Some(0.551),
            standard_error: Some(0.07),
            theory: Some(2.0 / 3.0),
            of_schedule: Some(0.54),
        };
        let [measured, theory] = slopes(&rate).map(|cell| cell.to_string());
        assert_eq!((measured.as_str(), theory.as_str()), ("-0.55 \u{b1}\u{a0}0.07", "-0.67 (-0.54)"));
        let nothing = slopes(&Rate::default()).map(|cell| cell.to_string());
        assert_eq!(nothing, ["-", "none"]);
    }

    #[test]
    fn sentences_tell_measured_from_predicted() {
        let duel = Duel {
            rival: "path tracing",
            seconds: 12.34,
            baseline_percent: 9.45,
            rival_percent: 15.0,
            exponents: Some([0.3, 0.5]),
            changed: None,
            predicted: Some((123.0, 4.74)),
            may_lack_light: false,
        };
        let text = sentence(&duel);
        for words in [
            "at 12.3 s",
            "photon mapping is ahead",
            "Predicted",
            "path tracing is ahead from about 120 s on, at 4.7 %",
        ] {
            assert!(text.contains(words), "{words} is not in {text}");
        }
        let lost = Duel { baseline_percent: 16.0, changed: Some(5.0), predicted: None, ..duel };
        let text = sentence(&lost);
        assert!(text.contains("path tracing is ahead") && text.contains("from 5.0 s on"), "{text}");
        assert!(text.contains("path tracing stays ahead") && !text.contains("Predicted"), "{text}");
        let dark = sentence(&Duel { predicted: None, may_lack_light: true, ..duel });
        assert!(dark.contains("Nothing is predicted") && !dark.contains("stays ahead"), "{dark}");
    }
}
