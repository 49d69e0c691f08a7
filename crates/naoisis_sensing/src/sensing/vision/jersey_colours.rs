//! The colours of jerseys that a vision recognises, with their errors.

use super::{JerseyVision, Percepts};
use crate::appearance::scene::Scene;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::Team;

/// The colour of the jerseys of a team, as its first robot wears it; without robots, as the first robot of the scene would wear it.
pub(super) fn of_team(scene: &Scene, team: Team) -> Option<Jersey> {
    let robots = scene.robots.iter().filter(|robot| robot.id.team == team);
    let first = robots.min_by_key(|robot| robot.id).or(scene.robots.first())?;
    first.body.jersey.map(|jersey| jersey.colour_of(team))
}

/// Removes the colours that are too far away, and replaces those that are mistaken.
pub(super) fn mistake(percepts: &mut Percepts, vision: &JerseyVision, stream: &mut RandomStream) {
    for robot in &mut percepts.robots {
        if robot.position_m.length() >= vision.colour_m {
            robot.colour = None;
        } else if robot.colour.is_some() && stream.chance(vision.colour_error) {
            let count = Jersey::COLOURS.len();
            let index = ((stream.uniform() * count as f32) as usize).min(count - 1);
            robot.colour = Some(Jersey::COLOURS[index].1);
        }
    }
}
