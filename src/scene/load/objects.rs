//! The tables `[[point_light]]`, `[[sphere]]` and `[[quad]]`.

use super::super::mesh::geometric_normal;
use super::super::{Mesh, PointLightDesc, SceneError, SphereDesc};
use super::fields::{COORDINATE, Fields, NON_NEGATIVE, Names, POSITIVE};
use crate::math::{Rgb, Vec2, Vec3};

/// The tables headed `[[name]]`, numbered from 1 in their places.
pub(super) fn each<'a, T>(
    root: &Fields<'a>,
    name: &str,
    known: &[&str],
    mut read: impl FnMut(&Fields<'a>) -> Result<T, SceneError>,
) -> Result<Vec<T>, SceneError> {
    let numbered = root.tables(name)?.into_iter().zip(1..);
    numbered.map(|(field, number)| read(&field.table(format!("{name} {number}"), known)?)).collect()
}

pub(super) fn point_lights(
    root: &Fields,
    warnings: &mut Vec<String>,
) -> Result<Vec<PointLightDesc>, SceneError> {
    each(root, "point_light", &["position", "intensity"], |table| {
        let position = table.required("position", "three numbers")?.vec3(&COORDINATE)?;
        let intensity = table.required("intensity", "three numbers, 0 or above")?.vec3(&NON_NEGATIVE)?;
        if intensity == Rgb::ZERO {
            warnings.push(format!("{}: {}: intensity is zero", table.whereabouts(), table.place));
        }
        Ok(PointLightDesc { position, intensity })
    })
}

pub(super) fn spheres(root: &Fields, names: &Names) -> Result<Vec<SphereDesc>, SceneError> {
    each(root, "sphere", &["center", "radius", "material"], |table| {
        let center = table.required("center", "three numbers")?.vec3(&COORDINATE)?;
        let radius = table.required("radius", POSITIVE.text)?.f32(&POSITIVE)?;
        if !(COORDINATE.holds)(f64::from(center.abs().max_element()) + f64::from(radius)) {
            return Err(table.error(String::from("reaches beyond 1.8e18; allowed: coordinates up to there")));
        }
        let material = material(table, names)?;
        Ok(SphereDesc { center, radius, material })
    })
}

/// The index of the material that the table's field `material` names.
pub(super) fn material(table: &Fields, names: &Names) -> Result<u32, SceneError> {
    let field = table.required("material", "the name of a material")?;
    Ok(field.choice(names)? as u32)
}

