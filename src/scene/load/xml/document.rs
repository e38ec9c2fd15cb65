//! From files to one tree: parameters are put in, included files are spliced in.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::super::super::SceneError;
use super::super::access::{Denial, Reader};
use super::super::fields::unknown_name;
use super::super::scene_text::read_scene_text;
use super::element::{Element, MOST_ELEMENTS, parse};

/// Files may include each other this deep.
const DEEPEST_INCLUDE: usize = 15;

/// The most bytes that parameters may make of all values together: one could double another, again and again.
const MOST_EXPANDED: usize = 16 << 20;

/// The scene of a file, with its parameters put in and its included files spliced in.
pub(super) fn read(path: &Path, reader: &Reader) -> Result<Element, SceneError> {
    let text = read_scene_text(path, reader)?;
    let mut assembly = Assembly::new(reader);
    let root = parse(path, &text)?;
    if root.tag != "scene" {
        return Err(root.error(format!("the root is <{}>; allowed: <scene>", root.tag)));
    }
    check_version(&root)?;
    let mut open = vec![path.to_owned()];
    let scene = assembly.expanded(root, &mut open)?;
    assembly.check_definitions(&scene)?;
    Ok(scene)
}

fn check_version(root: &Element) -> Result<(), SceneError> {
    root.only(&["version"])?;
    let Some(version) = root.attribute("version") else { return Ok(()) };
    let major = version.split('.').next().and_then(|major| major.trim().parse::<u32>().ok());
    if major.is_some_and(|major| (2..=3).contains(&major)) {
        return Ok(());
    }
    Err(root.error(format!("scene of version `{version}`, whose words differ; allowed: 2.0.0 up to 3.x.x")))
}

struct Assembly<'a> {
    reader: &'a Reader<'a>,
    /// Those of the command line and those of `default` so far.
    parameters: BTreeMap<String, String>,
    /// All names that a `default` gave or a `$` used.
    known: BTreeSet<String>,
    elements: usize,
    expanded: usize,
}

impl<'a> Assembly<'a> {
    fn new(reader: &'a Reader<'a>) -> Assembly<'a> {
        let parameters = reader.definitions().clone();
        Assembly { reader, parameters, known: BTreeSet::new(), elements: 0, expanded: 0 }
    }

    /// A definition that nothing asks for is a slip of the pen.
    fn check_definitions(&self, scene: &Element) -> Result<(), SceneError> {
        let known: Vec<&str> = self.known.iter().map(String::as_str).collect();
        match self.reader.definitions().keys().find(|name| !known.contains(&name.as_str())) {
            None => Ok(()),
            Some(name) if known.is_empty() => {
                Err(scene.error(format!("-D {name}: the scene has no parameters; allowed: no -D")))
            }
            Some(name) => {
                Err(scene.error(format!("-D {name}: unknown parameter {}", unknown_name(name, &known))))
            }
        }
    }

    fn expanded(&mut self, mut element: Element, open: &mut Vec<PathBuf>) -> Result<Element, SceneError> {
        self.elements += 1;
        if self.elements > MOST_ELEMENTS {
            return Err(element.error(format!("more than {MOST_ELEMENTS} elements; allowed: up to that")));
        }
        element.number = self.elements;
        if !element.is_own() {
            self.put_in(&mut element)?;
        }
        let mut children = Vec::new();
        for child in std::mem::take(&mut element.children) {
            match child.tag.as_str() {
                "default" => self.define(child)?,
                "include" => children.extend(self.included(child, open)?),
                _ => children.push(self.expanded(child, open)?),
            }
        }
        Ok(Element { children, ..element })
    }

    fn define(&mut self, mut element: Element) -> Result<(), SceneError> {
        self.put_in(&mut element)?;
        element.only(&["name", "value"])?;
        let name = element.required("name", "the parameter's name")?;
        if name.is_empty() || name.contains('$') {
            return Err(element.error(format!("parameter `{name}`; allowed: a name without `$`")));
        }
        let value = element.required("value", "what `$name` stands for")?;
        self.known.insert(name.to_owned());
        self.parameters.entry(name.to_owned()).or_insert_with(|| value.to_owned());
        Ok(())
    }

    /// Puts what `$name` stands for into all attributes; of several names that fit, the longest counts.
    fn put_in(&mut self, element: &mut Element) -> Result<(), SceneError> {
        let place = element.place.clone();
        for (_, value) in element.attributes.iter_mut().filter(|(_, value)| value.contains('$')) {
            let mut whole = String::new();
            let mut rest = value.as_str();
            while let Some(at) = rest.find('$') {
                let (before, after) = (&rest[..at], &rest[at + 1..]);
                let fits = |(name, _): &(&String, &String)| after.starts_with(name.as_str());
                let longest = self.parameters.iter().filter(fits).max_by_key(|(name, _)| name.len());
                let Some((name, put)) = longest else {
                    return Err(place.error(undefined(after, &self.parameters)));
                };
                whole.extend([before, put]);
                rest = &after[name.len()..];
                self.known.insert(name.clone());
                if self.expanded + whole.len() > MOST_EXPANDED {
                    return Err(
                        place.error(format!("parameters make more than {MOST_EXPANDED} bytes of values"))
                    );
                }
            }
            whole.push_str(rest);
            self.expanded += whole.len();
            *value = whole;
        }
        Ok(())
    }

    /// The children of an included `<scene>`, or the included root itself.
    fn included(
        &mut self,
        mut element: Element,
        open: &mut Vec<PathBuf>,
    ) -> Result<Vec<Element>, SceneError> {
        self.put_in(&mut element)?;
        element.only(&["filename"])?;
        let name = element.required("filename", "the path of an XML file")?;
        let path = self.reader.beside_scene(name);
        if open.contains(&path) {
            return Err(element.error(format!("`{name}` includes itself; allowed: files that do not")));
        }
        if open.len() > DEEPEST_INCLUDE {
            return Err(element.error(format!("files include each other deeper than {DEEPEST_INCLUDE}")));
        }
        let denied = |denial: Denial| element.error(format!("include `{name}` {}", denial.reason()));
        let bytes = self.reader.read(&path, "an XML file").map_err(denied)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| element.error(format!("include `{name}` is not UTF-8; an XML file is expected")))?;
        let root = parse(&path, text.strip_prefix('\u{feff}').unwrap_or(&text))?;
        open.push(path);
        let is_scene = root.tag == "scene";
        if is_scene {
            check_version(&root)?;
        }
        let mut root = self.expanded(root, open)?;
        root.brought_in_by(element.place.main_line);
        open.pop();
        Ok(if is_scene { root.children } else { vec![root] })
    }
}

