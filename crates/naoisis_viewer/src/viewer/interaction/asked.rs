//! What was asked for by hand and waits for the next cycle: where it will be, and its words on the pitch.

use bevy::prelude::*;

use naoisis_core::game::Intervention;
use naoisis_core::geometry::Pose;
use naoisis_core::team::RobotId;

/// Returns the place and the velocity that the ball will have, m and m/s, if interventions that wait change them.
pub(super) fn asked_ball(queue: &[Intervention]) -> Option<(Vec2, Vec2)> {
    queue.iter().rev().find_map(|asked| match asked {
        Intervention::PlaceBall { position_m, velocity_mps } => Some((*position_m, *velocity_mps)),
        Intervention::DropBall { position_m } => Some((*position_m, Vec2::ZERO)),
        Intervention::KickOff { .. } => Some((Vec2::ZERO, Vec2::ZERO)),
        _ => None,
    })
}

/// Returns the pose that a robot will have, if interventions that wait change it.
pub(super) fn asked_pose(queue: &[Intervention], wanted: RobotId) -> Option<Pose> {
    queue.iter().rev().find_map(|asked| match asked {
        Intervention::PlaceRobot { robot, pose } if *robot == wanted => Some(*pose),
        _ => None,
    })
}

/// Returns the words of what waits with their places, m; of several at the same place, those of the last.
pub(super) fn words_of(
    queue: &[Intervention],
    place_of_robot: impl Fn(RobotId) -> Option<Vec2>,
) -> impl Iterator<Item = (Vec2, String)> {
    queue.iter().enumerate().filter_map(move |(index, asked)| {
        let place = place_of(*asked, &place_of_robot)?;
        let is_last = queue[index + 1..].iter().all(|later| place_of(*later, &place_of_robot) != Some(place));
        is_last.then(|| (place, waiting_words(*asked)))
    })
}

/// Returns the place of an intervention on the pitch, m, if it has one: that of its robot, if it does not move anything.
fn place_of(intervention: Intervention, place_of_robot: impl Fn(RobotId) -> Option<Vec2>) -> Option<Vec2> {
    match intervention {
        Intervention::Penalise { robot, .. } | Intervention::PickUp { robot } => place_of_robot(robot),
        Intervention::PlaceRobot { pose, .. } => Some(pose.position),
        Intervention::PlaceBall { position_m, .. } | Intervention::DropBall { position_m } => Some(position_m),
        Intervention::KickOff { .. } => Some(Vec2::ZERO),
        _ => None,
    }
}

/// Returns the words of an intervention that waits. The ball, which is drawn at its new place, needs no name.
fn waiting_words(intervention: Intervention) -> String {
    /// When it happens.
    const WHEN: &str = "when the match goes on";
    match intervention {
        Intervention::PlaceRobot { robot, .. } => format!("{robot} {WHEN}"),
        Intervention::PlaceBall { .. } | Intervention::DropBall { .. } => WHEN.to_owned(),
        other => format!("{other} {WHEN}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::game::PenaltyReason;
    use naoisis_core::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    #[test]
    fn the_last_of_what_waits_says_where_ball_and_robot_will_be() {
        let put = |x| Intervention::PlaceBall { position_m: Vec2::new(x, 0.0), velocity_mps: Vec2::ZERO };
        let robot = |x| Intervention::PlaceRobot { robot: BLUE, pose: Pose::new(x, 1.0, 0.5) };
        let queue = [put(1.0), robot(2.0), put(2.0), robot(3.0), Intervention::Whistle];
        assert_eq!(asked_ball(&queue), Some((Vec2::new(2.0, 0.0), Vec2::ZERO)));
        assert_eq!(asked_pose(&queue, BLUE), Some(Pose::new(3.0, 1.0, 0.5)));
        assert_eq!((asked_ball(&queue[4..]), asked_pose(&queue, RobotId::new(Team::Pink, 1))), (None, None));
        let kick_off = Intervention::KickOff { team: Team::Blue };
        assert_eq!(asked_ball(&[put(1.0), kick_off]), Some((Vec2::ZERO, Vec2::ZERO)));
    }

    #[test]
    fn what_waits_is_said_once_where_it_will_happen() {
        let ball = |speed| Intervention::PlaceBall { position_m: Vec2::ONE, velocity_mps: Vec2::new(speed, 0.0) };
        let robot = Intervention::PlaceRobot { robot: BLUE, pose: Pose::new(2.0, 1.0, 0.5) };
        let kick_off = Intervention::KickOff { team: Team::Pink };
        let pink = RobotId::new(Team::Pink, 2);
        let penalty = Intervention::Penalise { robot: pink, reason: PenaltyReason::Manual, duration_s: None };
        let queue = [ball(0.0), robot, Intervention::Whistle, penalty, kick_off, ball(1.0)];
        let words: Vec<_> = words_of(&queue, |robot| (robot == pink).then_some(Vec2::NEG_X)).collect();
        assert!(words[1].0 == Vec2::NEG_X && words[1].1.ends_with("when the match goes on"), "{words:?}");
        let words: Vec<_> = words_of(&queue, |_| None).collect();
        let expected = [
            (Vec2::new(2.0, 1.0), "blue1 when the match goes on"),
            (Vec2::ZERO, "kick-off for pink when the match goes on"),
            (Vec2::ONE, "when the match goes on"),
        ];
        assert_eq!(words, expected.map(|(place, words)| (place, words.to_owned())));
    }
}
