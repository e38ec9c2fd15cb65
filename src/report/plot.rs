use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::element::DashedPathElement;
use plotters::prelude::*;

use super::html::escape;
use super::table::four_digits;

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
    /// Names and points of dashed lines that nobody measured: what theory says.
    pub guides: Vec<(String, Vec<(f64, f64)>)>,
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

/// Guides are grey, and told apart by their dashes: length and space in pixels.
const GUIDE: RGBColor = RGBColor(110, 110, 110);
const DASHES: [(u32, u32); 3] = [(7, 4), (2, 3), (14, 4)];

impl Plot {
    /// [`Plot::to_svg`] in a figure that scrolls where it does not fit.
    pub fn to_figure(&self) -> String {
        format!("<figure class=\"scroll\">{}</figure>\n", self.to_svg())
    }

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
        let lines = self.series.iter().chain(&self.guides);
        let values: Vec<f64> =
            lines.flat_map(|(_, points)| self.shown(points)).map(|p| coordinate(&p)).collect();
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
        for ((_, points), dashes) in self.guides.iter().zip(DASHES.into_iter().cycle()) {
            chart.draw_series([dashed(self.shown(points), dashes)])?;
        }
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
        let below = 60 + 22 * self.series.len() as i32;
        let dashes = DASHES.into_iter().cycle();
        for (((name, _), y), dashes) in self.guides.iter().zip((below..).step_by(22)).zip(dashes) {
            area.draw(&dashed(vec![(0, y), (20, y)], dashes))?;
            area.draw(&Text::new(name.clone(), (28, y - 4), ("sans-serif", 13)))?;
        }
        Ok(())
    }
}

/// A line of dashes so long and so far apart, in pixels.
fn dashed<C: Clone>(
    points: Vec<C>,
    (length, space): (u32, u32),
) -> DashedPathElement<std::vec::IntoIter<C>, u32> {
    DashedPathElement::new(points, length, space, GUIDE.stroke_width(1))
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

#[cfg(test)]
mod tests {
    use super::super::testing::page;
    use super::*;

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
    fn guides_are_dashed_and_named() {
        let (with, without) = (page().plots[1].clone(), Plot { guides: vec![], ..page().plots[1].clone() });
        let count = |plot: &Plot, what: &str| plot.to_svg().matches(what).count();
        assert!(count(&with, "<polyline") > count(&without, "<polyline") + 20, "many dashes");
        assert_eq!((count(&with, "\ntheory\n"), count(&without, "\ntheory\n")), (1, 0));
        assert_eq!(count(&with, "<circle"), count(&without, "<circle"), "nothing was measured on a guide");
    }

    #[test]
    fn a_plot_without_points_is_left_out() {
        let series = vec![("zero".into(), vec![(0.0, 0.0)])];
        let empty = Plot { series, guides: vec![], ..page().plots[1].clone() };
        assert_eq!(empty.to_svg(), "");
        let linear = Plot { scale: Scale::Linear, ..empty };
        assert!(linear.to_svg().starts_with("<svg"));
    }
}
