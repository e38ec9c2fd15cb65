use super::html::{escape, with_code};
use super::{Plot, Table};

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
h1, p { overflow-wrap: anywhere }
p, dl { max-width: 68em }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 12px; margin: 1em 0 }
th, td { padding: .2em .5em; text-align: right; white-space: nowrap; border-bottom: 1px solid #ddd }
thead th { border-bottom: 2px solid #888; vertical-align: bottom; white-space: normal }
.words, dl { text-align: left }
dl { display: grid; grid-template-columns: max-content minmax(0, auto); gap: .1em 1.5em }
.code span { white-space: nowrap }
.code { white-space: normal; min-width: 22em; max-width: 40em }
dt { color: #666 }
dd { margin: 0; overflow-wrap: anywhere }
.scroll { overflow-x: auto }
svg { width: 100%; max-width: 1020px; min-width: 640px; height: auto }
figure { margin: 1em 0; break-inside: avoid }
@media print { body { max-width: none; margin: 0 } svg { min-width: 0 } .scroll { overflow: visible } tr { break-inside: avoid } }";

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
        let plots: String = self.plots.iter().map(Plot::to_figure).collect();
        let (note, table) = (with_code(&self.note), self.table.to_html());
        Document {
            title: self.title.clone(),
            facts: self.facts.clone(),
            style: "",
            body: format!("<p>{note}</p>\n{plots}{table}"),
            script: "",
        }
        .to_html()
    }
}

/// What every page stands in: a head with the style, the title and the facts.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// What was measured.
    pub title: String,
    /// Names and values: the machine, the settings.
    pub facts: Vec<(&'static str, String)>,
    /// CSS beyond that of every page.
    pub style: &'static str,
    /// HTML: what follows the facts.
    pub body: String,
    /// A script that runs when all of the body is there; empty for none.
    pub script: &'static str,
}

impl Document {
    /// The whole HTML document.
    pub fn to_html(&self) -> String {
        let facts = facts_to_html(&self.facts);
        let (title, style, body) = (escape(&self.title), self.style, &self.body);
        let script = match self.script {
            "" => String::new(),
            script => format!("<script>\n{script}\n</script>\n"),
        };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}\n{style}\n</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
             {facts}{body}{script}</body>\n</html>\n"
        )
    }
}

/// Names and values as a list.
pub fn facts_to_html(facts: &[(&str, String)]) -> String {
    let fact =
        |(name, value): &(&str, String)| format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value));
    format!("<dl>\n{}</dl>\n", facts.iter().map(fact).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::super::Cell;
    use super::super::testing::page;

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
}
