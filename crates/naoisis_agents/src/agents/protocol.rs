//! The messages between a match and a program that plays one of its robots.
//!
//! The program starts with a [`Hello`]. The match answers with a [`Welcome`], or with a reason why the program may not
//! play. From then on the match sends one [`Perceive`] per cycle, and the program answers each with one [`Answer`], until
//! the match ends.

use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use schemars::JsonSchema;
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

use naoisis_core::behaviour::drawings::Drawing;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::camera_model::CameraName;
use naoisis_core::events::{CommandKind, Refusal};
use naoisis_core::game::{Rules, Score};
use naoisis_core::geometry::{Pose, file_units};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::interface::command::CommandError;
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::interface::vocabulary::{Perception, RobotCommand};
use naoisis_sim::scenario::{RobotModel, RobotSettings, RobotSpec, Scenario};

/// The version of the protocol that this library implements.
pub const PROTOCOL: u32 = 1;

/// The encoding of messages after the hello.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// One JSON object per line.
    #[default]
    Json,
    /// MessagePack maps, each after its length in 4 bytes, big-endian.
    Msgpack,
}

/// The introduction of a program.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// The version of the protocol that the program uses.
    pub protocol: u32,
    /// The name of the program.
    #[serde(default)]
    pub name: String,
    /// The robot that the program wants to play. Ignored on a pipe, where the program plays the robot that it was started for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotId>,
    /// The password of the match, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
    /// The encoding of all further messages.
    #[serde(default)]
    pub encoding: Encoding,
    /// The cameras whose images the program wants.
    #[serde(default)]
    pub images: Vec<CameraName>,
    /// Whether the program wants the belief of the built-in estimator.
    #[serde(default)]
    pub belief: bool,
    /// The parts of the perception that the program wants, such as `percepts.ball` or `game.state`; if empty, all. Fewer parts take less
    /// time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<String>,
}

/// The first message of a program.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HelloMessage {
    /// The introduction.
    pub hello: Hello,
}

/// The decision of a program in a cycle, and, for people, how it came to it.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// The cycle of the message that this answers.
    #[serde(deserialize_with = "whole_number")]
    pub cycle: u64,
    /// The command for the robot.
    #[serde(default)]
    pub command: RobotCommand,
    /// The program's own belief, in the team frame. It takes the place of the built-in estimator's in this cycle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub belief: Option<Belief>,
    /// The intention in a word or two, for people. Team-mates learn only that of `say`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intention: Option<String>,
    /// The options of the decision and the choice, for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reasons: Option<Reasons>,
    /// Drawings on the pitch, for people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawings: Vec<Drawing>,
    /// Values to plot, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f32>,
}

impl Answer {
    /// Returns the answer, after checking that its numbers are finite. Drawings that are not finite are left out later.
    ///
    /// # Errors
    /// The part that is wrong.
    pub fn checked(mut self) -> Result<Self, CommandError> {
        self.command = self.command.checked()?;
        if let Some(Reasons { options, chosen: Some(chosen) }) = &self.reasons
            && *chosen >= options.len()
        {
            return Err(CommandError::NoSuchOption { chosen: *chosen, options: options.len() });
        }
        if self.belief.as_ref().is_some_and(has_negative_variance) {
            return Err(CommandError::NegativeVariance("belief"));
        }
        let options = self.reasons.iter().flat_map(|reasons| &reasons.options);
        if !self.belief.as_ref().is_none_or(Belief::is_finite) {
            Err(CommandError::NotFinite("belief"))
        } else if !self.values.values().chain(options.map(|option| &option.value)).all(|value| value.is_finite()) {
            Err(CommandError::NotFinite("values"))
        } else {
            Ok(self)
        }
    }

    /// The remarks in the answer.
    pub(super) fn take_remarks(&mut self) -> Remarks {
        Remarks { intention: self.intention.take(), values: core::mem::take(&mut self.values) }
    }
}

/// Whether a variance in a belief is negative, by more than rounding explains.
fn has_negative_variance(belief: &Belief) -> bool {
    let [x, _, y, _, _, heading] = belief.pose_covariance;
    let of_ball = belief.ball.iter().flat_map(|ball| [ball.position_covariance, ball.velocity_covariance]);
    let of_robots = belief.team_mates.iter().chain(&belief.opponents).map(|robot| robot.covariance);
    let of_places = of_ball.chain(of_robots).flat_map(|[x, _, y]| [x, y]);
    of_places.chain([x, y, heading]).any(|variance| variance < -1e-6)
}

/// Reads a whole number, which some languages write as `1.0`.
fn whole_number<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
    let number = f64::deserialize(deserializer)?;
    // All cycles of a match are exact in this type.
    if number >= 0.0 && number.fract() == 0.0 && number < 2_f64.powi(53) {
        Ok(number as u64)
    } else {
        Err(D::Error::invalid_value(Unexpected::Float(number), &"a whole number"))
    }
}

