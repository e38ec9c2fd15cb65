//! MTL files: materials for meshes to which the scene file gives none.

mod statements;

pub(super) use self::statements::{Mtl, parse};

use crate::bsdf::{Bsdf, Ggx, Interface, Plastic, RoughSurface};
use crate::math::{Rgb, mean};

/// The albedo of surfaces whose material is missing.
const GREY: Rgb = Rgb::splat(0.5);
/// What stands in for a missing index of refraction: window glass.
const USUAL_IOR: f32 = 1.5;

/// The surface of triangles without a known material.
pub(super) fn grey() -> (Bsdf, Rgb) {
    (Bsdf::Diffuse { albedo: GREY }, Rgb::ZERO)
}

/// The scattering and emission of an MTL material by the table in the documentation of [`crate::scene`].
///
/// `label` names the material in warnings.
pub(super) fn surface(m: &Mtl, label: &str, warnings: &mut Vec<String>) -> (Bsdf, Rgb) {
    let mut clamped = |name: &str, color: Option<Rgb>, most: f32| {
        let color = color?;
        let inside = color.map(|c| if c.is_nan() { 0.0 } else { c.clamp(0.0, most) });
        if inside != color {
            warnings.push(format!("{label}: {name} is {color}; clamped to {inside}"));
        }
        Some(inside)
    };
    let colors = Colors { kd: clamped("Kd", m.kd, 1.0), ks: clamped("Ks", m.ks, 1.0).unwrap_or(Rgb::ZERO) };
    let emission = clamped("Ke", m.ke, f32::MAX).unwrap_or(Rgb::ZERO);
    let mut choice = Choice { m, colors, label, warnings };
    let bsdf = choice.bsdf();
    if m.map_kd.is_some() {
        warnings.push(format!("{label}: map_Kd is not read; the colour Kd counts"));
    }
    (bsdf, emission)
}

/// The opacity of an MTL material by `d` or `Tr`, which glass has no use for: from 0 to 1.
pub(super) fn opacity(m: &Mtl, bsdf: &Bsdf, label: &str, warnings: &mut Vec<String>) -> f32 {
    let by_tr = m.tr.map(|tr| 1.0 - tr);
    let mut tell = |what: &str| warnings.push(format!("{label}: {what}"));
    if let (Some(d), Some(by_tr)) = (m.d, by_tr)
        && (d - by_tr).abs() > 1e-3
    {
        tell(&format!("d {d} and Tr {} contradict each other, since d = 1 - Tr; d counts", 1.0 - by_tr));
    }
    if m.map_d.is_some() {
        tell("map_d is not read; the opacity d counts");
    }
    let given = m.d.or(by_tr).filter(|_| !bsdf.transmits()).unwrap_or(1.0);
    let opacity = if given.is_nan() { 1.0 } else { given.clamp(0.0, 1.0) };
    if opacity != given {
        tell(&format!("opacity {given} by d or Tr; clamped to {opacity}"));
    }
    opacity
}

/// Within 0 to 1.
#[derive(Clone, Copy)]
struct Colors {
    kd: Option<Rgb>,
    ks: Rgb,
}

/// The way from statements to a surface.
struct Choice<'a> {
    m: &'a Mtl,
    colors: Colors,
    label: &'a str,
    warnings: &'a mut Vec<String>,
}

