use crate::film::Image;

/// A named picture beside the main one in the same file.
#[derive(Clone, Copy, Debug)]
pub struct ExrLayer<'a> {
    /// Its name, without a dot.
    pub name: &'a str,
    /// Under which names the channels of `image` are written.
    pub channels: LayerChannels,
    /// As large as the main picture.
    pub image: &'a Image,
}

/// The channels of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerChannels {
    /// All three, as `NAME.R`, `NAME.G` and `NAME.B`.
    Rgb,
    /// All three, as `NAME.X`, `NAME.Y` and `NAME.Z`: directions.
    Xyz,
    /// The first one, as `NAME`: values that are the same in all.
    Single,
}

impl LayerChannels {
    /// The names of the channels of a layer, in the order of the image's.
    pub(super) fn names(self, layer: &str) -> Vec<String> {
        let dotted = |channels: [&str; 3]| channels.map(|channel| format!("{layer}.{channel}")).to_vec();
        match self {
            LayerChannels::Rgb => dotted(["R", "G", "B"]),
            LayerChannels::Xyz => dotted(["X", "Y", "Z"]),
            LayerChannels::Single => vec![layer.into()],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_that_other_programs_look_for() {
        assert_eq!(LayerChannels::Rgb.names("albedo"), ["albedo.R", "albedo.G", "albedo.B"]);
        assert_eq!(LayerChannels::Xyz.names("N"), ["N.X", "N.Y", "N.Z"]);
        assert_eq!(LayerChannels::Single.names("Z"), ["Z"]);
    }
}
