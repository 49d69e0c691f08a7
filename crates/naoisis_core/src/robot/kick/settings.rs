//! The kicks of a robot: their distances, geometry, timing and accuracy.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use tinyvec::ArrayVec;

use crate::geometry::file_units;
use crate::kick_geometry::{KickGeometry, KickName, KickType, Strike, strike_by};
use crate::knowledge::Knowledge;

/// One of a robot's kicks.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct KickModel {
    /// Distance that the ball rolls at speed 1, m; zero for a kick that the robot does not have.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub max_distance_m: f32,
    /// Least distance that the ball rolls, m. Weaker kicks are as strong as this.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 50.0))]
    pub min_distance_m: f32,
    /// The geometry of the kick; by default that of the paper's Table 2. Custom kicks must have one.
    pub region: Option<KickGeometry>,
    /// Time from the command until the foot strikes the ball, s; by default that of [`KickSettings`].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub wind_up_s: Option<f32>,
    /// Time from the strike until the robot can walk or kick again, s; by default that of [`KickSettings`].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub recovery_s: Option<f32>,
    /// Standard deviation of the direction, radians (degrees in files); by default that of [`KickSettings`].
    #[serde(
        rename = "direction_sd_deg",
        with = "file_units::optional_degrees",
        skip_serializing_if = "Option::is_none"
    )]
    #[schemars(with = "Option<f32>", range(min = 0.0, max = 180.0))]
    pub direction_sd: Option<f32>,
    /// Standard deviation of the launch speed, as a share of it; by default that of [`KickSettings`].
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ", a share of the speed"))]
    pub speed_sd: Option<f32>,
    /// Angle above the ground at which the ball leaves, radians (degrees in files). A raised ball starts as fast as a ball that rolls the
    /// same distance, and flies part of its way.
    #[serde(rename = "elevation_deg", with = "file_units::degrees", skip_serializing_if = "is_zero")]
    #[schemars(with = "f32", range(min = 0.0, max = 80.0))]
    pub elevation: f32,
    /// Whether the robot continues to walk in this kick: the swing is one of its steps.
    #[serde(skip_serializing_if = "is_false")]
    pub in_walk: bool,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

fn is_zero(number: &f32) -> bool {
    *number == 0.0
}

impl KickModel {
    /// A kick of this distance with the paper's geometry.
    pub const fn of(max_distance_m: f32) -> Self {
        Self {
            max_distance_m,
            min_distance_m: 0.0,
            region: None,
            wind_up_s: None,
            recovery_s: None,
            direction_sd: None,
            speed_sd: None,
            elevation: 0.0,
            in_walk: false,
        }
    }
}

impl Default for KickModel {
    fn default() -> Self {
        Self::of(4.0)
    }
}

/// The kicks of a robot besides the paper's four, in the order of their names. In files, a map by name.
#[derive(Clone, Copy, PartialEq, Debug, Default, Deref, Reflect)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct CustomKicks(ArrayVec<[(KickName, KickModel); CustomKicks::MOST]>);

impl CustomKicks {
    /// The greatest number of custom kicks of a robot.
    pub const MOST: usize = 6;

    /// These kicks; `None` if there are more than [`MOST`](Self::MOST).
    pub fn new(kicks: impl IntoIterator<Item = (KickName, KickModel)>) -> Option<Self> {
        let sorted: Vec<_> = kicks.into_iter().collect::<BTreeMap<_, _>>().into_iter().collect();
        ArrayVec::try_from(sorted.as_slice()).ok().map(Self)
    }

    /// The custom kick with this name.
    pub fn get(&self, name: KickName) -> Option<&KickModel> {
        self.iter().find(|(own, _)| *own == name).map(|(_, kick)| kick)
    }

    /// Whether there are no custom kicks.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for CustomKicks {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter().map(|(name, kick)| (name, kick)))
    }
}

