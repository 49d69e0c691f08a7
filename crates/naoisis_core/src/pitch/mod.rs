//! The pitch as data: dimensions, lines, marks and goals, and the geometry derived from them.
//!
//! Dimensions run between the centres of the lines, as in the rule books' figures. The `naoisis` pitch is that of
//! the 2010 rule book (6 x 4 m), `spl2025` that of 2025 (9 x 6 m).

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod goals;
mod markings;

use crate::knowledge::Knowledge;
pub use goals::GoalPost;
pub use markings::{CornerArc, JunctionShape, LineJunction, LineSegment, Markings};

/// Registers the pitch's types.
pub struct PitchPlugin;

impl Plugin for PitchPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Pitch>().register_type::<Pitch>().register_type::<Post>();
    }
}

/// A rectangular area in front of a goal.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AreaDimensions {
    /// From the goal line into the pitch, m.
    pub depth_m: f32,
    /// Along the goal line, m.
    pub width_m: f32,
}

/// The colour of a goal's posts and bar.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum GoalColour {
    /// RAL 1018, the goal at +x in 2010.
    Yellow,
    /// Sky-blue, RAL 5015, the goal at -x in 2010.
    Blue,
    /// Both goals today.
    White,
}

/// The goals: two posts, a bar, and a frame behind that carries the net.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GoalDimensions {
    /// Between the centres of the posts, m.
    pub width_m: f32,
    /// Height of the top of the bar, m.
    pub height_m: f32,
    /// From the posts' centres to the rear of the ground frame, m.
    pub depth_m: f32,
    /// Diameter of the posts, m.
    pub post_diameter_m: f32,
    /// Diameter of the crossbar, m.
    pub bar_diameter_m: f32,
    /// Whether the net and the bars on the ground that carry it stop the ball. By default they do not: the paper's goals are posts only.
    pub ground_bars: bool,
    /// Colour of the goal at -x.
    pub negative_x_colour: GoalColour,
    /// Colour of the goal at +x.
    pub positive_x_colour: GoalColour,
}

impl Default for GoalDimensions {
    fn default() -> Self {
        Self {
            width_m: 1.4,
            height_m: 0.8,
            depth_m: 0.4,
            post_diameter_m: 0.1,
            bar_diameter_m: 0.05,
            ground_bars: false,
            negative_x_colour: GoalColour::Blue,
            positive_x_colour: GoalColour::Yellow,
        }
    }
}

/// Dimensions of the pitch. The default is the paper's 6 x 4 m pitch (2010 rule book, section 1.1).
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Pitch {
    /// The preset's name, for display.
    pub name: String,
    /// Between the centres of the goal lines, m.
    pub length_m: f32,
    /// Between the centres of the side lines, m.
    pub width_m: f32,
    /// Width of the lines, m.
    pub line_width_m: f32,
    /// Width of the carpet beyond the centre of the side and goal lines, m.
    pub border_m: f32,
    /// Diameter of the centre circle, at the centre of its line, m.
    pub centre_circle_diameter_m: f32,
    /// The penalty area.
    pub penalty_area: AreaDimensions,
    /// The goal area inside the penalty area, if the pitch has one.
    pub goal_area: Option<AreaDimensions>,
    /// From the goal line to the penalty mark, m.
    pub penalty_mark_distance_m: f32,
    /// Length of the bars of the penalty cross, m.
    pub penalty_mark_size_m: f32,
    /// Radius of the quarter circles at the corners, at the centre of their line, m; zero if the pitch has none.
    pub corner_arc_radius_m: f32,
    /// The goals.
    pub goal: GoalDimensions,
    /// How much brighter or darker than the mean places of the carpet are at most, as a share; zero for an even carpet.
    #[reflect(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    #[serde(skip_serializing_if = "is_even")]
    pub unevenness: f32,
    /// How many people stand beside the carpet: the referee, two assistants, then spectators. Cameras see them; they do not collide.
    #[reflect(default)]
    #[serde(skip_serializing_if = "is_zero")]
    pub people: u8,
}

/// Whether there are no people beside the carpet.
fn is_zero(people: &u8) -> bool {
    *people == 0
}

/// Whether a carpet has the same colour everywhere.
fn is_even(unevenness: &f32) -> bool {
    *unevenness == 0.0
}

impl Default for Pitch {
    fn default() -> Self {
        Self {
            name: "naoisis".to_owned(),
            length_m: 6.0,
            width_m: 4.0,
            line_width_m: 0.05,
            border_m: 0.7,
            centre_circle_diameter_m: 1.2,
            penalty_area: AreaDimensions { depth_m: 0.6, width_m: 2.2 },
            goal_area: None,
            penalty_mark_distance_m: 1.8,
            penalty_mark_size_m: 0.1,
            corner_arc_radius_m: 0.0,
            goal: GoalDimensions::default(),
            unevenness: 0.0,
            people: 0,
        }
    }
}

/// One end of the pitch, or the goal there.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The end at -x, with the blue goal.
    #[default]
    NegativeX,
    /// The end at +x, with the yellow goal.
    PositiveX,
}

impl End {
    /// Both ends.
    pub const BOTH: [End; 2] = [End::NegativeX, End::PositiveX];

    /// The sign of x at this end: -1 or +1.
    pub fn sign(self) -> f32 {
        match self {
            End::NegativeX => -1.0,
            End::PositiveX => 1.0,
        }
    }

