//! `<bsdf>`: which of the core's surfaces each kind is.

use std::sync::Arc;

use glam::DAffine2;

use super::super::super::{SceneError, Textures};
use super::super::fields::{NON_NEGATIVE, unknown_name};
use super::super::material::{COAT, ROUGHNESS};
use super::super::pictures::{grey, luminance};
use super::element::Element;
use super::ior;
use super::object::{Context, Object};
use crate::bsdf::{Bsdf, Ggx, Interface, METALS, Plastic, RoughSurface};
use crate::math::Rgb;
use crate::texture::Texture;

/// Bsdfs may wrap each other this deep; a reference to itself would do so without end.
const DEEPEST: usize = 8;

const KINDS: &str = "`diffuse`, `dielectric`, `thindielectric`, `roughdielectric`, `conductor`, `roughconductor`, `plastic`, `mask`, `twosided`";

/// How a surface scatters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Surface {
    pub bsdf: Bsdf,
    pub textures: Textures,
    /// From texture coordinates to those by which the pictures are looked up.
    pub to_uv: DAffine2,
    /// The share of light that meets it.
    pub opacity: f32,
    /// Whether Mitsuba shows it black from behind: here no surface is.
    pub one_sided: bool,
}

impl Surface {
    /// That of shapes without a bsdf.
    pub const DEFAULT: Surface = Surface {
        textures: Textures::NONE,
        to_uv: DAffine2::IDENTITY,
        bsdf: Bsdf::Diffuse { albedo: Rgb::splat(0.5) },
        opacity: 1.0,
        one_sided: true,
    };

    /// That of shapes without a bsdf that shine.
    pub fn black() -> Surface {
        Surface::one_sided(Bsdf::Diffuse { albedo: Rgb::ZERO })
    }

    fn one_sided(bsdf: Bsdf) -> Surface {
        Surface { bsdf, one_sided: true, ..Surface::DEFAULT }
    }

    fn both_sides(bsdf: Bsdf) -> Surface {
        Surface { bsdf, one_sided: false, ..Surface::DEFAULT }
    }

    fn is_mask(&self) -> bool {
        self.opacity < 1.0 || self.textures.opacity.is_some()
    }
}

pub(super) fn read<'a>(element: &'a Element, context: &'a Context<'a>) -> Result<Surface, SceneError> {
    nested(element, context, 0)
}

fn nested<'a>(element: &'a Element, context: &'a Context<'a>, depth: usize) -> Result<Surface, SceneError> {
    if depth == DEEPEST {
        return Err(
            element.error(format!("bsdfs are nested deeper than {DEEPEST}; allowed: as deep as that"))
        );
    }
    let object = Object::new(element, context)?;
    let surface = match object.kind()? {
        "diffuse" => Surface::one_sided(Bsdf::Diffuse { albedo: object.reflectance("reflectance", 0.5)? }),
        "dielectric" => {
            object.only_white("specular_reflectance")?;
            object.only_white("specular_transmittance")?;
            Surface::both_sides(Bsdf::Dielectric { ior: ior::ratio(&object, "bk7")? })
        }
        "thindielectric" => {
            object.only_white("specular_reflectance")?;
            object.only_white("specular_transmittance")?;
            Surface::both_sides(Bsdf::ThinDielectric { ior: ior::ratio(&object, "bk7")? })
        }
        "roughdielectric" => {
            object.only_white("specular_reflectance")?;
            object.only_white("specular_transmittance")?;
            let interface = Interface::Dielectric { ior: ior::ratio(&object, "bk7")? };
            Surface::both_sides(Bsdf::Rough(RoughSurface { facets: facets(&object)?, interface }))
        }
        "conductor" => Surface::one_sided(match metal(&object)? {
            None => Bsdf::Mirror { reflectance: object.reflectance("specular_reflectance", 1.0)? },
            Some((eta, k)) => {
                Bsdf::Conductor { eta, k, reflectance: object.reflectance("specular_reflectance", 1.0)? }
            }
        }),
        "roughconductor" => Surface::one_sided(rough_conductor(&object)?),
        "plastic" => Surface::one_sided(plastic(&object)?),
        "mask" => mask(&object, depth)?,
        "twosided" => two_sided(&object, depth)?,
        other => {
            let reason = format!("bsdf `{other}` is not supported; allowed: {KINDS}");
            context.unsupported(element, &reason, "the picture has a diffuse grey 0.5 instead")?;
            return Ok(Surface::DEFAULT);
        }
    };
    object.own_note();
    object.finish()?;
    if surface.textures != Textures::NONE {
        return Ok(surface);
    }
    Ok(Surface { textures: object.textures(), to_uv: object.to_uv(), ..surface })
}

