//! The geometry of kicks (paper, section 3.2 and Table 2): where the ball must lie for each, and where it goes from there.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A side of a robot: of its feet, of a dive.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Its left, +y in the robot frame.
    Left,
    /// Its right, -y in the robot frame.
    Right,
}

impl Side {
    /// Its name: `left` or `right`.
    pub fn name(self) -> &'static str {
        match self {
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}

/// The four types of kick (paper, section 3.2).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickType {
    /// Forward with the left foot.
    LeftStraight,
    /// Forward with the right foot.
    RightStraight,
    /// With the left foot, extended to the front and swung inwards: a ball on the robot's right leaves to the right.
    LeftSide,
    /// With the right foot: a ball on the robot's left leaves to the left.
    RightSide,
}

impl KickType {
    /// As files spell it.
    pub fn name(self) -> &'static str {
        match self {
            KickType::LeftStraight => "left_straight",
            KickType::RightStraight => "right_straight",
            KickType::LeftSide => "left_side",
            KickType::RightSide => "right_side",
        }
    }

    /// All four, in the order of their declaration.
    pub const ALL: [KickType; 4] =
        [KickType::LeftStraight, KickType::RightStraight, KickType::LeftSide, KickType::RightSide];

    /// The foot that kicks.
    pub fn foot(self) -> Side {
        match self {
            KickType::LeftStraight | KickType::LeftSide => Side::Left,
            KickType::RightStraight | KickType::RightSide => Side::Right,
        }
    }

    /// Which foot kicks, and where the ball goes, for people.
    pub fn words(self) -> &'static str {
        match self {
            KickType::LeftStraight => "left foot, straight",
            KickType::RightStraight => "right foot, straight",
            KickType::LeftSide => "left foot, to the right",
            KickType::RightSide => "right foot, to the left",
        }
    }

    /// The rectangle in which the ball's centre must lie, robot frame, m (paper, Table 2).
    pub fn admissible_rectangle(self) -> Rect {
        KickGeometry::of_paper(self).rectangle()
    }

    /// Whether a ball there can be struck by this kick of the paper's robot: edges included, with a hundredth of a millimetre
    /// for rounding.
    pub fn admits(self, ball_in_robot: Vec2) -> bool {
        KickGeometry::of_paper(self).admits(ball_in_robot)
    }

    /// The straight kick of the same foot.
    fn straight(self) -> KickType {
        match self.foot() {
            Side::Left => KickType::LeftStraight,
            Side::Right => KickType::RightStraight,
        }
    }
}

/// Where the ball must lie for a kick, and where it goes from there.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KickGeometry {
    /// Nearest and farthest the ball's centre may lie, ahead, m, robot frame.
    pub x_m: [f32; 2],
    /// Furthest to the right and furthest to the left, m, robot frame.
    pub y_m: [f32; 2],
    /// The tip of the foot that kicks, m, robot frame.
    pub foot_m: Vec2,
    /// Where the ball lies best, m, robot frame: whoever walks up to it makes for that.
    pub best_m: Vec2,
    /// Where the ball goes.
    #[serde(default)]
    pub direction: KickDirection,
}

/// In which direction a kick sends the ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickDirection {
    /// Away from the tip of the foot, straight ahead if the ball lies on it (paper, section 3.2).
    #[default]
    FromFoot,
    /// Straight ahead wherever the ball lies: kicks that were learned correct for that.
    Ahead,
}

impl KickGeometry {
    /// That of the paper's robot (Table 2, and its caption).
    pub fn of_paper(kick_type: KickType) -> Self {
        let (x_m, y_m, best_m) = match kick_type {
            KickType::LeftStraight => ([0.10, 0.20], [0.0, 0.10], Vec2::new(0.175, 0.05)),
            KickType::RightStraight => ([0.10, 0.20], [-0.10, 0.0], Vec2::new(0.175, -0.05)),
            KickType::LeftSide => ([0.10, 0.22], [-0.15, 0.0], Vec2::new(0.17, -0.07)),
            KickType::RightSide => ([0.10, 0.22], [0.0, 0.15], Vec2::new(0.17, 0.07)),
        };
        let foot_m = match kick_type.foot() {
            Side::Left => Vec2::new(0.10, 0.05),
            Side::Right => Vec2::new(0.10, -0.05),
        };
        Self { x_m, y_m, foot_m, best_m, direction: KickDirection::FromFoot }
    }

    /// The rectangle in which the ball's centre must lie, m, robot frame.
    pub fn rectangle(&self) -> Rect {
        let corner = |end: usize| Vec2::new(self.x_m[end], self.y_m[end]);
        Rect { min: corner(0), max: corner(1) }
    }

