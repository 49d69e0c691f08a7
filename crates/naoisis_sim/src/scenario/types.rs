//! The types of a scenario, for programs and for files.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::expectation::Expectation;
use super::messages_form::MessagesForm;
use super::realism::RealismSettings;
use super::robot_settings::{RobotSettings, robot_settings};
use super::robot_spec::RobotSpec;
use super::saved_match::SavedMatch;
use super::teams_spec::TeamsSpec;
use naoisis_core::ball::flight::{BallFlight, FlightPhysics};
use naoisis_core::ball::{BallLook, BallPhysics, Rolling};
use naoisis_core::communication::{MessageLimits, MessageSettings};
use naoisis_core::game::{Rules, TimedIntervention};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;

/// Everything that a match starts from. In files, the fields of `settings` are beside the others.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
#[serde(from = "ScenarioForm", into = "ScenarioForm")]
pub struct Scenario {
    /// A name for display.
    pub name: String,
    /// Description, one sentence.
    pub description: String,
    /// The saved match that the match continues, with the random numbers of its own seed. In files, it is the path of the saved match.
    /// Values that are not given are those of that match. Times are counted from its last cycle.
    #[reflect(default)]
    pub from: Option<SavedMatch>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Duration of a cycle, s.
    pub cycle_s: f64,
    /// Duration of the match, s. Without it, the match ends with the final whistle, or after 60 s if the rules have no clock.
    pub duration_s: Option<f32>,
    /// The [league](super::League) for settings that are not given, if any.
    pub league: Option<String>,
    /// The [model](super::RobotModel) of the robots.
    pub model: String,
    /// The realism of settings that are not given.
    pub realism: RealismSettings,
    /// The sizes of pitch and goals.
    pub field: Pitch,
    /// The rules of the match.
    pub rules: Rules,
    /// The ball; none with `null`. Of several, the first.
    pub ball: Option<BallSpec>,
    /// Further balls of a training, like the first in all but place and velocity. In files `balls` has the starts of all.
    #[reflect(default)]
    pub more_balls: Vec<BallStart>,
    /// The settings of robots, unless they have their own.
    pub settings: RobotSettings,
    /// How messages travel.
    pub messages: MessageSettings,
    /// The robots, each with its place and its behaviour.
    pub robots: Vec<RobotSpec>,
    /// Two built-in teams lined up for a kick-off, instead of `robots`.
    pub teams: Option<TeamsSpec>,
    /// Posts besides those of the goals.
    pub posts: Vec<PostSpec>,
    /// Interventions of the referee, with their times.
    pub interventions: Vec<TimedIntervention>,
    /// Expectations of the match, tested by `naoisis check --play`.
    pub expectations: Vec<Expectation>,
}

impl Default for Scenario {
    fn default() -> Self {
        Self {
            name: String::new(),
            description: String::new(),
            from: None,
            seed: 1,
            cycle_s: 1.0 / 30.0,
            duration_s: None,
            league: None,
            model: "nao".to_owned(),
            realism: RealismSettings::default(),
            field: Pitch::default(),
            rules: Rules::default(),
            ball: Some(BallSpec::default()),
            more_balls: Vec::new(),
            settings: RobotSettings::default(),
            messages: MessageSettings::default(),
            robots: Vec::new(),
            teams: None,
            posts: Vec::new(),
            interventions: Vec::new(),
            expectations: Vec::new(),
        }
    }
}

impl Scenario {
    /// Time after which a match without a duration and without a clock ends, s.
    const LONGEST_WITHOUT_CLOCK_S: f32 = 60.0;

    /// Returns whether the match has this robot, either in the list or in a team.
    pub fn has_robot(&self, id: RobotId) -> bool {
        let lined_up = self.teams.is_some() && (1..=self.rules.team_size + self.rules.substitutes).contains(&id.number);
        lined_up || self.robots.iter().any(|robot| robot.id() == id)
    }

    /// Returns the time at which the match ends at the latest, s since its start. Returns `None` if it ends with the final whistle.
    pub fn end_s(&self) -> Option<f32> {
        let longest_s = self.longest_s()?;
        let begins_s = self.first_cycle() as f64 * self.cycle_s;
        Some(longest_s + begins_s as f32)
    }

    /// Returns the longest duration of the match, s. Returns `None` if it ends with the final whistle.
    pub fn longest_s(&self) -> Option<f32> {
        self.duration_s.or((!self.rules.clock).then_some(Self::LONGEST_WITHOUT_CLOCK_S))
    }

    /// Returns the cycle after which the match begins: that of the saved match, or 0.
    pub fn first_cycle(&self) -> u64 {
        self.from.as_ref().map_or(0, |saved| saved.cycle)
    }

    /// Returns the specification of a robot, from the list or from its team.
    pub fn robot(&self, id: RobotId) -> RobotSpec {
        let listed = self.robots.iter().find(|robot| robot.id() == id).cloned();
        let lined_up = || self.teams.as_ref().map(|teams| teams.robot(id.team, id.number));
        listed.or_else(lined_up).unwrap_or_else(|| RobotSpec { team: id.team, number: id.number, ..default() })
    }

