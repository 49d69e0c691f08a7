//! Numbers of the selected robot over time.

use bevy_egui::egui::{self, Color32, Rangef, TextStyle};
use egui_plot::{AxisHints, Corner, Legend, Line, Plot, PlotPoints, uniform_grid_spacer};

use crate::behaviour::drawings::Ink;
use crate::geometry::to_degrees;
use crate::team::RobotId;
use crate::viewer::cycle_samples::{CycleSamples, RobotSample};
use crate::viewer::palette;

/// The plots reach so far back, s.
const SPAN_S: f64 = 20.0;
/// Height of a plot, logical pixels.
const HEIGHT: f32 = 110.0;

/// A line of a plot: its name, its colour, and its value in a cycle of a duration, s.
type Curve = (&'static str, Ink, fn(&RobotSample, f32) -> Option<f32>);

const PLOTS: &[(&str, &[Curve])] = &[
    (
        "Error of the belief, m",
        &[
            ("own place", Ink::Purple, |robot, _| Some(robot.error?.position_m)),
            ("ball", Ink::Orange, |robot, _| Some(robot.error?.ball?.position_m)),
            ("opponents", Ink::Vermilion, |robot, _| robot.error?.opponent_m),
        ],
    ),
    (
        "Distances, m",
        &[
            ("ball", Ink::Orange, |robot, _| robot.ball_m),
            ("left sonar", Ink::Sky, |robot, _| robot.sonar.left),
            ("right sonar", Ink::Green, |robot, _| robot.sonar.right),
        ],
    ),
    (
        "Speed, m/s",
        &[
            ("speed", Ink::Yellow, |robot, _| Some(robot.speed_mps)),
            ("wanted", Ink::Sky, |robot, period| {
                robot.command.as_ref().map(|command| command.walk.unwrap_or_default().translation().length() / period)
            }),
        ],
    ),
    (
        "Head, °",
        &[
            ("yaw", Ink::Yellow, |robot, _| Some(to_degrees(robot.head.yaw))),
            ("pitch", Ink::Sky, |robot, _| Some(to_degrees(robot.head.pitch))),
        ],
    ),
];

/// Shows the plots of a robot until a cycle.
pub(super) fn show(ui: &mut egui::Ui, samples: &CycleSamples, id: RobotId, cycle: u64, period_s: f64) {
    let first = cycle.saturating_sub((SPAN_S / period_s) as u64);
    let now_s = cycle as f64 * period_s;
    for (name, curves) in PLOTS {
        ui.label(*name);
        let plot = Plot::new(*name)
            .height(HEIGHT)
            .include_x(now_s - SPAN_S)
            .include_x(now_s)
            .include_y(0.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .custom_x_axes(vec![AxisHints::new_x().formatter(move |mark, _| format!("{:.0} s", mark.value - now_s))])
            .x_grid_spacer(uniform_grid_spacer(|_| [SPAN_S / 4.0, SPAN_S / 2.0, SPAN_S]))
            .custom_y_axes(vec![AxisHints::new_y().label_spacing(Rangef::new(12.0, 22.0))])
            .legend(Legend::default().position(Corner::LeftTop).text_style(TextStyle::Small).background_alpha(0.5));
        plot.show(ui, |plot| {
            for (name, ink, value) in *curves {
                let value = |robot: &RobotSample| value(robot, period_s as f32);
                for (index, points) in runs(samples, id, [first, cycle], value).into_iter().enumerate() {
                    let points = points.into_iter().map(|[cycle, value]| [cycle * period_s, value]);
                    let line = Line::new(*name, PlotPoints::from_iter(points)).color(colour(*ink));
                    // One entry of the legend for all of them.
                    plot.line(line.id(format!("{name}{index}")));
                }
            }
        });
    }
}

fn colour(ink: Ink) -> Color32 {
    palette::in_panel(palette::ink(ink))
}

/// The values over the cycles, in runs without gaps.
fn runs(
    samples: &CycleSamples,
    id: RobotId,
    [first, last]: [u64; 2],
    value: impl Fn(&RobotSample) -> Option<f32>,
) -> Vec<Vec<[f64; 2]>> {
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut before = None;
    for (cycle, sample) in samples.between(first, last) {
        let Some(value) = sample.robots.get(&id).and_then(&value) else { continue };
        let point = [cycle as f64, f64::from(value)];
        match runs.last_mut() {
            Some(run) if before == cycle.checked_sub(1) => run.push(point),
            _ => runs.push(vec![point]),
        }
        before = Some(cycle);
    }
    runs
}