impl Choice<'_> {
    fn tell(&mut self, what: &str) {
        self.warnings.push(format!("{}: {what}", self.label));
    }

    fn bsdf(&mut self) -> Bsdf {
        let Colors { kd, ks } = self.colors;
        let outshines = mean(ks) > mean(kd.unwrap_or(Rgb::ZERO));
        match self.m.illum {
            Some(4 | 6 | 7 | 9) => self.glass(),
            Some(3) => self.mirror(),
            Some(5) if outshines => self.mirror(),
            _ if self.m.pm.is_some_and(|pm| pm > 0.5) => self.metal_of_its_colour(),
            None | Some(2) if ks != Rgb::ZERO && outshines => self.glossy(),
            None | Some(2) if ks != Rgb::ZERO => self.coated(),
            _ => self.diffuse(),
        }
    }

    fn diffuse(&mut self) -> Bsdf {
        if self.m.pr.is_some() {
            self.tell("Pr has no meaning for a diffuse surface; not used");
        }
        let albedo = self.colors.kd.unwrap_or_else(|| {
            self.tell("no Kd; diffuse grey 0.5");
            GREY
        });
        Bsdf::Diffuse { albedo }
    }

    fn glass(&mut self) -> Bsdf {
        let given = self.m.ni.filter(|ior| *ior > 0.0 && ior.is_finite());
        let ior = given.unwrap_or_else(|| {
            self.tell(&format!("no Ni above 0; {USUAL_IOR} instead"));
            USUAL_IOR
        });
        if self.m.tf.is_some_and(|tf| tf != Rgb::ONE) {
            self.tell("Tf is not used: glass is clear here, and loses light by Fresnel's law alone");
        }
        match self.facets() {
            Some(facets) => Bsdf::Rough(RoughSurface { facets, interface: Interface::Dielectric { ior } }),
            None => Bsdf::Dielectric { ior },
        }
    }

    fn mirror(&mut self) -> Bsdf {
        let reflectance = self.colors.ks;
        if self.colors.kd.is_some_and(|kd| kd != Rgb::ZERO) {
            self.tell("Kd beside a mirror is not used");
        }
        match self.facets() {
            Some(facets) => metal(facets, reflectance),
            None => Bsdf::Mirror { reflectance },
        }
    }

    /// Of Pm: metals have their colour from Kd.
    fn metal_of_its_colour(&mut self) -> Bsdf {
        let reflectance = self.colors.kd.unwrap_or(GREY);
        match self.facets() {
            Some(facets) => metal(facets, reflectance),
            None => Bsdf::Mirror { reflectance },
        }
    }

    /// Phong's highlight where it is most of the surface: facets whose slopes spread as far.
    ///
    /// # Source
    /// Walter, Marschner, Li and Torrance, EGSR 2007, section 5.2: `α² = 2 / (Ns + 2)`.
    fn glossy(&mut self) -> Bsdf {
        let ns = self.m.ns.filter(|ns| *ns >= 0.0).unwrap_or(0.0);
        let facets = self.facets().unwrap_or(Ggx { alpha: (2.0 / (ns + 2.0)).sqrt().max(Ggx::LEAST_ALPHA) });
        self.tell(&format!(
            "Ks above Kd: metal of reflectance Ks and roughness {}; Kd is not used",
            facets.alpha
        ));
        metal(facets, self.colors.ks)
    }

    /// Phong's highlight on a colour: a smooth coat.
    fn coated(&mut self) -> Bsdf {
        let given = self.m.ni.filter(|ior| *ior > 1.0 && *ior <= MOST_COAT);
        let ior = given.unwrap_or(USUAL_IOR);
        self.tell(&format!(
            "Ks on Kd: a smooth coat of index {ior}, which mirrors by Fresnel's law; Ks and Ns are not used"
        ));
        Bsdf::Plastic(Plastic::new(self.colors.kd.unwrap_or(Rgb::ZERO), ior, false))
    }

    /// By Pr, which is perceptual: the roughness is its square. None where it is smooth.
    fn facets(&mut self) -> Option<Ggx> {
        let pr = self.m.pr.filter(|pr| *pr > 0.0)?;
        let alpha = (pr * pr).min(1.0);
        (alpha >= Ggx::LEAST_ALPHA).then_some(Ggx { alpha })
    }
}

/// The largest index of a coat.
const MOST_COAT: f32 = 10.0;

