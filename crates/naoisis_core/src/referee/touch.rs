//! Touches of the ball.
//!
//! Kicks happen at the start of a cycle, and contacts with bodies later: of all touches of a cycle, kicks come first, then contacts in the
//! order in which they happened.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::events::{KickResult, MatchEvent};
use crate::team::RobotId;

/// A touch of the ball by a robot.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Touch {
    /// The robot that touched the ball.
    pub robot: RobotId,
    /// The cycle.
    pub cycle: u64,
    /// Position of the robot, m, pitch frame.
    pub robot_position: Vec2,
    /// Whether it was a kick.
    pub kick: bool,
}

/// Collects all touches of a cycle, in their order: the robot, and whether it was a kick. `contacts` are the robots that the ball hit, in
/// their order.
///
/// Of robots that kick in the same cycle, the one that gives the ball the greater speed has the last touch; of equal ones the first in
/// order. A robot that kicks and is hit by the ball has kicked it.
pub(crate) fn touches_of_cycle(
    events: &[MatchEvent],
    contacts: impl Iterator<Item = RobotId>,
    touches: &mut Vec<(RobotId, bool)>,
) {
    touches.clear();
    let mut hardest: Option<(usize, f32)> = None;
    for event in events {
        let MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, launch_speed_mps, .. } = event
        else {
            continue;
        };
        let speed = launch_speed_mps.unwrap_or(0.0);
        if hardest.is_none_or(|(_, most)| speed > most) {
            hardest = Some((touches.len(), speed));
        }
        touches.push((*robot, true));
    }
    if let Some((index, _)) = hardest {
        let last = touches.remove(index);
        touches.push(last);
    }
    let kicks = touches.len();
    for robot in contacts {
        let kicked = touches[..kicks].contains(&(robot, true));
        touches.push((robot, kicked));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kick_geometry::KickType;
    use crate::team::Team;

    fn kick(robot: RobotId, launch_speed: f32, result: KickResult) -> MatchEvent {
        MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftStraight,
            speed: Some(1.0),
            result,
            reason: None,
            direction: None,
            launch_speed_mps: Some(launch_speed),
        }
    }

    fn touches(events: &[MatchEvent], contacts: &[RobotId]) -> Vec<(RobotId, bool)> {
        let mut touches = Vec::new();
        touches_of_cycle(events, contacts.iter().copied(), &mut touches);
        touches
    }

    const BLUE: RobotId = RobotId::new(Team::Blue, 2);
    const PINK: RobotId = RobotId::new(Team::Pink, 3);

    #[test]
    fn a_contact_comes_after_a_kick_and_the_last_contact_counts() {
        let events = [kick(BLUE, 2.0, KickResult::Kicked)];
        assert_eq!(touches(&events, &[PINK]), [(BLUE, true), (PINK, false)]);
        assert_eq!(touches(&events, &[PINK, BLUE]), [(BLUE, true), (PINK, false), (BLUE, true)]);
        assert_eq!(touches(&events, &[]), [(BLUE, true)]);
    }

    #[test]
    fn a_missed_kick_is_no_touch_and_the_harder_of_two_comes_last() {
        assert_eq!(touches(&[kick(BLUE, 2.0, KickResult::Missed)], &[]), []);
        let harder = [kick(BLUE, 1.1, KickResult::Kicked), kick(PINK, 1.0, KickResult::Reduced)];
        assert_eq!(touches(&harder, &[]), [(PINK, true), (BLUE, true)]);
        let equal = [kick(BLUE, 1.0, KickResult::Kicked), kick(PINK, 1.0, KickResult::Kicked)];
        assert_eq!(touches(&equal, &[]), [(PINK, true), (BLUE, true)]);
    }
}
