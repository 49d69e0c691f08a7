//! The policies in the program: each is a behaviour, and a team of robots with this behaviour.

use bevy::prelude::*;
use std::sync::{Arc, LazyLock};

use super::LoadedPolicy;
use naoisis_core::behaviour::{BehaviourApp, BehaviourRegistry, Policy};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::BehaviourRandom;
use naoisis_sensing::belief::{Belief, SimpleBelief};

/// The names of the policies, in place of a path.
const LEARNED: &str = "learned";
const PASSERS_CLONE: &str = "passers_clone";

/// Marks a robot whose policy learned to play in teams of three, by imitation and by play against itself.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, BehaviourRandom, Policy = Policy(LEARNED.to_owned()))]
#[reflect(Component, @Knowledge::Belief)]
struct Learned;

/// Marks a robot whose policy learned from demonstrations of the team `passers`.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[require(Belief, SimpleBelief, BehaviourRandom, Policy = Policy(PASSERS_CLONE.to_owned()))]
#[reflect(Component, @Knowledge::Belief)]
struct PassersClone;

/// Adds the behaviours and teams.
pub(super) fn add(app: &mut App) {
    app.register_type::<Learned>()
        .register_type::<PassersClone>()
        .add_team(LEARNED, "Players with one neural network, which learned to play three against three.", |_, _| {
            LEARNED
        })
        .add_team(
            PASSERS_CLONE,
            "Players with one neural network, which learned from demonstrations of `passers`.",
            |_, _| PASSERS_CLONE,
        );
    let mut registry = app.world_mut().get_resource_or_init::<BehaviourRegistry>();
    registry.add_without_system::<Learned>(LEARNED);
    registry.add_without_system::<PassersClone>(PASSERS_CLONE);
}

/// Returns the policy of a name; `None` for the path of a file.
pub(super) fn named(name: &str) -> Option<Result<Arc<LoadedPolicy>, String>> {
    type Loaded = LazyLock<Result<Arc<LoadedPolicy>, String>>;
    macro_rules! file {
        ($include:ident, $name:literal, $ending:literal) => {
            $include!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/policies/", $name, $ending))
        };
    }
    macro_rules! policy {
        ($name:literal) => {{
            static POLICY: Loaded = LazyLock::new(|| {
                let (network, layout) = (file!(include_bytes, $name, ".onnx"), file!(include_str, $name, ".json"));
                LoadedPolicy::from_contents(network, layout).map(Arc::new)
            });
            Some(POLICY.clone())
        }};
    }
    match name {
        LEARNED => policy!("learned"),
        PASSERS_CLONE => policy!("passers_clone"),
        _ => None,
    }
}
