//! Scenes in the XML of Mitsuba 3. What the core has no counterpart for is refused by name, or told and left out by a lenient
//! reader; the tables in `docs/formats.md` list all of it.

mod bsdfs;
mod document;
mod element;
mod emitters;
mod interiors;
mod ior;
mod look;
mod materials;
mod object;
mod sensor;
mod shapes;
mod spectra;
mod tessellate;
#[cfg(test)]
mod testing;
mod textures;
mod transform;

use std::path::Path;

use toml::de::DeTable;

use self::element::Element;
use self::emitters::Lights;
use self::materials::Materials;
use self::object::{Context, Object};
use self::shapes::Shapes;
use super::super::{CameraDesc, FilmDesc, Places, RenderDesc, SceneDesc, SceneError};
use super::access::Reader;
use super::fields::Fields;
use super::settings;
use super::source::Source;

/// Reads a scene and the files that it names.
pub(super) fn read(path: &Path, reader: &Reader) -> Result<SceneDesc, SceneError> {
    let root = document::read(path, reader)?;
    let context = Context::new(reader, &root)?;
    let mut parts = Parts::default();
    let (camera, film, render) = parts.read(&root, &context)?;
    settings::check_eye_paths(&film, &render, reader.limits()).map_err(|reason| root.error(reason))?;
    let (materials, material_lines) = parts.materials.into_parts();
    context.warn_all(parts.shapes.note_of_backs());
    let (further_lights, further_lines) = parts.lights.further();
    let places = Places {
        file: path.display().to_string(),
        materials: material_lines,
        spheres: parts.shapes.sphere_lines,
        meshes: parts.shapes.mesh_lines,
        point_lights: parts.lights.point_lines,
        further_lights: further_lines,
        camera: Some(parts.sensor_line),
        film: Some(parts.sensor_line),
    };
    Ok(SceneDesc {
        name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        path: path.to_owned(),
        film,
        camera,
        render,
        materials,
        spheres: parts.shapes.spheres,
        meshes: parts.shapes.meshes,
        point_lights: parts.lights.points,
        further_lights,
        warnings: context.into_warnings(&root),
        places,
    })
}

/// What a scene is put together from.
#[derive(Default)]
struct Parts {
    materials: Materials,
    shapes: Shapes,
    lights: Lights,
    sensor_line: u32,
}

impl Parts {
    fn read<'a>(
        &mut self,
        root: &'a Element,
        context: &'a Context<'a>,
    ) -> Result<(CameraDesc, FilmDesc, RenderDesc), SceneError> {
        for bsdf in root.children.iter().filter(|child| child.tag == "bsdf") {
            self.materials.declare(bsdf, context)?;
        }
        let (mut seen, mut render) = (None, RenderDesc::default());
        for child in &root.children {
            match child.tag.as_str() {
                "bsdf" => {}
                "shape" => self.shapes.read(child, &mut self.materials, context)?,
                "emitter" => self.lights.read(child, context)?,
                "sensor" if seen.is_some() => {
                    context.has_no_use(format!("{} in line {}", child.label(), child.place.line))
                }
                "sensor" => {
                    self.sensor_line = child.place.main_line as u32;
                    seen = Some(sensor::read(child, context)?);
                }
                "integrator" => integrator(child, context)?,
                _ if child.is_own() => render = own_settings(child, context)?,
                _ => unknown(child, context)?,
            }
        }
        let (camera, film) =
            seen.ok_or_else(|| root.error("has no <sensor>; allowed: one `perspective` or `thinlens`"))?;
        Ok((camera, film, render))
    }
}

/// How Mitsuba would render is of no use to a photon mapper, but for what its pictures lack then.
fn integrator<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<(), SceneError> {
    let object = Object::new(element, context)?;
    context.has_no_use(element.label());
    if object.boolean("hide_emitters")? {
        let reason = "integrator: `hide_emitters` is not supported";
        context.unsupported(element, reason, "the picture shows the lights that the camera sees")?;
    }
    Ok(())
}

fn unknown<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<(), SceneError> {
    let object = context.resolved(element)?;
    if ["texture", "medium"].contains(&object.tag.as_str()) && element.tag != "ref" {
        // Whoever refers to it decides.
        context.has_no_use(format!("{} in line {}", element.label(), element.place.line));
        return Ok(());
    }
    let reason = format!(
        "<{}> in a scene is not supported; allowed: <default>, <include>, <integrator>, <sensor>, <bsdf>, <shape>, <emitter>",
        element.tag
    );
    context.unsupported(element, &reason, "the picture lacks it")
}

/// The settings of photon mapping, which Mitsuba has no word for, by the rules of a scene file's `[render]`.
fn own_settings<'a>(note: &'a Element, context: &'a Context<'a>) -> Result<RenderDesc, SceneError> {
    let lines = note.attributes.iter().map(|(name, value)| format!("{name} = {value}\n"));
    let text = format!("[render]\n{}", lines.collect::<String>());
    let table = DeTable::parse(&text).map_err(|e| note.error(format!("settings: {}", e.message())))?;
    let source = Source::new(&note.place.file, &text);
    let render = Fields::root(&source, &table, &["render"])
        .and_then(|root| settings::render(&root, context.reader.limits()));
    render.map_err(|e| note.error(e.reason()))
}

