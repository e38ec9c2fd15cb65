use super::flights::{FlightPacket, lanes_of};
use super::photon_media::PhotonMedia;
use crate::simd::Mask;

/// By the numbers of the paths, whether nothing but specular events lies behind each: then its photon makes a caustic.
/// Empty where no surface is specular.
#[derive(Debug, Default)]
pub(super) struct Pasts {
    specular: Vec<bool>,
    pub media: PhotonMedia,
}

impl Pasts {
    pub fn begin(&mut self, paths: usize) {
        self.specular.clear();
        self.specular.resize(paths, true);
    }

    /// Who of a packet has such a past.
    pub fn specular(&self, photons: &FlightPacket) -> Mask {
        if self.specular.is_empty() {
            return 0;
        }
        let lanes = photons.path.iter().enumerate().take(photons.rays.len);
        lanes.fold(0, |mask, (lane, &path)| mask | Mask::from(self.specular[path as usize]) << lane)
    }

    pub fn is_specular(&self, path: u32) -> bool {
        self.specular.get(path as usize).is_some_and(|&specular| specular)
    }

    /// Notes a bounce that is not specular.
    pub fn bounce(&mut self, photons: &FlightPacket, lanes: Mask) {
        if !self.specular.is_empty() {
            lanes_of(lanes).for_each(|lane| self.specular[photons.path[lane] as usize] = false);
        }
    }
}
