//! In which lines a scene file describes what.

use std::path::Path;

use super::super::{Places, SceneError};
use super::fields::{Field, Fields};

/// The lines of all tables of a scene file.
pub(super) fn places(path: &Path, root: &Fields) -> Result<Places, SceneError> {
    let lines = |name| Ok::<_, SceneError>(root.tables(name)?.iter().map(Field::line).collect::<Vec<u32>>());
    let line = |name| root.optional(name).map(|field| field.line());
    Ok(Places {
        file: path.display().to_string(),
        materials: materials(root)?,
        spheres: lines("sphere")?,
        meshes: [lines("quad")?, lines("mesh")?].concat(),
        point_lights: lines("point_light")?,
        further_lights: [
            lines("spot_light")?,
            lines("distant_light")?,
            line("environment").into_iter().collect(),
        ]
        .concat(),
        camera: line("camera"),
        film: line("film"),
    })
}

fn materials(root: &Fields) -> Result<Vec<u32>, SceneError> {
    let Some(field) = root.optional("material") else { return Ok(Vec::new()) };
    let table = field.open_table(String::from("scene"))?;
    Ok(table.all().map(|(_, field)| field.line()).collect())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, good};
    use crate::scene::{Item, Scene};

    const ADDED: &str = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"a\"\n[film]\nwidth = 3\n\
        [[mesh]]\nfile = \"m.obj\"\n[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nmaterial = \"a\"\n";

    #[test]
    fn everything_is_named_with_its_line() {
        let scene = format!("{BASE}{ADDED}");
        let desc = good(&scene, &[("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
        let file = desc.path.display().to_string();
        let line_of = |start: &str| scene.lines().position(|line| line == start).unwrap() + 1;
        let scene = Scene::new(desc).unwrap();
        for (item, name, start) in [
            (Item::Material(0), "material `a`", "[material.a]"),
            (Item::Sphere(0), "sphere 1", "[[sphere]]"),
            (Item::Mesh(0), "quad 1", "[[quad]]"),
            (Item::Mesh(1), "m.obj", "[[mesh]]"),
            (Item::PointLight(0), "point_light 1", "[[point_light]]"),
            (Item::Camera, "camera", "[camera]"),
            (Item::Film, "film", "[film]"),
        ] {
            assert_eq!(scene.describe(item), format!("{name} ({file}:{})", line_of(start)), "{item:?}");
        }
        assert_eq!(scene.describe(Item::Material(1)), "material `m.obj:(none)`");
    }

    #[test]
    fn what_no_file_describes_has_a_name_alone() {
        let desc = good(&format!("{BASE}{ADDED}"), &[("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")]);
        let scene = Scene::new(desc.without_places()).unwrap();
        assert_eq!([scene.describe(Item::Sphere(0)), scene.describe(Item::Film)], ["sphere 1", "film"]);
    }
}
