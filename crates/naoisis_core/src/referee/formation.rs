//! The formation for a kick-off.
//!
//! The positions are legal by the rule books of 2010 (section 3.5: all robots in their own half, field players outside their own penalty
//! area, the defending ones behind their penalty mark, the keeper in its penalty area) and of 2025, on both pitches.

use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use crate::game::{KickOffProcedure, Rules};
use crate::geometry::{Pose, angle_of};
use crate::pitch::{End, Pitch};

/// The number of different positions; robots with higher numbers stand at the nearest free positions.
pub const MOST_PLACES: u8 = 11;

/// Distance of the kicking-off striker from the ball, m.
const STRIKER_DISTANCE: f32 = 0.3;
/// Distance of the keeper from the middle of the goal line, m.
const KEEPER_DISTANCE: f32 = 0.2;
/// Distance of the second row from the centre circle's line at the team's own kick-off, m.
const CIRCLE_CLEARANCE: f32 = 0.2;
/// Distance of the defenders' first row behind its penalty mark, m: the base reaches 0.15 m ahead, and robots do not know their
/// position exactly.
const MARK_CLEARANCE: f32 = 0.3;
/// Distance from the side line at which robots that walk in stand, m: their feet reach the line.
const BESIDE_LINE_M: f32 = 0.15;
/// Distance of kick-off positions from the middle of the pitch, m, within which the jersey number decides from which side the robot walks in.
const MIDDLE_M: f32 = 0.1;
/// Distance of the last row in front of the penalty area, m.
const AREA_CLEARANCE: f32 = 0.2;

/// The kick-off pose, in the pitch frame, of the robot with this jersey number (from 1) in a team of `team_size` that defends `own_end`.
/// The robot faces the ball.
///
/// Number 1 is the keeper, unless it is alone. Number 2 (or a lone robot) is the striker: if `kicking_off`, it stands behind the ball
/// inside the centre circle; otherwise well outside the circle. The others fill rows behind it.
pub fn formation(pitch: &Pitch, team_size: u8, number: u8, own_end: End, kicking_off: bool) -> Pose {
    let position = match number {
        1 if team_size > 1 => Vec2::new(-pitch.half_length() + KEEPER_DISTANCE, 0.0),
        0..=2 => field_place(pitch, 0, kicking_off),
        _ => field_place(pitch, usize::from((number - 2) % (MOST_PLACES - 1)), kicking_off),
    };
    let in_team = Pose { position, heading: angle_of(-position) };
    match own_end {
        End::NegativeX => in_team,
        End::PositiveX => in_team.turned_half(),
    }
}

/// Returns the pose, in the pitch frame, at which a robot is placed for a kick-off by `rules`: that of its [`formation`] or, if robots walk in,
/// beside the nearer side line with a view across the pitch. From the middle, odd numbers go to the left and even ones to the right.
pub fn start_pose(pitch: &Pitch, rules: &Rules, number: u8, own_end: End, kicking_off: bool) -> Pose {
    let place = formation(pitch, rules.team_size, number, own_end, kicking_off);
    if !rules.walk_in || rules.kick_off != KickOffProcedure::ReadyAndSet {
        return place;
    }
    let to_the_line = pitch.half_width() + BESIDE_LINE_M.min(pitch.border_m / 2.0);
    let is_even = number.is_multiple_of(2);
    let side = match place.position.y {
        y if y.abs() >= MIDDLE_M => y.signum(),
        _ if is_even == (own_end == End::NegativeX) => -1.0,
        _ => 1.0,
    };
    Pose { position: Vec2::new(place.position.x, side * to_the_line), heading: -side * FRAC_PI_2 }
}

/// The position of the field player with `index`, the striker being 0, in the team frame.
fn field_place(pitch: &Pitch, index: usize, kicking_off: bool) -> Vec2 {
    let (length, width) = (pitch.half_length(), pitch.half_width());
    let rear = -(length - pitch.penalty_area.depth_m - AREA_CLEARANCE);
    if kicking_off {
        // Behind the striker there are two robots at the circle, then rows in front of the penalty area.
        let wings = -(pitch.centre_circle_diameter_m / 2.0 + CIRCLE_CLEARANCE);
        let middle = -length * 0.5;
        [
            Vec2::new(-STRIKER_DISTANCE, 0.0),
            Vec2::new(wings, width * 0.5),
            Vec2::new(wings, -width * 0.5),
            Vec2::new(middle, 0.0),
            Vec2::new(middle, width * 0.3),
            Vec2::new(middle, -width * 0.3),
            Vec2::new(middle, width * 0.7),
            Vec2::new(middle, -width * 0.7),
            Vec2::new(rear, width * 0.18),
            Vec2::new(rear, -width * 0.18),
        ][index]
    } else {
        // 46 % of a half's length is well outside the circle. If the penalty mark is in front of its area, as in 2010, defenders stand
        // behind it.
        let mark = length - pitch.penalty_mark_distance_m;
        let mark_counts = pitch.penalty_mark_distance_m > pitch.penalty_area.depth_m;
        let front = -(length * 0.46).max(if mark_counts { mark + MARK_CLEARANCE } else { 0.0 });
        let middle = front.midpoint(rear);
        [
            Vec2::new(front, 0.0),
            Vec2::new(front, width * 0.4),
            Vec2::new(front, -width * 0.4),
            Vec2::new(middle, width * 0.2),
            Vec2::new(middle, -width * 0.2),
            Vec2::new(middle, width * 0.6),
            Vec2::new(middle, -width * 0.6),
            Vec2::new(rear, 0.0),
            Vec2::new(rear, width * 0.4),
            Vec2::new(rear, -width * 0.4),
        ][index]
    }
}

