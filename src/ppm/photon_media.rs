//! Which bodies the photons of a chunk are in, and what those absorb of their power on the way.

use super::FluxLedger;
use super::flights::{FlightPacket, Flights};
use crate::scene::{HitPacket, Media, Scene, SurfaceHit};

/// By the numbers of the paths; empty where nothing absorbs.
#[derive(Debug, Default)]
pub(super) struct PhotonMedia {
    of_path: Vec<Media>,
}

impl PhotonMedia {
    /// Photons that leave their lights, of so many paths.
    pub fn begin(&mut self, scene: &Scene, paths: usize, flights: &Flights) {
        self.of_path.clear();
        if scene.absorbs() {
            self.of_path.resize(paths, Media::NONE);
            for (path, origin) in flights.starts() {
                self.of_path[path as usize] = scene.light_media(origin);
            }
        }
    }

    /// Takes from photons that reach surfaces what was absorbed on their way.
    pub fn attenuate(
        &self,
        scene: &Scene,
        photons: &mut FlightPacket,
        hits: &HitPacket,
        flux: &mut FluxLedger,
    ) {
        if self.of_path.is_empty() {
            return;
        }
        for lane in 0..photons.rays.len {
            let media = self.of_path[photons.path[lane] as usize];
            let Some(hit) = hits.hit(lane).filter(|_| media != Media::NONE) else { continue };
            let power = photons.power(lane);
            let left = power * scene.transmittance(media, hit.t);
            flux.absorb(power.as_dvec3() - left.as_dvec3());
            photons.set_power(lane, left);
        }
    }

    /// Notes that a photon goes on behind the surface at `hit`.
    pub fn cross(&mut self, scene: &Scene, path: u32, hit: &SurfaceHit) {
        if let Some(media) = self.of_path.get_mut(path as usize) {
            *media = scene.crossed(*media, hit);
        }
    }
}
