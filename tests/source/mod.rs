//! A look at Rust source that is just sharp enough for rules about its shape.

mod imports;

pub use imports::{Imports, circles, imports};

/// A source file whose comments and literals are blanked, so that braces match and words mean what they say.
pub struct Source {
    /// Its path below `src`.
    pub name: String,
    text: String,
}

/// Where a function is and how long.
pub struct Function {
    pub name: String,
    /// The line of its `fn`, from 1.
    pub line: usize,
    /// From the `fn` to the closing brace, both counted.
    pub lines: usize,
}

impl Source {
    pub fn new(name: &str, text: &str) -> Source {
        Source { name: name.to_owned(), text: blank(text) }
    }

    /// The module below the crate's root that the file belongs to.
    pub fn top_module(&self) -> &str {
        self.name.split('/').next().unwrap_or_default().trim_end_matches(".rs")
    }

    /// The files of the modules that it declares behind `#[cfg(test)]`.
    pub fn test_files(&self) -> Vec<String> {
        let folder = self.name.trim_end_matches("mod.rs").trim_end_matches(".rs").trim_end_matches('/');
        let behind = self.text.split("#[cfg(test)]").skip(1).map(str::trim_start);
        let declared = behind.filter_map(|text| text.strip_prefix("mod ")?.split_once(';'));
        declared
            .filter(|(name, _)| name.chars().all(is_word))
            .map(|(name, _)| format!("{folder}/{name}.rs"))
            .collect()
    }

    /// The same without what stands behind `#[cfg(test)]`.
    pub fn without_tests(&self) -> Source {
        let mut text = self.text.clone();
        while let Some(start) = text.find("#[cfg(test)]") {
            let end = item_end(&text, start);
            let blanked: String = text[start..end].chars().map(blank_char).collect();
            text.replace_range(start..end, &blanked);
        }
        Source { name: self.name.clone(), text }
    }

    /// The modules named right below the crate's root, with their lines.
    pub fn imports(&self) -> Vec<(usize, String)> {
        let from_root = self.words("crate").chain(self.words("caustica")).map(|(at, word)| at + word.len());
        let mut ends: Vec<usize> = from_root.chain(self.supers_to_root()).collect();
        ends.sort_unstable();
        let names = |end: usize| {
            let first = self.text[end..].strip_prefix("::").map(first_segments).unwrap_or_default();
            first.into_iter().map(move |name| (self.line_of(end), name))
        };
        ends.into_iter().flat_map(names).collect()
    }

    /// The ends of those chains of `super` that lead to the crate's root.
    fn supers_to_root(&self) -> Vec<usize> {
        let mut ends = Vec::new();
        for (start, _) in self.words("super").filter(|&(at, _)| !self.text[..at].ends_with("super::")) {
            let chain = self.text[start..].split("::").take_while(|&segment| segment == "super").count();
            if chain >= self.depth_at(start) {
                ends.push(start + chain * "super::".len() - "::".len());
            }
        }
        ends
    }

    /// How many modules below the crate's root the code at byte `at` is.
    fn depth_at(&self, at: usize) -> usize {
        let file = self.name.trim_end_matches(".rs").trim_end_matches("/mod").split('/').count();
        let opens_around = |&(start, _): &(usize, &str)| {
            let body = self.text[start..].find(['{', ';']).map(|offset| start + offset);
            body.is_some_and(|body| {
                self.text[body..].starts_with('{') && body < at && at < item_end(&self.text, start)
            })
        };
        file + self.words("mod").filter(opens_around).count()
    }

    pub fn functions(&self) -> Vec<Function> {
        let mut functions = Vec::new();
        for (start, _) in self.words("fn") {
            let name: String =
                self.text[start + 2..].trim_start().chars().take_while(|&c| is_word(c)).collect();
            let end = item_end(&self.text, start);
            if !name.is_empty() && self.text[..end].ends_with('}') {
                let line = self.line_of(start);
                functions.push(Function { name, line, lines: self.line_of(end) - line + 1 });
            }
        }
        functions
    }

