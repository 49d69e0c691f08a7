//! The geometry of kicks (paper, section 3.2 and Table 2): where the ball must lie, and in which direction it leaves.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;

use crate::geometry::{angle_of, file_units, unit};
use crate::short_name::short_name;

/// The left or the right side of a robot.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Its left, +y in the robot frame.
    Left,
    /// Its right, -y in the robot frame.
    Right,
}

impl Side {
    /// The name of the side: `left` or `right`.
    pub fn name(self) -> &'static str {
        match self {
            Side::Left => "left",
            Side::Right => "right",
        }
    }
}

short_name! {
    /// The name of a custom kick of a robot's model.
    KickName, NotAKickName, 15, "a kick", "The name of a kick of the robot's model.", "^[a-z0-9_]{1,15}$"
}

/// A type of kick: one of the paper's four (section 3.2), or a custom kick by its name.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect)]
#[reflect(Serialize, Deserialize)]
pub enum KickType {
    /// Forward with the left foot.
    LeftStraight,
    /// Forward with the right foot.
    RightStraight,
    /// With the left foot, extended to the front and swung inwards: a ball on the robot's right leaves to the right.
    LeftSide,
    /// With the right foot: a ball on the robot's left leaves to the left.
    RightSide,
    /// A kick that the robot's model describes.
    Custom(KickName),
}

impl KickType {
    /// The name in files.
    pub fn name(&self) -> &str {
        match self {
            KickType::LeftStraight => "left_straight",
            KickType::RightStraight => "right_straight",
            KickType::LeftSide => "left_side",
            KickType::RightSide => "right_side",
            KickType::Custom(name) => name.as_str(),
        }
    }

    /// The paper's four, in the order of their declaration.
    pub const ALL: [KickType; 4] =
        [KickType::LeftStraight, KickType::RightStraight, KickType::LeftSide, KickType::RightSide];

    /// The foot that kicks. For a custom kick the left one if its name begins with `left`, otherwise the right one.
    pub fn foot(&self) -> Side {
        match self {
            KickType::LeftStraight | KickType::LeftSide => Side::Left,
            KickType::RightStraight | KickType::RightSide => Side::Right,
            KickType::Custom(name) if name.as_str().starts_with("left") => Side::Left,
            KickType::Custom(_) => Side::Right,
        }
    }

    /// The foot and the direction in words.
    pub fn words(&self) -> Cow<'static, str> {
        match self {
            KickType::LeftStraight => "left foot, straight".into(),
            KickType::RightStraight => "right foot, straight".into(),
            KickType::LeftSide => "left foot, to the right".into(),
            KickType::RightSide => "right foot, to the left".into(),
            KickType::Custom(name) => name.as_str().replace('_', " ").into(),
        }
    }

    /// Whether it is one of the paper's two side kicks.
    pub fn is_side_kick(&self) -> bool {
        matches!(self, KickType::LeftSide | KickType::RightSide)
    }

    /// The rectangle in which the ball's centre must lie, robot frame, m (paper, Table 2); empty for a custom kick.
    pub fn admissible_rectangle(self) -> Rect {
        KickGeometry::of_paper(self).map_or(Rect::EMPTY, |geometry| geometry.rectangle())
    }

    /// Whether this kick of the paper's robot reaches a ball at `ball_in_robot`. Edges are included, with a hundredth of a
    /// millimetre for rounding.
    pub fn admits(self, ball_in_robot: Vec2) -> bool {
        KickGeometry::of_paper(self).is_some_and(|geometry| geometry.admits(ball_in_robot))
    }

    /// The straight kick of the same foot, whose range applies to a ball on the wrong side of a side kick.
    fn straight(self) -> Option<KickType> {
        match self {
            KickType::LeftSide | KickType::LeftStraight => Some(KickType::LeftStraight),
            KickType::RightSide | KickType::RightStraight => Some(KickType::RightStraight),
            KickType::Custom(_) => None,
        }
    }
}

impl fmt::Display for KickType {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(self.name())
    }
}

impl FromStr for KickType {
    type Err = NotAKickName;

    fn from_str(word: &str) -> Result<Self, NotAKickName> {
        match KickType::ALL.into_iter().find(|kick| kick.name() == word) {
            Some(kick) => Ok(kick),
            None => word.parse().map(KickType::Custom),
        }
    }
}