#[cfg(test)]
mod tests {
    use super::super::Access;
    use super::testing::{SENSOR, fails, good, read_text, read_with, with_sensor};
    use super::*;
    use crate::scene::{Item, Scene};

    #[test]
    fn own_settings_follow_the_rules_of_scene_files() {
        let render = good("<?caustica passes=\"3\" photons=\"5_000\" samples=\"9\" alpha=\"1\" radius=\"1e-3\" depth=\"0\"?>", &[]).render;
        assert_eq!(
            render,
            RenderDesc { passes: 3, photons: 5000, samples: 9, alpha: 1.0, radius: Some(1e-3), depth: 0 }
        );
        assert_eq!(good("", &[]).render, RenderDesc::default());
        fails("<?caustica passes=\"0\"?>", 7, "render: field `passes` is 0; allowed: a whole number from 1");
        fails("\n<?caustica pases=\"1\"?>", 8, "did you mean `passes`?");
        fails("<?caustica passes=\"one\"?>", 7, "settings: ");
    }

    #[test]
    fn what_is_of_no_use_is_listed() {
        let body = "<integrator type='path'><integer name='max_depth' value='5'/></integrator>";
        let sensor = SENSOR
            .replace("<float", "<sampler type='independent'/><float name='near_clip' value='1'/><float");
        let scene = read_text(&with_sensor(body).replace(SENSOR, &sensor), &[], &[]).unwrap();
        let listed =
            "s.xml:1: read, but of no use here: integrator `path`, sampler `independent`, sensor `near_clip`";
        assert!(scene.warnings.contains(&String::from(listed)), "{:?}", scene.warnings);
    }

    #[test]
    fn unknown_elements_are_refused_or_told_by_a_lenient_reader() {
        let body = "<shape type='hair' id='h'/>\n<emitter type='sunsky'/>\n<bsdf type='principled' id='p'/>\n<volume type='grid'/>\n<shape type='cube'><ref id='p'/></shape>";
        fails(body, 9, "bsdf `principled` is not supported");
        let lenient = read_with(&with_sensor(body), &[], Access::any().lenient(true)).unwrap();
        for line in [
            "s.xml:9: bsdf `principled` is not supported; allowed: `diffuse`, `dielectric`, `thindielectric`, `roughdielectric`, `conductor`, `roughconductor`, `plastic`, `mask`, `twosided`; the picture has a diffuse grey 0.5 instead",
            "s.xml:10: <volume> in a scene is not supported",
            "s.xml:8: emitter `sunsky` is not supported; allowed: `point`, `spot`, `directional`, `constant`, `envmap`, and `area` in a <shape>; the picture lacks its light",
            "s.xml:7: shape `hair` is not supported",
        ] {
            assert!(lenient.warnings.iter().any(|w| w.starts_with(line)), "{line}: {:?}", lenient.warnings);
        }
        fails("<path value='a'/>", 7, "<path> in a scene is not supported");
        fails("<ref id='x'/>", 7, "unknown id `x`; allowed: none");
    }

    #[test]
    fn everything_is_named_with_its_line() {
        let other = "<scene version='3.0.0'>\n\n<shape type='sphere'/></scene>";
        let body = "<bsdf type='diffuse' id='a'/>\n<shape type='cube'/>\n<emitter type='point'/>\n<include filename='o.xml'/>";
        let scene = Scene::new(good(body, &[("o.xml", other)])).unwrap();
        let line = |item| scene.describe(item).rsplit(':').next().unwrap().to_owned();
        for (item, expected) in [
            (Item::Material(0), "7)"),
            (Item::Mesh(0), "8)"),
            (Item::PointLight(0), "9)"),
            (Item::Sphere(0), "10)"),
            (Item::Camera, "2)"),
        ] {
            assert_eq!(line(item), expected, "{item:?}");
        }
    }

    #[test]
    fn the_sandbox_holds() {
        let sandbox = |text: &str| read_with(text, &[], Access::sandbox()).unwrap_err();
        let film = "<film type='hdrfilm'><integer name='width' value='9000'/></film></sensor>";
        assert!(
            sandbox(&with_sensor("").replace("</sensor>", film))
                .contains("`width` is 9000; allowed: up to 8192 in the sandbox")
        );
        let film = "<film type='hdrfilm'><integer name='width' value='8192'/><integer name='height' value='8192'/></film></sensor>";
        assert!(
            sandbox(&with_sensor("").replace("</sensor>", film))
                .contains("eye samples; allowed in the sandbox")
        );
        assert!(
            sandbox(&with_sensor("<include filename='../../etc/passwd'/>"))
                .contains("include `../../etc/passwd`")
        );
        let outside = "<shape type='ply'><string name='filename' value='/etc/hostname'/></shape>";
        assert!(sandbox(&with_sensor(outside)).contains("lies outside the scene's folder"));
    }
}
