/// How much light becomes how much brightness of a display, before its gamma.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Curve {
    /// `y = x`: what is brighter than white is white.
    #[default]
    Plain,
    /// `y = x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14)`, at most 1: dark tones keep their contrast, highlights fade to white,
    /// which is reached at 7.24. It is a fit to the film-like rendering of the Academy Color Encoding System (ACES).
    ///
    /// # Source
    /// Narkowicz, "ACES Filmic Tone Mapping Curve", 2016.
    Filmic,
}

/// All light beyond is white; its square is still a number.
const WHITE: f32 = 1e4;

impl Curve {
    /// The brightness in `[0, 1]` for so much light; 0 for none, for less than none and for NaN.
    pub fn apply(self, light: f32) -> f32 {
        let x = if light > 0.0 { light.min(WHITE) } else { 0.0 };
        match self {
            Curve::Plain => x.min(1.0),
            Curve::Filmic => (x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const CURVES: [Curve; 2] = [Curve::Plain, Curve::Filmic];

    proptest! {
        #[test]
        fn more_light_is_no_darker(bits in any::<[u32; 2]>()) {
            let [a, b] = bits.map(f32::from_bits);
            prop_assume!(a <= b);
            for curve in CURVES {
                let (dark, bright) = (curve.apply(a), curve.apply(b));
                prop_assert!(dark <= bright, "{a} becomes {dark}, {b} {bright}");
                prop_assert!((0.0..=1.0).contains(&dark) && (0.0..=1.0).contains(&bright));
            }
        }
    }

    #[test]
    fn ends_are_black_and_white_and_nothing_is_no_number() {
        for curve in CURVES {
            assert_eq!([0.0, -0.0, -1.0, f32::NEG_INFINITY, f32::NAN].map(|x| curve.apply(x)), [0.0; 5]);
            assert_eq!([8.0, f32::MAX, f32::INFINITY].map(|x| curve.apply(x)), [1.0; 3]);
        }
    }

    /// By hand: 0.18 (2.51 · 0.18 + 0.03) / (0.18 (2.43 · 0.18 + 0.59) + 0.14) = 0.086724 / 0.324932.
    #[test]
    fn the_filmic_curve_is_the_published_one() {
        for (x, y) in [(0.18, 0.26690), (1.0, 0.80380), (7.2, 0.99981)] {
            assert!((Curve::Filmic.apply(x) - y).abs() < 2e-5, "{x}: {}", Curve::Filmic.apply(x));
        }
    }
}
