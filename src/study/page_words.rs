//! How the page of a study writes: its marks, numbers and sections.

use crate::report::{Cell, escape, with_code};

/// A name and points.
pub(super) type Line = (String, Vec<(f64, f64)>);

/// Stars emphasise, backticks mark code.
pub(super) fn text(source: &str) -> String {
    let part =
        |(index, part): (usize, &str)| if index % 2 == 1 { format!("<em>{part}</em>") } else { part.into() };
    with_code(source).split('*').enumerate().map(part).collect()
}

pub(super) fn section(title: &str, note: &str, content: &str) -> String {
    format!("<h2>{}</h2>\n<p>{}</p>\n{content}", escape(title), text(note))
}

/// So many digits as the number deserves.
pub(super) fn digits(x: f64, count: i32) -> String {
    if x <= 0.0 || !x.is_finite() {
        return Cell::Number(x).to_string();
    }
    let exponent = x.log10().floor() as i32 - count + 1;
    let unit = 10f64.powi(exponent);
    format!("{:.*}", -exponent.min(0) as usize, (x / unit).round() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_they_deserve() {
        let texts = [0.01234, 0.99, 1.26, 12.6, 126.0, 98765.0].map(|x| digits(x, 2));
        assert_eq!(texts, ["0.012", "0.99", "1.3", "13", "130", "99000"]);
        let texts = [0.01234, 1.0, 12.6, 126.4, 0.0, f64::NAN].map(|x| digits(x, 3));
        assert_eq!(texts, ["0.0123", "1.00", "12.6", "126", "0.000", "-"]);
    }

    #[test]
    fn emphasis_and_code_are_marked() {
        assert_eq!(text("*a* `b` <c>"), "<em>a</em> <code>b</code> &lt;c&gt;");
    }
}
