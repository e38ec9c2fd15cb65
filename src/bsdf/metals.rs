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
    Metal { name: "Ag", eta: Rgb::new(0.1553, 0.1167, 0.1384), k: Rgb::new(4.8284, 3.1223, 2.1470) },
    Metal { name: "Al", eta: Rgb::new(1.6575, 0.8804, 0.5212), k: Rgb::new(9.2239, 6.2695, 4.8370) },
    Metal { name: "Au", eta: Rgb::new(0.1431, 0.3750, 1.4425), k: Rgb::new(3.9832, 2.3857, 1.6032) },
    Metal { name: "Cu", eta: Rgb::new(0.2004, 0.9240, 1.1022), k: Rgb::new(3.9129, 2.4528, 2.1422) },
];
