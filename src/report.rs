//! Tables and plots for people: as text, as CSV, and as one HTML page that needs nothing beside itself.
//!
//! A number is rounded once, in [`Cell`], so every form shows the same digits.

use std::fmt;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// An exact count.
    Count(u64),
    /// A measured number, shown with four digits; a dash where it is not finite.
    Number(f64),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Cell::Text(text) => f.pad(text),
            Cell::Count(count) => f.pad(&count.to_string()),
            Cell::Number(number) => f.pad(&four_digits(*number)),
        }
    }
}

fn four_digits(x: f64) -> String {
    if !x.is_finite() {
        return "-".into();
    }
    let magnitude = if x == 0.0 { 0.0 } else { x.abs().log10().floor() };
    let decimals = (3.0 - magnitude).clamp(0.0, 12.0) as usize;
    format!("{x:.decimals$}")
}

/// Rows under named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What each column holds, with its unit.
    pub columns: Vec<&'static str>,
    /// As many cells in each row as there are columns.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// In columns of equal width, with words to the left and numbers to the right.
    pub fn to_text(&self) -> String {
        let widths: Vec<usize> = (0..self.columns.len()).map(|k| self.width(k)).collect();
        let titles = self.columns.iter().map(|&title| Cell::Text(title.into())).collect();
        let rule = widths.iter().map(|&w| Cell::Text("-".repeat(w))).collect();
        let mut text = String::new();
        for row in [&titles, &rule].into_iter().chain(&self.rows) {
            let cells: Vec<String> =
                row.iter().enumerate().map(|(k, cell)| self.padded(k, cell, widths[k])).collect();
            text += cells.join("  ").trim_end();
            text.push('\n');
        }
        text
    }

    /// As comma-separated values, with the columns' names in the first line.
    pub fn to_csv(&self) -> String {
        let titles = self.columns.iter().map(|&title| Cell::Text(title.into())).collect();
        let line = |row: &Vec<Cell>| row.iter().map(csv_field).collect::<Vec<_>>().join(",") + "\n";
        [&titles].into_iter().chain(&self.rows).map(line).collect()
    }

    fn to_html(&self) -> String {
        let title = |(column, title): (usize, &&str)| {
            let class = if self.holds_words(column) { " class=\"words\"" } else { "" };
            format!("<th{class}>{}</th>", escape(title))
        };
        let titles: String = self.columns.iter().enumerate().map(title).collect();
        let cell = |cell: &Cell| match cell {
            Cell::Text(text) => format!("<td class=\"words\">{}</td>", escape(text)),
            _ => format!("<td>{cell}</td>"),
        };
        let row = |row: &Vec<Cell>| format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
        let rows: String = self.rows.iter().map(row).collect();
        format!("<table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n")
    }

    fn width(&self, column: usize) -> usize {
        let cells = self.rows.iter().map(|row| row[column].to_string().chars().count());
        cells.chain([self.columns[column].chars().count()]).max().unwrap_or(0)
    }

    fn padded(&self, column: usize, cell: &Cell, width: usize) -> String {
        if self.holds_words(column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    }

    fn holds_words(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(&row[column], Cell::Text(text) if !text.is_empty()))
    }
}

fn csv_field(cell: &Cell) -> String {
    let text = cell.to_string();
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// What stands between backticks is code.
fn with_code(text: &str) -> String {
    let part = |(index, part): (usize, &str)| {
        if index % 2 == 1 { format!("<code>{}</code>", escape(part)) } else { escape(part) }
    };
    text.split('`').enumerate().map(part).collect()
}

/// How an axis counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps, from zero.
    Linear,
    /// Equal factors; what is not positive is left out.
    Logarithmic,
}

/// Lines through measured points.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// What is shown.
    pub title: String,
    /// What goes to the right, with its unit.
    pub x_label: String,
    /// What goes up, with its unit.
    pub y_label: String,
    /// How both axes count.
    pub scale: Scale,
    /// Names and points.
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

