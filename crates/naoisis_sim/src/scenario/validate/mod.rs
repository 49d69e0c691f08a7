//! What types cannot say: that numbers are finite and within their ranges, and that nothing overlaps.

mod commands;
mod numbers;
mod placement;
mod robots;
mod settings;

pub use numbers::Numbers;
pub(super) use placement::place_ball_beside_robots;
use robots::SensorsAtBody;

use core::fmt::Display;
use core::ops::RangeInclusive;

use super::expectation::Quantity;
use super::fault::{ScenarioFault, WrongPlace};
use super::field_path::FieldPath;
use super::robot_spec::RobotSpec;
use super::types::Scenario;
use naoisis_core::geometry::to_degrees;
use naoisis_core::robot::motion::MotionLimits;
use naoisis_core::team::Team;
use naoisis_sensing::sensing::camera::CameraRendering;
use naoisis_sensing::sensing::fidelity::Fidelity;
use naoisis_sensing::sensing::vision::VisionSource;

impl Scenario {
    /// Checks what types cannot say. Names of behaviours and teams are not checked here: they are the program's.
    ///
    /// # Errors
    /// The first of the [faults](Scenario::faults).
    pub fn validate(&self) -> Result<(), ScenarioFault> {
        self.faults().into_iter().next().map_or(Ok(()), Err)
    }

    /// Everything that is wrong, numbers first, then places; of very many faults the first.
    pub fn faults(&self) -> Vec<ScenarioFault> {
        self.faults_besides(Vec::new(), &|_| true)
    }

    /// As [`Scenario::faults`], but for what may only come of the places in its file that are known to be wrong. `is_given` tells
    /// whether the file gives a value.
    pub(super) fn faults_besides(
        &self,
        mut wrong: Vec<WrongPlace>,
        is_given: &impl Fn(&FieldPath) -> bool,
    ) -> Vec<ScenarioFault> {
        let mut faults = self.faults_of_parts();
        faults.retain(|fault| !fault.may_come_of(&wrong, is_given));
        wrong.extend(faults.iter().map(WrongPlace::from));
        faults.retain(|fault| !fault.may_come_of_others(&wrong));
        let mut more = self.checked(|checks| {
            checks.whole(self);
            checks.placement(self);
            // Whoever is to be lined up must have a sound pitch to stand on.
            if wrong.is_empty() && checks.faults.is_empty() {
                checks.room_at_kick_offs(self);
            }
        });
        more.retain(|fault| !fault.may_come_of(&wrong, is_given));
        faults.append(&mut more);
        faults
    }

    /// What is wrong with its settings, whose numbers are finite, wherever robots, ball and posts are.
    pub fn faults_of_settings(&self) -> Vec<ScenarioFault> {
        self.checked(|checks| {
            checks.parts(self);
            checks.whole(self);
        })
    }

    /// What is wrong with single settings, whatever is to be thought of them together.
    fn faults_of_parts(&self) -> Vec<ScenarioFault> {
        self.checked(|checks| checks.parts(self))
    }

    fn checked(&self, check: impl FnOnce(&mut Checks)) -> Vec<ScenarioFault> {
        let lengths = [self.robots.len(), self.posts.len(), self.interventions.len(), self.expectations.len()];
        let longer = LONGEST_LISTS.into_iter().zip(lengths).find(|((_, most), length)| length > most);
        if let Some(((field, most), length)) = longer {
            return vec![too_long(field, length, most)];
        }
        // With a number that is not finite nothing else can be judged.
        if let Err(fault) = Numbers::FINITE.check(self) {
            return vec![fault];
        }
        let mut checks = Checks::default();
        check(&mut checks);
        checks.faults
    }
}

/// Durations of a cycle that can be, s.
const CYCLE_S: RangeInclusive<f64> = 0.001..=1.0;

/// The most posts that a scenario may have besides those of the goals.
pub const MOST_POSTS: usize = 1000;
/// The most robots, posts and interventions that a scenario may have: more would take a program's memory and time for
/// nothing.
pub(super) const LONGEST_LISTS: [(&str, usize); 4] =
    [("robots", 2 * u8::MAX as usize), ("posts", MOST_POSTS), ("interventions", 10_000), ("expect", 1000)];

/// What is said of a list that is too long.
pub(super) fn too_long(field: &str, length: usize, most: usize) -> ScenarioFault {
    ScenarioFault::new(FieldPath::from(field), format!("`{field}` is a list of {length}"), format!("at most {most}"))
}

/// More faults than these say nothing new, and would take memory and time.
pub(super) const MOST_FAULTS: usize = 100;

/// Collects faults.
#[derive(Default)]
struct Checks {
    faults: Vec<ScenarioFault>,
}

