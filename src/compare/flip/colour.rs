use crate::math::{Rgb, Vec3};
use glam::Mat3;

/// The exponent `q_c` that compresses colour differences.
const COMPRESSION: f32 = 0.7;
/// Differences up to the share `p_c` of the largest are spread over `[0, p_t]`, larger ones over what is left.
const KNEE: f32 = 0.4;
const BELOW_KNEE: f32 = 0.95;

/// Where the cube root of CIELAB goes over into a straight line.
const LAB_DELTA: f32 = 6.0 / 29.0;

/// The colour spaces of FLIP, all relative to the white of linear sRGB.
///
/// YCxCz is the linear opponent space in which the eye's contrast sensitivity is known; in CIELAB, equal distances look
/// equally different.
pub(super) struct ColourSpaces {
    to_xyz: Mat3,
    to_rgb: Mat3,
    white: Vec3,
    largest_difference: f32,
}

impl ColourSpaces {
    pub(super) fn new() -> ColourSpaces {
        // The primaries and the white of IEC 61966-2-1 (sRGB) as fractions of XYZ.
        let to_xyz = Mat3::from_cols(
            Vec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
            Vec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
            Vec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
        );
        let white = to_xyz * Vec3::ONE;
        let spaces = ColourSpaces { to_xyz, to_rgb: to_xyz.inverse(), white, largest_difference: 1.0 };
        let largest_difference = spaces.compressed_distance(Rgb::Y, Rgb::Z);
        ColourSpaces { largest_difference, ..spaces }
    }

    pub(super) fn ycxcz(&self, rgb: Rgb) -> Vec3 {
        let xyz = self.to_xyz * rgb / self.white;
        Vec3::new(116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z))
    }

    /// The colour that a display can show next to one in YCxCz, in linear RGB.
    pub(super) fn displayed(&self, ycxcz: Vec3) -> Rgb {
        let y = (ycxcz.x + 16.0) / 116.0;
        let xyz = Vec3::new(y + ycxcz.y / 500.0, y, y - ycxcz.z / 200.0);
        (self.to_rgb * (xyz * self.white)).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// How different two displayed colours look, `ΔE_c` from 0 (the same) to 1 (green and blue).
    pub(super) fn difference(&self, a: Rgb, b: Rgb) -> f32 {
        let difference = self.compressed_distance(a, b);
        let knee = KNEE * self.largest_difference;
        if difference < knee {
            return difference * BELOW_KNEE / knee;
        }
        let beyond = (difference - knee) / (self.largest_difference - knee);
        BELOW_KNEE + beyond * (1.0 - BELOW_KNEE)
    }

    /// The HyAB distance, which suits large differences, to the power of `q_c`.
    fn compressed_distance(&self, a: Rgb, b: Rgb) -> f32 {
        let difference = self.hunt_lab(a) - self.hunt_lab(b);
        (difference.x.abs() + difference.y.hypot(difference.z)).powf(COMPRESSION)
    }

    /// CIELAB with the effect of Hunt: colours look the less colourful the darker they are.
    fn hunt_lab(&self, rgb: Rgb) -> Vec3 {
        let f = (self.to_xyz * rgb / self.white).map(lab_curve);
        let lightness = 116.0 * f.y - 16.0;
        let hunt = 0.01 * lightness;
        Vec3::new(lightness, hunt * 500.0 * (f.x - f.y), hunt * 200.0 * (f.y - f.z))
    }
}

fn lab_curve(t: f32) -> f32 {
    if t > LAB_DELTA.powi(3) { t.cbrt() } else { t / (3.0 * LAB_DELTA * LAB_DELTA) + 4.0 / 29.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_has_no_chroma_and_comes_back() {
        let spaces = ColourSpaces::new();
        let grey = spaces.ycxcz(Rgb::splat(0.5));
        assert!(grey.abs_diff_eq(Vec3::new(42.0, 0.0, 0.0), 1e-4), "{grey}");
        let colour = Rgb::new(0.2, 0.9, 0.4);
        assert!(spaces.displayed(spaces.ycxcz(colour)).abs_diff_eq(colour, 1e-5));
        assert_eq!(spaces.displayed(Vec3::new(200.0, 0.0, 0.0)), Rgb::ONE);
    }

    #[test]
    fn known_colours_of_cielab_are_met() {
        // CIELAB of the sRGB primary blue under D65: (32.297, 79.188, -107.860); Hunt scales a and b by 0.323.
        let blue = ColourSpaces::new().hunt_lab(Rgb::Z);
        let expected = Vec3::new(32.297, 0.322_97 * 79.188, 0.322_97 * -107.860);
        assert!(blue.abs_diff_eq(expected, 0.02), "{blue}");
    }

    #[test]
    fn differences_run_from_none_to_green_and_blue() {
        let spaces = ColourSpaces::new();
        assert_eq!(spaces.difference(Rgb::X, Rgb::X), 0.0);
        assert!((spaces.difference(Rgb::Y, Rgb::Z) - 1.0).abs() < 1e-6);
        let small = spaces.difference(Rgb::splat(0.5), Rgb::splat(0.51));
        assert!((0.0..0.1).contains(&small), "{small}");
    }
}