/// Width and height of a plot (pixels), and the width of its legend.
const PLOT_SIZE: (u32, u32) = (1020, 440);
const LEGEND_WIDTH: u32 = 240;

/// Told apart on white.
const COLORS: [RGBColor; 8] = [
    RGBColor(31, 119, 180),
    RGBColor(214, 39, 40),
    RGBColor(44, 160, 44),
    RGBColor(255, 127, 14),
    RGBColor(148, 103, 189),
    RGBColor(0, 0, 0),
    RGBColor(23, 190, 207),
    RGBColor(227, 119, 194),
];

type DrawResult = Result<(), Box<dyn std::error::Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Plot {
    /// The plot as an SVG element; empty where there is no point to draw.
    pub fn to_svg(&self) -> String {
        let (Some(x), Some(y)) = (self.range(|p| p.0), self.range(|p| p.1)) else { return String::new() };
        let mut svg = String::new();
        // Nothing that is written to a string can fail; a plot that could not be drawn says so in its place.
        let drawn = self.draw(&mut svg, x, y);
        drawn.map_or_else(|error| format!("<p>{}</p>", escape(&error.to_string())), |()| svg)
    }

    fn shown(&self, points: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let fits = |value: f64| value.is_finite() && (self.scale == Scale::Linear || value > 0.0);
        points.iter().copied().filter(|&(x, y)| fits(x) && fits(y)).collect()
    }

    /// From the smallest to the largest coordinate, with some room.
    fn range(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values: Vec<f64> =
            self.series.iter().flat_map(|(_, points)| self.shown(points)).map(|p| coordinate(&p)).collect();
        let min = values.iter().copied().reduce(f64::min)?;
        let max = values.iter().copied().reduce(f64::max)?;
        Some(match self.scale {
            Scale::Linear => (min.min(0.0), if max > 0.0 { 1.1 * max } else { 1.0 }),
            Scale::Logarithmic => (0.8 * min, 1.25 * max),
        })
    }

    fn draw(&self, svg: &mut String, x: (f64, f64), y: (f64, f64)) -> DrawResult {
        let area = SVGBackend::with_string(svg, PLOT_SIZE).into_drawing_area();
        area.fill(&WHITE)?;
        let (chart, legend) = area.split_horizontally(PLOT_SIZE.0 - LEGEND_WIDTH);
        match self.scale {
            Scale::Linear => self.draw_lines(&chart, x.0..x.1, y.0..y.1)?,
            Scale::Logarithmic => {
                let axis = |(min, max): (f64, f64)| (min..max).log_scale().with_key_points(ticks(min, max));
                self.draw_lines(&chart, axis(x), axis(y))?;
            }
        }
        self.draw_legend(&legend)?;
        Ok(area.present()?)
    }

    fn draw_lines<X, Y>(&self, area: &Area, x: X, y: Y) -> DrawResult
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 18))
            .margin(12)
            .x_label_area_size(44)
            .y_label_area_size(72)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.15))
            .label_style(("sans-serif", 13))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|value| tick_label(*value))
            .y_label_formatter(&|value| tick_label(*value))
            .draw()?;
        for (color, (_, points)) in COLORS.iter().cycle().zip(&self.series) {
            let points = self.shown(points);
            chart.draw_series([PathElement::new(points.clone(), color.stroke_width(2))])?;
            chart.draw_series(points.into_iter().map(|point| Circle::new(point, 3, color.filled())))?;
        }
        Ok(())
    }

    /// The names of the series, one below the other, beside the lines.
    fn draw_legend(&self, area: &Area) -> DrawResult {
        for ((color, (name, _)), y) in COLORS.iter().cycle().zip(&self.series).zip((60..).step_by(22)) {
            area.draw(&PathElement::new(vec![(0, y), (20, y)], color.stroke_width(2)))?;
            area.draw(&Circle::new((10, y), 3, color.filled()))?;
            area.draw(&Text::new(name.clone(), (28, y - 4), ("sans-serif", 13)))?;
        }
        Ok(())
    }
}