    /// Returns all settings of a robot: its own or otherwise the common ones, with the handicap of its team.
    pub fn settings_of(&self, robot: &RobotSpec) -> RobotSettings {
        let handicap = self.teams.as_ref().map_or(0.0, |teams| teams.robots[robot.team].handicap);
        self.settings.patched(&robot.own).with_handicap(handicap)
    }

    /// Returns the body of a robot: its own or otherwise the common one.
    pub fn body_of(&self, robot: &RobotSpec) -> Body {
        robot.own.body.unwrap_or(self.settings.body)
    }

    /// Returns the message limits of a robot: its own or otherwise the common ones, and never more than the match allows.
    pub fn message_limits_of(&self, robot: &RobotSpec) -> MessageLimits {
        self.messages.limits_with(&robot.own.messages.unwrap_or(self.settings.messages))
    }

    /// All balls at the start, the first first.
    pub fn balls(&self) -> impl Iterator<Item = BallSpec> {
        let like_first = |start: &BallStart| {
            let BallStart { position_m, velocity_mps } = *start;
            self.ball.map(|ball| BallSpec { position_m, velocity_mps, ..ball })
        };
        self.ball.into_iter().chain(self.more_balls.iter().filter_map(like_first))
    }

    /// From a list of all balls, the first gives the ball its start.
    fn take_first_ball(&mut self) {
        if !self.more_balls.is_empty() {
            let BallStart { position_m, velocity_mps } = self.more_balls.remove(0);
            self.ball = Some(BallSpec { position_m, velocity_mps, ..self.ball.unwrap_or_default() });
        }
    }

    /// Makes a list of all balls, if there are several.
    fn put_first_ball_back(&mut self) {
        if let (Some(BallSpec { position_m, velocity_mps, .. }), false) = (self.ball, self.more_balls.is_empty()) {
            self.more_balls.insert(0, BallStart { position_m, velocity_mps });
        }
    }

    /// Returns the cycle after which the match ends at the latest. Returns `None` if it ends with the final whistle.
    pub fn last_cycle(&self) -> Option<u64> {
        let longest_s = self.longest_s()?;
        Some(self.first_cycle() + (f64::from(longest_s) / self.cycle_s).round() as u64)
    }
}