impl<'de> Deserialize<'de> for CustomKicks {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let kicks = BTreeMap::<KickName, KickModel>::deserialize(deserializer)?;
        if let Some(kick) = KickType::ALL.iter().find(|kick| kicks.keys().any(|name| name.as_str() == kick.name())) {
            return Err(D::Error::custom(format!("`{kick}` is not a kick of its own; expected it beside `own`")));
        }
        let count = kicks.len();
        let too_many = || D::Error::custom(format!("{count} kicks of its own; expected at most {}", Self::MOST));
        Self::new(kicks).ok_or_else(too_many)
    }
}

/// The kicks of a robot and their common parameters.
///
/// Distances: rUNSWift's forward kick of 2010 reached 4.0 to 5.8 m at full power, its side kick 2 to 3 m.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct KickSettings {
    /// The left straight kick; 4 m by default.
    pub left_straight: KickModel,
    /// The right straight kick; 4 m by default.
    pub right_straight: KickModel,
    /// The left side kick; 2 m by default.
    pub left_side: KickModel,
    /// The right side kick; 2 m by default.
    pub right_side: KickModel,
    /// Custom kicks by name.
    #[serde(skip_serializing_if = "CustomKicks::is_empty")]
    #[schemars(with = "BTreeMap<String, KickModel>")]
    pub own: CustomKicks,
    /// A side kick from the wrong side is a straight kick at this share of the speed (paper, section 3.2).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_side_speed_factor: f32,
    /// Time from the command until the foot strikes the ball, s; for side kicks at least [`extension_s`](Self::extension_s).
    #[schemars(range(min = 0.0, max = 60.0))]
    pub wind_up_s: f32,
    /// Time in which the foot of a side kick extends to the front before it moves aside, s (paper, section 3.2): the first part of
    /// the wind-up. The extending foot strikes a ball that is on the wrong side.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub extension_s: f32,
    /// Time from the strike until the robot can walk or kick again, s.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub recovery_s: f32,
    /// Standard deviation of the direction, radians (degrees in files).
    #[serde(rename = "direction_sd_deg", with = "file_units::degrees")]
    #[schemars(with = "f32", range(min = 0.0, max = 180.0))]
    pub direction_sd: f32,
    /// Standard deviation of the launch speed, as a share of it.
    #[schemars(range(min = 0.0, max = 10.0), extend("unit" = ", a share of the speed"))]
    pub speed_sd: f32,
}

impl Default for KickSettings {
    fn default() -> Self {
        Self {
            left_straight: KickModel::of(4.0),
            right_straight: KickModel::of(4.0),
            left_side: KickModel::of(2.0),
            right_side: KickModel::of(2.0),
            own: CustomKicks::default(),
            wrong_side_speed_factor: 0.5,
            wind_up_s: 0.0,
            extension_s: 0.3,
            recovery_s: 1.0,
            direction_sd: 0.0,
            speed_sd: 0.0,
        }
    }
}

impl KickSettings {
    /// All described kicks, including those with distance zero: the paper's four, then custom kicks by name.
    pub fn models(&self) -> impl Iterator<Item = (KickType, &KickModel)> {
        let of_paper = KickType::ALL
            .into_iter()
            .zip([&self.left_straight, &self.right_straight, &self.left_side, &self.right_side]);
        of_paper.chain(self.own.iter().map(|(name, kick)| (KickType::Custom(*name), kick)))
    }

    /// The types of kick that the robot has.
    pub fn types(&self) -> impl Iterator<Item = KickType> {
        self.models().filter(|(_, kick)| kick.max_distance_m > 0.0).map(|(kick_type, _)| kick_type)
    }

    /// The kick with the greatest distance; the first of equals.
    pub fn strongest(&self) -> Option<KickType> {
        let further = |best: KickType, next: KickType| {
            if self.max_distance_m(next) > self.max_distance_m(best) { next } else { best }
        };
        self.types().reduce(further)
    }