fn undefined(after: &str, parameters: &BTreeMap<String, String>) -> String {
    let end = after.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(after.len());
    let known: Vec<&str> = parameters.keys().map(String::as_str).collect();
    if known.is_empty() {
        return format!(
            "undefined parameter `${}`; allowed: those of <default> above it, or -D",
            &after[..end]
        );
    }
    format!("undefined parameter {}", unknown_name(&after[..end], &known))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{fails, good, read_defining};

    fn point(attributes: &str) -> String {
        format!("<emitter type=\"point\"><point name=\"position\" {attributes}/></emitter>")
    }

    #[test]
    fn parameters_are_put_in_and_the_command_line_counts_first() {
        let body = format!(
            "<default name=\"a\" value=\"1\"/><default name=\"ab\" value=\"2, $a\"/>{}",
            point("value=\"3,$ab\"")
        );
        assert_eq!(good(&body, &[]).point_lights[0].position.to_array(), [3.0, 2.0, 1.0]);
        let scene = read_defining(&body, &[], &[("a", "7")]).unwrap();
        assert_eq!(scene.point_lights[0].position.to_array(), [3.0, 2.0, 7.0]);
    }

    #[test]
    fn unknown_parameters_are_refused() {
        fails(&point("x=\"$a\""), 7, "undefined parameter `$a`; allowed: those of <default>");
        fails(
            &format!("<default name=\"size\" value=\"1\"/>{}", point("x=\"$siez\"")),
            7,
            "undefined parameter `siez`; did you mean `size`?",
        );
        let body = "<default name=\"size\" value=\"1\"/>";
        let told = |name| read_defining(body, &[], &[(name, "7")]).unwrap_err();
        assert!(
            told("sice").contains("-D sice: unknown parameter `sice`; did you mean `size`?"),
            "{}",
            told("sice")
        );
        assert!(read_defining("", &[], &[("a", "1")]).unwrap_err().contains("the scene has no parameters"));
    }

    #[test]
    fn values_cannot_grow_without_end() {
        let mut body = format!("<default name=\"a0\" value=\"{}\"/>", "x".repeat(64));
        for k in 1..40 {
            body += &format!(
                "<default name=\"a{k}_\" value=\"$a0$a0\"/><default name=\"b{k}\" value=\"{}\"/>",
                "$a0".repeat(8000)
            );
        }
        fails(&body, 7, "parameters make more than 16777216 bytes");
    }

    #[test]
    fn files_include_each_other_but_not_themselves() {
        let other = "<scene version=\"3.0.0\"><default name=\"x\" value=\"4\"/><include filename=\"third.xml\"/></scene>";
        let third = point("x=\"$x\"");
        let scene = good("<include filename=\"other.xml\"/>", &[("other.xml", other), ("third.xml", &third)]);
        assert_eq!(scene.point_lights[0].position.x, 4.0);
        let again = "<scene version=\"3.0.0\">\n<include filename=\"other.xml\"/></scene>";
        let error =
            read_defining("<include filename=\"other.xml\"/>", &[("other.xml", again)], &[]).unwrap_err();
        assert!(error.starts_with("other.xml:2: `other.xml` includes itself"), "{error}");
        fails("<include filename=\"no.xml\"/>", 7, "include `no.xml` cannot be read");
    }

    #[test]
    fn scenes_of_other_versions_are_refused() {
        for (text, words) in [
            ("<scene version=\"0.6.0\"/>", "s.xml:1: scene of version `0.6.0`"),
            ("<bsdf/>", "s.xml:1: the root is <bsdf>; allowed: <scene>"),
        ] {
            let error = super::super::testing::read_text(text, &[], &[]).unwrap_err();
            assert!(error.starts_with(words), "{error}");
        }
    }
}
