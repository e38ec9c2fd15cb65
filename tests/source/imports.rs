//! Which files take names from which: every path in the source, followed through re-exports to the file that defines what it ends
//! at. Naming a module takes nothing from its file, and neither does declaring it.

use std::collections::{BTreeMap, BTreeSet};

use super::{Source, comma_parts, is_word};

/// The names that each file takes from each other one.
pub type Imports = BTreeMap<String, BTreeMap<String, BTreeSet<String>>>;

/// The files of one crate, which are modules by their paths: `""` is the root, `scene::load` a module of a module.
struct Modules(BTreeMap<String, Module>);

struct Module {
    file: String,
    uses: Vec<Use>,
    paths: Vec<Path>,
}

type Path = Vec<String>;

/// One name of a `use`.
struct Use {
    name: String,
    path: Path,
    /// Whether it has a visibility, so that it may be there for others alone.
    is_export: bool,
}

/// What the files of a library import. Inline modules count as the file they are in, globs as a name of the module they open.
pub fn imports(sources: &[Source]) -> Imports {
    let modules = Modules(sources.iter().map(module).collect());
    let of_file = |(name, module): (&String, &Module)| (module.file.clone(), modules.taken_by(name, module));
    modules.0.iter().map(of_file).collect()
}

fn module(source: &Source) -> (String, Module) {
    let name = source.name.trim_end_matches(".rs");
    let name = if name == "lib" { "" } else { name.trim_end_matches("/mod") };
    let (uses, rest) = split_uses(&source.text);
    (name.replace('/', "::"), Module { file: source.name.clone(), uses, paths: paths(&rest) })
}

impl Modules {
    /// The names that the file of a module takes from others, by their files. What it exports counts where it uses that itself.
    fn taken_by(&self, name: &str, module: &Module) -> BTreeMap<String, BTreeSet<String>> {
        let own_uses = module.uses.iter().filter(|used| !used.is_export).map(|used| &used.path);
        let mut taken: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (from, item) in own_uses.chain(&module.paths).filter_map(|path| self.item(name, path)) {
            if from != module.file {
                taken.entry(from.to_owned()).or_default().insert(item);
            }
        }
        taken
    }

    /// The file that defines what a path in a module means, and that item's name; nothing for modules and for other crates.
    fn item(&self, module: &str, path: &[String]) -> Option<(&str, String)> {
        let known = |first: &String| {
            ["crate", "self", "super"].contains(&first.as_str())
                || self.child(module, first).is_some()
                || self.used(module, first).is_some_and(|used| used.path[0] != *first)
        };
        let (first, rest) = path.split_first().filter(|(first, _)| known(first))?;
        if first == "crate" { self.item_below("", rest) } else { self.item_below(module, path) }
    }

    fn item_below(&self, module: &str, path: &[String]) -> Option<(&str, String)> {
        let (first, rest) = path.split_first()?;
        if first == "self" {
            return self.item_below(module, rest);
        }
        if first == "super" {
            return self.item_below(module.rsplit_once("::").map_or("", |(parent, _)| parent), rest);
        }
        let used = self.used(module, first);
        // A module and an item may share a name: more of a path leads through the module, an export at its end is the item.
        match self.child(module, first).filter(|_| !rest.is_empty() || used.is_none()) {
            Some(child) => self.item_below(&child, rest),
            None => match used {
                Some(used) => self.item(module, &[&used.path, rest].concat()),
                None => Some((&self.0[module].file, first.clone())),
            },
        }
    }

    fn child(&self, module: &str, name: &str) -> Option<String> {
        let child = if module.is_empty() { name.to_owned() } else { format!("{module}::{name}") };
        self.0.contains_key(&child).then_some(child)
    }

    fn used(&self, module: &str, name: &str) -> Option<&Use> {
        self.0[module].uses.iter().find(|used| used.name == name)
    }
}

