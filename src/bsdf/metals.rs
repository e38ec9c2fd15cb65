use crate::math::Rgb;

/// A metal by its complex index of refraction, `eta - i k`, for red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// The symbol of the element.
    pub name: &'static str,
    /// Real part.
    pub eta: Rgb,
    /// Imaginary part.
    pub k: Rgb,
}

/// Metals that scenes name.
///
/// # Source
/// The figures are those of the renderer Tungsten (Bitterli), which has them from measured spectra.
pub const METALS: [Metal; 4] = [
    Metal {
        name: "Ag",
        eta: Rgb::new(0.155_264, 0.116_723, 0.138_381),
        k: Rgb::new(4.828_371, 3.122_250, 2.147_040),
    },
    Metal {
        name: "Al",
        eta: Rgb::new(1.657_460, 0.880_369, 0.521_229),
        k: Rgb::new(9.223_869, 6.269_523, 4.837_001),
    },
    Metal {
        name: "Au",
        eta: Rgb::new(0.143_119, 0.374_957, 1.442_479),
        k: Rgb::new(3.983_160, 2.385_721, 1.603_215),
    },
    Metal {
        name: "Cu",
        eta: Rgb::new(0.200_438, 0.924_033, 1.102_212),
        k: Rgb::new(3.912_949, 2.452_848, 2.142_188),
    },
];