pub(super) fn quads(root: &Fields, names: &Names) -> Result<Vec<Mesh>, SceneError> {
    each(root, "quad", &["corners", "material"], |table| {
        let corners = table.required("corners", "four points")?.elements::<4>("points")?;
        let [a, b, c, d] = &corners;
        let vertices = [a, b, c, d].map(|corner| corner.vec3(&COORDINATE));
        let vertices = vertices.into_iter().collect::<Result<Vec<Vec3>, SceneError>>()?;
        check_quad(&vertices).map_err(|reason| table.error(reason))?;
        Ok(Mesh {
            name: table.place.clone(),
            vertices,
            normals: None,
            uvs: Some(vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            materials: vec![material(table, names)?; 2],
        })
    })
}

/// What keeps four corners from being a quad.
pub(in super::super) fn check_quad(corners: &[Vec3]) -> Result<(), String> {
    let normal = |i: usize, j: usize| geometric_normal([corners[0], corners[i], corners[j]]);
    let (Some(first), Some(second)) = (normal(1, 2), normal(2, 3)) else {
        let halves = "the triangles of corners 0 1 2 and 0 2 3 must have an area";
        return Err(format!("has zero area in one half; {halves}"));
    };
    if first.dot(second) <= 0.0 {
        let reason = "is folded: its corners are not in order, or it is concave at corner 1 or 3";
        return Err(format!("{reason}; allowed: corners in order around it"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{BASE, added_fails_with, changed_fails_with, good, normal};
    use super::*;

    #[test]
    fn mistakes_in_a_point_light_are_told() {
        for (old, new, place, words) in [
            (
                "[[point_light]]",
                "[point_light]",
                "s.toml:7:1",
                "allowed: tables that are headed [[point_light]]",
            ),
            (
                "intensity = [1, 1, 1]",
                "intensity = [1, -1, 1]",
                "s.toml:9:17: point_light 1",
                "is -1; allowed: a finite number, 0 or above",
            ),
            (
                "intensity = [1, 1, 1]",
                "intensity = [1, 1e39, 1]",
                "s.toml:9:17",
                "is 1e39; allowed: a finite number",
            ),
            ("intensity = [1, 1, 1]", "", "s.toml:7:1", "field `intensity` is missing"),
        ] {
            changed_fails_with(old, new, place, words);
        }
    }

    #[test]
    fn mistakes_in_spheres_and_quads_are_told() {
        for (tables, line, words) in [
            (
                "[[sphere]]\ncenter = [0, 0, 0]\nradius = -1\nmaterial = \"a\"",
                12,
                "sphere 1: field `radius` is -1; allowed: a finite number above 0",
            ),
            (
                "[[sphere]]\ncenter = [1e18, 0, 0]\nradius = 1e18\nmaterial = \"a\"",
                10,
                "reaches beyond 1.8e18",
            ),
            (
                "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = \"A\"",
                13,
                "unknown name `A`; did you mean `a`? allowed: `a`",
            ),
            (
                "[[sphere]]\ncenter = [0, 0, 0]\nradius = 1\nmaterial = 3",
                13,
                "is 3; allowed: a text in quotes",
            ),
            ("[[sphere]]\ncenter = [0, 0, 0]\nradius = 1", 10, "field `material` is missing"),
            ("[[sphere]]\nradius = 1\n[[sphere]]\n", 10, "sphere 1: field `center` is missing"),
            (
                "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0]]\nmaterial = \"a\"",
                11,
                "allowed: an array of 4 points",
            ),
            (
                "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,nan,0]]\nmaterial = \"a\"",
                11,
                "`corners[3][1]` is nan",
            ),
            (
                "[[quad]]\ncorners = [[0,0,0],[1,0,0],[2,0,0],[3,0,0]]\nmaterial = \"a\"",
                10,
                "quad 1: has zero area",
            ),
            (
                "[[quad]]\ncorners = [[0,0,0],[1,0,0],[1,1,0],[1,1,0]]\nmaterial = \"a\"",
                10,
                "quad 1: has zero area",
            ),
            ("[[quad]]\ncorners = [[0,0,0],[1,1,0],[1,0,0],[0,1,0]]\nmaterial = \"a\"", 10, "is folded"),
        ] {
            added_fails_with(tables, line, words);
        }
    }

    #[test]
    fn a_sphere_arrives() {
        let sphere = "[[sphere]]\ncenter = [1, 2, 3]\nradius = 2\nmaterial = \"l\"\n";
        let material = "[material.l]\nmirror = { reflectance = [0, 0, 0] }\nemission = [1, 0, 0]\n";
        let scene = good(&format!("{BASE}{material}{sphere}"), &[]);
        assert_eq!(
            scene.spheres,
            [SphereDesc { center: Vec3::new(1.0, 2.0, 3.0), radius: 2.0, material: 1 }]
        );
    }

    #[test]
    fn quads_become_two_triangles_by_the_right_hand() {
        let quad = "[[quad]]\ncorners = [[0,0,0],[0,0,2],[2,0.5,2],[2,0,0]]\nmaterial = \"a\"\n";
        let scene = good(&format!("{BASE}{quad}"), &[]);
        let mesh = &scene.meshes[0];
        assert_eq!((mesh.name.as_str(), &mesh.triangles[..]), ("quad 1", &[[0, 1, 2], [0, 2, 3]][..]));
        assert!(normal(mesh, 0).y > 0.9 && normal(mesh, 1).y > 0.9);
        assert_eq!((mesh.materials.clone(), mesh.normals.clone()), (vec![0, 0], None));
    }
}
