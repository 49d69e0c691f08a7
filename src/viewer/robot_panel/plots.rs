//! Numbers of the selected robot over time.

use bevy_egui::egui::{self, Color32, Rangef};
use egui_plot::{AxisHints, Line, Plot, PlotPoints, uniform_grid_spacer};

use crate::behaviour::drawings::Ink;
use crate::geometry::to_degrees;
use crate::team::RobotId;
use crate::viewer::cycle_samples::{CycleSamples, LOOK_BACK_S, RobotSample};
use crate::viewer::palette;
use crate::viewer::theme::{dim, minutes, text_size};

/// A trace may have a record of every so many cycles only: cycles that are so far apart are not joined, s.
const LONGEST_GAP_S: f64 = 0.5;
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
    let first = cycle.saturating_sub((LOOK_BACK_S / period_s) as u64);
    let now_s = cycle as f64 * period_s;
    for (name, curves) in PLOTS {
        ui.label(*name);
        show_legend(ui, curves);
        let plot = Plot::new(*name)
            .height(HEIGHT)
            .include_x(now_s - LOOK_BACK_S)
            .include_x(now_s)
            .include_y(0.0)
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .custom_x_axes(vec![AxisHints::new_x().formatter(|mark, _| time_words(mark.value))])
            .x_grid_spacer(uniform_grid_spacer(|_| [5.0, 10.0, 20.0]))
            .custom_y_axes(vec![AxisHints::new_y().label_spacing(Rangef::new(12.0, 22.0))]);
        plot.show(ui, |plot| {
            for (name, ink, value) in *curves {
                let value = |robot: &RobotSample| value(robot, period_s as f32);
                let gap = (LONGEST_GAP_S / period_s) as u64;
                for (index, points) in runs(samples, id, [first, cycle], gap, value).into_iter().enumerate() {
                    let points = points.into_iter().map(|[cycle, value]| [cycle * period_s, value]);
                    let line = Line::new(*name, PlotPoints::from_iter(points)).color(colour(*ink));
                    plot.line(line.id(format!("{name}{index}")));
                }
            }
        });
    }
}

/// The names of the curves, each with its colour, beside the data and not on it.
fn show_legend(ui: &mut egui::Ui, curves: &[Curve]) {
    ui.horizontal(|ui| {
        for (name, ink, _) in curves {
            let (area, _) = ui.allocate_exact_size(egui::vec2(14.0, 3.0), egui::Sense::hover());
            ui.painter().rect_filled(area, 1.0, colour(*ink));
            ui.label(dim(*name).size(text_size::SMALL));
        }
    });
}

/// A time since the start of the match; none before it.
fn time_words(time_s: f64) -> String {
    if time_s < 0.0 { String::new() } else { minutes(time_s as f32) }
}

fn colour(ink: Ink) -> Color32 {
    palette::in_panel(palette::ink(ink))
}

/// The values over the cycles, in runs without gaps of more than so many cycles.
fn runs(
    samples: &CycleSamples,
    id: RobotId,
    [first, last]: [u64; 2],
    longest_gap: u64,
    value: impl Fn(&RobotSample) -> Option<f32>,
) -> Vec<Vec<[f64; 2]>> {
    let mut runs: Vec<Vec<[f64; 2]>> = Vec::new();
    let mut before: Option<u64> = None;
    for (cycle, sample) in samples.between(first, last) {
        let Some(value) = sample.robots.get(&id).and_then(&value) else {
            before = None;
            continue;
        };
        let point = [cycle as f64, f64::from(value)];
        match runs.last_mut() {
            Some(run) if before.is_some_and(|before| cycle - before <= longest_gap) => run.push(point),
            _ => runs.push(vec![point]),
        }
        before = Some(cycle);
    }
    runs
}
