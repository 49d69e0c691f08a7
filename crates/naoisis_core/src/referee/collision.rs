//! Responsibility of robots for collisions.
//!
//! The paper (section 3.4): "Responsibility is judged based on the relative speeds of the colliding robots, and the
//! location of the ball." Here:
//!
//! - The relevant speed is that of a robot's intended walk towards the other, along the line between them.
//! - A standing robot is never responsible; of two walking robots the faster one is, and at equal speeds both are.
//! - A robot that kicks a ball in its reach counts as standing, also where it walks on while it kicks (HSL 2026, 12.3.4).
//! - Neither is responsible if the two face each other with the ball between them: they fight for it.
//! - A robot whose side touches another on its way to the ball is exempt if [`Rules::side_contacts`](crate::game::Rules) says so.
//! - A contact below a least speed is not an offence.

use bevy::prelude::*;

use super::areas::{goes_to_ball, is_keeper_at_home, place_of_ball};
use super::obstruction::steps_into_way;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{Evidence, SideContacts};

/// Speeds that differ by less count as equal, m/s.
const EQUAL_SPEEDS_MPS: f32 = 1e-3;
/// Cosine of the angle within which two robots face each other: 60 degrees of straight ahead.
const FACING_COSINE: f32 = 0.5;
/// The ball is between two robots if its distance from the line between their origins is at most half the width of the wider
/// one plus this, m.
const HAND_M: f32 = 0.1;
/// The ball is in reach of a kick within this distance from the robot, m, which it may roll during the kick.
const KICK_REACH_M: f32 = 1.0;

/// Which of the robots with the indices `pair` are responsible for their collision, which has lasted for `contact_cycles`.
pub(crate) fn responsible(snapshot: &MatchSnapshot, pair: [usize; 2], contact_cycles: u64) -> [bool; 2] {
    let [a, b] = pair.map(|index| &snapshot.robots[index]);
    if a.id.team == b.id.team && !snapshot.rules.collisions_between_team_mates {
        return [false; 2];
    }
    if fight_for_ball(snapshot, a, b) {
        return [false; 2];
    }
    let rules = snapshot.rules;
    let is_long = rules.push_contact_s.is_some_and(|seconds| contact_cycles > snapshot.cycles(seconds));
    let least_mps = if is_long { 0.0 } else { rules.collision_speed_mps };
    let both = rules.chest_to_chest_penalises_both && face_each_other(a, b);
    let speeds = [[a, b], [b, a]].map(|[robot, other]| match kicks_ball(snapshot, robot) {
        true => 0.0,
        false => approach_speed(robot, other),
    });
    let margin = match rules.equal_speeds_penalise_both {
        true => -EQUAL_SPEEDS_MPS,
        // Front to front, the faster robot must be clearly faster.
        false if face_each_other(a, b) && !is_long => rules.collision_speed_mps,
        false => EQUAL_SPEEDS_MPS,
    };
    let is_responsible = |[own, others]: [f32; 2], robot: &RobotSnapshot, other: &RobotSnapshot| {
        own > least_mps
            && (both || own >= others + margin)
            && !(rules.keeper_may_push && is_keeper_at_home(snapshot, robot))
            && !may_touch(snapshot, robot, other)
            && !(rules.obstruction && steps_into_way(snapshot, other, robot))
    };
    [is_responsible(speeds, a, b), is_responsible([speeds[1], speeds[0]], b, a)]
}