impl Serialize for KickType {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl<'de> Deserialize<'de> for KickType {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = Cow::<str>::deserialize(deserializer)?;
        word.parse().map_err(D::Error::custom)
    }
}

impl JsonSchema for KickType {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "KickType".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "string",
            "description": "One of the robot's kicks: left_straight, right_straight, left_side, right_side, or the name of a kick of its model's own.",
            "pattern": "^[a-z0-9_]{1,15}$",
        })
    }
}

/// The geometry of a kick: where the ball must lie, and in which direction it leaves.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KickGeometry {
    /// Nearest and farthest the ball's centre may lie, ahead, m, robot frame.
    #[schemars(inner(range(min = -1.0, max = 2.0)))]
    pub x_m: [f32; 2],
    /// Furthest to the right and furthest to the left, m, robot frame.
    #[schemars(inner(range(min = -1.0, max = 1.0)))]
    pub y_m: [f32; 2],
    /// The tip of the foot that kicks, m, robot frame.
    #[schemars(with = "[f32; 2]")]
    pub foot_m: Vec2,
    /// The best position of the ball, m, robot frame: the target when walking up to the ball.
    #[schemars(with = "[f32; 2]")]
    pub best_m: Vec2,
    /// The direction in which the ball leaves.
    #[serde(default)]
    pub direction: KickDirection,
}

/// The direction in which a kick sends the ball.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickDirection {
    /// Away from the tip of the foot, straight ahead if the ball lies on it (paper, section 3.2).
    #[default]
    FromFoot,
    /// Straight ahead, independently of the position of the ball, as learned kicks do.
    Ahead,
    /// The requested direction, within limits: a kick that can be aimed.
    Chosen {
        /// The furthest to either side, radians (degrees in files).
        #[serde(rename = "most_deg", with = "file_units::degrees")]
        #[schemars(with = "f32", range(min = 0.0, max = 90.0))]
        most: f32,
    },
}

impl KickGeometry {
    /// The geometry of the paper's robot (Table 2 and its caption); `None` for a custom kick.
    pub fn of_paper(kick_type: KickType) -> Option<Self> {
        let (x_m, y_m, best_m) = match kick_type {
            KickType::LeftStraight => ([0.10, 0.20], [0.0, 0.10], Vec2::new(0.175, 0.05)),
            KickType::RightStraight => ([0.10, 0.20], [-0.10, 0.0], Vec2::new(0.175, -0.05)),
            KickType::LeftSide => ([0.10, 0.22], [-0.15, 0.0], Vec2::new(0.17, -0.07)),
            KickType::RightSide => ([0.10, 0.22], [0.0, 0.15], Vec2::new(0.17, 0.07)),
            KickType::Custom(_) => return None,
        };
        let foot_m = match kick_type.foot() {
            Side::Left => Vec2::new(0.10, 0.05),
            Side::Right => Vec2::new(0.10, -0.05),
        };
        Some(Self { x_m, y_m, foot_m, best_m, direction: KickDirection::FromFoot })
    }

    /// The rectangle in which the ball's centre must lie, m, robot frame.
    pub fn rectangle(&self) -> Rect {
        let corner = |end: usize| Vec2::new(self.x_m[end], self.y_m[end]);
        Rect { min: corner(0), max: corner(1) }
    }

    /// Whether the kick reaches a ball at `ball_in_robot`. Edges are included, with a hundredth of a millimetre for rounding.
    pub fn admits(&self, ball_in_robot: Vec2) -> bool {
        self.rectangle().inflate(1e-5).contains(ball_in_robot)
    }

    /// The direction in which a ball at `ball_in_robot` leaves, unit vector, robot frame. `wanted` is the requested direction,
    /// radians, which only kicks that can be aimed follow.
    pub fn leaves(&self, ball_in_robot: Vec2, wanted: f32) -> Vec2 {
        match self.direction {
            KickDirection::FromFoot => (ball_in_robot - self.foot_m).normalize_or(Vec2::X),
            KickDirection::Ahead => Vec2::X,
            KickDirection::Chosen { most } => unit(wanted.clamp(-most, most)),
        }
    }

    /// Greatest angle to either side of straight ahead at which the kick can be aimed, radians; zero if it cannot.
    pub fn aims_within(&self) -> f32 {
        match self.direction {
            KickDirection::Chosen { most } => most,
            _ => 0.0,
        }
    }

