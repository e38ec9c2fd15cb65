use std::fmt;

use serde::{Serialize, Serializer};

/// What a scene can ask of this renderer: a closed set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effect {
    /// Surfaces scatter light diffusely: they receive photons and are seen by them.
    Diffuse,
    /// Surfaces mirror.
    SpecularReflection,
    /// Surfaces refract.
    SpecularTransmission,
    /// Surfaces are rough: they mirror or refract by facets.
    Glossy,
    /// Surfaces let light pass as if nothing were there.
    Mask,
    /// Bodies absorb light on its way through them.
    Absorption,
    /// Pictures on surfaces.
    Texture,
    /// Lamps that the camera may see.
    Emission,
    /// Lights without extent.
    DeltaLight,
    /// Lights with an extent.
    AreaLight,
    /// Light from all around.
    Environment,
    /// The camera has a lens: what is out of focus blurs.
    Lens,
    /// The film weighs the light around a pixel.
    AreaFilter,
}

impl Effect {
    /// All of them, in the order of the variants.
    pub const ALL: [Effect; 13] = [
        Effect::Diffuse,
        Effect::SpecularReflection,
        Effect::SpecularTransmission,
        Effect::Glossy,
        Effect::Mask,
        Effect::Absorption,
        Effect::Texture,
        Effect::Emission,
        Effect::DeltaLight,
        Effect::AreaLight,
        Effect::Environment,
        Effect::Lens,
        Effect::AreaFilter,
    ];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Effect::Diffuse => "diffuse reflection",
            Effect::SpecularReflection => "specular reflection",
            Effect::SpecularTransmission => "specular transmission",
            Effect::Glossy => "rough surfaces",
            Effect::Mask => "masks",
            Effect::Absorption => "absorption",
            Effect::Texture => "textures",
            Effect::Emission => "lamps in the picture",
            Effect::DeltaLight => "point lights",
            Effect::AreaLight => "area lights",
            Effect::Environment => "environment",
            Effect::Lens => "lens",
            Effect::AreaFilter => "pixel filter",
        }
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for Effect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// A set of effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EffectSet {
    /// One bit each, by the order of the variants.
    bits: u16,
}

impl EffectSet {
    /// No effect.
    pub const NONE: EffectSet = EffectSet { bits: 0 };

    /// Whether `effect` is one of them.
    pub fn contains(self, effect: Effect) -> bool {
        self.bits & bit(effect) != 0
    }

    /// Those in either.
    pub fn union(self, other: EffectSet) -> EffectSet {
        EffectSet { bits: self.bits | other.bits }
    }

    /// The same with `effect` if it `is_needed`.
    pub fn with(self, effect: Effect, is_needed: bool) -> EffectSet {
        if is_needed { EffectSet { bits: self.bits | bit(effect) } } else { self }
    }

    /// Those that it contains, in the order of [`Effect::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Effect> {
        Effect::ALL.into_iter().filter(move |effect| self.contains(*effect))
    }
}

fn bit(effect: Effect) -> u16 {
    1 << effect as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_what_was_put_in() {
        for (effect, number) in Effect::ALL.into_iter().zip(0..) {
            assert_eq!(effect as i32, number);
            let set = EffectSet::NONE.with(effect, true);
            assert!(set.iter().eq([effect]) && EffectSet::NONE.with(effect, false) == EffectSet::NONE);
        }
        let set = EffectSet::NONE.with(Effect::Lens, true).union(EffectSet::NONE.with(Effect::Diffuse, true));
        assert!(set.iter().eq([Effect::Diffuse, Effect::Lens]));
    }
}
