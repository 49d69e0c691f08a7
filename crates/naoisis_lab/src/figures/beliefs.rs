//! Figure 7: the belief of a robot about its opponent in three stages: before any observation, with its camera, and
//! with its sonar while the camera looks elsewhere.

use bevy::math::{Vec2, ops};
use serde_json::json;

use super::FigureError;
use super::axes::{Axes, Plan, caption, remark};
use super::figure_match::{FigureMatch, PINK};
use naoisis_core::geometry::{Pose, to_degrees};
use naoisis_core::pitch::End;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_record::record::canvas::{Anchor, Canvas, GREY, INK, PAPER};
use naoisis_record::record::marks::{
    self, ORANGE, SKY_BLUE, VERMILION, YELLOW, bright_arrow, bright_line, confidence_ellipse, key, sd_along_and_across,
    sector,
};
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::belief::{Belief, RobotBelief, SimpleBelief, point_pitch_from_team, team_from_pitch};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

const SIZE: Vec2 = Vec2::new(1600.0, 1080.0);
/// The scenario: the robot on the right believes, the robot on the left is its opponent.
fn scenario(model: &RobotModel) -> Result<String, FigureError> {
    let alone = FigureMatch::begin(model, r#"{ "rules": "free", "ball": null, "robots": [{ "team": "pink" }] }"#)?;
    let [away, ahead, down] =
        [[100.0, 0.0], [0.0, 5.0], [95.0, 20.0]].map(|angles| alone.within_head_limits(PINK, angles));
    let scenario = json!({
        "rules": "free", "seed": 7, "ball": { "position_m": [0.2, -0.55] },
        "robots": [
            // The opponent comes nearer while the robot looks elsewhere.
            { "team": "blue", "number": 1, "pose": [-0.62, 0.16, -20.0], "behaviour": { "script": [
                { "from_s": 2.9, "until_s": 4.2, "walk": [0.005, 0.0, 0.0] }
            ] } },
            { "team": "pink", "number": 1, "pose": [0.85, -0.1, 172.0], "head_deg": away, "behaviour": { "script": [
                { "from_s": 1.0, "head_deg": ahead },
                { "from_s": 1.6, "until_s": 5.7, "walk": [0.006, 0.0, 0.0] },
                { "from_s": 2.4, "head_deg": down },
            ] } },
        ],
    });
    Ok(scenario.to_string())
}

const CYCLES: usize = 190;

/// The sensors of the robot.
struct Senses {
    sonar: SonarSettings,
    /// Half of the horizontal angle of view of its first camera, radians.
    half_view: f32,
}

impl Senses {
    fn of(played: &FigureMatch) -> Result<Senses, FigureError> {
        let lacking = |what| FigureError::Lacking { figure: 7, what };
        let sonar: SonarSettings = played.robot(PINK);
        let head: HeadLimits = played.robot(PINK);
        let cameras: CameraSettings = played.robot(PINK);
        let camera = cameras.mounts.as_slice().first().ok_or(lacking("what a camera sees"))?;
        if !sonar.fitted {
            return Err(lacking("what sonars hear"));
        }
        if !head.moves() || head.yaw[1] <= head.yaw[0] {
            return Err(lacking("what a head sees that looks away and ahead"));
        }
        Ok(Senses { sonar, half_view: ops::atan(cameras.intrinsics(camera).half_slopes().x) })
    }
}

/// The truth and the belief at the end of a cycle.
struct Sample {
    time_s: f32,
    scene: Scene,
    own: Pose,
    opponent: Pose,
    head: HeadAngles,
    sonar: SonarReading,
    belief: Belief,
}

impl Sample {
    fn of(played: &FigureMatch) -> Sample {
        let app = &played.app;
        Sample {
            time_s: played.time_s() as f32,
            scene: played.scene().clone(),
            own: app.robot_pose(PINK).unwrap_or_default(),
            opponent: app.robot_pose(super::figure_match::BLUE).unwrap_or_default(),
            head: app.robot::<HeadAngles>(PINK).copied().unwrap_or_default(),
            sonar: app.robot::<SonarReading>(PINK).copied().unwrap_or_default(),
            belief: app.robot::<Belief>(PINK).cloned().unwrap_or_default(),
        }
    }

    fn track(&self) -> Option<&RobotBelief> {
        self.belief.opponents.first()
    }

    fn heard(&self) -> bool {
        self.sonar.left.is_some() || self.sonar.right.is_some()
    }

    /// The error of the opponent's believed position, m.
    fn error_m(&self) -> Option<f32> {
        let place = point_pitch_from_team(self.track()?.position_m, End::PositiveX);
        Some(place.distance(self.opponent.position))
    }

    /// The standard deviations of the opponent's position along and across the line of sight, m.
    fn sd(&self) -> Option<[f32; 2]> {
        let track = self.track()?;
        Some(sd_along_and_across(track.covariance, self.belief.pose.position, track.position_m))
    }
}

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let mut played = FigureMatch::begin(model, &scenario(model)?)?;
    let senses = Senses::of(&played)?;
    let pink = played.app.world().resource::<Roster>().get(PINK);
    let own = team_from_pitch(played.app.robot_pose(PINK).unwrap_or_default(), End::PositiveX);
    let Some(pink) = pink else { return Err(missing("the robot does not play")) };
    played.app.world_mut().entity_mut(pink).insert((SimpleBelief::default(), Belief::at(own)));
    let mut samples = vec![Sample::of(&played)];
    played.play(CYCLES, |played| samples.push(Sample::of(played)));

    let seen = samples.iter().position(|sample| sample.track().is_some());
    let seen = seen.ok_or(missing("the opponent was not seen"))?;
    let before_echo = |index: &usize| samples[*index + 1].heard() && samples[*index].track().is_some();
    let remembered = (seen..samples.len() - 1).find(before_echo).ok_or(missing("the opponent was not heard"))?;
    // After a few cycles the robot believes the echo.
    let heard = (remembered + 12).min(samples.len() - 1);
    let nothing = seen.saturating_sub(24);

    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    let panels = [
        ("a", "No information yet", nothing, None),
        ("b", "Seen by the camera", seen, None),
        ("c", "Heard by the sonar", heard, Some(remembered)),
    ];
    for (column, (letter, words, index, earlier)) in panels.into_iter().enumerate() {
        let at = Vec2::new(96.0 + 508.0 * column as f32, 56.0);
        let sample = &samples[index];
        let words = format!("{words}, {:.1} s", sample.time_s);
        caption(&mut canvas, letter, &words, at - Vec2::Y * 16.0);
        draw_stage(&mut canvas, &senses, at, sample, earlier.map(|earlier| &samples[earlier]), column == 0);
    }
    let beliefs = [
        (YELLOW, "where the robot on the right thinks that its opponent is; 95 % ellipse"),
        (VERMILION, "the same just before its sonar heard anything"),
    ];
    key(&mut canvas, &beliefs, Vec2::new(96.0, 596.0));
    let others = [
        (SKY_BLUE, "where it thinks that it is itself; 95 % ellipse"),
        (ORANGE, "the distance that its sonars measure, and in grey, their sectors and the camera's view"),
    ];
    key(&mut canvas, &others, Vec2::new(820.0, 596.0));
    draw_deviations(&mut canvas, &samples, [("a", nothing), ("b", seen), ("c", heard)]);
    Ok(canvas.into_image())
}

