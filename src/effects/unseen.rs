/// Passes in a row without a photon on anything that is seen, after which a render says so. A pass has thousands of photons,
/// so with eight of them hardly more than one in ten thousand finds its way.
const PASSES_UNTIL_TOLD: u32 = 8;

/// Notices that no photon falls on what the camera sees. It says so once and changes nothing: a rare photon may yet come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Passes so far, as long as none brought a photon.
    passes_without_a_photon: u32,
    emitted: u64,
    is_over: bool,
}

impl Unseen {
    /// What to tell after a pass that emitted so many photons and added so many to hit points.
    pub fn after_pass(&mut self, emitted: u64, gathered: u64) -> Option<String> {
        if self.is_over || gathered > 0 {
            self.is_over = true;
            return None;
        }
        self.passes_without_a_photon += 1;
        self.emitted += emitted;
        if self.passes_without_a_photon < PASSES_UNTIL_TOLD {
            return None;
        }
        self.is_over = true;
        let (emitted, passes) = (self.emitted, self.passes_without_a_photon);
        Some(format!(
            "none of {emitted} photons in {passes} passes fell on anything that the camera sees: more photons a pass, or a \
             light nearer to it, may help; direct light is not affected"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(passes: impl IntoIterator<Item = u64>) -> Vec<usize> {
        let mut unseen = Unseen::default();
        let told =
            passes.into_iter().enumerate().filter_map(|(pass, n)| unseen.after_pass(1, n).map(|_| pass + 1));
        told.collect()
    }

    #[test]
    fn it_is_told_once_and_only_if_no_photon_ever_came() {
        assert_eq!(told([0; 30]), [8]);
        let mut unseen = Unseen::default();
        let words: Vec<String> = (0..9).filter_map(|_| unseen.after_pass(1000, 0)).collect();
        assert!(
            words[0].starts_with("none of 8000 photons in 8 passes fell on anything that the camera sees")
        );
        assert!(told([0; 7]).is_empty());
        for first in 0..8 {
            let told = told((0..30).map(|pass| u64::from(pass == first)));
            assert!(told.is_empty(), "a photon in pass {first}: {told:?}");
        }
        assert_eq!(told((0..30).map(|pass| u64::from(pass == 8))), [8]);
    }
}
