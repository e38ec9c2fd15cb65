use serde::Serialize;

use super::FluxLedger;

/// Where the photons of a pass went. Every photon emitted ends in exactly one of the four ways below it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Ledger {
    /// Photons emitted: the count that flux is normalised by.
    pub emitted: u64,
    /// Ended by roulette at a surface.
    pub absorbed: u64,
    /// Left the scene.
    pub escaped: u64,
    /// Cut at the longest allowed path.
    pub terminated: u64,
    /// Dropped because their power was black or not finite.
    pub dropped: u64,
    /// Rays traced.
    pub rays: u64,
    /// Places where a photon was stored on a diffuse surface.
    pub deposited: u64,
    /// What they carried.
    pub flux: FluxLedger,
}

impl Ledger {
    /// The sum of two ledgers.
    pub fn plus(self, other: Ledger) -> Ledger {
        Ledger {
            emitted: self.emitted + other.emitted,
            absorbed: self.absorbed + other.absorbed,
            escaped: self.escaped + other.escaped,
            terminated: self.terminated + other.terminated,
            dropped: self.dropped + other.dropped,
            rays: self.rays + other.rays,
            deposited: self.deposited + other.deposited,
            flux: self.flux.plus(other.flux),
        }
    }

    /// Whether every photon is accounted for, and the flux of all; see [`FluxLedger::is_balanced`].
    pub fn is_balanced(&self) -> bool {
        let ended = self.absorbed + self.escaped + self.terminated + self.dropped;
        self.emitted == ended && self.flux.is_balanced(self.emitted)
    }
}