    /// The model of a kick; `None` if the robot does not have it.
    pub fn get(&self, kick_type: KickType) -> Option<&KickModel> {
        let kick = match kick_type {
            KickType::LeftStraight => &self.left_straight,
            KickType::RightStraight => &self.right_straight,
            KickType::LeftSide => &self.left_side,
            KickType::RightSide => &self.right_side,
            KickType::Custom(name) => self.own.get(name)?,
        };
        (kick.max_distance_m > 0.0).then_some(kick)
    }

    /// Greatest distance of a type of kick, m; zero if the robot does not have it.
    pub fn max_distance_m(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).map_or(0.0, |kick| kick.max_distance_m)
    }

    /// Least distance of a type of kick, m.
    pub fn min_distance_m(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).map_or(0.0, |kick| kick.min_distance_m)
    }

    /// Time from the command of a kick until the foot strikes the ball, s.
    pub fn wind_up_of_s(&self, kick_type: KickType) -> f32 {
        let least_s = if kick_type.is_side_kick() { self.extension_s } else { 0.0 };
        self.get(kick_type).and_then(|kick| kick.wind_up_s).unwrap_or(self.wind_up_s.max(least_s))
    }

    /// The part of the wind-up in which the foot extends to the front, s; zero unless it is a side kick.
    pub fn extension_of_s(&self, kick_type: KickType) -> f32 {
        if kick_type.is_side_kick() { self.extension_s.min(self.wind_up_of_s(kick_type)) } else { 0.0 }
    }

    /// Time from the strike of a kick until the robot can walk or kick again, s.
    pub fn recovery_of_s(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).and_then(|kick| kick.recovery_s).unwrap_or(self.recovery_s)
    }

    /// Whether the robot continues to walk in a kick of this type.
    pub fn is_in_walk(&self, kick_type: KickType) -> bool {
        self.get(kick_type).is_some_and(|kick| kick.in_walk)
    }

    /// Angle above the ground at which the ball leaves in a kick of this type, radians.
    pub fn elevation_of(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).map_or(0.0, |kick| kick.elevation)
    }

    /// Standard deviation of a kick's direction, radians.
    pub fn direction_sd_of(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).and_then(|kick| kick.direction_sd).unwrap_or(self.direction_sd)
    }

    /// Standard deviation of a kick's launch speed, as a share of it.
    pub fn speed_sd_of(&self, kick_type: KickType) -> f32 {
        self.get(kick_type).and_then(|kick| kick.speed_sd).unwrap_or(self.speed_sd)
    }

    /// The geometry of a type of kick; `None` if the robot does not have it.
    pub fn geometry(&self, kick_type: KickType) -> Option<KickGeometry> {
        self.get(kick_type)?.region.or_else(|| KickGeometry::of_paper(kick_type))
    }

    /// The strike of a kick of this robot on a ball at `ball_in_robot`; `None` if the ball is out of reach. `wanted` is the requested
    /// direction, radians, robot frame, which only kicks that can be aimed follow.
    pub fn strike(&self, kick_type: KickType, ball_in_robot: Vec2, wanted: f32) -> Option<Strike> {
        strike_by(kick_type, ball_in_robot, wanted, |kick| self.geometry(kick))
    }

    /// Checks that the robot's settings describe this type of kick, even with distance zero.
    ///
    /// # Errors
    /// [`UnknownKick`] otherwise.
    pub fn check(&self, kick_type: KickType) -> Result<(), UnknownKick> {
        match kick_type {
            KickType::Custom(name) if self.own.get(name).is_none() => Err(UnknownKick {
                wanted: name.to_string(),
                known: self.types().map(|kick_type| kick_type.name().to_owned()).collect(),
            }),
            _ => Ok(()),
        }
    }
}

/// Error of [`KickSettings::check`]: the robot has no kick of this name.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no kick `{wanted}`; expected {}", known.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "))]
pub struct UnknownKick {
    /// The name.
    pub wanted: String,
    /// The names of the robot's kicks.
    pub known: Vec<String>,
}