/// A metal that mirrors the share `reflectance` from everywhere, by facets.
fn metal(facets: Ggx, reflectance: Rgb) -> Bsdf {
    // With these Fresnel's law gives 1 at every angle.
    let interface = Interface::Conductor { eta: Rgb::ZERO, k: Rgb::ONE, reflectance };
    Bsdf::Rough(RoughSurface { facets, interface })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// The surfaces of an MTL text, and the warnings about them.
    fn surfaces(text: &str) -> (Vec<(Bsdf, Rgb)>, Vec<String>) {
        let mut warnings = Vec::new();
        let materials = parse(Path::new("m.mtl"), text, &mut warnings);
        let surfaces = materials.iter().map(|m| surface(m, &m.name, &mut warnings)).collect();
        (surfaces, warnings)
    }

    fn one(statements: &str) -> (Bsdf, Rgb, Vec<String>) {
        let (surfaces, warnings) = surfaces(&format!("newmtl a\n{statements}"));
        let [(bsdf, emission)] = surfaces[..] else { panic!("{surfaces:?}") };
        (bsdf, emission, warnings)
    }

    #[test]
    fn each_row_of_the_table_holds() {
        let half = Rgb::splat(0.5);
        let diffuse = |albedo| Bsdf::Diffuse { albedo };
        let mirror = Bsdf::Mirror { reflectance: half };
        for (text, expected) in [
            ("Kd 0.1 0.2 0.3", diffuse(Rgb::new(0.1, 0.2, 0.3))),
            ("Kd 0.25 # grey", diffuse(Rgb::splat(0.25))),
            ("Kd 0 0 0\nKs .5 .5 .5\nillum 1", diffuse(Rgb::ZERO)),
            ("Kd 0 0 0\nKs .5 .5 .5\nillum 3", mirror),
            ("Ks .5 .5 .5\nillum 3\nPr 0.5", metal(Ggx { alpha: 0.25 }, half)),
            ("Kd .5 .5 .5\nPm 1\nPr 0.01", mirror),
            (
                "Ni 1.25\nillum 7\nPr 0.2",
                Bsdf::Rough(RoughSurface {
                    facets: Ggx { alpha: 0.2 * 0.2 },
                    interface: Interface::Dielectric { ior: 1.25 },
                }),
            ),
            ("Kd 0.5\nd 1\nTr 0", diffuse(half)),
            ("Kd 0 0 0\nKs .5 .5 .5\nillum 5", mirror),
            ("Ks .5 .5 .5\nillum 5", mirror),
            ("Kd .5 .5 .5\nKs .5 .5 .5\nillum 5", diffuse(half)),
            ("Ni 1.25\nillum 4", Bsdf::Dielectric { ior: 1.25 }),
            ("Ni 1.25\nillum 6", Bsdf::Dielectric { ior: 1.25 }),
            ("\tillum 7\r\n\tNi 1.25\r\n", Bsdf::Dielectric { ior: 1.25 }),
            ("Ni 1.25\nillum 9", Bsdf::Dielectric { ior: 1.25 }),
        ] {
            assert_eq!(one(text), (expected, Rgb::ZERO, Vec::new()), "{text}");
        }
        assert_eq!(one("Kd 0 0 0\nKe 5 6 7").1, Rgb::new(5.0, 6.0, 7.0));
    }

    #[test]
    fn repairs_leave_a_warning() {
        let grey = Bsdf::Diffuse { albedo: GREY };
        let albedo = |r, g, b| Bsdf::Diffuse { albedo: Rgb::new(r, g, b) };
        let mirror = Bsdf::Mirror { reflectance: Rgb::splat(0.5) };
        for (text, expected, words) in [
            ("", grey, "a: no Kd"),
            ("Ka 1 1 1", grey, "m.mtl: read, but of no use here: Ka"),
            ("Kd .1 .1 .1\nKs .5 .5 .5\nillum 3", mirror, "a: Kd beside a mirror"),
            ("Kd .01 .01 .01\nKs .5 .5 .5\nillum 5", mirror, "a: Kd beside a mirror"),
            (
                "Kd .1 .1 .1\nKs .5 .5 .5\nNs 6",
                metal(Ggx { alpha: 0.5 }, Rgb::splat(0.5)),
                "a: Ks above Kd: metal of reflectance Ks and roughness 0.5",
            ),
            (
                "Kd .5 .5 .5\nKs .25 .25 .25\nillum 2\nNi 2",
                Bsdf::Plastic(Plastic::new(Rgb::splat(0.5), 2.0, false)),
                "a: Ks on Kd: a smooth coat of index 2",
            ),
            ("illum 7\nNi 1.5\nTf .1 .1 .1", Bsdf::Dielectric { ior: 1.5 }, "a: Tf is not used"),
            ("Kd 0.25\nPr 0.5", albedo(0.25, 0.25, 0.25), "a: Pr has no meaning"),
            (
                "Kd 0 0 0\nmap_Bump a.png",
                albedo(0.0, 0.0, 0.0),
                "m.mtl:3: `map_Bump a.png` is not supported; allowed: newmtl, Kd",
            ),
            ("illum 7", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("illum 7\nNi 0", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("illum 7\nNi inf", Bsdf::Dielectric { ior: 1.5 }, "a: no Ni"),
            ("Kd 1.5 -1 nan", albedo(1.0, 0.0, 0.0), "a: Kd is [1.5, -1, NaN]; clamped"),
            ("Kd .1 .1 .1\nKd 1 1", albedo(0.1, 0.1, 0.1), "m.mtl:3: `Kd 1 1`; allowed: three numbers"),
            ("Kd spectral x.rfl", grey, "m.mtl:2: `Kd spectral"),
            ("Kd 0 0 0\nillum x", albedo(0.0, 0.0, 0.0), "m.mtl:3: `illum x`; allowed: 0 to 255"),
            ("Kd 0 0 0\nillum", albedo(0.0, 0.0, 0.0), "m.mtl:3: `illum`"),
            ("Kd 0 0 0\nNi", albedo(0.0, 0.0, 0.0), "m.mtl:3: `Ni`; allowed: a number"),
            ("Kd 0 0 0\nmap_Kd wood.png", albedo(0.0, 0.0, 0.0), "a: map_Kd is not read"),
        ] {
            let (bsdf, _, warnings) = one(text);
            assert_eq!(bsdf, expected, "{text}");
            assert!(warnings[0].contains(words), "{text}: {warnings:?}");
        }
        assert_eq!(one("Kd 0 0 0\nKe -5 6 inf").1, Rgb::new(0.0, 6.0, f32::MAX));
    }

    #[test]
    fn opacity_is_d_or_what_tr_leaves() {
        let of = |statements: &str| {
            let mut warnings = Vec::new();
            let materials =
                parse(Path::new("m.mtl"), &format!("newmtl a\nKd 0\n{statements}"), &mut warnings);
            let (bsdf, _) = surface(&materials[0], "a", &mut warnings);
            (opacity(&materials[0], &bsdf, "a", &mut warnings), warnings.join("; "))
        };
        for (statements, expected, words) in [
            ("", 1.0, ""),
            ("d 0.5", 0.5, ""),
            ("Tr 0.25", 0.75, ""),
            ("d 0.5\nTr 0.5", 0.5, ""),
            ("illum 7\nNi 1.5\nd 0.5", 1.0, ""),
            ("d 1\nTr 1", 1.0, "a: d 1 and Tr 1 contradict each other, since d = 1 - Tr; d counts"),
            ("d 0\nmap_d leaf.png", 0.0, "a: map_d is not read; the opacity d counts"),
            ("d -1", 0.0, "a: opacity -1 by d or Tr; clamped to 0"),
            ("Tr nan", 1.0, "a: opacity NaN by d or Tr; clamped to 1"),
        ] {
            assert_eq!(of(statements), (expected, words.into()), "{statements}");
        }
    }

    #[test]
    fn an_unnamed_material_does_not_change_the_one_before() {
        let (surfaces, _) = surfaces("newmtl a\nKd 0 0 0\nnewmtl\nKd 1 1 1\nmap_Kd\n");
        assert_eq!(surfaces[0].0, Bsdf::Diffuse { albedo: Rgb::ZERO });
        assert_eq!(surfaces.len(), 2);
    }
}
