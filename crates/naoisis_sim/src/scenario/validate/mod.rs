//! Checks what types cannot express: that numbers are finite and in their [ranges], that values agree, and that nothing overlaps.

mod commands;
mod numbers;
mod placement;
mod ranges;
mod robots;
mod settings;

pub use numbers::Numbers;
pub(super) use placement::place_ball_beside_robots;
use robots::SensorsAtBody;

use super::fault::ScenarioFault;
use super::field_path::FieldPath;
use super::quantity::Quantity;
use super::robot_settings::{RobotPatch, RobotSettings, robot_settings};
use super::robot_spec::RobotSpec;
use super::types::Scenario;
use naoisis_core::communication::MessageLimits;
use naoisis_core::geometry::to_degrees;
use naoisis_core::named_values::NamedValues;
use naoisis_core::referee::hearing::Hearing;
use naoisis_core::robot::condition::Breakdowns;
use naoisis_core::robot::latency::Latency;
use naoisis_core::robot::motion::MotionSettings;
use naoisis_core::team::Team;
use naoisis_sensing::belief::localisation_method::LocalisationMethod;
use naoisis_sensing::sensing::camera::CameraRendering;
use naoisis_sensing::sensing::odometry::OdometrySettings;
use naoisis_sensing::sensing::vision::{VisionSettings, VisionSource};

impl Scenario {
    /// Checks what types cannot express. Names of behaviours and teams are not checked, since only the program knows them.
    ///
    /// # Errors
    /// The first of the [faults](Scenario::faults).
    pub fn validate(&self) -> Result<(), ScenarioFault> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Returns the faults of single values or, if there are none, those of values together and of places. Very many faults are cut off.
    pub fn faults(&self) -> Vec<ScenarioFault> {
        let faults = self.faults_of_values();
        if faults.is_empty() { self.faults_together() } else { faults }
    }

    /// Returns the faults of the settings, independent of the places of robots, ball and posts.
    pub fn faults_of_settings(&self) -> Vec<ScenarioFault> {
        let faults = self.faults_of_values();
        if faults.is_empty() { checked(|checks| checks.together(self)) } else { faults }
    }

    /// Returns the faults of single values: numbers that are not finite or out of range, and lists that are too long.
    pub(super) fn faults_of_values(&self) -> Vec<ScenarioFault> {
        let [robots, posts] = [self.robots.len(), self.posts.len()];
        let lengths = [robots, posts, self.interventions.len(), self.expectations.len(), self.balls().count()];
        let longer = LONGEST_LISTS.into_iter().zip(lengths).find(|((_, most), length)| length > most);
        if let Some(((field, most), length)) = longer {
            return vec![too_long(field, length, most)];
        }
        // If a number is not finite, nothing else can be checked.
        if let Err(fault) = Numbers::FINITE.check(self) {
            return vec![fault];
        }
        let mut faults = ranges::faults(self);
        let path = FieldPath::from("field");
        faults.extend(
            self.field
                .errors()
                .into_iter()
                .map(|error| ScenarioFault::new(path.field(error.field), error.message, error.expected)),
        );
        faults.extend(checked(|checks| checks.rules(&FieldPath::from("rules"), &self.rules)));
        faults.truncate(MOST_FAULTS);
        faults
    }

    /// Returns the faults of values together, each of which is valid, and of places.
    pub(super) fn faults_together(&self) -> Vec<ScenarioFault> {
        checked(|checks| {
            checks.together(self);
            checks.placement(self);
            // Lining up the teams needs a valid pitch.
            if checks.faults.is_empty() {
                checks.room_at_kick_offs(self);
            }
        })
    }
}

fn checked(check: impl FnOnce(&mut Checks)) -> Vec<ScenarioFault> {
    let mut checks = Checks::default();
    check(&mut checks);
    checks.faults
}

/// Number of posts in a scenario at most, besides those of the goals.
pub const MOST_POSTS: usize = 1000;
/// The most robots, posts, balls and interventions that a scenario may have: more would take a program's memory and time for
/// nothing.
pub(super) const LONGEST_LISTS: [(&str, usize); 5] = [
    ("robots", 2 * u8::MAX as usize),
    ("posts", MOST_POSTS),
    ("interventions", 10_000),
    ("expect", 1000),
    ("balls", 100),
];

