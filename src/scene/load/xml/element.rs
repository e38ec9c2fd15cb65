//! XML as a tree of elements that know their line: what `roxmltree` reads, without its ties to the text.

use std::path::Path;
use std::rc::Rc;

use roxmltree::{Document, Node, NodeType, ParsingOptions};

use super::super::super::SceneError;

/// More elements of one file, and more of all files of a scene, are refused.
pub(super) const MOST_ELEMENTS: usize = 1 << 20;

/// Elements may be nested this deep; scenes need a handful of levels.
const DEEPEST: usize = 64;

/// The processing instruction by which this program notes what Mitsuba has no word for; Mitsuba skips it.
const OWN_TARGET: &str = "caustica";
/// No element can be called that.
const OWN_TAG: &str = "?caustica";

/// The line of a file.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub file: Rc<Path>,
    pub line: usize,
    /// The line of the scene file itself that brings it in.
    pub main_line: usize,
}

impl Place {
    pub fn error(&self, reason: impl Into<String>) -> SceneError {
        SceneError::Line { path: self.file.to_path_buf(), line: self.line, reason: reason.into() }
    }

    /// The message of a warning: it starts as an error would.
    pub fn told(&self, text: &str) -> String {
        self.error(text).to_string()
    }
}

/// An element, or a processing instruction of this program's own.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub tag: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    pub place: Place,
    /// From 1, each element of a scene its own.
    pub number: usize,
}

impl Element {
    /// Says that line `main_line` of the scene file brings it in.
    pub fn brought_in_by(&mut self, main_line: usize) {
        self.place.main_line = main_line;
        self.children.iter_mut().for_each(|child| child.brought_in_by(main_line));
    }

    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub fn error(&self, reason: impl Into<String>) -> SceneError {
        self.place.error(reason)
    }

    /// The value of an attribute, or an error that says what may stand there.
    pub fn required(&self, name: &str, allowed: &str) -> Result<&str, SceneError> {
        let missing = || self.error(format!("<{}> has no attribute `{name}`; allowed: {allowed}", self.tag));
        self.attribute(name).ok_or_else(missing)
    }

    /// Refuses attributes that are not `known`.
    pub fn only(&self, known: &[&str]) -> Result<(), SceneError> {
        match self.attributes.iter().find(|(name, _)| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some((name, _)) => Err(self.error(format!(
                "<{}>: unknown attribute `{name}`; allowed: `{}`",
                self.tag,
                known.join("`, `")
            ))),
        }
    }

    /// Whether it is this program's own note.
    pub fn is_own(&self) -> bool {
        self.tag == OWN_TAG
    }

    /// What people call it: its tag, type and id.
    pub fn label(&self) -> String {
        let named = |key| self.attribute(key).map_or(String::new(), |value| format!(" `{value}`"));
        match self.attribute("id") {
            Some(_) => format!("{}{} with id{}", self.tag, named("type"), named("id")),
            None => format!("{}{}", self.tag, named("type")),
        }
    }
}

/// The root element of a document.
pub(super) fn parse(path: &Path, text: &str) -> Result<Element, SceneError> {
    let options =
        ParsingOptions { allow_dtd: false, nodes_limit: 4 * MOST_ELEMENTS as u32, ..Default::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| SceneError::Line {
        path: path.to_owned(),
        line: e.pos().row as usize,
        reason: format!("is no well-formed XML: {e}"),
    })?;
    let lines =
        Lines { file: Rc::from(path), newlines: text.match_indices('\n').map(|(at, _)| at).collect() };
    lines.element(document.root_element(), 0)
}

struct Lines {
    file: Rc<Path>,
    newlines: Vec<usize>,
}

impl Lines {
    fn place(&self, node: Node) -> Place {
        let start = node.range().start;
        let line = self.newlines.partition_point(|&at| at < start) + 1;
        Place { file: self.file.clone(), line, main_line: line }
    }

    fn element(&self, node: Node, depth: usize) -> Result<Element, SceneError> {
        let place = self.place(node);
        if depth == DEEPEST {
            return Err(
                place.error(format!("elements are nested deeper than {DEEPEST}; allowed: as deep as that"))
            );
        }
        let attributes = node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect();
        let children = node.children().filter_map(|child| self.child(child, depth + 1).transpose());
        let children = children.collect::<Result<Vec<Element>, SceneError>>()?;
        Ok(Element { tag: node.tag_name().name().to_owned(), attributes, children, place, number: 0 })
    }

    fn child(&self, node: Node, depth: usize) -> Result<Option<Element>, SceneError> {
        match node.node_type() {
            NodeType::Element => self.element(node, depth).map(Some),
            NodeType::PI => self.own_note(node),
            NodeType::Text if !node.text().unwrap_or_default().trim().is_empty() => {
                Err(self.place(node).error("text between elements; allowed: elements and comments"))
            }
            NodeType::Text | NodeType::Comment | NodeType::Root => Ok(None),
        }
    }

    /// `<?caustica name="value"?>`: its value is read as attributes are.
    fn own_note(&self, node: Node) -> Result<Option<Element>, SceneError> {
        let Some(note) = node.pi().filter(|note| note.target == OWN_TARGET) else { return Ok(None) };
        let place = self.place(node);
        let text = format!("<{OWN_TARGET} {}/>", note.value.unwrap_or_default());
        let wrong = || place.error(format!("<?{OWN_TARGET}?> holds no attributes; allowed: name=\"value\""));
        let document = Document::parse(&text).map_err(|_| wrong())?;
        let root = document.root_element();
        if root.has_children() {
            return Err(wrong());
        }
        let attributes = root.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect();
        Ok(Some(Element { tag: OWN_TAG.to_owned(), attributes, children: Vec::new(), place, number: 0 }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Element, String> {
        parse(Path::new("s.xml"), text).map_err(|e| e.to_string())
    }

    #[test]
    fn elements_know_their_lines() {
        let root = read("<?xml version='1.0'?>\n<a b='1'>\n<!-- c -->\n <d e='&lt;2'/>\n</a>").unwrap();
        assert_eq!((root.tag.as_str(), root.attribute("b"), root.place.line), ("a", Some("1"), 2));
        let child = &root.children[0];
        assert_eq!((child.tag.as_str(), child.attribute("e"), child.place.line), ("d", Some("<2"), 4));
    }

    #[test]
    fn own_notes_are_elements_and_those_of_others_are_not() {
        let root = read("<a>\n<?caustica passes=\"3\" x='y'?><?php 1?></a>").unwrap();
        assert_eq!(root.children.len(), 1);
        assert!(root.children[0].is_own());
        assert_eq!(root.children[0].attribute("passes"), Some("3"));
        assert!(read("<a>\n<?caustica 3?></a>").unwrap_err().starts_with("s.xml:2: <?caustica?>"));
        assert!(read("<a><?caustica /><b?></a>").unwrap_err().contains("holds no attributes"));
    }

    #[test]
    fn hostile_documents_are_refused() {
        let deep = format!("{}{}", "<a>".repeat(100_000), "</a>".repeat(100_000));
        assert!(read(&deep).unwrap_err().contains("nested deeper than 64"), "{:?}", read(&deep).err());
        let bomb = "<!DOCTYPE a [<!ENTITY x 'xxxxxxxx'>]><a b='&x;'/>";
        assert!(read(bomb).unwrap_err().contains("s.xml:1: is no well-formed XML"));
        assert!(read("<a>\nwords</a>").unwrap_err().contains("text between elements"));
        assert!(read("<a><b></a>").unwrap_err().contains("s.xml:1: is no well-formed XML"));
    }
}