/// Round numbers from `min` to `max` on a logarithmic axis: the fewer decades there are, the more of each.
fn ticks(min: f64, max: f64) -> Vec<f64> {
    let decades = (max / min).log10();
    let of_decade: &[f64] = match decades {
        ..1.0 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        ..3.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let exponents = min.log10().floor() as i32..=max.log10().floor() as i32;
    let all = exponents.flat_map(|exponent| of_decade.iter().map(move |digit| digit * 10f64.powi(exponent)));
    all.filter(|tick| (min..=max).contains(tick)).collect()
}

/// Without the zeros that say how exact a number is.
fn tick_label(value: f64) -> String {
    let text = four_digits(value);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A page of plots and a table, with what one must know to read them on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// What was measured.
    pub title: String,
    /// Names and values: the machine, the settings.
    pub facts: Vec<(&'static str, String)>,
    /// What the numbers mean; names of columns stand between backticks.
    pub note: String,
    /// The numbers.
    pub table: Table,
    /// The pictures.
    pub plots: Vec<Plot>,
}

const STYLE: &str = "\
body { font: 15px/1.5 sans-serif; color: #222; max-width: 84em; margin: 2em auto; padding: 0 1em }
p, dl { max-width: 68em }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 12px; margin: 1em 0 }
th, td { padding: .2em .5em; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd }
thead th { border-bottom: 2px solid #888; vertical-align: bottom; white-space: normal }
.words, dl { text-align: left }
dl { display: grid; grid-template-columns: max-content auto; gap: .1em 1.5em }
dt { color: #666 }
dd { margin: 0 }
svg { max-width: 100%; height: auto }";

impl Page {
    /// The facts, the table and the note as text.
    pub fn to_text(&self) -> String {
        let width = self.facts.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        let facts: String =
            self.facts.iter().map(|(name, value)| format!("{name:<width$}  {value}\n")).collect();
        format!("{}\n\n{facts}\n{}\n{}\n", self.title, self.table.to_text(), self.note)
    }

    /// A whole HTML document without references to anything outside.
    pub fn to_html(&self) -> String {
        let fact =
            |(name, value): &(&str, String)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value));
        let facts: String = self.facts.iter().map(fact).collect();
        let plots: String = self.plots.iter().map(|plot| format!("<p>{}</p>\n", plot.to_svg())).collect();
        let (title, note, table) = (escape(&self.title), with_code(&self.note), self.table.to_html());
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
             <style>\n{STYLE}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n<dl>\n{facts}</dl>\n<p>{note}</p>\n\
             {plots}{table}</body>\n</html>\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page() -> Page {
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
        };
        Page {
            title: "Speed < light".into(),
            facts: vec![("Processor", "X & Y".into()), ("Cores", "2".into())],
            note: "Lower `time` is <better>.".into(),
            table,
            plots: vec![plot(Scale::Linear), plot(Scale::Logarithmic)],
        }
    }

    #[test]
    fn numbers_have_four_digits() {
        let shown = [0.0, 1.0, 12.345_6, 123_456.7, 0.001_234_56, -2.5, f64::NAN, f64::INFINITY];
        let texts = shown.map(|x| Cell::Number(x).to_string());
        assert_eq!(texts, ["0.000", "1.000", "12.35", "123457", "0.001235", "-2.500", "-", "-"]);
        assert_eq!(Cell::Count(u64::MAX).to_string(), "18446744073709551615");
    }

    #[test]
    fn every_form_shows_the_same_numbers() {
        let page = page();
        for number in ["4000000", "1235", "7", "0.01235"] {
            assert!(page.table.to_csv().contains(number), "CSV lacks {number}");
            assert!(page.to_text().contains(&format!(" {number}")), "the text lacks {number}");
            assert!(page.to_html().contains(&format!("<td>{number}</td>")), "HTML lacks {number}");
        }
    }

    #[test]
    fn text_stands_in_columns() {
        let expected = "\
name         points  time (ms)
----------  -------  ---------
a, \"b\" <c>  4000000       1235
d                 7    0.01235
";
        assert_eq!(page().table.to_text(), expected);
    }

    #[test]
    fn csv_quotes_what_would_split() {
        let csv = page().table.to_csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines, ["name,points,time (ms)", "\"a, \"\"b\"\" <c>\",4000000,1235", "d,7,0.01235"]);
    }

    #[test]
    fn the_page_needs_nothing_beside_itself() {
        let html = page().to_html();
        let rest = html.replace("http://www.w3.org/2000/svg", "");
        for reference in ["http:", "https:", "src=", "href=", "url(", "@import", "<script"] {
            assert!(!rest.contains(reference), "{reference}");
        }
        assert_eq!(html.matches("<svg").count(), 2);
    }

    #[test]
    fn nothing_in_the_page_is_taken_for_markup() {
        let html = page().to_html();
        assert!(html.contains("Speed &lt; light") && html.contains("X &amp; Y"));
        assert!(html.contains("a, &quot;b&quot; &lt;c&gt;"));
        assert!(html.contains("Lower <code>time</code> is &lt;better&gt;."));
        assert!(html.contains("a&lt;b") && !html.contains("a<b") && !html.contains("&amp;lt;"));
    }

    #[test]
    fn words_stand_on_the_left_with_their_title() {
        let mut page = page();
        page.table.rows[0][1] = Cell::Text(String::new());
        let html = page.to_html();
        assert!(html.contains("<th class=\"words\">name</th><th>points</th>"));
        assert_eq!(html.matches("<td class=\"words\">").count(), 3);
    }

    #[test]
    fn axes_are_labelled_with_whole_numbers() {
        let svg = page().plots[1].to_svg();
        let labels: Vec<&str> = svg.lines().filter(|line| line.parse::<f64>().is_ok()).collect();
        assert_eq!(labels, ["1", "2", "5", "10", "20", "50", "100", "1", "2", "5", "10", "20", "50", "100"]);
        let ends = [(2.5, 9.0), (900.0, 2e6), (20_000.0, 20_000.1)].map(|(min, max)| ticks(min, max));
        assert_eq!(ends[0], [3.0, 4.0, 5.0, 7.0]);
        assert_eq!(ends[1], [1e3, 1e4, 1e5, 1e6]);
        assert_eq!(ends[2], [2e4]);
        assert_eq!([1000.0, 250.0, 0.5, 0.02].map(tick_label), ["1000", "250", "0.5", "0.02"]);
    }

    /// No name lies on the lines: the legend is to the right of everything else.
    #[test]
    fn every_line_has_its_name_beside_the_plot() {
        let svg = page().plots[0].to_svg();
        let x_of = |name: &str| {
            let text = svg.split("<text ").find(|text| text.contains(&format!("\n{name}\n"))).unwrap();
            text.split("x=\"").nth(1).unwrap().split('"').next().unwrap().parse::<u32>().unwrap()
        };
        let edge = PLOT_SIZE.0 - LEGEND_WIDTH;
        assert!(["a&lt;b", "c", "none"].iter().all(|name| x_of(name) > edge));
        assert!(["points", "ms"].iter().all(|name| x_of(name) < edge));
    }

    #[test]
    fn a_plot_without_points_is_left_out() {
        let empty = Plot { series: vec![("zero".into(), vec![(0.0, 0.0)])], ..page().plots[1].clone() };
        assert_eq!(empty.to_svg(), "");
        let linear = Plot { scale: Scale::Linear, ..empty };
        assert!(linear.to_svg().starts_with("<svg"));
    }
}