/// Whether `robot` kicks a ball that was in its reach.
fn kicks_ball(snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> bool {
    robot.is_kicking
        && place_of_ball(snapshot).is_some_and(|ball| ball.distance(robot.previous.position) < KICK_REACH_M)
}

/// Whether the rules let `robot` touch `other` with its side.
fn may_touch(snapshot: &MatchSnapshot, robot: &RobotSnapshot, other: &RobotSnapshot) -> bool {
    let goes = |robot: &RobotSnapshot| goes_to_ball(snapshot, robot);
    match snapshot.rules.side_contacts {
        SideContacts::Count => false,
        SideContacts::FreeIfBothGoToBall => has_at_its_side(robot, other) && goes(robot) && goes(other),
        SideContacts::FreeOnTheWayToBall => has_at_its_side(robot, other) && goes(robot),
    }
}

/// Whether `other` is neither within 60 degrees of straight ahead nor of straight behind.
fn has_at_its_side(robot: &RobotSnapshot, other: &RobotSnapshot) -> bool {
    let direction = (other.previous.position - robot.previous.position).normalize_or_zero();
    robot.previous.forward().dot(direction).abs() < FACING_COSINE
}

/// The speed at which `robot` intends to approach `other`, along the line between their positions at the start of the cycle,
/// m/s.
pub(crate) fn approach_speed(robot: &RobotSnapshot, other: &RobotSnapshot) -> f32 {
    let line = (other.previous.position - robot.previous.position).normalize_or_zero();
    robot.wanted_velocity.dot(line)
}

/// Whether two robots face each other with the ball between them at the start of the cycle.
fn fight_for_ball(snapshot: &MatchSnapshot, a: &RobotSnapshot, b: &RobotSnapshot) -> bool {
    let Some(place) = place_of_ball(snapshot) else { return false };
    let (start, line) = (a.previous.position, b.previous.position - a.previous.position);
    let Some(direction) = line.try_normalize() else { return false };
    let along = (place - start).dot(direction).clamp(0.0, line.length());
    let half_width = a.bounds.torso.half_width_m.max(b.bounds.torso.half_width_m);
    face_each_other(a, b) && place.distance(start + direction * along) <= half_width + HAND_M
}

/// Whether each of two robots faced the other at the start of the cycle.
fn face_each_other(a: &RobotSnapshot, b: &RobotSnapshot) -> bool {
    let direction = (b.previous.position - a.previous.position).normalize_or_zero();
    a.previous.forward().dot(direction) > FACING_COSINE && b.previous.forward().dot(-direction) > FACING_COSINE
}

/// The evidence against the robot with index `robot` for a collision with the robot with index `other`.
pub fn evidence(snapshot: &MatchSnapshot, robot: usize, other: usize) -> Evidence {
    let (robot, other) = (&snapshot.robots[robot], &snapshot.robots[other]);
    let (own, others) = (approach_speed(robot, other), approach_speed(other, robot));
    let otherwise = if others > snapshot.rules.collision_speed_mps {
        format!("It had to walk towards {} slower than the {others:.2} m/s at which {} came.", other.id, other.id)
    } else {
        format!("It had to walk towards {} at no more than {} m/s.", other.id, snapshot.rules.collision_speed_mps)
    };
    snapshot
        .evidence(
            "Of two robots that collide, the one that walks faster towards the other is responsible, unless they face \
         each other with the ball between them.",
            robot.pose.position.midpoint(other.pose.position),
        )
        .with_robot(robot.evidence())
        .with_robot(other.evidence())
        .with_measurement("m/s towards the other", own, others.max(snapshot.rules.collision_speed_mps))
        .otherwise(otherwise)
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::events::MatchEvent;
    use crate::game::PenaltyReason;
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};
    use core::f32::consts::PI;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    /// Blue 2 at x = 1 and pink 2 at x = 1.2, face to face, in contact; the ball is far away.
    fn face_to_face() -> MatchFixture {
        MatchFixture::three_a_side()
            .robot_at(BLUE2, Pose::new(1.0, 0.0, 0.0))
            .robot_at(PINK2, Pose::new(1.2, 0.0, PI))
            .ball_rolled([-1.0, 1.0], [-1.0, 1.0])
            .contact(BLUE2, PINK2)
    }

    fn penalised(situation: &MatchFixture) -> Vec<RobotId> {
        let penalty = |event: &MatchEvent| match event {
            MatchEvent::Penalty { robot, reason: PenaltyReason::Pushing, .. } => Some(*robot),
            _ => None,
        };
        situation.decide().events.iter().filter_map(penalty).collect()
    }

    #[test]
    fn a_standing_robot_is_never_responsible() {
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.2, 0.0])), [BLUE2]);
        assert_eq!(penalised(&face_to_face()), []);
    }

    #[test]
    fn a_robot_that_kicks_a_ball_in_reach_counts_as_standing() {
        let kicking = |ball: [f32; 2]| {
            let mut situation = face_to_face().walking(BLUE2, [0.2, 0.0]).walking(PINK2, [-0.1, 0.0]);
            situation.robot_mut(BLUE2).is_kicking = true;
            penalised(&situation.ball_rolled(ball, ball))
        };
        assert_eq!(kicking([1.0, 0.9]), [PINK2]);
        assert_eq!(kicking([1.0, 1.1]), [BLUE2]);
    }

    #[test]
    fn the_one_that_is_faster_along_the_line_between_them_is_responsible() {
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.1, 0.0]).walking(PINK2, [-0.2, 0.0])), [PINK2]);
        // Pink is faster, but across the line; along the line, it walks at 0.06 m/s.
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.1, 0.0]).walking(PINK2, [-0.06, 0.2])), [BLUE2]);
        // Pink runs away; blue runs into its back.
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.15, 0.0]).walking(PINK2, [0.1, 0.0])), [BLUE2]);
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.1, 0.0]).walking(PINK2, [-0.1, 0.0])), [BLUE2, PINK2]);
    }

    #[test]
    fn a_brush_is_no_offence() {
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.051, 0.0])), [BLUE2]);
        assert_eq!(penalised(&face_to_face().walking(BLUE2, [0.049, 0.0])), []);
    }

    #[test]
    fn nobody_is_responsible_for_a_fight_for_the_ball() {
        let walking = face_to_face().walking(BLUE2, [0.2, 0.0]).walking(PINK2, [-0.1, 0.0]);
        // The ball 24 and 26 cm beside the line between the two.
        assert_eq!(penalised(&walking.clone().ball_rolled([1.1, 0.24], [1.1, 0.24])), []);
        assert_eq!(penalised(&walking.clone().ball_rolled([1.1, 0.26], [1.1, 0.26])), [BLUE2]);
        // Between wider robots, a ball at 26 cm counts as between them, at 31 cm it does not.
        let mut wide = walking.clone().ball_rolled([1.1, 0.26], [1.1, 0.26]);
        wide.robot_mut(BLUE2).bounds.torso.half_width_m = 0.2;
        assert_eq!(penalised(&wide), []);
        assert_eq!(penalised(&wide.ball_rolled([1.1, 0.31], [1.1, 0.31])), [BLUE2]);
        // Pink turns its back: 180 degrees away.
        let from_behind = walking.robot_at(PINK2, Pose::new(1.2, 0.0, 0.0)).ball_rolled([1.1, 0.1], [1.1, 0.1]);
        assert_eq!(penalised(&from_behind), [BLUE2]);
    }

    #[test]
    fn a_side_that_touches_another_on_the_way_to_the_ball_is_no_offence_where_the_rules_say_so() {
        // Both face +x, pink on blue's left; blue comes closer to it at 0.2 sin 20° = 0.068 m/s, pink to blue at less.
        let shoulders = |blue: [f32; 2], pink: [f32; 2], ball: [f32; 2], side_contacts| {
            let mut situation = face_to_face()
                .robot_at(BLUE2, Pose::new(0.0, 0.0, 0.0))
                .robot_at(PINK2, Pose::new(0.0, 0.31, 0.0))
                .walking(BLUE2, blue)
                .walking(PINK2, pink)
                .ball_rolled(ball, ball);
            situation.rules.side_contacts = side_contacts;
            penalised(&situation)
        };
        let (ahead, elsewhere) = ([1.0, 0.3], [-1.0, 0.3]);
        let (blue, pink, pink_away) = ([0.188, 0.068], [0.2, 0.0], [-0.2, 0.0]);
        assert_eq!(shoulders(blue, pink, ahead, SideContacts::Count), [BLUE2]);
        assert_eq!(shoulders(blue, pink, ahead, SideContacts::FreeIfBothGoToBall), []);
        assert_eq!(shoulders(blue, pink_away, ahead, SideContacts::FreeIfBothGoToBall), [BLUE2]);
        assert_eq!(shoulders(blue, pink_away, ahead, SideContacts::FreeOnTheWayToBall), []);
        assert_eq!(shoulders(blue, pink, elsewhere, SideContacts::FreeOnTheWayToBall), [BLUE2]);

        // Pink 59 and 61 degrees to the left of straight ahead.
        for (bearing, expected) in [(59.0_f32, vec![BLUE2]), (61.0, vec![])] {
            let place = Vec2::from_angle(bearing.to_radians()) * 0.3;
            let mut situation = face_to_face()
                .robot_at(BLUE2, Pose::new(0.0, 0.0, 0.0))
                .robot_at(PINK2, Pose::new(place.x, place.y, 0.0))
                .walking(BLUE2, [0.2, 0.0])
                .ball_rolled(ahead, ahead);
            situation.rules.side_contacts = SideContacts::FreeOnTheWayToBall;
            assert_eq!(penalised(&situation), expected, "at {bearing} degrees");
        }
    }

    #[test]
    fn team_mates_and_the_keeper_at_home_can_be_exempt() {
        let mates = face_to_face().robot_at(BLUE3, Pose::new(1.2, 0.0, PI)).walking(BLUE2, [0.2, 0.0]);
        let mut mates = MatchFixture { contacts: vec![], ..mates }.contact(BLUE2, BLUE3);
        assert_eq!(penalised(&mates), []);
        mates.rules.collisions_between_team_mates = true;
        assert_eq!(penalised(&mates), [BLUE2]);

        let keeper = RobotId::new(Team::Blue, 1);
        let mut at_home = MatchFixture::three_a_side()
            .robot_at(keeper, Pose::new(-2.5, 0.0, 0.0))
            .robot_at(PINK2, Pose::new(-2.3, 0.0, PI))
            .walking(keeper, [0.2, 0.0])
            .contact(keeper, PINK2);
        assert_eq!(penalised(&at_home), [keeper]);
        at_home.rules.keeper_may_push = true;
        assert_eq!(penalised(&at_home), []);
        let outside = at_home.robot_at(keeper, Pose::new(-2.3, 0.0, 0.0)).robot_at(PINK2, Pose::new(-2.1, 0.0, PI));
        assert_eq!(penalised(&outside), [keeper]);
    }

    #[test]
    fn who_pushes_too_often_is_removed_for_the_rest_of_the_half() {
        let mut situation = face_to_face().walking(BLUE2, [0.2, 0.0]);
        situation.rules.pushing_limit = Some(4);
        situation.memory.pushes.blue = 2;
        let third = situation.decide();
        // 30 s of 1/30 s.
        assert_eq!(third.robots[1].penalty.0.unwrap().cycles_left, 900);
        situation.memory.pushes.blue = 3;
        assert_eq!(situation.decide().robots[1].penalty.0.unwrap().cycles_left, 18_000);
    }
}