    /// The direction to request for a ball to leave along `direction` (robot frame), within the limits, radians.
    pub fn wanted_for(&self, direction: Vec2) -> f32 {
        let most = self.aims_within();
        if most > 0.0 { angle_of(direction).clamp(-most, most) } else { 0.0 }
    }
}

/// The effect of a kick on a ball within reach.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Strike {
    /// Direction in which the ball leaves, robot frame, unit vector.
    pub direction: Vec2,
    /// The kick whose range applies.
    pub range_of: KickType,
    /// Whether it is a side kick from the wrong side, at reduced speed.
    pub reduced: bool,
}

/// The strike of a kick of the paper's robot on a ball at `ball_in_robot`; `None` if the ball is out of reach (paper, section 3.2).
///
/// The ball leaves along the ray from the tip of the foot through its centre; straight ahead if it lies on the tip.
/// A side kick from the wrong side, with the ball where the same foot's straight kick reaches it, is a straight kick
/// of reduced speed.
pub fn strike(kick_type: KickType, ball_in_robot: Vec2) -> Option<Strike> {
    strike_by(kick_type, ball_in_robot, 0.0, KickGeometry::of_paper)
}

/// Like [`strike`], with the geometry that `geometry_of` returns for each kick, `None` for a kick that the robot does not have. `wanted` is
/// the requested direction, radians, robot frame, which only kicks that can be aimed follow.
pub fn strike_by(
    kick_type: KickType,
    ball_in_robot: Vec2,
    wanted: f32,
    geometry_of: impl Fn(KickType) -> Option<KickGeometry>,
) -> Option<Strike> {
    let geometry = geometry_of(kick_type)?;
    let leaves = |geometry: &KickGeometry| geometry.leaves(ball_in_robot, wanted);
    if geometry.admits(ball_in_robot) {
        return Some(Strike { direction: leaves(&geometry), range_of: kick_type, reduced: false });
    }
    let straight = kick_type.straight()?;
    let geometry = geometry_of(straight).filter(|geometry| geometry.admits(ball_in_robot))?;
    Some(Strike { direction: leaves(&geometry), range_of: straight, reduced: true })
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn over_the_whole_of_each_rectangle_the_ball_leaves_along_the_ray_from_the_foot_tip() {
        for kick_type in KickType::ALL {
            let rectangle = kick_type.admissible_rectangle();
            let tip = KickGeometry::of_paper(kick_type).unwrap().foot_m;
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
                let straight = kick_type.straight().unwrap();
                let expected = straight != kick_type && straight.admits(outside);
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

    #[test]
    fn a_kick_that_can_be_aimed_goes_where_it_is_wanted_within_its_limits() {
        let aimed = KickGeometry {
            direction: KickDirection::Chosen { most: 0.8 },
            ..KickGeometry::of_paper(KickType::RightStraight).unwrap()
        };
        let visual = KickType::Custom("visual".parse().unwrap());
        let struck = |wanted: f32, y_m: f32| {
            strike_by(visual, Vec2::new(0.15, y_m), wanted, |kick| (kick == visual).then_some(aimed))
        };
        for (wanted, goes) in [(0.0, 0.0), (0.5, 0.5), (-0.5, -0.5), (2.0, 0.8), (-2.0, -0.8)] {
            let direction = struck(wanted, -0.05).unwrap().direction;
            assert_abs_diff_eq!(angle_of(direction), goes, epsilon = 1e-6);
            assert_abs_diff_eq!(aimed.wanted_for(unit(wanted)), goes, epsilon = 1e-6);
        }
        // Outside of its rectangle nothing moves: a robot's own kick has no straight kick in its stead.
        assert_eq!(struck(0.0, 0.05), None);
    }

    #[test]
    fn kicks_are_words_in_files() {
        let read = |text: &str| serde_json::from_str::<KickType>(text);
        assert_eq!(read("\"left_side\"").unwrap(), KickType::LeftSide);
        let own = read("\"visual_kick\"").unwrap();
        assert_eq!((own.name(), serde_json::to_string(&own).unwrap().as_str()), ("visual_kick", "\"visual_kick\""));
        for wrong in ["\"Left\"", "\"a kick of many letters\"", "\"\"", "3"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