#[cfg(test)]
pub(in crate::referee) mod tests {
    use super::*;
    use crate::robot::body::Body;
    use approx::assert_abs_diff_eq;
    use core::f32::consts::PI;

    /// The options with which scenario files are read.
    pub(in crate::referee) fn ron_options() -> ron::Options {
        ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
    }

    fn pitches() -> [Pitch; 2] {
        let spl2025 = include_str!("../../../../assets/fields/spl2025.ron");
        [Pitch::default(), ron_options().from_str(spl2025).unwrap()]
    }

    #[test]
    fn robots_walk_in_from_beside_their_half() {
        let rules = Rules { walk_in: true, kick_off: KickOffProcedure::ReadyAndSet, team_size: 7, ..Rules::default() };
        for pitch in pitches() {
            for number in 1..=7 {
                let [left, right] = End::BOTH.map(|end| start_pose(&pitch, &rules, number, end, false));
                // The teams stand opposite each other.
                assert_abs_diff_eq!(right.turned_half().position, left.position, epsilon = 1e-5);
                let place = formation(&pitch, 7, number, End::NegativeX, false);
                assert_eq!(left.position.x, place.position.x);
                let beside_m = left.position.y.abs();
                assert!(beside_m > pitch.half_width() + 0.1 && beside_m < pitch.carpet_half_extents().y);
                assert_abs_diff_eq!(left.heading, -left.position.y.signum() * FRAC_PI_2);
            }
            // Where robots are placed for kick-offs, they do not walk in.
            let placed = Rules { kick_off: KickOffProcedure::Placed, ..rules.clone() };
            let expected = formation(&pitch, 7, 2, End::NegativeX, true);
            assert_eq!(start_pose(&pitch, &placed, 2, End::NegativeX, true), expected);
        }
    }

    #[test]
    fn eleven_robots_a_side_have_places_of_their_own_in_their_half() {
        let bounds = Body::default();
        for pitch in pitches() {
            for kicking_off in [Some(End::NegativeX), Some(End::PositiveX)] {
                let poses: Vec<(End, Pose)> = End::BOTH
                    .into_iter()
                    .flat_map(|end| {
                        let pitch = &pitch;
                        (1..=11).map(move |number| (end, formation(pitch, 11, number, end, kicking_off == Some(end))))
                    })
                    .collect();
                for (index, (end, pose)) in poses.iter().enumerate() {
                    // The whole robot is in its own half, and off the halfway line (half its width is 2.5 cm).
                    for corner in bounds.base.footprint(*pose).corners() {
                        assert!(corner.x * end.sign() > 0.025, "{pose:?}");
                        assert!(corner.x.abs() < pitch.half_length() && corner.y.abs() < pitch.half_width());
                    }
                    for (_, other) in &poses[index + 1..] {
                        // Circles about the origins that contain the torsos do not overlap.
                        assert!(pose.position.distance(other.position) > 2.0 * bounds.torso.reach());
                    }
                }
            }
        }
    }

    #[test]
    fn the_places_are_legal_by_the_rule_book_of_2010() {
        let pitch = Pitch::default();
        let bounds = Body::default();
        let keeper = formation(&pitch, 3, 1, End::PositiveX, false);
        assert!(pitch.in_penalty_area(End::PositiveX, keeper.position));
        for number in 2..=11 {
            for kicking_off in [true, false] {
                let pose = formation(&pitch, 11, number, End::NegativeX, kicking_off);
                let base = bounds.base.footprint(pose);
                assert!(base.corners().iter().all(|corner| !pitch.in_penalty_area(End::NegativeX, *corner)));
                let in_circle = pose.position.length() < pitch.centre_circle_diameter_m / 2.0 + base.bounding_radius();
                assert_eq!(in_circle, kicking_off && number == 2, "{number}");
                // The defenders' penalty mark is 1.8 m from the goal line, 1.2 m from the halfway line.
                assert!(kicking_off || base.corners().iter().all(|corner| corner.x < -1.2));
            }
        }
    }

    #[test]
    fn the_other_side_is_the_same_turned_by_half_a_turn_and_a_lone_robot_is_the_striker() {
        let pitch = Pitch::default();
        let left = formation(&pitch, 3, 3, End::NegativeX, true);
        let right = formation(&pitch, 3, 3, End::PositiveX, true);
        assert_abs_diff_eq!(left.position, -right.position, epsilon = 1e-6);
        let lone = formation(&pitch, 1, 1, End::PositiveX, true);
        assert_abs_diff_eq!(lone.position, Vec2::new(STRIKER_DISTANCE, 0.0), epsilon = 1e-6);
        assert_abs_diff_eq!(lone.heading.abs(), PI, epsilon = 1e-6);
    }
}