fn missing(missing: &'static str) -> FigureError {
    FigureError::Missing { figure: 7, missing }
}

/// Draws a stage from above.
fn draw_stage(
    canvas: &mut Canvas,
    senses: &Senses,
    at: Vec2,
    sample: &Sample,
    earlier: Option<&Sample>,
    is_first: bool,
) {
    let plan = Plan::new(at, Vec2::new(452.0, 400.0), Vec2::new(-0.1, 0.0), 170.0, false);
    let mut picture = Canvas::scaled(plan.axes.size, canvas.scale(), PAPER);
    let inner = Plan { axes: Axes { at: Vec2::ZERO, ..plan.axes }, ..plan };
    inner.picture(&mut picture, &sample.scene);
    // The sectors of the sensors.
    let view = inner.places(sector(sample.own, sample.head.yaw, senses.half_view, [0.08, 4.0]));
    picture.fill(&view, PAPER, 0.13);
    picture.outline(&view, GREY, 1.5);
    let settings = senses.sonar;
    for (heading, distance) in [(settings.heading, sample.sonar.left), (-settings.heading, sample.sonar.right)] {
        let range = [settings.min_m, settings.max_m];
        picture.outline(&inner.places(sector(sample.own, heading, settings.half_angle, range)), GREY, 1.2);
        if let Some(distance) = distance {
            let echo = inner.places(marks::arc(sample.own, heading, settings.half_angle, distance));
            bright_line(&mut picture, &echo, ORANGE, 4.0);
        }
    }
    // The resulting belief.
    let own = sample.belief.pose_in_pitch(End::PositiveX);
    let [xx, xy, yy, ..] = sample.belief.pose_covariance;
    draw_pose(&mut picture, &inner, own);
    bright_line(&mut picture, &closed(inner.places(confidence_ellipse(own.position, [xx, xy, yy]))), SKY_BLUE, 2.5);
    if let Some(track) = earlier.and_then(Sample::track) {
        draw_track(&mut picture, &inner, track, VERMILION, 0.0);
    }
    match sample.track() {
        Some(track) => {
            draw_track(&mut picture, &inner, track, YELLOW, 0.25);
            let error = sample.error_m().unwrap_or_default();
            let sd = sample.sd().unwrap_or_default();
            let words = format!(
                "error {:.0} cm; along the line of sight \u{b1}{:.0} cm, across \u{b1}{:.0} cm",
                100.0 * error,
                100.0 * sd[0],
                100.0 * sd[1]
            );
            remark(canvas, &words, at + Vec2::new(0.0, plan.axes.size.y + 76.0));
            if let Some(error) = earlier.and_then(Sample::error_m) {
                let words =
                    format!("it came nearer unseen: just before the echo, the error was {:.0} cm", 100.0 * error);
                remark(canvas, &words, at + Vec2::new(0.0, plan.axes.size.y + 100.0));
            }
        }
        None => {
            let words = format!("the head is turned by {:.0}\u{b0}: no opponent is known", to_degrees(sample.head.yaw));
            remark(canvas, &words, at + Vec2::new(0.0, plan.axes.size.y + 76.0));
        }
    }
    canvas.pixels(&picture.into_image(), at);
    plan.axes.frame(canvas, [0.5; 2], ["x, m", if is_first { "y, m" } else { "" }]);
}