/// A message from a match to a program.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Message<'a> {
    /// The program may play.
    Welcome(Box<Welcome<'a>>),
    /// The program may not play.
    Refused {
        /// The reason.
        reason: &'a str,
        /// The version of the protocol of the match, for programs that know several.
        protocol: u32,
    },
    /// The match is over.
    End {
        /// The reason for the end, in words.
        reason: &'a str,
        /// Goals of both teams.
        score: Score,
    },
}

/// The information that a robot may have before the match.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Welcome<'a> {
    /// The version of the protocol.
    pub protocol: u32,
    /// The robot that the program plays.
    pub robot: RobotId,
    /// Where the robot stands at the start, as the people know who place it: `[x m, y m, heading deg]`, team frame. None for a program that
    /// comes later.
    #[serde(with = "file_units::optional_pose", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub pose: Option<Pose>,
    /// The duration of a cycle, s.
    pub cycle_s: f64,
    /// The number of robots of a team, without substitutes.
    pub team_size: u8,
    /// The dimensions of pitch and goals.
    pub field: &'a Pitch,
    /// The rules of the match.
    pub rules: &'a Rules,
    /// The model of the robot.
    pub model: Model,
    /// The realism of the match, in words.
    pub realism: String,
}

/// The abilities of a robot, named as in scenarios.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Model {
    /// The name of the model.
    pub name: String,
    /// The settings of the robot as in scenarios: its body, walk and kicks, its sensors with their errors, its delays, and the limits of
    /// its messages together with those of the match.
    #[serde(flatten)]
    pub settings: RobotSettings,
}

impl Model {
    /// The abilities of a robot of a scenario, by the settings of the robot, its team or its model, or else by those of the scenario.
    fn of(scenario: &Scenario, robot: &RobotSpec) -> Self {
        let name = RobotModel::name_of(robot.model.as_ref().unwrap_or(&scenario.model));
        let messages = scenario.message_limits_of(robot);
        Model { name, settings: RobotSettings { messages, ..scenario.settings_of(robot) } }
    }
}

impl<'a> Welcome<'a> {
    /// The information of a scenario that the robot with this id may have, and where it stands at the start.
    pub fn of(scenario: &'a Scenario, robot: RobotId, pose: Option<Pose>) -> Self {
        let plays = |spec: &&RobotSpec| spec.team == robot.team && !spec.substitute;
        let of_team = scenario.robots.iter().filter(plays).count();
        let team_size = if of_team > 0 { of_team as u8 } else { scenario.rules.team_size };
        Welcome {
            protocol: PROTOCOL,
            robot,
            pose,
            cycle_s: scenario.cycle_s,
            team_size,
            field: &scenario.field,
            rules: &scenario.rules,
            model: Model::of(scenario, &scenario.robot(robot)),
            realism: scenario.realism_in_words(),
        }
    }
}

/// The perception of a robot in a cycle.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Perceive<'a> {
    /// The current cycle, from 1.
    pub cycle: u64,
    /// The time of the perception, s since the start.
    pub time_s: f64,
    /// The perception as in a trace; only the `fields` of the hello, if it names any.
    #[schemars(with = "Perception")]
    pub perception: PerceptionParts<'a>,
    /// The commands of the robot that were refused in the last cycle.
    #[serde(skip_serializing_if = "<[RefusedCommand]>::is_empty")]
    pub refused: &'a [RefusedCommand],
    /// The belief of the built-in estimator, if the hello asked for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub belief: Option<&'a Belief>,
    /// New camera images by the names of the cameras, if the hello asked for them.
    #[schemars(with = "BTreeMap<String, ImageMessage<'static>>")]
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub images: BTreeMap<CameraName, ImageMessage<'a>>,
}

/// A command that was refused.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, JsonSchema)]
pub struct RefusedCommand {
    /// The part of the command.
    pub command: CommandKind,
    /// The reason.
    pub reason: Refusal,
}

/// The parts of a perception that a program wants.
#[derive(Clone, Copy, Debug)]
pub struct PerceptionParts<'a> {
    /// The whole perception.
    pub perception: &'a Perception,
    /// The parts that are sent.
    pub fields: &'a Fields,
}

impl Serialize for PerceptionParts<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.fields.of(self.perception).serialize(serializer)
    }
}

/// A camera image.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ImageMessage<'a> {
    /// The time at which the image was taken, s since the start.
    pub time_s: f64,
    /// The width, pixels.
    pub width: u32,
    /// The height, pixels.
    pub height: u32,
    /// Red, green and blue of each pixel, row by row from the top: base64 in JSON, raw bytes in MessagePack.
    #[serde(serialize_with = "bytes")]
    #[schemars(with = "String")]
    pub rgb: &'a [u8],
    /// The depth of each pixel along the axis of the camera, if the robot's cameras have `depth`: millimetres as 16-bit numbers in
    /// little-endian order, 0 for the sky; base64 in JSON, raw bytes in MessagePack.
    #[serde(serialize_with = "bytes", skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Option<String>")]
    pub depth_mm: Vec<u8>,
}

