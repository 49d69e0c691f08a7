//! The true state of a match as an array, for critics.

use bevy::ecs::archetype::Archetype;
use bevy::prelude::*;

use super::entry::{Entries, Group, ObservationEntry, PLACE, SPEED, Sink, UNIT, Values};
use naoisis_core::ball::{Ball, BallVelocity};
use naoisis_core::game::{Game, GameState, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::{Roster, Velocity};
use naoisis_core::team::Team;
use naoisis_sensing::belief::{point_team_from_pitch, team_from_pitch};

/// The position and velocity of the ball, pitch frame, m and m/s.
pub(super) fn ball_of(world: &World) -> Option<(Vec2, Vec2)> {
    // Several times in each step: a query would have to be prepared in each call.
    let ball = world.components().component_id::<Ball>()?;
    let with_ball = world.archetypes().component_index().get(&ball)?;
    let archetypes = with_ball.keys().filter_map(|id| world.archetypes().get(*id));
    let ball = archetypes.flat_map(Archetype::entities).next()?.id();
    Some((world.get::<Pose>(ball)?.position, world.get::<BallVelocity>(ball)?.0))
}

/// The entries of the true state, for critics.
pub fn state_entries(world: &World) -> Vec<ObservationEntry> {
    let mut entries = Entries::default();
    state_into(&mut entries, world);
    entries.0
}

/// Fills `array` with the true state of the whole match in the frame of team blue, for critics.
pub(super) fn state(array: &mut [f32], world: &World) {
    state_into(&mut Values { array, filled: 0 }, world);
}

fn state_into(sink: &mut impl Sink, world: &World) {
    let game = world.resource::<Game>();
    let own_end = game.own_end(Team::Blue);
    let (place, velocity) = ball_of(world).unwrap_or_default();
    let [place, velocity] = [place, velocity].map(|vector| point_team_from_pitch(vector, own_end));
    Group::new(sink, "ball", 0)
        .put("x", PLACE, "position, m", place.x)
        .put("y", PLACE, "position, m", place.y)
        .put("vx", SPEED, "velocity, m/s", velocity.x)
        .put("vy", SPEED, "velocity, m/s", velocity.y);
    for (id, entity) in world.resource::<Roster>().iter() {
        let Ok(robot) = world.get_entity(entity) else { continue };
        let pose = team_from_pitch(robot.get::<Pose>().copied().unwrap_or_default(), own_end);
        let velocity = robot.get::<Velocity>().copied().unwrap_or_default().linear;
        let velocity = point_team_from_pitch(velocity, own_end);
        let forward = pose.forward();
        Group::new(sink, id.team.name(), id.number)
            .flag("plays", "1 while it is not penalised", !robot.get::<Penalty>().is_some_and(Penalty::is_active))
            .put("x", PLACE, "position, m", pose.position.x)
            .put("y", PLACE, "position, m", pose.position.y)
            .put("cos", UNIT, "cosine of its heading", forward.x)
            .put("sin", UNIT, "sine of its heading", forward.y)
            .put("vx", SPEED, "velocity, m/s", velocity.x)
            .put("vy", SPEED, "velocity, m/s", velocity.y);
    }
    let minutes_left = game.time_left_s(world.resource()).unwrap_or(0.0) / 60.0;
    Group::new(sink, "game", 0)
        .flag("playing", "1 while the ball is in play", game.state == GameState::Playing)
        .put(
            "lead",
            [-10.0, 10.0],
            "goals of blue minus goals of pink",
            game.score.blue as f32 - game.score.pink as f32,
        )
        .put("minutes_left", [0.0, 60.0], "minutes left in this half", minutes_left);
}