    /// Where the `needles` stand, as complaints.
    pub fn lines_with(&self, needles: &[&str]) -> Vec<String> {
        let hits = needles.iter().flat_map(|needle| self.words(needle));
        hits.map(|(at, needle)| format!("src/{}:{}: {needle}", self.name, self.line_of(at))).collect()
    }

    fn line_of(&self, at: usize) -> usize {
        self.text[..at].matches('\n').count() + 1
    }

    /// The places of `word`, unless it is part of a longer one.
    fn words<'a>(&'a self, word: &'a str) -> impl Iterator<Item = (usize, &'a str)> {
        let joins =
            |near: Option<char>, edge: Option<char>| near.is_some_and(is_word) && edge.is_some_and(is_word);
        self.text.match_indices(word).filter(move |&(at, word)| {
            let (before, after) = (&self.text[..at], &self.text[at + word.len()..]);
            !joins(before.chars().next_back(), word.chars().next())
                && !joins(after.chars().next(), word.chars().next_back())
        })
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The first path segments behind a `::`: several of a braced group, one otherwise.
fn first_segments(path: &str) -> Vec<String> {
    let segment =
        |text: &str| text.trim().chars().take_while(|&c| is_word(c) || c == '*').collect::<String>();
    if !path.starts_with('{') {
        return vec![segment(path)];
    }
    let parts = comma_parts(&path[1..item_end(path, 0) - 1]);
    parts.into_iter().map(segment).filter(|name| !name.is_empty()).collect()
}

/// The parts between those commas of a list that stand in no braces.
fn comma_parts(list: &str) -> Vec<&str> {
    let mut depth = 0;
    let between = list.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    between.filter(|part| !part.trim().is_empty()).collect()
}

/// The byte behind the item that starts at `start`: behind its body's closing brace, or its semicolon.
fn item_end(text: &str, start: usize) -> usize {
    let (mut brackets, mut braces) = (0, 0);
    for (at, c) in text[start..].char_indices() {
        match c {
            '(' | '[' => brackets += 1,
            ')' | ']' => brackets -= 1,
            '{' => braces += 1,
            '}' => braces -= 1,
            _ => {}
        }
        if braces == 0 && (c == '}' || (c == ';' && brackets == 0)) {
            return start + at + 1;
        }
    }
    text.len()
}

fn blank_char(c: char) -> char {
    if c == '\n' { c } else { ' ' }
}

/// Replaces comments, strings and characters by spaces; lines stay where they are.
fn blank(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let after_word = out.chars().next_back().is_some_and(is_word);
        let length = literal_length(rest, after_word);
        if length == 0 {
            out.push(c);
            rest = &rest[c.len_utf8()..];
        } else {
            out.extend(rest[..length].chars().map(blank_char));
            rest = &rest[length..];
        }
    }
    out
}

/// The length in bytes of the comment or literal that `text` starts with; 0 for anything else.
fn literal_length(text: &str, after_word: bool) -> usize {
    let up_to =
        |end: &str, from: usize| text[from..].find(end).map_or(text.len(), |at| from + at + end.len());
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if text.starts_with("/*") {
        return up_to("*/", 2);
    }
    if text.starts_with('"') {
        return quoted_length(text, '"');
    }
    let hashes = text.strip_prefix('r').map_or(0, |raw| raw.len() - raw.trim_start_matches('#').len());
    if !after_word && text.starts_with('r') && text[1 + hashes..].starts_with('"') {
        return up_to(&format!("\"{}", "#".repeat(hashes)), hashes + 2);
    }
    // A quote that closes after one character or escape is a character; otherwise it starts a lifetime.
    let mut behind = text.strip_prefix('\'').unwrap_or_default().chars();
    match (behind.next(), behind.next()) {
        (Some('\\'), _) | (Some(_), Some('\'')) => quoted_length(text, '\''),
        _ => 0,
    }
}

/// The length of a literal between `quote`s, with backslash escapes.
fn quoted_length(text: &str, quote: char) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return at + 1,
            _ => {}
        }
    }
    text.len()
}
