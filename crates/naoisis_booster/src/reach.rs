//! The network on which Booster programs find their robots.

use bevy::prelude::*;
use naoisis_core::knowledge::Knowledge;

/// The network and the domain of DDS: by default the loopback interface and domain 0.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Reach {
    /// The domain of DDS.
    pub domain: u16,
    /// Whether it speaks on all network interfaces, not on the loopback interface alone.
    pub network: bool,
}