    /// Whether a ball there can be struck: edges included, with a hundredth of a millimetre for rounding.
    pub fn admits(&self, ball_in_robot: Vec2) -> bool {
        self.rectangle().inflate(1e-5).contains(ball_in_robot)
    }

    /// The direction in which a ball leaves that lies there, unit vector, robot frame.
    pub fn leaves(&self, ball_in_robot: Vec2) -> Vec2 {
        match self.direction {
            KickDirection::FromFoot => (ball_in_robot - self.foot_m).normalize_or(Vec2::X),
            KickDirection::Ahead => Vec2::X,
        }
    }
}

/// What a kick does to a ball within reach.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Strike {
    /// Direction in which the ball leaves, robot frame, unit vector.
    pub direction: Vec2,
    /// The kick by whose range the ball goes.
    pub range_of: KickType,
    /// Whether it is a side kick from the wrong side, at reduced speed.
    pub reduced: bool,
}

/// What a kick does to a ball at this place in the robot frame, if anything (paper, section 3.2).
///
/// The ball leaves along the ray from the tip of the foot through its centre; straight ahead if it lies on the tip.
/// A side kick from the wrong side, with the ball where the same foot's straight kick reaches it, is a straight kick
/// of reduced speed.
pub fn strike(kick_type: KickType, ball_in_robot: Vec2) -> Option<Strike> {
    strike_by(kick_type, ball_in_robot, |kick| Some(KickGeometry::of_paper(kick)))
}

/// As [`strike`], with the geometry of a robot's own kicks; none of a kick that it does not have.
pub fn strike_by(
    kick_type: KickType,
    ball_in_robot: Vec2,
    geometry_of: impl Fn(KickType) -> Option<KickGeometry>,
) -> Option<Strike> {
    let geometry = geometry_of(kick_type)?;
    if geometry.admits(ball_in_robot) {
        return Some(Strike { direction: geometry.leaves(ball_in_robot), range_of: kick_type, reduced: false });
    }
    let straight = kick_type.straight();
    let geometry = geometry_of(straight).filter(|geometry| geometry.admits(ball_in_robot))?;
    Some(Strike { direction: geometry.leaves(ball_in_robot), range_of: straight, reduced: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn over_the_whole_of_each_rectangle_the_ball_leaves_along_the_ray_from_the_foot_tip() {
        for kick_type in KickType::ALL {
            let rectangle = kick_type.admissible_rectangle();
            let tip = KickGeometry::of_paper(kick_type).foot_m;
            for column in 0..=20 {
                for row in 0..=20 {
                    let share = Vec2::new(column as f32, row as f32) / 20.0;
                    let ball = rectangle.min + share * rectangle.size();
                    let strike = strike(kick_type, ball).unwrap();
                    assert!(!strike.reduced);
                    // Direction: (ball - tip) / |ball - tip|; on the tip itself straight ahead.
                    let ray = ball - tip;
                    if ray.length() > 1e-4 {
                        assert_abs_diff_eq!(strike.direction.perp_dot(ray), 0.0, epsilon = 1e-6);
                        assert!(strike.direction.dot(ray) > 0.0);
                    } else {
                        assert_abs_diff_eq!(strike.direction, Vec2::X, epsilon = 1e-3);
                    }
                }
            }
        }
    }

    #[test]
    fn just_outside_every_edge_nothing_moves_unless_the_straight_kick_reaches_it() {
        for kick_type in KickType::ALL {
            let rectangle = kick_type.admissible_rectangle();
            let (centre, half) = (rectangle.center(), rectangle.half_size());
            for step in [Vec2::X, -Vec2::X, Vec2::Y, -Vec2::Y] {
                let inside = centre + step * (half - 1e-3);
                let outside = centre + step * (half + 1e-3);
                assert!(strike(kick_type, inside).is_some_and(|strike| !strike.reduced));
                let expected = kick_type.straight() != kick_type && kick_type.straight().admits(outside);
                assert_eq!(strike(kick_type, outside).is_some_and(|strike| strike.reduced), expected);
                assert_eq!(strike(kick_type, outside).is_some(), expected);
            }
        }
    }

    #[test]
    fn a_side_kick_sends_the_ball_to_its_side_and_from_the_wrong_side_ahead() {
        // The left foot reaches over to a ball on the right: from (10, 5) to (15, -10) cm.
        let right = strike(KickType::LeftSide, Vec2::new(0.15, -0.10)).unwrap();
        assert_abs_diff_eq!(right.direction, Vec2::new(0.05, -0.15).normalize(), epsilon = 1e-6);
        let wrong = strike(KickType::LeftSide, Vec2::new(0.15, 0.05)).unwrap();
        assert!(wrong.reduced);
        assert_eq!(wrong.range_of, KickType::LeftStraight);
        assert_abs_diff_eq!(wrong.direction, Vec2::X, epsilon = 1e-6);
    }
}
