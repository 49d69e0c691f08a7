//! Saves the present situation of a match as a scenario, for starting new matches from it.

use bevy::prelude::*;

use super::spawn::resolved;
use crate::scenario::{BallStart, Scenario, ScenarioFault};
use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{BallVelocity, ExtraBall};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState, Intervention, Interventions, Penalty, Score, TimedIntervention};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;

/// Returns a scenario that begins in the present situation of the match in `world`: places, heads, the rolling ball, penalties, the score,
/// and interventions that have not happened yet. Unlike a [`Snapshot`](super::Snapshot) it is a new match, which can be edited by hand, and
/// in which the robots know only their own poses. Its clock starts at zero; a match that was in play is in play from its first cycle on. If the teams have changed sides, everything is turned by half a turn.
///
/// # Errors
/// [`ScenarioFault`] if robots overlap, which is possible only while they are being placed.
pub fn situation(world: &mut World) -> Result<Scenario, ScenarioFault> {
    let started_from = world.get_resource::<Scenario>().cloned().unwrap_or_default();
    let mut scenario = resolved(world, &started_from);
    let (clock, game) = (*world.resource::<CycleClock>(), world.resource::<Game>().clone());
    let is_turned = game.blue_end != Game::default().blue_end;
    // This is a new match.
    scenario.from = None;
    scenario.description = format!("{} after {:.2} s", scenario.name, clock.end_time_s());
    let mut interventions = Vec::new();
    for robot in &mut scenario.robots {
        let Some(entity) = world.resource::<Roster>().get(robot.id()) else { continue };
        if let Some(pose) = world.get::<Pose>(entity) {
            robot.pose = if is_turned { pose.turned_half() } else { *pose };
        }
        if let Some(head) = world.get::<HeadAngles>(entity) {
            robot.head_angles = [head.yaw, head.pitch];
        }
        robot.lies_on = match world.get::<Posture>(entity) {
            Some(Posture::Fallen { on, .. } | Posture::GettingUp { on, .. }) => Some(*on),
            _ => None,
        };
        if let Some(penalty) = world.get::<Penalty>(entity).and_then(|penalty| penalty.0) {
            let duration_s = Some((penalty.cycles_left as f64 * clock.period_s) as f32);
            interventions.push(Intervention::Penalise { robot: robot.id(), reason: penalty.reason, duration_s });
        }
    }
    if game.score != Score::default() {
        interventions.push(Intervention::SetScore { blue: game.score.blue, pink: game.score.pink });
    }
    scenario.interventions =
        interventions.into_iter().map(|intervention| TimedIntervention { at_s: 0.0, intervention }).collect();
    put_balls(world, &mut scenario, if is_turned { -1.0 } else { 1.0 });
    let is_in_play = game.state == GameState::Playing && game.stop.is_none() && game.shoot_out.is_none();
    if is_in_play && scenario.rules.clock {
        scenario.interventions.extend(play_on(&scenario));
    }
    for &asked in &world.resource::<Interventions>().queue {
        carry_out(&mut scenario, if is_turned { turned(asked) } else { asked });
    }
    scenario.validate()?;
    Ok(scenario)
}

/// The interventions by which a match with a clock begins in play: it would begin with a kick-off otherwise, for which the robots leave
/// their places.
fn play_on(scenario: &Scenario) -> Vec<TimedIntervention> {
    let Some(ball) = &scenario.ball else { return Vec::new() };
    let (position_m, velocity_mps) = (ball.position_m.truncate(), ball.velocity_mps.truncate());
    let rolls = (velocity_mps != Vec2::ZERO).then_some(Intervention::PlaceBall { position_m, velocity_mps });
    let all = [Intervention::DropBall { position_m }].into_iter().chain(rolls);
    all.map(|intervention| TimedIntervention { at_s: 0.0, intervention }).collect()
}

/// Lets the balls start where they are now, turned by half a turn with the `sign` -1.
fn put_balls(world: &mut World, scenario: &mut Scenario, sign: f32) {
    let Some(first) = &mut scenario.ball else { return };
    let mut balls = world.query::<(Option<&ExtraBall>, &Pose, &BallVelocity, &BallFlight)>();
    for (which, pose, velocity, flight) in balls.iter(world) {
        let height_m = if flight.is_airborne() { first.radius_m + flight.height_m } else { 0.0 };
        let position_m = (sign * pose.position).extend(height_m);
        let velocity_mps = (sign * velocity.0).extend(flight.climb_mps);
        match which {
            None => (first.position_m, first.velocity_mps) = (position_m, velocity_mps),
            Some(ExtraBall(number)) => {
                if let Some(ball) = scenario.more_balls.get_mut(usize::from(*number).wrapping_sub(1)) {
                    *ball = BallStart { position_m, velocity_mps };
                }
            }
        }
    }
}

/// Applies an intervention that would happen at the end of the next cycle to the beginning of the scenario.
fn carry_out(scenario: &mut Scenario, asked: Intervention) {
    match asked {
        Intervention::PlaceRobot { robot, pose } => {
            for spec in scenario.robots.iter_mut().filter(|spec| spec.id() == robot) {
                spec.pose = pose;
            }
        }
        Intervention::PlaceBall { position_m, velocity_mps } => {
            if let Some(ball) = &mut scenario.ball {
                (ball.position_m, ball.velocity_mps) = (position_m.extend(0.0), velocity_mps.extend(0.0));
            }
        }
        intervention => scenario.interventions.push(TimedIntervention { at_s: 0.0, intervention }),
    }
}

/// Returns the intervention on a pitch that is turned by half a turn.
fn turned(asked: Intervention) -> Intervention {
    match asked {
        Intervention::PlaceRobot { robot, pose } => Intervention::PlaceRobot { robot, pose: pose.turned_half() },
        Intervention::PlaceBall { position_m, velocity_mps } => {
            Intervention::PlaceBall { position_m: -position_m, velocity_mps: -velocity_mps }
        }
        Intervention::DropBall { position_m } => Intervention::DropBall { position_m: -position_m },
        other => other,
    }
}