impl Checks {
    fn fault(&mut self, path: FieldPath, message: impl Into<String>, expected: impl Into<String>) {
        self.push(ScenarioFault::new(path, message, expected));
    }

    /// The fault of a value that is wrong whatever the others are.
    fn value_fault(&mut self, path: FieldPath, message: impl Into<String>, expected: impl Into<String>) {
        self.push(ScenarioFault::new(path, message, expected).by_itself());
    }

    fn push(&mut self, fault: ScenarioFault) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(fault);
        }
    }

    /// That a value is within a range.
    fn range<T: PartialOrd + Display>(&mut self, path: FieldPath, value: T, range: RangeInclusive<T>, unit: &str) {
        if !range.contains(&value) {
            let name = path.name();
            let expected = format!("{} to {}{unit}", range.start(), range.end());
            self.value_fault(path, format!("`{name}` is {value}"), expected);
        }
    }

    /// That a value is above nought and not beyond `most`.
    fn positive(&mut self, path: FieldPath, value: f32, most: f32, unit: &str) {
        if !(value > 0.0 && value <= most) {
            let name = path.name();
            self.value_fault(path, format!("`{name}` is {value}"), format!("more than 0, at most {most}{unit}"));
        }
    }

    /// That an angle in radians is within a range of degrees.
    fn degrees(&mut self, path: FieldPath, radians: f32, range: RangeInclusive<f32>, unit: &str) {
        self.range(path, to_degrees(radians), range, unit);
    }

    fn probability(&mut self, path: FieldPath, value: f32) {
        self.range(path, value, 0.0..=1.0, ", a probability");
    }

    /// That robots that see by their images have some.
    fn image_source(&mut self, scenario: &Scenario) {
        if scenario.cameras.render != CameraRendering::Off {
            return;
        }
        let root = FieldPath::default();
        let lined_up = RobotSpec::default();
        let robots = (0..).zip(&scenario.robots).map(|(index, robot)| (root.field("robots").index(index), robot));
        let teams = scenario.teams.iter().map(|_| (root.clone(), &lined_up));
        for (path, robot) in robots.chain(teams) {
            let word = scenario.fidelity_of(robot).vision;
            let source = robot.vision.as_ref().unwrap_or(&scenario.vision).source;
            let by_word = word.is_some_and(|word| word == Fidelity::Image);
            if by_word || (word.is_none() && source == VisionSource::Image) {
                let message = "`render` is off, but robots see by their images";
                let fault = ScenarioFault::new(root.field("cameras").field("render"), message, "`software` or `auto`");
                self.push(fault.related_to(path.field("vision")));
                return;
            }
        }
    }

    /// What can be said of each setting by itself, or with its neighbours.
    fn parts(&mut self, scenario: &Scenario) {
        let root = FieldPath::default();
        self.range(root.field("cycle_s"), scenario.cycle_s, CYCLE_S, " s");
        if let Some(duration) = scenario.duration_s {
            self.positive(root.field("duration_s"), duration, 1e6, " s");
        }
        for error in scenario.field.errors() {
            let path = root.field("field");
            let limits = error.limited_by.map(|field| path.field(field));
            self.push(ScenarioFault::new(path.field(error.field), error.message, error.expected).judged_with(limits));
        }
        self.rules(&root.field("rules"), &scenario.rules);
        if let Some(ball) = &scenario.ball {
            self.ball(&root.field("ball"), ball);
        }
        self.body(&root.field("body"), &scenario.body);
        self.motion(&root.field("motion"), &scenario.motion);
        self.turn(&root.field("motion"), &scenario.motion, scenario.cycle_s);
        self.kicks(&root.field("kicks"), &scenario.kicks);
        self.falls(&root.field("falls"), &scenario.falls);
        self.latency(&root.field("latency"), scenario.latency);
        self.head(&root.field("head"), &scenario.head);
        self.sonar(&root.field("sonar"), &scenario.sonar);
        self.odometry(&root.field("odometry"), &scenario.odometry);
        self.cameras(&root.field("cameras"), &scenario.cameras);
        self.vision(&root.field("vision"), &scenario.vision);
        self.messages(&root.field("messages"), &scenario.messages);
        let common = SensorsAtBody { body: &scenario.body, mounts: &scenario.cameras.mounts, sonar: &scenario.sonar };
        self.sensors_at_body(&root, [&root.field("cameras"), &root.field("sonar")], common);
        for (index, robot) in scenario.robots.iter().enumerate() {
            self.robot(&root.field("robots").index(index), robot, scenario);
        }
        if let Some(teams) = &scenario.teams {
            let path = root.field("teams");
            for (side, name) in [("blue", &teams.blue), ("pink", &teams.pink)] {
                if name.trim().is_empty() {
                    let expected = "the name of a team, as `naoisis list teams` shows them";
                    self.value_fault(path.field(side), format!("`{side}` has no name"), expected);
                }
            }
            for team in Team::BOTH {
                // Numbers are given when they are lined up.
                self.robot(&path.field(team.name()), &teams.robot(team, 1), scenario);
            }
        }
        for (index, post) in scenario.posts.iter().enumerate() {
            let path = root.field("posts").index(index);
            self.positive(path.field("radius_m"), post.radius_m, 1.0, " m");
            self.positive(path.field("height_m"), post.height_m, 10.0, " m");
        }
    }

    /// What takes more than one part of the scenario to be said.
    fn whole(&mut self, scenario: &Scenario) {
        let root = FieldPath::default();
        self.image_source(scenario);
        self.numbers(&scenario.robots);
        if scenario.teams.is_some() && !scenario.robots.is_empty() {
            self.fault(root.field("teams"), "both `teams` and `robots` are given", "one of the two");
        }
        for (index, expectation) in scenario.expectations.iter().enumerate() {
            if let Quantity::OfRobot(robot, _) = expectation.quantity
                && !scenario.has_robot(robot)
            {
                let message = format!("there is no robot `{robot}` in the match");
                self.value_fault(root.field("expect").index(index), message, "a robot of the match");
            }
        }
        for (index, timed) in scenario.interventions.iter().enumerate() {
            self.intervention(&root.field("interventions").index(index), timed, scenario);
        }
    }

    fn robot(&mut self, path: &FieldPath, robot: &RobotSpec, scenario: &Scenario) {
        if robot.number == 0 {
            self.value_fault(path.field("number"), "`number` is 0", "a jersey number from 1 to 255");
        }
        if let Some(motion) = &robot.motion {
            self.motion(&path.field("motion"), motion);
            self.turn(&path.field("motion"), motion, scenario.cycle_s);
        }
        if let Some(body) = &robot.body {
            self.body(&path.field("body"), body);
        }
        if let Some(kicks) = &robot.kicks {
            self.kicks(&path.field("kicks"), kicks);
        }
        if let Some(falls) = &robot.falls {
            self.falls(&path.field("falls"), falls);
        }
        if let Some(latency) = robot.latency {
            self.latency(&path.field("latency"), latency);
        }
        if let Some(cameras) = &robot.cameras {
            self.cameras(&path.field("cameras"), cameras);
        }
        if let Some(head) = &robot.head_limits {
            self.head(&path.field("head"), head);
        }
        if let Some(sonar) = &robot.sonar {
            self.sonar(&path.field("sonar"), sonar);
        }
        if robot.body.is_some() || robot.cameras.is_some() || robot.sonar.is_some() {
            let own = SensorsAtBody {
                body: robot.body.as_ref().unwrap_or(&scenario.body),
                mounts: &robot.cameras.as_ref().unwrap_or(&scenario.cameras).mounts,
                sonar: robot.sonar.as_ref().unwrap_or(&scenario.sonar),
            };
            self.sensors_at_body(path, [&path.field("cameras"), &path.field("sonar")], own);
        }
        if let Some(odometry) = &robot.odometry {
            self.odometry(&path.field("odometry"), odometry);
        }
        if let Some(vision) = &robot.vision {
            self.vision(&path.field("vision"), vision);
        }
        if let Some(limits) = &robot.messages {
            self.message_limits(&path.field("messages"), limits);
        }
        let limits = robot.head_limits.as_ref().unwrap_or(&scenario.head);
        for (index, (angle, limit)) in
            robot.head.into_iter().zip([limits.yaw, limits.pitch_at(robot.head[0])]).enumerate()
        {
            // Limits that exclude nought are kept at the start by turning the head there.
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

    /// That within a cycle a robot can turn by less than half a turn to either side.
    fn turn(&mut self, path: &FieldPath, motion: &MotionLimits, cycle_s: f64) {
        let turn_deg = f64::from(to_degrees(motion.max_angular)) * cycle_s;
        // Of an impossible cycle enough is said.
        if turn_deg >= 180.0 && CYCLE_S.contains(&cycle_s) {
            let message = format!("with cycles of {cycle_s} s a robot could turn by {turn_deg:.0} degrees in one");
            self.fault(path.field("max_angular_degps"), message, "less than 180 degrees a cycle");
        }
    }

    /// That no two robots of a team share a number.
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
            let fault = ScenarioFault::new(other.field("number"), message, expected);
            self.push(fault.judged_with([other.field("team"), one.field("number"), one.field("team")]));
        }
    }
}