/// Returns the fault of a list that is too long.
pub(super) fn too_long(field: &str, length: usize, most: usize) -> ScenarioFault {
    ScenarioFault::new(FieldPath::from(field), format!("`{field}` is a list of {length}"), format!("at most {most}"))
}

/// Number of faults that are reported at most. More would only take memory and time.
pub(super) const MOST_FAULTS: usize = 100;

/// Collects faults.
#[derive(Default)]
struct Checks {
    faults: Vec<ScenarioFault>,
}

/// Generates calls of a check for each setting of a robot. The check has the setting's name and tests what involves several values.
macro_rules! checks_of_settings {
    ({} $($group:ident { $($(#[$documentation:meta])* $setting:ident: $type:ty $([$($error:literal),*])?,)* })*) => {
        impl Checks {
            /// Checks the settings of a robot at `path`.
            fn settings(&mut self, path: &FieldPath, settings: &RobotSettings) {
                $($(self.$setting(&path.field(stringify!($setting)), &settings.$setting);)*)*
            }

            /// Checks the own settings of a robot at `path`.
            fn patch(&mut self, path: &FieldPath, patch: &RobotPatch) {
                $($(if let Some(own) = &patch.$setting {
                    self.$setting(&path.field(stringify!($setting)), own);
                })*)*
            }
        }
    };
}
robot_settings! { checks_of_settings {} }

impl Checks {
    /// Settings that need no other check than their ranges.
    fn breakdowns(&mut self, _: &FieldPath, _: &Breakdowns) {}
    fn hearing(&mut self, _: &FieldPath, _: &Hearing) {}
    fn latency(&mut self, _: &FieldPath, _: &Latency) {}
    fn odometry(&mut self, _: &FieldPath, _: &OdometrySettings) {}
    fn vision(&mut self, _: &FieldPath, _: &VisionSettings) {}
    fn messages(&mut self, _: &FieldPath, _: &MessageLimits) {}
    fn localisation(&mut self, _: &FieldPath, _: &LocalisationMethod) {}
    fn sensors(&mut self, _: &FieldPath, _: &NamedValues) {}

    fn fault(&mut self, path: FieldPath, message: impl Into<String>, expected: impl Into<String>) {
        self.push(ScenarioFault::new(path, message, expected));
    }

    fn push(&mut self, fault: ScenarioFault) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(fault);
        }
    }

    /// Checks that images are made for robots that see by images.
    fn image_source(&mut self, scenario: &Scenario) {
        if scenario.settings.cameras.render != CameraRendering::Off {
            return;
        }
        let root = FieldPath::default();
        let lined_up = RobotSpec::default();
        let robots = (0..).zip(&scenario.robots).map(|(index, robot)| (root.field("robots").index(index), robot));
        let teams = scenario.teams.iter().map(|_| (root.clone(), &lined_up));
        for (path, robot) in robots.chain(teams) {
            let source = robot.own.vision.as_ref().unwrap_or(&scenario.settings.vision).source;
            if source == VisionSource::Image {
                let message = "`render` is off, but robots see by their images";
                let fault = ScenarioFault::new(root.field("cameras").field("render"), message, "`software` or `auto`");
                self.push(fault.related_to(path.field("vision")));
                return;
            }
        }
    }

    /// Checks what involves more than one value.
    fn together(&mut self, scenario: &Scenario) {
        self.parts(scenario);
        self.whole(scenario);
    }

    /// Checks each part of the scenario together with the settings of all robots.
    fn parts(&mut self, scenario: &Scenario) {
        let root = FieldPath::default();
        for (index, ball) in scenario.balls().enumerate() {
            self.ball_speed(scenario.path_of_ball(index).field("velocity_mps"), ball.velocity_mps);
        }
        self.settings(&root, &scenario.settings);
        self.turn(&root.field("motion"), &scenario.settings.motion, scenario.cycle_s);
        let common = SensorsAtBody::of(&scenario.settings);
        self.sensors_at_body([&root.field("cameras"), &root.field("sonar")], common);
        for (index, robot) in scenario.robots.iter().enumerate() {
            self.robot(&root.field("robots").index(index), robot, scenario);
        }
        if let Some(teams) = &scenario.teams {
            let path = root.field("teams");
            for (side, name) in [("blue", &teams.blue), ("pink", &teams.pink)] {
                if name.trim().is_empty() {
                    let expected = "the name of a team, as `naoisis list teams` shows them";
                    self.fault(path.field(side), format!("`{side}` has no name"), expected);
                }
            }
            for team in Team::BOTH {
                // Robots of teams get their numbers when they are lined up.
                self.robot(&path.field(team.name()), &teams.robot(team, 1), scenario);
            }
        }
    }

    /// Checks what involves more than one part of the scenario.
    fn whole(&mut self, scenario: &Scenario) {
        let root = FieldPath::default();
        self.image_source(scenario);
        self.one_ball(scenario);
        self.numbers(&scenario.robots);
        if scenario.teams.is_some() && !scenario.robots.is_empty() {
            self.fault(root.field("teams"), "both `teams` and `robots` are given", "one of the two");
        }
        for (index, expectation) in scenario.expectations.iter().enumerate() {
            if let Quantity::OfRobot(robot, _) = expectation.quantity
                && !scenario.has_robot(robot)
            {
                let message = format!("there is no robot `{robot}` in the match");
                self.fault(root.field("expect").index(index), message, "a robot of the match");
            }
        }
        for (index, timed) in scenario.interventions.iter().enumerate() {
            self.intervention(&root.field("interventions").index(index), timed, scenario);
        }
    }

    fn robot(&mut self, path: &FieldPath, robot: &RobotSpec, scenario: &Scenario) {
        self.patch(path, &robot.own);
        if let Some(motion) = &robot.own.motion {
            self.turn(&path.field("motion"), motion, scenario.cycle_s);
        }
        let settings = scenario.settings_of(robot);
        if robot.own.body.is_some() || robot.own.cameras.is_some() || robot.own.sonar.is_some() {
            let sensors = SensorsAtBody::of(&settings);
            self.sensors_at_body([&path.field("cameras"), &path.field("sonar")], sensors);
        }
        let limits = &settings.head;
        for (index, (angle, limit)) in
            robot.head_angles.into_iter().zip([limits.yaw, limits.pitch_at(robot.head_angles[0])]).enumerate()
        {
            // An angle of zero outside the limits is no fault: the head turns into its limits at the start.
            if angle != 0.0 && !(limit[0]..=limit[1]).contains(&angle) {
                let name = ["yaw", "pitch"][index];
                let [least, most] = limit.map(to_degrees);
                self.fault(
                    path.field("head_deg").index(index),
                    format!("the head's {name} is {} degrees", to_degrees(angle)),
                    format!("{least} to {most} degrees, this robot's limits"),
                );
            }
        }
        self.behaviour(path, robot, scenario);
    }

    /// Checks that a robot can turn by less than half a turn to either side in a cycle.
    fn turn(&mut self, path: &FieldPath, motion: &MotionSettings, cycle_s: f64) {
        let turn_deg = f64::from(to_degrees(motion.max_angular)) * cycle_s;
        if turn_deg >= 180.0 {
            let message = format!("with cycles of {cycle_s} s a robot could turn by {turn_deg:.0} degrees in one");
            self.fault(path.field("max_angular_degps"), message, "less than 180 degrees a cycle");
        }
    }

    /// Checks that no two robots of a team have the same number.
    fn numbers(&mut self, robots: &[RobotSpec]) {
        let mut order: Vec<usize> = (0..robots.len()).collect();
        order.sort_by_key(|&index| (robots[index].id(), index));
        let mut repeated: Vec<(usize, usize)> = order
            .windows(2)
            .map(|pair| (pair[0], pair[1]))
            .filter(|&(first, second)| robots[first].id() == robots[second].id())
            .collect();
        repeated.sort_by_key(|&(_, second)| second);
        for (first, second) in repeated {
            let [one, other] = [first, second].map(|index| FieldPath::default().field("robots").index(index));
            let message = format!("there is a {} already: {one}", robots[second].id());
            let expected = "a number that no other robot of the team has";
            self.fault(other.field("number"), message, expected);
        }
    }
}
