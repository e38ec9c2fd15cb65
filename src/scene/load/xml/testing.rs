//! What the tests of this module share.

use std::collections::BTreeMap;
use std::fs;

use super::super::super::{SceneDesc, load_with};
use super::super::{Access, testing};

/// A sensor, which takes lines 2 to 6 of the scenes of [`good`].
pub const SENSOR: &str = "<sensor type=\"perspective\">\n<float name=\"fov\" value=\"40\"/>\n<transform name=\"to_world\">\n\
    <lookat origin=\"0,0,5\" target=\"0,0,0\" up=\"0,1,0\"/></transform>\n</sensor>\n";

pub fn read_text(
    text: &str,
    files: &[(&str, &str)],
    definitions: &[(&str, &str)],
) -> Result<SceneDesc, String> {
    read_with(text, files, Access::any().defining(pairs(definitions)))
}

fn pairs(definitions: &[(&str, &str)]) -> BTreeMap<String, String> {
    definitions.iter().map(|(name, value)| (String::from(*name), String::from(*value))).collect()
}

pub fn read_with(text: &str, files: &[(&str, &str)], access: Access) -> Result<SceneDesc, String> {
    let (folder, _) = testing::folder(b"", files);
    let path = folder.path().join("s.xml");
    fs::write(&path, text).unwrap();
    let shorten = |text: String| text.replace(&format!("{}/", folder.path().display()), "");
    let scene = load_with(&path, &access).map_err(|e| shorten(e.to_string()))?;
    Ok(SceneDesc { warnings: scene.warnings.iter().cloned().map(shorten).collect(), ..scene })
}

/// A scene of [`SENSOR`] and `body`, which begins in line 7.
pub fn with_sensor(body: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{SENSOR}{body}\n</scene>")
}

pub fn read_defining(
    body: &str,
    files: &[(&str, &str)],
    definitions: &[(&str, &str)],
) -> Result<SceneDesc, String> {
    read_text(&with_sensor(body), files, definitions)
}

pub fn good(body: &str, files: &[(&str, &str)]) -> SceneDesc {
    read_defining(body, files, &[]).unwrap()
}

/// The scene fails in `line` with `words`, and loads by lenient reading at most with a warning.
pub fn fails(body: &str, line: usize, words: &str) {
    let error = read_defining(body, &[], &[]).expect_err(body);
    assert!(error.starts_with(&format!("s.xml:{line}: ")), "{body}\n{error}\nis not in line {line}");
    assert!(error.contains(words), "{body}\n{error}\nlacks {words}");
}