/// `eta` and `k`; none of a perfect mirror.
fn metal(object: &Object) -> Result<Option<(Rgb, Rgb)>, SceneError> {
    let has = |name: &str| object.element.children.iter().any(|child| child.attribute("name") == Some(name));
    let given = object.string("material")?;
    if has("eta") || has("k") {
        if given.is_some() {
            return Err(object.error("has `material` beside `eta` or `k`; allowed: either"));
        }
        let index = |name, default| object.color(name, default, &NON_NEGATIVE);
        return Ok(Some((index("eta", Rgb::ZERO)?, index("k", Rgb::ONE)?)));
    }
    let Some(name) = given.filter(|name| !name.eq_ignore_ascii_case("none")) else { return Ok(None) };
    if let Some(metal) = METALS.iter().find(|metal| metal.name == name) {
        return Ok(Some((metal.eta, metal.k)));
    }
    let mut names: Vec<&str> = METALS.iter().map(|metal| metal.name).collect();
    names.push("none");
    let reason =
        format!("{}: `material`: unknown name {}", object.element.label(), unknown_name(name, &names));
    object.context.unsupported(
        object.element,
        &reason,
        "the picture has a mirror without Fresnel's law instead",
    )?;
    Ok(None)
}

fn rough_conductor(object: &Object) -> Result<Bsdf, SceneError> {
    let reflectance = object.reflectance("specular_reflectance", 1.0)?;
    // As Mitsuba's `none`: all light is mirrored.
    let (eta, k) = metal(object)?.unwrap_or((Rgb::ZERO, Rgb::ONE));
    let interface = Interface::Conductor { eta, k, reflectance };
    Ok(Bsdf::Rough(RoughSurface { facets: facets(object)?, interface }))
}

/// How the facets lie.
fn facets(object: &Object) -> Result<Ggx, SceneError> {
    let distribution = object.string("distribution")?.unwrap_or("beckmann");
    if distribution != "ggx" {
        let reason = format!(
            "{}: distribution `{distribution}` is not supported; allowed: `ggx`",
            object.element.label()
        );
        object.context.unsupported(
            object.element,
            &reason,
            "the picture has `ggx` of the same `alpha` instead",
        )?;
    }
    object.has_no_use_for(&["sample_visible"]);
    if let Some(texture) = object.picture("alpha")? {
        let alpha = object.roughness_picture(texture).clamp(Ggx::LEAST_ALPHA, 1.0);
        return Ok(Ggx { alpha });
    }
    let along = [object.optional_f64("alpha_u", &ROUGHNESS)?, object.optional_f64("alpha_v", &ROUGHNESS)?];
    let alpha = match along {
        [None, None] => object.f64("alpha", 0.1, &ROUGHNESS)?,
        [Some(u), Some(v)] if u == v => u,
        _ => {
            return Err(object.error(
                "other facets along `alpha_u` than along `alpha_v` are not supported; allowed: `alpha`",
            ));
        }
    };
    Ok(Ggx { alpha: alpha as f32 })
}

fn plastic(object: &Object) -> Result<Bsdf, SceneError> {
    object.only_white("specular_reflectance")?;
    let base = object.reflectance("diffuse_reflectance", 0.5)?;
    let ior = ior::ratio(object, "polypropylene")?;
    if !(COAT.holds)(f64::from(ior)) {
        return Err(object.error(format!("`int_ior` over `ext_ior` is {ior}; allowed: {}", COAT.text)));
    }
    Ok(Bsdf::Plastic(Plastic::new(base, ior, object.boolean("nonlinear")?)))
}

fn mask(object: &Object, depth: usize) -> Result<Surface, SceneError> {
    let inner = object.object("bsdf")?.ok_or_else(|| object.error(WRAPS_NOTHING))?;
    let picture = object.picture("opacity")?.and_then(|picture| grey_texture(&picture));
    let opacity = match &picture {
        Some(picture) => picture.max().x,
        None => luminance(object.reflectance("opacity", 0.5)?),
    };
    let surface = nested(inner, object.context, depth + 1)?;
    if surface.is_mask() {
        return Err(object.error("wraps another mask; allowed: one, of the product of both opacities"));
    }
    let to_uv = match (&picture, surface.textures == Textures::NONE) {
        (None, _) => surface.to_uv,
        (Some(_), true) => object.to_uv(),
        (Some(_), false) if object.to_uv() == surface.to_uv => surface.to_uv,
        (Some(_), false) => {
            return Err(
                object.error("its picture has another `to_uv` than those below; allowed: the same of all")
            );
        }
    };
    Ok(Surface { opacity, to_uv, textures: Textures { opacity: picture, ..surface.textures }, ..surface })
}

