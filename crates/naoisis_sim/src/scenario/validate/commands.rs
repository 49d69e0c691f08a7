//! Checks the commands to robots and to the match: behaviours, scripts, interventions.

use super::Checks;
use crate::scenario::field_path::FieldPath;
use crate::scenario::robot_spec::{BehaviourSpec, RobotSpec};
use crate::scenario::types::Scenario;
use crate::scenario::wording::{did_you_mean, one_of, quoted};
use naoisis_core::behaviour::script::ScriptEntry;
use naoisis_core::communication::MOST_ROBOTS;
use naoisis_core::game::{Intervention, Rules, TimedIntervention};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::kick::KickSettings;

impl Checks {
    /// Checks that a robot's behaviour can be executed.
    pub(super) fn behaviour(&mut self, path: &FieldPath, robot: &RobotSpec, scenario: &Scenario) {
        match &robot.behaviour {
            BehaviourSpec::Named(name) if name.trim().is_empty() => {
                let expected = "`idle`, the name of a behaviour, or a script";
                self.fault(path.field("behaviour"), "`behaviour` has no name", expected);
            }
            BehaviourSpec::Named(_) => {}
            BehaviourSpec::Program(words) => {
                if words.first().is_none_or(|word| word.trim().is_empty())
                    || words.iter().any(|word| word.contains('\0'))
                {
                    let expected = "the words of a command line, such as [\"python3\", \"my_team.py\"]";
                    self.fault(path.field("behaviour.program"), "`program` names no program", expected);
                }
            }
            BehaviourSpec::Policy(file) => {
                if file.trim().is_empty() {
                    self.fault(path.field("behaviour.policy"), "`policy` names no file", "the path of an ONNX file");
                }
            }
            BehaviourSpec::Script(entries) => {
                let kicks = robot.own.kicks.as_ref().unwrap_or(&scenario.settings.kicks);
                for (index, entry) in entries.iter().enumerate() {
                    let entry_path = path.field("behaviour.script").index(index);
                    self.script_entry(&entry_path, entry);
                    if let Some(kick) = entry.kick {
                        self.has_kick(&entry_path, kick.kick_type, kicks);
                    }
                    self.text(&entry_path, entry, scenario.message_limits_of(robot).max_text_bytes);
                }
            }
        }
    }

    /// Checks that a robot has the kick in an entry of its script.
    fn has_kick(&mut self, entry: &FieldPath, kick: KickType, kicks: &KickSettings) {
        if kicks.get(kick).is_some() {
            return;
        }
        let names: Vec<String> = kicks.types().map(|kick| kick.name().to_owned()).collect();
        let names = || names.iter().map(String::as_str);
        let message = format!("this robot has no kick {}{}", quoted(kick.name()), did_you_mean(kick.name(), names()));
        let expected =
            if names().next().is_none() { "none: it has no kicks at all".to_owned() } else { one_of(names()) };
        self.fault(entry.field("kick.type"), message, expected);
    }

    /// Checks an entry of a script. The size of its commands is checked during the match, which refuses what is too much.
    fn script_entry(&mut self, path: &FieldPath, entry: &ScriptEntry) {
        if let Some(until) = entry.until_s
            && until <= entry.from_s
        {
            let message = format!("`until_s` is {until}, and `from_s` {}", entry.from_s);
            let expected = "an end after the start, or none for a single cycle";
            self.fault(path.field("until_s"), message, expected);
        }
        let acts = entry.walk.is_some() || entry.kick.is_some() || entry.head.is_some() || entry.posture.is_some();
        if !acts && entry.say.is_none() && entry.request.is_none() {
            let expected = "`walk`, `kick`, `head_deg`, `posture`, `request` or `say`";
            self.fault(path.clone(), "this entry of a script does nothing", expected);
        }
    }

    /// Checks that an intervention can be executed when its time comes.
    pub(super) fn intervention(&mut self, path: &FieldPath, timed: &TimedIntervention, scenario: &Scenario) {
        let path = path.field("do");
        let carpet = scenario.field.carpet_half_extents();
        let (robot, place) = match timed.intervention {
            Intervention::PlaceBall { position_m, velocity_mps } => {
                self.ball_speed(path.field("place_ball.velocity_mps"), velocity_mps.extend(0.0));
                (None, Some(("place_ball.position_m", position_m)))
            }
            Intervention::DropBall { position_m } => (None, Some(("drop_ball.position_m", position_m))),
            Intervention::PlaceRobot { robot, pose } => {
                (Some(("place_robot.robot", robot)), Some(("place_robot.pose", pose.position)))
            }
            Intervention::Penalise { robot, .. } => (Some(("penalise.robot", robot)), None),
            Intervention::PickUp { robot } => (Some(("pick_up.robot", robot)), None),
            Intervention::Return { robot } => (Some(("return.robot", robot)), None),
            Intervention::Substitute { robot, by } => {
                if !scenario.has_robot(robot) {
                    let message = format!("there is no robot {robot}");
                    self.fault(path.field("substitute.robot"), message, "a robot of this scenario");
                }
                (Some(("substitute.by", by)), None)
            }
            Intervention::Timeout { team, duration_s } => {
                self.timeout(&path.field("timeout"), team.is_some(), duration_s, &scenario.rules);
                (None, None)
            }
            Intervention::SetScore { .. }
            | Intervention::Whistle
            | Intervention::KickOff { .. }
            | Intervention::Stop
            | Intervention::Resume => (None, None),
        };
        if let Some((field, robot)) = robot
            && !scenario.has_robot(robot)
        {
            let message = format!("there is no robot {robot}");
            self.fault(path.field(field), message, "a robot of this scenario");
        }
        if let Some((field, place)) = place
            && !place.abs().cmple(carpet).all()
        {
            let message = format!("({}, {}) is outside the carpet", place.x, place.y);
            let expected = format!("within ±{} m and ±{} m", carpet.x, carpet.y);
            self.fault(path.field(field), message, expected);
        }
    }

    /// Checks that the rules allow the time-out.
    fn timeout(&mut self, path: &FieldPath, of_team: bool, duration_s: Option<f32>, rules: &Rules) {
        if of_team && rules.timeouts == 0 {
            let expected = "rules with `timeouts`, or no `team`: a time-out of the referee";
            self.fault(path.field("team"), "by these rules a team has no time-outs", expected);
        }
        let longest_s = if of_team { rules.timeout_s } else { rules.referee_timeout_s };
        if let Some(duration_s) = duration_s
            && !(0.0..=longest_s).contains(&duration_s)
        {
            let message = format!("`duration_s` is {duration_s}");
            self.fault(path.field("duration_s"), message, format!("0 to {longest_s} s, as the rules say"));
        }
    }

    /// Checks that the message of an entry may be sent.
    fn text(&mut self, path: &FieldPath, entry: &ScriptEntry, most_bytes: Option<u32>) {
        let Some(say) = &entry.say else { return };
        if say.robots_m.len() > MOST_ROBOTS {
            let message = format!("this message tells of {} robots", say.robots_m.len());
            self.fault(path.field("say").field("robots_m"), message, format!("at most {MOST_ROBOTS} places"));
        }
        let Some(most_bytes) = most_bytes else { return };
        if say.text_bytes() > most_bytes as usize {
            let message = format!("the texts of this message have {} bytes", say.text_bytes());
            self.fault(path.field("say"), message, format!("at most {most_bytes} bytes, `messages.max_text_bytes`"));
        }
    }
}
