//! A page that the tests of this module share.

use super::{Cell, Page, Plot, Scale, Table};

pub fn page() -> Page {
    let row = |name: &str, n, x| vec![Cell::Text(name.into()), Cell::Count(n), Cell::Number(x)];
    let table = Table {
        columns: vec!["name", "points", "time (ms)"],
        rows: vec![row("a, \"b\" <c>", 4_000_000, 1234.56), row("d", 7, 0.012_345_6)],
    };
    let points = |f: f64| vec![(1.0, f), (10.0, 7.0 * f), (100.0, 50.0 * f)];
    let plot = |scale| Plot {
        title: "Time & more".into(),
        x_label: "points".into(),
        y_label: "ms".into(),
        scale,
        series: vec![("a<b".into(), points(1.0)), ("c".into(), points(3.0)), ("none".into(), vec![])],
        guides: vec![("theory".into(), vec![(1.0, 2.0), (100.0, 20.0)])],
    };
    Page {
        title: "Speed < light".into(),
        facts: vec![("Processor", "X & Y".into()), ("Cores", "2".into())],
        note: "Lower `time` is <better>.".into(),
        table,
        plots: vec![plot(Scale::Linear), plot(Scale::Logarithmic)],
    }
}
