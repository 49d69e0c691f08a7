//! Figure 8: a match of one against one. Above the field, below the view of the pink robot, with the camera that shows
//! it the ball if there is one.

use bevy::math::Vec2;

use super::FigureError;
use super::figure_match::{self, FigureMatch, PINK, pixels, supersampling, view_of_robot};
use naoisis_core::camera_model::{CameraMount, CameraName};
use naoisis_core::events::MatchEvent;
use naoisis_core::game::GameState;
use naoisis_core::team::Team;
use naoisis_record::record::canvas::{Anchor, Canvas, GREY, INK, PAPER, ellipse};
use naoisis_record::record::marks::YELLOW;
use naoisis_record::record::match_renderer::view_of_field;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

const PAGE_WIDTH: f32 = 1600.0;
const COLUMNS: usize = 4;
const SAMPLES: usize = 8;
const WIDTH: f32 = 374.0;
const FIELD_HEIGHT: f32 = 214.0;
/// The longest time to wait for a goal, cycles.
const MOST_CYCLES: usize = 1_500;
/// The number of seeds that are tried. The figure shows the first match with an early goal, whichever way the teams
/// play.
const SEEDS: u64 = 40;

/// The scene after a cycle.
struct Sample {
    time_s: f64,
    scene: Scene,
}

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    // A robot without a camera does not score, so there would be no goal to wait for.
    if model.scenario()?.settings.cameras.mounts.as_slice().is_empty() {
        return Err(FigureError::Lacking { figure: 8, what: "what a camera sees" });
    }
    let Goal { samples, scorer, cameras } = first_goal(model)?;
    let height_of = |mount: &CameraMount| {
        let [width, height] = mount.size.unwrap_or([cameras.width, cameras.height]);
        WIDTH * height as f32 / width as f32
    };
    let view_height = cameras.mounts.as_slice().iter().map(height_of).fold(0.0, f32::max);
    let row_height = FIELD_HEIGHT + view_height + 83.5;
    let mut canvas = Canvas::scaled(Vec2::new(PAGE_WIDTH, 24.0 + 2.0 * row_height), scale, PAPER);
    let last = samples.len() - 1;
    let begin_s = samples[0].time_s;
    for place in 0..SAMPLES {
        let sample = &samples[place * last / (SAMPLES - 1)];
        let (column, row) = ((place % COLUMNS) as f32, (place / COLUMNS) as f32);
        let at = Vec2::new(30.0 + 388.7 * column, 48.0 + row_height * row);
        let words = match place {
            0 => "kick-off".to_owned(),
            7 => format!("{:.1} s: goal for {scorer}", sample.time_s - begin_s),
            _ => format!("{:.1} s", sample.time_s - begin_s),
        };
        canvas.words(&words, at - Vec2::Y * 10.0, 21.0, Anchor::Left, INK);
        let size = Vec2::new(WIDTH, FIELD_HEIGHT);
        let size = pixels(size, scale);
        let view = View { supersampling: supersampling(size), ..view_of_field(&sample.scene.pitch, size) };
        canvas.pixels(&figure_match::draw(&sample.scene, &view), at);
        if let Some(pixel) = sample.scene.ball.and_then(|ball| view.project(ball.centre())) {
            // The ball is so small that it needs a ring.
            let ring = ellipse(at + pixel / scale, Vec2::X * 9.0, Vec2::Y * 9.0);
            canvas.outline(&ring, YELLOW, 2.0);
        }
        let below = at + Vec2::Y * (FIELD_HEIGHT + 4.0);
        match view_with_ball(sample, &cameras, scale) {
            Some((camera, view)) => {
                canvas.pixels(&figure_match::draw(&sample.scene, &view), below);
                if cameras.mounts.as_slice().len() > 1 {
                    let corner = at + Vec2::new(WIDTH, -10.0);
                    canvas.words(&format!("below: {camera} camera"), corner, 17.0, Anchor::Right, GREY);
                }
            }
            None => {
                let size = Vec2::new(WIDTH, view_height);
                canvas.rectangle(below, size, GREY, 0.25);
                canvas.words("not on the pitch", below + size / 2.0, 18.0, Anchor::Middle, INK);
            }
        }
    }
    Ok(canvas.into_image())
}

/// The view of the pink robot by the camera that has the ball in its image, else by its first camera. `None` if the
/// robot is not on the pitch.
fn view_with_ball(sample: &Sample, cameras: &CameraSettings, scale: f32) -> Option<(CameraName, View)> {
    let view_of = |camera| Some((camera, view_of_robot(&sample.scene, cameras, PINK, camera, WIDTH, scale)?.0));
    let has_ball = |(_, view): &(CameraName, View)| {
        let pixel = sample.scene.ball.and_then(|ball| view.project(ball.centre()));
        pixel.is_some_and(|pixel| pixel.cmpge(Vec2::ZERO).all() && pixel.cmple(view.intrinsics.size).all())
    };
    let names = || cameras.mounts.names();
    names().filter_map(view_of).find(has_ball).or_else(|| names().find_map(view_of))
}

/// The cycles from the kick-off to a goal.
struct Goal {
    samples: Vec<Sample>,
    scorer: Team,
    /// The cameras of the pink robot.
    cameras: CameraSettings,
}

/// The goal of the first match with an early one.
fn first_goal(model: &RobotModel) -> Result<Goal, FigureError> {
    for seed in 1..=SEEDS {
        if let Some(goal) = first_goal_of(model, seed)? {
            return Ok(goal);
        }
    }
    Err(FigureError::Missing { figure: 8, missing: "no goal was scored" })
}

/// The goal of the match with this seed; `None` if there is no early one.
fn first_goal_of(model: &RobotModel, seed: u64) -> Result<Option<Goal>, FigureError> {
    let scenario = format!(
        r#"{{ "seed": {seed}, "rules": {{ "preset": "naoisis", "team_size": 1 }},
             "teams": {{ "blue": "chasers", "pink": "chasers" }} }}"#
    );
    let mut played = FigureMatch::begin(model, &scenario)?;
    let mut samples: Vec<Sample> = Vec::new();
    for _ in 0..MOST_CYCLES {
        played.play(1, |_| ());
        let goal = played.app.events().iter().find_map(|event| match event {
            MatchEvent::Goal { team, .. } => Some(*team),
            _ => None,
        });
        if let Some(scorer) = goal
            && !samples.is_empty()
        {
            return Ok(Some(Goal { samples, scorer, cameras: played.robot(PINK) }));
        }
        if played.app.game().state == GameState::Playing {
            samples.push(Sample { time_s: played.time_s(), scene: played.scene().clone() });
        }
    }
    Ok(None)
}
