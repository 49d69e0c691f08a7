//! Shows a match at a given time when the window opens.

use bevy::prelude::*;
use bevy::time::TimeSystems;

use super::drive;
use super::match_panel::trace_reading::TraceReading;
use super::shared::Playback;
use super::timeline::{self, Timeline};
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::history::History;

/// Goes to the time of [`StartAt`].
pub struct StartAtPlugin;

impl Plugin for StartAtPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(First, go.run_if(resource_exists::<StartAt>).after(drive::set_clocks).before(TimeSystems));
    }
}

/// The time at which the match is to be shown, paused, s since its start. It is removed once the match has come that far.
#[derive(Resource, Clone, Copy, PartialEq, Debug)]
pub struct StartAt(pub f64);

fn go(world: &mut World) {
    let Some(&StartAt(time_s)) = world.get_resource() else { return };
    let cycle = (time_s / world.resource::<CycleClock>().period_s).round() as u64;
    let is_there = if world.resource::<Timeline>().is_replay() {
        let is_read = world.resource::<History>().last_cycle().is_some_and(|last| last >= cycle);
        let is_there = is_read || !world.get_resource::<TraceReading>().is_some_and(TraceReading::is_on);
        if is_there {
            timeline::go_to(world, cycle as f64);
        } else {
            // Its start is no moment that was asked for.
            world.resource_mut::<Playback>().paused = true;
        }
        is_there
    } else {
        drive::play_until(world, cycle)
    };
    if is_there {
        world.resource_mut::<Playback>().paused = true;
        // The clock of this frame is set already: without this, cycles would follow that are due in it.
        world.resource_mut::<Time<Virtual>>().pause();
        world.remove_resource::<StartAt>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn the_match_stands_at_the_time_that_was_asked_for_or_at_its_end() {
        for (asked_s, expected) in [(3.0, 90), (60.0, 150)] {
            let mut app = App::new();
            app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, StartAtPlugin));
            let scenario = Scenario { duration_s: Some(5.0), ..Scenario::named("match3v3").unwrap() };
            app.start_match(&scenario).unwrap();
            app.insert_resource(StartAt(asked_s));
            while app.world().contains_resource::<StartAt>() {
                app.update();
            }
            app.update();
            assert_eq!(app.cycle(), expected);
            assert!(app.world().resource::<Playback>().paused);
        }
    }
}