fn grey_texture(texture: &Texture) -> Option<Arc<Texture>> {
    Texture::new(texture.name.clone(), grey(texture.image().clone())).map(Arc::new)
}

const WRAPS_NOTHING: &str = "wraps no bsdf; allowed: one";

fn two_sided(object: &Object, depth: usize) -> Result<Surface, SceneError> {
    let inner = object.objects("bsdf")?;
    let Some((front, others)) = inner.split_first() else { return Err(object.error(WRAPS_NOTHING)) };
    if let Some(second) = others.first() {
        let reason = "bsdf `twosided` with another bsdf for the back is not supported";
        object.context.unsupported(second, reason, "the picture has that of the front on both sides")?;
    }
    let surface = nested(front, object.context, depth + 1)?;
    if surface.bsdf.transmits() || surface.is_mask() {
        return Err(object.error("wraps a bsdf that lets light through; allowed: an opaque one"));
    }
    Ok(Surface { one_sided: false, ..surface })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{fails, good};
    use super::*;
    use crate::film::Image;
    use crate::output::{Metadata, write_exr};

    fn surface(bsdf: &str) -> Bsdf {
        good(bsdf, &[]).materials[0].bsdf
    }

    #[test]
    fn kinds_become_surfaces() {
        assert_eq!(surface("<bsdf type='diffuse'/>"), Bsdf::Diffuse { albedo: Rgb::splat(0.5) });
        assert_eq!(
            surface("<bsdf type='dielectric'/>"),
            Bsdf::Dielectric { ior: (1.5046 / 1.000277) as f32 }
        );
        let named = "<bsdf type='dielectric'><string name='int_ior' value='Water'/><float name='ext_ior' value='1'/></bsdf>";
        assert_eq!(surface(named), Bsdf::Dielectric { ior: 1.333 });
        let rough = "<bsdf type='roughconductor'><string name='distribution' value='ggx'/><string name='material' value='Au'/></bsdf>";
        let Bsdf::Rough(RoughSurface { facets, interface: Interface::Conductor { eta, .. } }) =
            surface(rough)
        else {
            panic!()
        };
        assert_eq!((facets.alpha, eta), (0.1, METALS[2].eta));
        assert_eq!(surface("<bsdf type='conductor'/>"), Bsdf::Mirror { reflectance: Rgb::ONE });
        let plastic = "<bsdf type='plastic'><float name='ext_ior' value='1'/><boolean name='nonlinear' value='true'/></bsdf>";
        assert_eq!(surface(plastic), Bsdf::Plastic(Plastic::new(Rgb::splat(0.5), 1.49, true)));
        let pane = "<bsdf type='thindielectric'><string name='ext_ior' value='vacuum'/></bsdf>";
        assert_eq!(surface(pane), Bsdf::ThinDielectric { ior: 1.5046 });
        let mirror = "<bsdf type='twosided'><bsdf type='conductor'><string name='material' value='none'/></bsdf></bsdf>";
        assert_eq!(surface(mirror), Bsdf::Mirror { reflectance: Rgb::ONE });
    }

    #[test]
    fn masks_become_opacities() {
        let masked = |opacity: &str| {
            let text = format!(
                "<bsdf type='mask'>{opacity}<bsdf type='twosided'><bsdf type='diffuse'/></bsdf></bsdf>"
            );
            let material = good(&text, &[]).materials[0].clone();
            assert_eq!(material.bsdf, Bsdf::Diffuse { albedo: Rgb::splat(0.5) });
            material.opacity
        };
        assert_eq!(masked(""), 0.5);
        assert_eq!(masked("<float name='opacity' value='0.3'/>"), 0.3);
        assert_eq!(masked("<rgb name='opacity' value='0.3, 0.3, 0.3'/>"), 0.3);
        assert!((masked("<rgb name='opacity' value='1, 0, 0'/>") - 0.2126).abs() < 1e-6);
    }

    /// The picture of opacity is grey, and that of the colour below stays.
    #[test]
    fn pictures_of_opacity_stand_beside_those_of_colour() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("p.exr");
        let picture = Image::from_pixels(2, 1, vec![Rgb::Y, Rgb::ZERO]).unwrap();
        write_exr(&file, &picture, &Metadata::default()).unwrap();
        let texture = |name: &str| {
            format!(
                "<texture name='{name}' type='bitmap'><string name='filename' value='{}'/></texture>",
                file.display()
            )
        };
        let text = format!(
            "<bsdf type='mask'>{}<bsdf type='diffuse'>{}</bsdf></bsdf>",
            texture("opacity"),
            texture("reflectance")
        );
        let material = good(&text, &[]).materials[0].clone();
        let [color, opacity] =
            [material.textures.color, material.textures.opacity].map(|t| t.unwrap().image().get(0, 0));
        assert_eq!((color, opacity, material.opacity), (Rgb::Y, Rgb::splat(0.7152), 0.7152));
    }

    #[test]
    fn references_reach_any_bsdf() {
        let text = "<bsdf type='twosided' id='b'><ref id='a'/></bsdf><bsdf type='diffuse' id='a'><float name='reflectance' value='0.25'/></bsdf>";
        let materials = good(text, &[]).materials;
        assert_eq!((materials[0].name.as_str(), materials[0].bsdf), ("b", materials[1].bsdf));
        assert_eq!(materials[0].bsdf, Bsdf::Diffuse { albedo: Rgb::splat(0.25) });
    }

    #[test]
    fn what_has_no_counterpart_is_refused_by_name() {
        for (bsdf, words) in [
            ("<bsdf type='hair'/>", "bsdf `hair` is not supported; allowed: `diffuse`"),
            ("<bsdf/>", "<bsdf> has no attribute `type`"),
            (
                "<bsdf type='diffuse'><float name='roughness' value='1'/></bsdf>",
                "bsdf `diffuse`: <float> `roughness` is not supported",
            ),
            (
                "<bsdf type='diffuse'><float name='reflectance' value='2'/></bsdf>",
                "`reflectance` is 2; allowed: a number from 0 to 1",
            ),
            (
                "<bsdf type='dielectric'><string name='int_ior' value='glas'/></bsdf>",
                "`int_ior`: unknown name `glas`;",
            ),
            (
                "<bsdf type='dielectric'><float name='int_ior' value='0'/></bsdf>",
                "`int_ior` is a <float> of value `0`; allowed: <float>, a finite number above 0",
            ),
            (
                "<bsdf type='dielectric'><float name='specular_reflectance' value='0.5'/></bsdf>",
                "`specular_reflectance` other than 1",
            ),
            ("<bsdf type='roughconductor'/>", "distribution `beckmann` is not supported; allowed: `ggx`"),
            (
                "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/><float name='alpha' value='2'/></bsdf>",
                "a number from 0.001 to 1",
            ),
            (
                "<bsdf type='conductor'><string name='material' value='Ir'/></bsdf>",
                "`material`: unknown name `Ir`;",
            ),
            (
                "<bsdf type='conductor'><string name='material' value='Au'/><float name='k' value='1'/></bsdf>",
                "allowed: either",
            ),
            (
                "<bsdf type='plastic'><float name='ext_ior' value='2'/></bsdf>",
                "`int_ior` over `ext_ior` is 0.745; allowed: a number from 1 to 10",
            ),
            ("<bsdf type='twosided'/>", "wraps no bsdf"),
            (
                "<bsdf type='twosided'><bsdf type='dielectric'/></bsdf>",
                "wraps a bsdf that lets light through",
            ),
            ("<bsdf type='twosided' id='a'><ref id='a'/></bsdf>", "nested deeper than 8"),
            ("<bsdf type='twosided' id='a'><ref id='b'/></bsdf>", "ref: unknown id `b`; did you mean `a`?"),
            ("<bsdf type='diffuse' id='a'/><bsdf type='diffuse' id='a'/>", "id `a` is that of line 7, too"),
        ] {
            fails(bsdf, 7, words);
        }
    }

    #[test]
    fn masks_wrap_one_bsdf_that_is_none() {
        for (bsdf, words) in [
            ("<bsdf type='mask'/>", "bsdf `mask`: wraps no bsdf; allowed: one"),
            (
                "<bsdf type='mask'><bsdf type='diffuse'/><bsdf type='diffuse'/></bsdf>",
                "bsdf `mask`: a second <bsdf>; allowed: one",
            ),
            (
                "<bsdf type='mask'><float name='opacity' value='2'/><bsdf type='diffuse'/></bsdf>",
                "bsdf `mask`: `opacity` is 2; allowed: a number from 0 to 1",
            ),
            (
                "<bsdf type='mask'><bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf>",
                "wraps another mask; allowed: one, of the product of both opacities",
            ),
            (
                "<bsdf type='twosided'><bsdf type='mask'><bsdf type='diffuse'/></bsdf></bsdf>",
                "wraps a bsdf that lets light through",
            ),
        ] {
            fails(bsdf, 7, words);
        }
    }
}