/// The names of all `use`s, and the text without them.
fn split_uses(text: &str) -> (Vec<Use>, String) {
    let (mut uses, mut rest) = (Vec::new(), String::new());
    let mut behind = text;
    while let Some((before, tree, after)) = next_use(behind) {
        let is_export = before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
        uses.extend(leaves(&[], tree).into_iter().map(|(name, path)| Use { name, path, is_export }));
        rest.push_str(before);
        behind = after;
    }
    (uses, rest + behind)
}

/// What stands before the next `use`, its tree of paths, and what stands behind it.
fn next_use(text: &str) -> Option<(&str, &str, &str)> {
    let at = text.match_indices("use ").map(|(at, _)| at).find(|&at| !text[..at].ends_with(is_word))?;
    let (tree, after) = text[at + "use ".len()..].split_once(';')?;
    Some((&text[..at], tree, after))
}

/// The names that a tree of paths brings, each with its whole path.
fn leaves(prefix: &[String], tree: &str) -> Vec<(String, Path)> {
    if let Some((head, group)) = tree.split_once('{') {
        let prefix = [prefix, &segments(head)].concat();
        let group = group.trim_end().trim_end_matches('}');
        return comma_parts(group).into_iter().flat_map(|part| leaves(&prefix, part)).collect();
    }
    let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
    let mut path = [prefix, &segments(path)].concat();
    if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
        path.pop();
    }
    let name =
        if alias.is_empty() { path.last().cloned().unwrap_or_default() } else { alias.trim().to_owned() };
    vec![(name, path)]
}

fn segments(path: &str) -> Path {
    path.split("::").map(str::trim).filter(|segment| !segment.is_empty()).map(str::to_owned).collect()
}

/// All paths in code, names alone among them; fields, methods, lifetimes and declared modules are none.
fn paths(code: &str) -> Vec<Path> {
    let mut paths = Vec::new();
    let mut at = 0;
    while let Some(start) = code[at..].find(is_word).map(|offset| at + offset) {
        let of_path = |text: &str| text.find(|c| !is_word(c)).unwrap_or(text.len());
        at = start + of_path(&code[start..]);
        while let Some(next) = code[at..].strip_prefix("::").filter(|next| next.starts_with(is_word)) {
            at += "::".len() + of_path(next);
        }
        let before = &code[..start];
        let is_member = before.ends_with('.') && !before.ends_with("..");
        let is_declared = before.ends_with("mod ");
        if !is_member && !is_declared && !before.ends_with("::") && !before.ends_with('\'') {
            paths.push(segments(&code[start..at]));
        }
    }
    paths
}

/// The circles among imports, each as a list of what ties its files to each other.
pub fn circles(imports: &Imports) -> Vec<String> {
    let reached: BTreeMap<&String, BTreeSet<&String>> =
        imports.keys().map(|file| (file, reached_from(imports, file))).collect();
    let circle_of = |file: &String| -> Vec<&String> {
        reached[file].iter().copied().filter(|other| reached[other].contains(file)).collect()
    };
    let mut circles: Vec<Vec<&String>> = reached.keys().map(|file| circle_of(file)).collect();
    circles.retain(|circle| !circle.is_empty());
    circles.sort();
    circles.dedup();
    circles.iter().map(|circle| ties(imports, circle)).collect()
}

/// The files that imports lead to; the file itself among them if they come back.
fn reached_from<'a>(imports: &'a Imports, file: &str) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&String> = imports[file].keys().collect();
    while let Some(next) = open.pop() {
        if reached.insert(next) {
            open.extend(imports[next].keys());
        }
    }
    reached
}

fn ties(imports: &Imports, circle: &[&String]) -> String {
    let mut told = format!("{} files import each other in a circle:", circle.len());
    for &file in circle {
        for (from, names) in imports[file].iter().filter(|(from, _)| circle.contains(from)) {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            told += &format!("\n  src/{file} takes from src/{from}: {}", names.join(", "));
        }
    }
    told
}
