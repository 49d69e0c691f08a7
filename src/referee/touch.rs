//! Who touched the ball last.
//!
//! Kicks happen at the start of a cycle, the ball meets bodies in its course: so of all touches of a cycle, kicks
//! come first, then contacts in the order in which they happened.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::events::{KickResult, MatchEvent};
use crate::robot::RobotId;

/// A touch of the ball by a robot.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct Touch {
    /// Who.
    pub robot: RobotId,
    /// In which cycle.
    pub cycle: u64,
    /// Where the robot was, m, pitch frame.
    pub robot_position: Vec2,
    /// Whether it was a kick.
    pub kick: bool,
}

/// The last touch of a cycle: who, and whether by a kick. `contacts` are the robots that the ball met, in the order
/// in which it met them.
///
/// Of two robots that kick in the same cycle, the one that gives the ball the greater speed has the last touch; of
/// equal ones the first in order.
pub fn last_touch_of_cycle(
    events: &[MatchEvent],
    contacts: impl DoubleEndedIterator<Item = RobotId>,
) -> Option<(RobotId, bool)> {
    let mut contacts = contacts;
    if let Some(robot) = contacts.next_back() {
        return Some((robot, false));
    }
    let mut hardest: Option<(RobotId, f32)> = None;
    for event in events {
        let MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, launch_speed_mps, .. } = event
        else {
            continue;
        };
        let speed = launch_speed_mps.unwrap_or(0.0);
        if hardest.is_none_or(|(_, most)| speed > most) {
            hardest = Some((*robot, speed));
        }
    }
    hardest.map(|(robot, _)| (robot, true))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Team;
    use crate::robot::kick::KickType;

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

    const BLUE: RobotId = RobotId::new(Team::Blue, 2);
    const PINK: RobotId = RobotId::new(Team::Pink, 3);

    #[test]
    fn a_contact_comes_after_a_kick_and_the_last_contact_counts() {
        let events = [kick(BLUE, 2.0, KickResult::Kicked)];
        assert_eq!(last_touch_of_cycle(&events, [PINK].into_iter()), Some((PINK, false)));
        assert_eq!(last_touch_of_cycle(&events, [PINK, BLUE].into_iter()), Some((BLUE, false)));
        assert_eq!(last_touch_of_cycle(&events, [].into_iter()), Some((BLUE, true)));
    }

    #[test]
    fn a_missed_kick_is_no_touch_and_the_harder_of_two_counts() {
        assert_eq!(last_touch_of_cycle(&[kick(BLUE, 2.0, KickResult::Missed)], [].into_iter()), None);
        let both = [kick(BLUE, 1.0, KickResult::Kicked), kick(PINK, 1.1, KickResult::Reduced)];
        assert_eq!(last_touch_of_cycle(&both, [].into_iter()), Some((PINK, true)));
        let equal = [kick(BLUE, 1.0, KickResult::Kicked), kick(PINK, 1.0, KickResult::Kicked)];
        assert_eq!(last_touch_of_cycle(&equal, [].into_iter()), Some((BLUE, true)));
    }
}
