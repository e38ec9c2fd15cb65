//! The shape of the source: who imports whom, how long functions are, where `unsafe` stands.

#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

mod source;

use source::{Function, Imports, Source, circles, imports};

/// Lines that a function may have: at the median, at the 90th percentile, and at all.
const MEDIAN_LINES: usize = 10;
const NINETIETH_LINES: usize = 30;
const MOST_LINES: usize = 60;

/// Files whose importers they import, and why that is left so.
const CIRCLES_LEFT: [(&str, &str); 1] =
    [("ppm/mod.rs", "a render is made of its phases, and these go on in its methods")];

/// One row of the table in `ARCHITECTURE.md`.
struct Row {
    floor: u32,
    module: String,
    imports: Vec<String>,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn table_of_the_project() -> Vec<Row> {
    let rows = table(&fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap());
    assert!(rows.len() > 10, "the table in ARCHITECTURE.md is not read: {} rows", rows.len());
    rows
}

/// The table below the heading `Who may import whom`.
fn table(document: &str) -> Vec<Row> {
    let section = document.split("\n## ").find(|section| section.starts_with("Who may import whom"));
    let lines = section.expect("ARCHITECTURE.md has a section `Who may import whom`").lines();
    let mut rows: Vec<Row> = Vec::new();
    for line in lines.filter(|line| line.starts_with('|')) {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let Ok(floor) = cells[0].parse() else { continue };
        let imports = match cells[2] {
            "every module above" => rows.iter().map(|row| row.module.clone()).collect(),
            cell => in_backticks(cell),
        };
        rows.push(Row { floor, module: in_backticks(cells[1]).concat(), imports });
    }
    rows
}

fn in_backticks(cell: &str) -> Vec<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// What is wrong with the table itself: imports must stand above, on a floor that is no higher. Where that holds, every import
/// leads up the table, so that no chain of them comes back: there is no cycle between modules.
fn table_faults(rows: &[Row]) -> Vec<String> {
    let mut faults = Vec::new();
    let mut floors: BTreeMap<&str, u32> = BTreeMap::new();
    for row in rows {
        for import in &row.imports {
            if floors.get(import.as_str()).is_none_or(|&floor| floor > row.floor) {
                faults.push(format!("{} may import {import}, which is not below it", row.module));
            }
        }
        floors.insert(&row.module, row.floor);
    }
    faults
}

/// All Rust files below `dir`, in the order of their names.
fn rust_files(dir: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(dir).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let files =
        entries.into_iter().flat_map(|path| if path.is_dir() { rust_files(&path) } else { vec![path] });
    files.filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

fn sources() -> Vec<Source> {
    let src = root().join("src");
    let name = |path: &Path| path.strip_prefix(&src).unwrap().to_str().unwrap().to_owned();
    rust_files(&src).iter().map(|path| Source::new(&name(path), &fs::read_to_string(path).unwrap())).collect()
}

fn sources_without_tests() -> Vec<Source> {
    let sources = sources();
    let test_files: Vec<String> = sources.iter().flat_map(Source::test_files).collect();
    let of_program = sources.iter().filter(|source| !test_files.contains(&source.name));
    of_program.map(Source::without_tests).collect()
}

fn import_faults(rows: &[Row], source: &Source) -> Vec<String> {
    let module = source.top_module();
    let Some(row) = rows.iter().find(|row| row.module == module) else {
        return vec![format!("src/{}: the table in ARCHITECTURE.md lacks the module {module}", source.name)];
    };
    let is_foreign = |import: &String| *import != module && !row.imports.contains(import);
    let faults = source.imports().into_iter().filter(|(_, import)| is_foreign(import));
    faults
        .map(|(line, import)| format!("src/{}:{line}: {module} may not import {import}", source.name))
        .collect()
}

fn assert_none(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn no_import_leaves_the_table_and_so_none_closes_a_cycle() {
    let rows = table_of_the_project();
    assert_none(&table_faults(&rows));
    let sources = sources();
    let in_modules = sources.iter().filter(|source| source.name != "lib.rs");
    assert_none(&in_modules.flat_map(|source| import_faults(&rows, source)).collect::<Vec<_>>());
}

#[test]
fn embree_and_bvh_never_see_each_other() {
    let rows = table_of_the_project();
    let may_import = |module: &str, other: &str| {
        let row = rows.iter().find(|row| row.module == module);
        row.is_some_and(|row| row.imports.iter().any(|import| import == other))
    };
    assert!(may_import("bvh", "math") && may_import("embree", "math"));
    assert!(!may_import("bvh", "embree") && !may_import("embree", "bvh"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut sources = sources_without_tests();
    sources.retain(|source| source.name != "main.rs");
    let all = imports(&sources);
    assert!(all.values().map(BTreeMap::len).sum::<usize>() > sources.len(), "imports are not read");
    let left = CIRCLES_LEFT.map(|(file, _)| file);
    assert_none(&circles(&without_imports_of(&all, &left)));
    for file in left {
        let others: Vec<&str> = left.into_iter().filter(|other| *other != file).collect();
        let needed = !circles(&without_imports_of(&all, &others)).is_empty();
        assert!(needed, "{file} is in no circle any more: take it out of the list of those left");
    }
}

/// Imports, as if nobody imported these files.
fn without_imports_of(all: &Imports, files: &[&str]) -> Imports {
    let mut imports = all.clone();
    imports.values_mut().for_each(|from| from.retain(|file, _| !files.contains(&file.as_str())));
    imports
}

#[test]
fn functions_are_short() {
    let sources = sources_without_tests();
    let in_file = |source: &Source| {
        let file = source.name.clone();
        source.functions().into_iter().map(move |function| (file.clone(), function))
    };
    let mut functions: Vec<(String, Function)> = sources.iter().flat_map(in_file).collect();
    functions.sort_by_key(|(_, function)| function.lines);
    let quantile = |share: f64| functions[(share * (functions.len() - 1) as f64) as usize].1.lines;
    let [median, ninetieth, longest] = [0.5, 0.9, 1.0].map(quantile);
    let told = format!("lines: median {median}, 90th percentile {ninetieth}, longest {longest}");
    println!("{} functions in {} files; {told}", functions.len(), sources.len());
    let long = functions.iter().filter(|(_, function)| function.lines > MOST_LINES);
    let faults = long.map(|(file, f)| format!("src/{file}:{}: `{}` has {} lines", f.line, f.name, f.lines));
    assert_none(&faults.collect::<Vec<_>>());
    assert!(median <= MEDIAN_LINES && ninetieth <= NINETIETH_LINES, "{told}");
}

#[test]
fn unsafe_stands_behind_the_fence_and_in_the_lanes_alone() {
    let allowed = |source: &Source| ["embree/", "simd/"].iter().any(|room| source.name.starts_with(room));
    let (fence, others): (Vec<Source>, Vec<Source>) = sources().into_iter().partition(allowed);
    let places = |sources: &[Source]| -> Vec<String> {
        sources.iter().flat_map(|source| source.lines_with(&["unsafe"])).collect()
    };
    assert!(!places(&fence).is_empty());
    assert_none(&places(&others));
}

#[test]
fn nothing_unwraps_outside_tests() {
    let mut sources = sources_without_tests();
    sources.push(Source::new("../build.rs", &fs::read_to_string(root().join("build.rs")).unwrap()));
    let places = |source: &Source| source.lines_with(&[".unwrap()", ".expect("]);
    assert_none(&sources.iter().flat_map(places).collect::<Vec<_>>());
}

mod checks_of_the_checks {
    use super::*;

    const TABLE: &str = "# A\n\n## Who may import whom\n\n| Floor | Module | May import |\n|---|---|---|\n\
                         | 0 | `math` | nothing |\n| 1 | `bvh` | `math` |\n| 2 | `cli` | every module above |\n\n## B\n\
                         | 3 | `other` | `cli` |\n";

    #[test]
    fn the_table_ends_with_its_section() {
        let rows = table(TABLE);
        let modules: Vec<&str> = rows.iter().map(|row| row.module.as_str()).collect();
        assert_eq!(modules, ["math", "bvh", "cli"]);
        assert!(rows[0].imports.is_empty());
        assert_eq!(rows[2].imports, ["math", "bvh"]);
        assert!(table_faults(&rows).is_empty());
    }

    #[test]
    fn a_table_that_points_upward_is_found() {
        assert_eq!(table_faults(&table(&TABLE.replace("nothing", "`bvh`"))).len(), 1);
        assert_eq!(table_faults(&table(&TABLE.replace("| 0 |", "| 2 |"))).len(), 1);
    }

    #[test]
    fn imports_in_all_their_forms_are_found() {
        let faults = |name: &str, text: &str| import_faults(&table(TABLE), &Source::new(name, text)).len();
        assert_eq!(faults("math/ray.rs", "use super::Vec3;\nuse crate::math::Ray;"), 0);
        assert_eq!(faults("bvh/mod.rs", "use crate::math::{Aabb, Vec3};"), 0);
        assert_eq!(faults("math/ray.rs", "use crate::bvh::Tree;"), 1);
        assert_eq!(faults("math/ray.rs", "fn f() -> crate::bvh::Tree {}"), 1);
        assert_eq!(
            faults("math/ray.rs", "use crate::{\n    bvh::{self, Tree},\n    math::Ray,\n    cli,\n};"),
            2
        );
        assert_eq!(faults("math/ray.rs", "use super::super::bvh;"), 1);
        assert_eq!(faults("math.rs", "use super::bvh;"), 1);
        assert_eq!(faults("math.rs", "mod tests {\n    use super::*;\n    use super::super::bvh;\n}"), 1);
        assert_eq!(faults("math.rs", "use crate::*;"), 1);
        assert_eq!(faults("math.rs", "//! [`crate::bvh`]\nconst S: &str = \"use crate::bvh;\";"), 0);
        assert_eq!(faults("light.rs", ""), 1, "a module without a row");
    }

    fn circles_of(files: &[(&str, &str)]) -> Vec<String> {
        let sources: Vec<Source> =
            files.iter().map(|(name, text)| Source::new(name, text).without_tests()).collect();
        circles(&imports(&sources))
    }

    #[test]
    fn files_that_import_each_other_are_found_through_whoever_exports_them() {
        let root = ("lib.rs", "pub mod a;\nmod b;\npub use a::X;");
        let a = ("a/mod.rs", "mod x;\nmod y;\npub use x::{X, x};\npub use y::Y;");
        let y = ("a/y.rs", "use super::X;\npub struct Y(X);");
        let circle = "2 files import each other in a circle:\n  src/a/x.rs takes from src/a/y.rs: Y\n  \
                      src/a/y.rs takes from src/a/x.rs: X";
        for x in [
            "use super::Y;\npub struct X;",
            "use crate::{\n    a::{self, Y as Z},\n};",
            "fn x() -> super::Y {}",
            "fn x(y: &self::super::y::Y) {}",
            "use crate::a;\nfn x() -> Vec<a::Y> {}",
        ] {
            assert_eq!(circles_of(&[root, a, ("a/x.rs", x), y]), [circle], "{x}");
        }
        for x in [
            "pub struct X;\n#[cfg(test)]\nmod tests {\n    use super::super::Y;\n}",
            "use super::super::a;\nuse std::fmt::Y;\npub(super) struct X(Y);",
            "//! [`super::Y`]\nfn x(x: X) { x.Y }",
        ] {
            assert!(circles_of(&[root, a, ("a/x.rs", x), y]).is_empty(), "{x}");
        }
    }

    #[test]
    fn a_parent_is_in_a_circle_if_it_uses_the_child_that_needs_it() {
        let child = ("a/x.rs", "use super::LIMIT;\npub struct X;");
        let with = |parent| circles_of(&[("lib.rs", "mod a;"), ("a/mod.rs", parent), child]).len();
        assert_eq!(with("mod x;\npub use x::X;\nconst LIMIT: u32 = 1;"), 0, "it exports alone");
        assert_eq!(with("mod x;\npub use x::X;\nconst LIMIT: u32 = 1;\nfn f(x: X) {}"), 1);
        assert_eq!(with("mod x;\nuse x::X;\nconst LIMIT: u32 = 1;"), 1);
        assert_eq!(with("mod x;\nconst LIMIT: u32 = x::X::LIMIT;"), 1);
    }

    #[test]
    fn functions_are_measured_from_signature_to_brace() {
        let text = "fn one() -> [u8; 4] { [b'{'; 4] }\ntrait T {\n    fn none(&self);\n}\n\
                    #[cfg(test)]\nmod tests {\n    fn hidden() {}\n}\nfn four<'a>(\n    s: &'a str,\n) -> char {\n    '}' }\n";
        let functions = Source::new("x.rs", text).without_tests().functions();
        let found: Vec<(&str, usize, usize)> =
            functions.iter().map(|f| (f.name.as_str(), f.line, f.lines)).collect();
        assert_eq!(found, [("one", 1, 1), ("four", 9, 4)]);
    }

    #[test]
    fn words_in_comments_strings_and_longer_names_do_not_count() {
        let text = "// unsafe\n/* unsafe */ const A: &str = r#\"unsafe\"#;\n#![deny(unsafe_code)]\n";
        assert!(Source::new("x.rs", text).lines_with(&["unsafe"]).is_empty());
        assert_eq!(Source::new("x.rs", "\nunsafe {}").lines_with(&["unsafe"]), ["src/x.rs:2: unsafe"]);
        assert_eq!(Source::new("x.rs", "a.unwrap()").lines_with(&[".unwrap()"]), ["src/x.rs:1: .unwrap()"]);
    }
}
