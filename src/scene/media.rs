//! What lies inside of glass and water: media that absorb light on its way, by the law of Beer and Lambert.
//!
//! A path knows the bodies that it went into and not out of again. It absorbs by the one that it entered last, whatever lies around
//! that: so glass in water absorbs as glass, and an air bubble in water, a body of its own, as air.

use super::desc::Material;
use crate::math::{Rgb, Vec3};

/// The media around a point of a path, innermost last: up to four, of which those entered first are forgotten beyond that.
///
/// Each takes a byte, the innermost the lowest; 0 is none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Media(u32);

impl Media {
    /// Outside of all bodies.
    pub const NONE: Media = Media(0);

    pub(super) const DEPTH: u32 = 4;

    /// The number of the innermost medium.
    pub(super) fn top(self) -> usize {
        (self.0 & 0xff) as usize
    }

    pub(super) fn enter(self, medium: u8) -> Media {
        Media(self.0 << 8 | u32::from(medium))
    }

    /// Without the innermost one of that number, if it is there.
    pub(super) fn leave(self, medium: u8) -> Media {
        let at = |level: &u32| self.0 >> (8 * level) & 0xff == u32::from(medium);
        let Some(level) = (0..Media::DEPTH).find(at) else { return self };
        let inner = self.0 & ((1 << (8 * level)) - 1);
        let outer = if level + 1 < Media::DEPTH { self.0 >> (8 * (level + 1)) } else { 0 };
        Media(outer << (8 * level) | inner)
    }
}

/// Most different absorptions of a scene: what a byte can number.
pub(super) const MOST_MEDIA: usize = 255;

/// The media of a scene; empty where nothing absorbs.
#[derive(Clone, Debug, Default)]
pub(super) struct Absorbers {
    /// The number of what lies inside of each material; 0 where it has no inside.
    pub of_material: Vec<u8>,
    /// `σ` by number (1 / scene unit); that of no medium is 0.
    pub sigmas: Vec<Rgb>,
    /// The way out, unit: see [`super::Scene::media_at`].
    pub outward: Vec3,
    /// Where the camera is.
    pub camera: Media,
    /// Whether some light may lie in a body that absorbs.
    pub hold_lights: bool,
}

impl Absorbers {
    /// Bodies that absorb alike have one number.
    pub fn of(materials: &[Material]) -> Absorbers {
        if materials.iter().all(|material| material.inside().is_none_or(|sigma| sigma == Rgb::ZERO)) {
            return Absorbers::default();
        }
        let mut sigmas = vec![Rgb::ZERO];
        let number = |material: &Material| {
            let Some(sigma) = material.inside() else { return 0 };
            let known = sigmas.iter().skip(1).position(|known| *known == sigma);
            let number = known.map_or(sigmas.len(), |known| known + 1).min(MOST_MEDIA);
            if number == sigmas.len() {
                sigmas.push(sigma);
            }
            number as u8
        };
        let of_material = materials.iter().map(number).collect();
        Absorbers { of_material, sigmas, ..Absorbers::default() }
    }

    pub fn are_any(&self) -> bool {
        !self.sigmas.is_empty()
    }
}

/// How many media of different absorption the materials hold, clear ones among them; none where all are clear.
pub(super) fn count(materials: &[Material]) -> usize {
    let mut insides: Vec<[u32; 3]> = materials
        .iter()
        .filter_map(Material::inside)
        .map(|sigma| (sigma + 0.0).to_array().map(f32::to_bits))
        .collect();
    insides.sort_unstable();
    insides.dedup();
    if insides == [[0; 3]] { 0 } else { insides.len() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entered(media: &[u8]) -> Media {
        media.iter().fold(Media::NONE, |all, &medium| all.enter(medium))
    }

    #[test]
    fn the_last_one_entered_counts_until_it_is_left() {
        let both = entered(&[1, 2]);
        assert_eq!((both.top(), both.leave(2).top(), both.leave(2).leave(1)), (2, 1, Media::NONE));
        assert_eq!(both.leave(1), entered(&[2]), "bodies that overlap");
        assert_eq!(both.leave(3), both, "a body that was not entered");
        assert_eq!(Media::NONE.leave(7), Media::NONE);
        assert_eq!(entered(&[3, 3]).leave(3), entered(&[3]), "bodies of one kind in each other");
    }

    /// Beyond four the outermost is forgotten.
    #[test]
    fn four_media_are_known() {
        let five = entered(&[1, 2, 3, 4, 255]);
        assert_eq!(five, entered(&[2, 3, 4, 255]));
        assert_eq!(five.leave(2), entered(&[3, 4, 255]));
        assert_eq!(five.leave(255).leave(4).leave(3).leave(2).leave(1), Media::NONE);
    }
}
