use std::fmt;

use super::html::escape;

/// An entry of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A command line; in a page it may run over several lines.
    Code(String),
    /// An exact count.
    Count(u64),
    /// A measured number, shown with four digits; a dash where it is not finite.
    Number(f64),
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Cell::Text(text) | Cell::Code(text) => f.pad(text),
            Cell::Count(count) => f.pad(&count.to_string()),
            Cell::Number(number) => f.pad(&four_digits(*number)),
        }
    }
}

pub(super) fn four_digits(x: f64) -> String {
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

    /// As an HTML element.
    pub fn to_html(&self) -> String {
        let title = |(column, title): (usize, &&str)| {
            let class = if self.holds_words(column) { " class=\"words\"" } else { "" };
            format!("<th{class}>{}</th>", escape(title))
        };
        let titles: String = self.columns.iter().enumerate().map(title).collect();
        let cell = |cell: &Cell| match cell {
            Cell::Text(text) => format!("<td class=\"words\">{}</td>", escape(text)),
            Cell::Code(text) => format!("<td class=\"words code\"><code>{}</code></td>", command(text)),
            _ => format!("<td>{cell}</td>"),
        };
        let row = |row: &Vec<Cell>| format!("<tr>{}</tr>\n", row.iter().map(cell).collect::<String>());
        let rows: String = self.rows.iter().map(row).collect();
        format!(
            "<div class=\"scroll\"><table>\n<thead><tr>{titles}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
        )
    }

    fn width(&self, column: usize) -> usize {
        let cells = self.rows.iter().map(|row| row[column].to_string().chars().count());
        cells.chain([self.columns[column].chars().count()]).max().unwrap_or(0)
    }

    fn padded(&self, column: usize, cell: &Cell, width: usize) -> String {
        if self.holds_words(column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    }

    fn holds_words(&self, column: usize) -> bool {
        self.rows
            .iter()
            .any(|row| matches!(&row[column], Cell::Text(text) | Cell::Code(text) if !text.is_empty()))
    }
}

/// Browsers break lines behind the hyphens of options unless they are told not to.
fn command(line: &str) -> String {
    let word = |word: &str| match word.starts_with("--") {
        true => format!("<span>{}</span>", escape(word)),
        false => escape(word),
    };
    line.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

fn csv_field(cell: &Cell) -> String {
    let text = cell.to_string();
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

#[cfg(test)]
mod tests {
    use super::super::testing::page;
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let shown = [0.0, 1.0, 12.345_6, 123_456.7, 0.001_234_56, -2.5, f64::NAN, f64::INFINITY];
        let texts = shown.map(|x| Cell::Number(x).to_string());
        assert_eq!(texts, ["0.000", "1.000", "12.35", "123457", "0.001235", "-2.500", "-", "-"]);
        assert_eq!(Cell::Count(u64::MAX).to_string(), "18446744073709551615");
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
    fn commands_break_between_words_alone() {
        let table = Table { columns: vec!["how"], rows: vec![vec![Cell::Code("a <b> --c-d 1".into())]] };
        let cell = "<td class=\"words code\"><code>a &lt;b&gt; <span>--c-d</span> 1</code></td>";
        assert!(table.to_html().contains(cell), "{}", table.to_html());
        assert!(table.to_text().contains("a <b> --c-d 1\n") && table.to_csv().contains("\na <b> --c-d 1\n"));
    }

    #[test]
    fn csv_quotes_what_would_split() {
        let csv = page().table.to_csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines, ["name,points,time (ms)", "\"a, \"\"b\"\" <c>\",4000000,1235", "d,7,0.01235"]);
    }
}