    /// The other end.
    pub fn opposite(self) -> End {
        match self {
            End::NegativeX => End::PositiveX,
            End::PositiveX => End::NegativeX,
        }
    }
}

/// A post on the pitch: a vertical cylinder at its [`Pose`](crate::geometry::Pose).
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Post {
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
    /// The colour of the goal that it belongs to; `None` for an extra post, which is an obstacle but no goal post.
    pub colour: Option<GoalColour>,
}

impl Pitch {
    /// Half the length between the goal lines' centres, m.
    pub fn half_length(&self) -> f32 {
        self.length_m / 2.0
    }

    /// Half the width between the side lines' centres, m.
    pub fn half_width(&self) -> f32 {
        self.width_m / 2.0
    }

    /// Half extents of the whole carpet, m.
    pub fn carpet_half_extents(&self) -> Vec2 {
        Vec2::new(self.half_length() + self.border_m, self.half_width() + self.border_m)
    }

    /// Half extents of the playing field to the outer edges of its lines, m: a ball that is completely outside is out.
    pub fn outer_half_extents(&self) -> Vec2 {
        Vec2::new(self.half_length(), self.half_width()) + self.line_width_m / 2.0
    }

    /// The colour of the goal at this end.
    pub fn goal_colour(&self, end: End) -> GoalColour {
        match end {
            End::NegativeX => self.goal.negative_x_colour,
            End::PositiveX => self.goal.positive_x_colour,
        }
    }
}

/// Error of [`Pitch::validate`]: a dimension is out of range.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("{message}: expected {expected}")]
pub struct PitchError {
    /// The field of [`Pitch`] that is out of range, as a path such as `goal.width_m`.
    pub field: &'static str,
    /// The field and its value.
    pub message: String,
    /// The valid range.
    pub expected: String,
}

debug_as_displayed!(PitchError);

impl Pitch {
    /// Checks that the dimensions describe a pitch on which a match can be played.
    ///
    /// # Errors
    /// The first of the [errors](Pitch::errors).
    pub fn validate(&self) -> Result<(), PitchError> {
        self.errors().into_iter().next().map_or(Ok(()), Err)
    }

    /// Returns all fields that are out of range. A field whose range depends on others is checked only if these are within their ranges.
    pub fn errors(&self) -> Vec<PitchError> {
        let (half_length_m, half_width_m) = (self.length_m / 2.0, self.width_m / 2.0);
        let goal_area = self.goal_area.unwrap_or_default();
        let of_themselves = [
            ("length_m", self.length_m, 1.0, 120.0),
            ("width_m", self.width_m, 1.0, 90.0),
            ("line_width_m", self.line_width_m, 0.01, 0.5),
            ("border_m", self.border_m, 0.2, 10.0),
            ("penalty_mark_size_m", self.penalty_mark_size_m, 0.0, 1.0),
            ("goal.height_m", self.goal.height_m, 0.1, 10.0),
            ("goal.depth_m", self.goal.depth_m, 0.05, 10.0),
        ];
        let on_the_pitch = [
            ("centre_circle_diameter_m", self.centre_circle_diameter_m, 0.1, self.width_m),
            ("penalty_area.depth_m", self.penalty_area.depth_m, 0.0, half_length_m),
            ("penalty_area.width_m", self.penalty_area.width_m, 0.0, self.width_m),
            ("goal_area.depth_m", goal_area.depth_m, 0.0, half_length_m),
            ("goal_area.width_m", goal_area.width_m, 0.0, self.width_m),
            ("penalty_mark_distance_m", self.penalty_mark_distance_m, 0.0, half_length_m),
            ("corner_arc_radius_m", self.corner_arc_radius_m, 0.0, half_width_m),
            ("goal.width_m", self.goal.width_m, 0.2, self.width_m),
        ];
        let of_the_goal = [
            ("goal.post_diameter_m", self.goal.post_diameter_m, 0.01, self.goal.width_m / 2.0),
            ("goal.bar_diameter_m", self.goal.bar_diameter_m, 0.005, self.goal.width_m / 2.0),
        ];
        let error = |&(field, value, least, most): &(&'static str, f32, f32, f32)| PitchError {
            field,
            message: format!("{field} is {value}"),
            expected: format!("{least} to {most} m"),
        };
        let errors = |ranges: &[(&'static str, f32, f32, f32)]| -> Vec<PitchError> {
            ranges.iter().filter(|(_, value, least, most)| !(*least..=*most).contains(value)).map(error).collect()
        };
        let groups: [&[_]; 3] = [&of_themselves, &on_the_pitch, &of_the_goal];
        groups.into_iter().map(errors).find(|errors| !errors.is_empty()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_pitch_has_the_2010_rule_books_dimensions() {
        let pitch = Pitch::default();
        assert_eq!(pitch.validate(), Ok(()));
        assert_eq!(pitch.outer_half_extents(), Vec2::new(3.025, 2.025));
        assert!(pitch.goal_posts()[3].position.abs_diff_eq(Vec2::new(2.975, 0.7), 1e-6));
        assert_eq!(pitch.goal_posts()[0].colour, GoalColour::Blue);
        // 5 lines of the field and 3 of each penalty area.
        assert_eq!(pitch.line_segments().len(), 11);
        // 4 corners, 2 + 4 T, 2 X at the circle, 4 corners of the penalty areas.
        assert_eq!(pitch.line_junctions().len(), 16);
    }
}