impl<'a> ImageMessage<'a> {
    /// Prepares `image`, taken at `time_s`, for sending.
    pub fn of(image: &'a Image, time_s: f64) -> Self {
        Self { time_s, width: image.width, height: image.height, rgb: &image.rgb, depth_mm: image.depth_mm() }
    }
}

fn bytes<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        serializer.collect_str(&Base64Display::new(bytes, &STANDARD))
    } else {
        serializer.serialize_bytes(bytes)
    }
}

/// A valid hello, shown in error messages.
pub const EXAMPLE_HELLO: &str = r#"{"hello": {"protocol": 1, "name": "my team"}}"#;

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn a_robot_is_told_of_its_own_body_with_any_team_mates() {
        let scenario = Scenario::from_json(
            r#"{ "league": "spl2025", "teams": {
                 "blue": { "team": "remote", "model": "booster_k1", "messages": { "max_text_bytes": 64 } }, "pink": "remote" } }"#,
        )
        .unwrap();
        let told = |team: Team| serde_json::to_value(Welcome::of(&scenario, RobotId::new(team, 2), None)).unwrap();
        let (k1, nao) = (told(Team::Blue), told(Team::Pink));
        let of_k1 = &k1["model"];
        assert_eq!((&of_k1["name"], &nao["model"]["name"]), (&"booster_k1".into(), &"nao_v6".into()));
        let number = |value: &serde_json::Value| value.as_f64().unwrap();
        assert!((number(&of_k1["body"]["height_m"]) - 0.95).abs() < 1e-6);
        assert!((number(&nao["model"]["body"]["torso"]["half_width_m"]) - 0.15).abs() < 1e-6);
        assert_eq!(of_k1["cameras"]["mounts"][0]["name"], "head");
        assert!(of_k1["kicks"]["own"]["visual"].is_object() && nao["model"]["kicks"]["own"]["visual"].is_null());
        assert_eq!(
            [&of_k1["messages"], &nao["model"]["messages"]].map(|own| own["max_text_bytes"].as_u64()),
            [Some(64), Some(128)]
        );
    }

    #[test]
    fn what_a_program_says_of_itself_must_make_sense() {
        let checked = |text: &str| {
            let answer: Answer = serde_json::from_str(&format!(r#"{{ "cycle": 1, {text} }}"#)).unwrap();
            answer.checked().map_err(|error| error.to_string())
        };
        let options = r#""options": [{ "name": "pass" }, { "name": "shoot" }]"#;
        assert!(checked(&format!(r#""reasons": {{ {options}, "chosen": 1 }}"#)).is_ok());
        let error = checked(&format!(r#""reasons": {{ {options}, "chosen": 2 }}"#)).unwrap_err();
        assert_eq!(error, "`reasons.chosen` is 2, of 2 options; expected the index of one of them, from 0");
        let ball = |variance: f32| {
            checked(&format!(
                r#""belief": {{ "ball": {{ "position_m": [1, 2], "position_covariance": [0.1, 0, {variance}] }} }}"#
            ))
        };
        assert!(ball(-1e-9).is_ok() && ball(0.0).is_ok());
        assert!(ball(-0.1).unwrap_err().starts_with("`belief` has a negative variance"));
    }

    #[test]
    fn a_robot_is_told_the_noise_that_its_sensors_have() {
        let welcome = |words: &str| {
            let text = format!(r#"{{ {words} "robots": [{{ "number": 1, "sonar": {{ "max_m": 0.5 }} }}] }}"#);
            let scenario = Scenario::from_json(&text).unwrap();
            serde_json::to_value(Welcome::of(&scenario, RobotId::new(Team::Blue, 1), None)).unwrap()
        };
        let (noisy, ideal) = (welcome(""), welcome(r#""fidelity": "ideal","#));
        assert!(noisy["model"]["sonar"]["noise"]["gaussian"].is_object(), "{noisy}");
        assert_eq!(ideal["model"]["sonar"]["noise"], "none");
        assert_eq!(ideal["model"]["vision"]["noise"]["head_angle_sd_deg"], 0.0);
        assert_eq!(ideal["model"]["odometry"]["noise"]["translation_sd_m"], 0.0);
    }

    #[test]
    fn a_robot_of_a_file_is_told_what_the_file_calls_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("my_file.ron");
        let text =
            r#"(name: "tall nao", description: "", settings: (body: (height_m: 0.6)), realistic: (), sources: {})"#;
        std::fs::write(&path, text).unwrap();
        let scenario = serde_json::json!({ "model": path, "robots": [{ "number": 1 }] }).to_string();
        let scenario = Scenario::from_json(&scenario).unwrap();
        let name = || Welcome::of(&scenario, RobotId::new(Team::Blue, 1), None).model.name;
        assert_eq!(name(), "tall nao");
        // A saved match is played without the file.
        std::fs::remove_file(&path).unwrap();
        assert_eq!(name(), "my_file");
    }
}
