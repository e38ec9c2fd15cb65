//! What theory says of a configuration.

use serde::Serialize;

use super::{Configuration, Method};
use crate::ppm::Settings;

/// How fast errors ought to fall with the steps: exponents of the relative root-mean-square error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Theory {
    /// Of the noise: half that of the variance, which is `N^-α` where radii follow `α`.
    pub noise: f64,
    /// Of the bias, which goes with the area of the discs, `N^-(1-α)` there; `None` where there is none.
    pub bias: Option<f64>,
}

impl Theory {
    /// # Source
    /// Knaus and Zwicker, "Progressive Photon Mapping: A Probabilistic Approach", ACM Transactions on Graphics 30(3), 2011.
    pub fn of(configuration: &Configuration) -> Theory {
        let Settings { alpha, policy, .. } = configuration.settings;
        match configuration.method {
            Method::PhotonMapping => {
                let [noise, bias] = policy.exponents(alpha);
                Theory { noise, bias: Some(bias) }
            }
            Method::Reference(_) => Theory { noise: 0.5, bias: None },
        }
    }
}
