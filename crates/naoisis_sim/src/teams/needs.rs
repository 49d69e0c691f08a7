//! The plugins that the built-in teams need.

use bevy::prelude::*;

use naoisis_core::behaviour::BehaviourPlugin;
use naoisis_core::communication::CommunicationPlugin;
use naoisis_core::cycle::CyclePlugin;
use naoisis_core::referee::RefereePlugin;
use naoisis_core::robot::RobotPlugin;
use naoisis_sensing::belief::SimpleBeliefPlugin;
use naoisis_sensing::sensing::SensingPlugin;

/// Returns whether the app has the plugins for everything that the built-in behaviours read and command.
pub(super) fn are_met(app: &App) -> bool {
    app.is_plugin_added::<CyclePlugin>()
        && app.is_plugin_added::<RobotPlugin>()
        && app.is_plugin_added::<SensingPlugin>()
        && app.is_plugin_added::<CommunicationPlugin>()
        && app.is_plugin_added::<BehaviourPlugin>()
        && app.is_plugin_added::<RefereePlugin>()
        && app.is_plugin_added::<SimpleBeliefPlugin>()
}