debug_as_displayed!(UnknownKick);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kick_of_ones_own_is_a_line_in_a_file_and_says_of_times_and_spreads_what_it_has_for_itself() {
        let settings: KickSettings = serde_json::from_str(
            r#"{ "wind_up_s": 0.4, "direction_sd_deg": 6,
                 "left_side": { "max_distance_m": 0 },
                 "own": { "visual": { "max_distance_m": 5, "min_distance_m": 1, "recovery_s": 2, "direction_sd_deg": 3,
                     "region": { "x_m": [0.1, 0.4], "y_m": [-0.2, 0.2], "foot_m": [0.1, 0], "best_m": [0.3, 0],
                                 "direction": { "chosen": { "most_deg": 45 } } } } } }"#,
        )
        .unwrap();
        let visual: KickType = "visual".parse().unwrap();
        let names: Vec<String> = settings.types().map(|kick| kick.to_string()).collect();
        assert_eq!(names, ["left_straight", "right_straight", "right_side", "visual"]);
        assert_eq!([KickType::LeftStraight, visual].map(|kick| settings.wind_up_of_s(kick)), [0.4, 0.4]);
        assert_eq!([KickType::LeftStraight, visual].map(|kick| settings.recovery_of_s(kick)), [1.0, 2.0]);
        let spreads = [KickType::LeftStraight, visual].map(|kick| settings.direction_sd_of(kick).to_degrees().round());
        assert_eq!(spreads, [6.0, 3.0]);
        let strike = settings.strike(visual, Vec2::new(0.2, 0.1), -0.5).unwrap();
        assert!((strike.direction.to_angle() + 0.5).abs() < 1e-6);
        let again: KickSettings = serde_json::from_str(&serde_json::to_string(&settings).unwrap()).unwrap();
        assert_eq!(again, settings);
        // Custom kicks are written only if there are any.
        assert!(!serde_json::to_string(&KickSettings::default()).unwrap().contains("own"));
    }

    #[test]
    fn a_side_kick_takes_at_least_as_long_as_its_foot_extends() {
        let mut settings = KickSettings { wind_up_s: 0.1, extension_s: 0.3, ..KickSettings::default() };
        let times = |settings: &KickSettings, kick| [settings.wind_up_of_s(kick), settings.extension_of_s(kick)];
        assert_eq!(times(&settings, KickType::LeftStraight), [0.1, 0.0]);
        assert_eq!(times(&settings, KickType::LeftSide), [0.3, 0.3]);
        settings.wind_up_s = 0.7;
        assert_eq!(times(&settings, KickType::LeftSide), [0.7, 0.3]);
        settings.left_side.wind_up_s = Some(0.2);
        assert_eq!(times(&settings, KickType::LeftSide), [0.2, 0.2]);
    }

    #[test]
    fn a_kick_that_nobody_has_described_is_named_with_those_that_there_are() {
        let settings = KickSettings::default();
        assert_eq!(settings.check(KickType::LeftSide), Ok(()));
        let problem = settings.check("left_stright".parse().unwrap()).unwrap_err().to_string();
        assert!(problem.contains("`left_stright`") && problem.contains("`left_straight`"), "{problem}");
    }

    #[test]
    fn the_papers_kicks_are_not_ones_own_and_ones_own_are_few() {
        let read = |text: &str| serde_json::from_str::<CustomKicks>(text);
        assert!(read(r#"{ "left_side": {} }"#).unwrap_err().to_string().contains("beside `own`"));
        let seven: Vec<String> = (0..7).map(|index| format!("\"kick_{index}\": {{}}")).collect();
        assert!(read(&format!("{{ {} }}", seven.join(", "))).unwrap_err().to_string().contains("at most 6"));
        assert_eq!(read(&format!("{{ {} }}", seven[..6].join(", "))).unwrap().iter().count(), 6);
    }
}