fn closed(mut places: Vec<Vec2>) -> Vec<Vec2> {
    places.extend(places.first().copied());
    places
}

/// Draws a believed position with its ellipse. It is in the team frame of the pink team, which defends +x.
fn draw_track(canvas: &mut Canvas, plan: &Plan, track: &RobotBelief, colour: Colour, cover: f32) {
    // The covariance of a frame turned by half a turn is the same.
    let place = point_pitch_from_team(track.position_m, End::PositiveX);
    let ellipse = plan.places(confidence_ellipse(place, track.covariance));
    canvas.fill(&ellipse, colour, cover);
    bright_line(canvas, &closed(ellipse), colour, 2.5);
    let centre = plan.place(place);
    for axis in [Vec2::X, Vec2::Y] {
        bright_line(canvas, &[centre - 6.0 * axis, centre + 6.0 * axis], colour, 2.0);
    }
}

/// Draws a believed pose: position and heading.
fn draw_pose(canvas: &mut Canvas, plan: &Plan, pose: Pose) {
    let [from, to] = [Vec2::ZERO, Vec2::X * 0.26].map(|place| plan.place(pose.transform_point(place)));
    bright_arrow(canvas, [from, to], SKY_BLUE, 2.5);
}

/// Plots the uncertainty of the opponent's position over time.
fn draw_deviations(canvas: &mut Canvas, samples: &[Sample], stages: [(&str, usize); 3]) {
    let at = Vec2::new(96.0, 722.0);
    let end_s = samples.last().map_or(1.0, |sample| sample.time_s);
    let axes = Axes { at, size: Vec2::new(1464.0, 270.0), across: [0.0, end_s], up: [0.0, 0.5] };
    axes.grid(canvas, [1.0, 0.1]);
    for (letter, index) in stages {
        let x = axes.place(Vec2::new(samples[index].time_s, 0.0)).x;
        canvas.dashes(&[Vec2::new(x, at.y), Vec2::new(x, at.y + axes.size.y)], INK, 1.5);
        canvas.words(&format!("({letter})"), Vec2::new(x + 6.0, at.y + 22.0), 19.0, Anchor::Left, INK);
    }
    let curve = |value: &dyn Fn(&Sample) -> Option<f32>| -> Vec<Vec2> {
        samples
            .iter()
            .filter_map(|sample| Some(axes.place(Vec2::new(sample.time_s, value(sample)?.min(0.5)))))
            .collect()
    };
    canvas.line(&curve(&|sample| Some(sample.sd()?[0])), VERMILION, 3.5);
    canvas.line(&curve(&|sample| Some(sample.sd()?[1])), marks::BLUE, 3.5);
    canvas.line(&curve(&Sample::error_m), INK, 2.0);
    axes.frame(canvas, [1.0, 0.1], ["time, s", "m"]);
    caption(canvas, "d", "Uncertainty and error over time", at - Vec2::Y * 16.0);
    for (index, (colour, words)) in [
        (VERMILION, "standard deviation along the line of sight"),
        (marks::BLUE, "standard deviation across it"),
        (INK, "distance from the truth"),
    ]
    .into_iter()
    .enumerate()
    {
        key(canvas, &[(colour, words)], Vec2::new(460.0 + 410.0 * index as f32, at.y - 22.0));
    }
}
