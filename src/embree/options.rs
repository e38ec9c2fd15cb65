use super::sys;

/// How much time Embree may take to build for faster queries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BuildQuality {
    /// By Morton codes, in a tree for each geometry.
    Low,
    /// By the surface area heuristic.
    Medium,
    /// By the surface area heuristic, with triangles split where that pays. Embree splits none in robust scenes: those
    /// get the tree of [`BuildQuality::Medium`].
    #[default]
    High,
}

/// How Embree builds and asks a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SceneOptions {
    /// The quality of the tree.
    pub quality: BuildQuality,
    /// Whether no ray may slip through between adjacent triangles.
    pub robust: bool,
}

impl Default for SceneOptions {
    /// Fast queries without cracks.
    fn default() -> SceneOptions {
        SceneOptions { quality: BuildQuality::High, robust: true }
    }
}

impl SceneOptions {
    pub(super) fn raw_quality(self) -> sys::RTCBuildQuality {
        match self.quality {
            BuildQuality::Low => sys::RTC_BUILD_QUALITY_LOW,
            BuildQuality::Medium => sys::RTC_BUILD_QUALITY_MEDIUM,
            BuildQuality::High => sys::RTC_BUILD_QUALITY_HIGH,
        }
    }

    pub(super) fn raw_flags(self) -> sys::RTCSceneFlags {
        if self.robust { sys::RTC_SCENE_FLAG_ROBUST } else { sys::RTC_SCENE_FLAG_NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Device, Scene, SceneBuilder};
    use super::*;
    use crate::math::{Ray, Rng, Stream, Vec3, warp};

    const QUALITIES: [BuildQuality; 3] = [BuildQuality::Low, BuildQuality::Medium, BuildQuality::High];

    fn all_options() -> Vec<SceneOptions> {
        let with = |quality| [false, true].map(|robust| SceneOptions { quality, robust });
        QUALITIES.into_iter().flat_map(with).collect()
    }

    fn rng(index: u64) -> Rng {
        Rng::new(5, Stream::Test, 0, index)
    }

    fn point_in_cube(rng: &mut Rng) -> Vec3 {
        Vec3::new(rng.next_f32(), rng.next_f32(), rng.next_f32())
    }

    /// Long thin triangles, each of them `copies` times in a row.
    fn splinters(copies: u32, options: SceneOptions) -> Scene {
        let corners = (0..1000).flat_map(|index| {
            let mut rng = rng(index << 32);
            let (a, b) = (point_in_cube(&mut rng), point_in_cube(&mut rng));
            [a, b, b + 0.1 * point_in_cube(&mut rng)]
        });
        let triangles: Vec<[u32; 3]> =
            (0..1000 * copies).map(|k| 3 * (k / copies)).map(|first| [first, first + 1, first + 2]).collect();
        let mut builder = SceneBuilder::with_options(&Device::new().unwrap(), options).unwrap();
        builder.add_triangles(&corners.collect::<Vec<_>>(), &triangles).unwrap();
        builder.commit().unwrap()
    }

    fn hits(scene: &Scene) -> Vec<Option<u32>> {
        let ray = |index| {
            let mut rng = rng(index);
            Ray::new(point_in_cube(&mut rng), warp::square_to_uniform_sphere(rng.next_vec2()))
        };
        (0..20_000).map(|index| scene.intersect(&ray(index)).map(|hit| hit.primitive)).collect()
    }

    #[test]
    fn scenes_of_all_options_are_hit_alike() {
        let expected = hits(&splinters(1, SceneOptions::default()));
        assert!(expected.iter().flatten().count() > 5000);
        for options in all_options() {
            let found = hits(&splinters(1, options));
            let different = found.iter().zip(&expected).filter(|(a, b)| a != b).count();
            assert!(different < 5, "{options:?}: {different} rays");
        }
    }

    /// Which one of equal triangles is hit depends on the tree, and on nothing else.
    #[test]
    fn every_option_reaches_embree() {
        let winners = |quality, robust| hits(&splinters(3, SceneOptions { quality, robust }));
        let [low, medium, high] = QUALITIES.map(|quality| winners(quality, false));
        assert!(low != medium && medium != high && high != low);
        let robust = winners(BuildQuality::High, true);
        assert!(robust != high);
        assert_eq!(robust, winners(BuildQuality::Medium, true), "robust trees are never split");
        assert_eq!(robust, hits(&splinters(3, SceneOptions::default())));
    }
}