macro_rules! scenario_form {
    (
        { $($(#[$attribute:meta])* $field:ident: $field_type:ty,)* }
        exact { $($(#[$exact_meta:meta])* $exact:ident: $exact_type:ty,)* }
        real { $($(#[$real_meta:meta])* $real:ident: $real_type:ty [$($error:literal),*],)* }
        messages { $(#[$messages_meta:meta])* $messages:ident: $messages_type:ty [$($messages_error:literal),*], }
        program { $($(#[$program_meta:meta])* $program:ident: $program_type:ty,)* }
    ) => {
        /// The file form of a [`Scenario`].
        #[derive(Clone, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        #[schemars(rename = "Scenario")]
        pub(super) struct ScenarioForm {
            $($(#[$attribute])* $field: $field_type,)*
            $($(#[$exact_meta])* $exact: $exact_type,)*
            $($(#[$real_meta])* $real: $real_type,)*
            $($(#[$program_meta])* $program: $program_type,)*
            /// How messages travel, and the most that robots send.
            messages: MessagesForm,
        }

        impl From<ScenarioForm> for Scenario {
            fn from(form: ScenarioForm) -> Self {
                let (messages, limits) = form.messages.into();
                let settings = RobotSettings {
                    $($exact: form.$exact,)* $($real: form.$real,)* messages: limits, $($program: form.$program,)*
                };
                let mut scenario = Self { $($field: form.$field,)* settings, messages };
                scenario.take_first_ball();
                scenario
            }
        }

        impl From<Scenario> for ScenarioForm {
            fn from(mut scenario: Scenario) -> Self {
                scenario.put_first_ball_back();
                let settings = scenario.settings;
                Self {
                    $($field: scenario.$field,)*
                    $($exact: settings.$exact,)* $($real: settings.$real,)* $($program: settings.$program,)*
                    messages: (scenario.messages, settings.messages).into(),
                }
            }
        }
    };
}

robot_settings! { scenario_form {
    /// A name for display.
    name: String,
    /// What it shows, in a sentence.
    description: String,
    /// The path of a saved match that the match continues.
    #[serde(skip_serializing_if = "Option::is_none")]
    from: Option<SavedMatch>,
    /// Seed of all random numbers.
    seed: u64,
    /// Duration of a cycle, s.
    #[schemars(range(min = 0.001, max = 1.0))]
    cycle_s: f64,
    /// Duration of the match, s. Without it, the match ends with the final whistle, or after 60 s if the rules have no clock.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1_000_000.0))]
    duration_s: Option<f32>,
    /// The league for settings that are not given, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    league: Option<String>,
    /// The model of the robots.
    model: String,
    /// The realism of settings that are not given.
    realism: RealismSettings,
    /// The sizes of pitch and goals.
    field: Pitch,
    /// The rules of the match.
    rules: Rules,
    /// The ball; `null` for none.
    ball: Option<BallSpec>,
    /// Where balls start, if there are several: with the rules `free`. The first is `ball`, and the others are like it.
    #[serde(rename = "balls", skip_serializing_if = "Vec::is_empty")]
    more_balls: Vec<BallStart>,
    /// The robots, each with its place and its behaviour.
    robots: Vec<RobotSpec>,
    /// Two built-in teams lined up for a kick-off, instead of `robots`.
    teams: Option<TeamsSpec>,
    /// Posts besides those of the goals.
    posts: Vec<PostSpec>,
    /// Interventions of the referee, with their times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    interventions: Vec<TimedIntervention>,
    /// Expectations of the match, tested by `naoisis check --play`.
    #[serde(rename = "expect", skip_serializing_if = "Vec::is_empty")]
    expectations: Vec<Expectation>,
} }

impl Default for ScenarioForm {
    fn default() -> Self {
        Scenario::default().into()
    }
}

/// The ball at the start.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BallSpec {
    /// Centre, m, pitch frame. Two numbers are a place on the ground; a third is the height of the centre. A ball that is lower than its
    /// radius lies on the ground.
    #[serde(with = "super::plane_or_space")]
    #[schemars(with = "Vec<f32>", extend("minItems" = 2, "maxItems" = 3))]
    pub position_m: Vec3,
    /// Velocity, m/s, pitch frame. A third number is the vertical velocity, positive upwards.
    #[serde(with = "super::plane_or_space")]
    #[schemars(with = "Vec<f32>", extend("minItems" = 2, "maxItems" = 3))]
    pub velocity_mps: Vec3,
    /// Radius, m: 0.03 (paper, section 3.1).
    #[schemars(range(min = 0.005, max = 0.5))]
    pub radius_m: f32,
    /// How it slows down.
    pub rolling: Rolling,
    /// Share of the approach speed that is left after a bounce: 0.4 (rUNSWift 2019).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub restitution: f32,
    /// How it flies.
    pub flight: FlightPhysics,
    /// Its colours in images: `orange`, or `pentagons` for white with black pentagons.
    #[reflect(default)]
    #[serde(skip_serializing_if = "BallLook::is_orange")]
    pub look: BallLook,
}

impl Default for BallSpec {
    fn default() -> Self {
        let at_rest = Self {
            position_m: Vec3::ZERO,
            velocity_mps: Vec3::ZERO,
            radius_m: 0.0,
            rolling: Rolling::default(),
            restitution: 0.0,
            flight: FlightPhysics::default(),
            look: BallLook::default(),
        };
        at_rest.with_physics(BallPhysics::default())
    }
}

impl BallSpec {
    /// Returns the ball's position on the ground, m, pitch frame.
    pub fn place_m(&self) -> Vec2 {
        self.position_m.truncate()
    }

    /// Returns height and vertical velocity at the start.
    pub fn start_flight(&self) -> BallFlight {
        BallFlight { height_m: (self.position_m.z - self.radius_m).max(0.0), climb_mps: self.velocity_mps.z }
    }

    /// Returns the ball's physical parameters.
    pub fn physics(&self) -> BallPhysics {
        let Self { radius_m, rolling, restitution, flight, look, .. } = *self;
        BallPhysics { radius_m, rolling, restitution, flight, look }
    }

    /// Returns the same ball at the same position with other physical parameters.
    #[must_use]
    pub fn with_physics(self, physics: BallPhysics) -> BallSpec {
        let BallPhysics { radius_m, rolling, restitution, flight, look } = physics;
        BallSpec { radius_m, rolling, restitution, flight, look, ..self }
    }
}

/// Where one of several balls starts.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BallStart {
    /// Centre, m, pitch frame, as in [`BallSpec::position_m`].
    #[serde(with = "super::plane_or_space")]
    #[schemars(with = "Vec<f32>", extend("minItems" = 2, "maxItems" = 3))]
    pub position_m: Vec3,
    /// Velocity, m/s, pitch frame, as in [`BallSpec::velocity_mps`].
    #[serde(with = "super::plane_or_space")]
    #[schemars(with = "Vec<f32>", extend("minItems" = 2, "maxItems" = 3))]
    pub velocity_mps: Vec3,
}

/// An extra post: a vertical cylinder.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PostSpec {
    /// Centre on the ground, m, pitch frame.
    #[schemars(with = "[f32; 2]")]
    pub position_m: Vec2,
    /// Radius, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1.0))]
    pub radius_m: f32,
    /// Height, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 10.0))]
    pub height_m: f32,
}

impl Default for PostSpec {
    fn default() -> Self {
        Self { position_m: Vec2::ZERO, radius_m: 0.05, height_m: 0.8 }
    }
}
