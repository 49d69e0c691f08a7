//! The time axis of a panel; lanes and plots show the same part of the match.

use bevy::math::ops;
use bevy::prelude::*;
use bevy_egui::egui::{self, Rect as Area, Stroke};
use naoisis_record::record::axis::ticks;

/// The shortest visible part of the match, cycles.
const LEAST_PART: f64 = 30.0;

/// The width of what stands before the axes of the timeline, the lanes and the plots, logical pixels: all begin at the same
/// place.
pub const BEFORE: f32 = 52.0;
/// The width of the legend behind the axes of the plots, logical pixels. The lanes leave it free if there are plots above
/// them.
pub const LEGEND: f32 = 136.0;

/// The visible part of the match: its first and its last cycle; `None` for the whole match.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct ShownPart(pub Option<[f64; 2]>);

/// The mapping from cycles to pixels.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Axis {
    /// The first and the last cycle.
    pub part: [f64; 2],
    /// Its left end, logical pixels.
    pub left: f32,
    /// Its width, logical pixels.
    pub width: f32,
}

impl Axis {
    /// Returns the position of a cycle, logical pixels.
    pub fn x(&self, cycle: f64) -> f32 {
        let [first, last] = self.part;
        self.left + ((cycle - first) / (last - first)) as f32 * self.width
    }

    /// Returns the cycle at a position.
    pub fn cycle(&self, x: f32) -> f64 {
        let [first, last] = self.part;
        first + f64::from((x - self.left) / self.width) * (last - first)
    }

    /// Returns the time at a position, with tenths of a second if the tooltip of the next pixel would have the same second.
    pub fn time_at(&self, x: f32, period_s: f64) -> String {
        let pixel_s = (self.part[1] - self.part[0]) / f64::from(self.width) * period_s;
        time_words(self.cycle(x) * period_s, pixel_s)
    }

    /// The part after zooming by `factor` about a cycle and moving by some cycles, within the whole match.
    fn moved(&self, whole: [f64; 2], about: f64, factor: f64, by: f64) -> [f64; 2] {
        let length =
            ((self.part[1] - self.part[0]) / factor).clamp(LEAST_PART.min(whole[1] - whole[0]), whole[1] - whole[0]);
        let share = ((about - self.part[0]) / (self.part[1] - self.part[0])).clamp(0.0, 1.0);
        let first = (about - share * length + by).clamp(whole[0], whole[1] - length);
        [first, first + length]
    }

    /// Returns the part after the input of the mouse: the wheel zooms, a drag moves, a double click shows all.
    pub fn changed_part(&self, ui: &egui::Ui, response: &egui::Response, whole: [f64; 2]) -> Option<ShownPart> {
        if response.double_clicked() {
            return Some(ShownPart(None));
        }
        let wheel = if response.hovered() { ui.input(|input| input.smooth_scroll_delta.y) } else { 0.0 };
        let drag = if response.dragged() { response.drag_delta().x } else { 0.0 };
        if wheel == 0.0 && drag == 0.0 {
            return None;
        }
        let about = response.hover_pos().map_or(self.part[0], |at| self.cycle(at.x));
        let factor = f64::from(ops::exp(wheel / 150.0));
        let by = -f64::from(drag / self.width) * (self.part[1] - self.part[0]);
        Some(ShownPart(Some(self.moved(whole, about, factor, by))))
    }
}

/// Returns at most `most` ticks at round times of a range, s, with their texts.
pub fn time_ticks(range_s: [f64; 2], most: usize) -> Vec<(f64, String)> {
    const STEPS_S: [f64; 15] =
        [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0];
    let least = (range_s[1] - range_s[0]) / most.max(1) as f64;
    let step = STEPS_S.into_iter().find(|step| *step >= least).unwrap_or(7200.0);
    ticks(range_s, step).map(|time_s| (time_s, time_words(time_s, step))).collect()
}

/// A time since the start of the match, with tenths if ticks are less than a second apart.
fn time_words(time_s: f64, step_s: f64) -> String {
    let sign = if time_s < -1e-9 { "\u{2212}" } else { "" };
    let tenths = (time_s.abs() * 10.0).round() as u64;
    let whole = format!("{sign}{}:{:02}", tenths / 600, tenths / 10 % 60);
    if step_s < 1.0 { format!("{whole}.{}", tenths % 10) } else { whole }
}

/// Draws a vertical line if it is within an area.
pub fn upright(ui: &egui::Ui, x: f32, area: Area, stroke: Stroke) {
    if area.x_range().contains(x) {
        ui.painter().vline(x, area.y_range(), stroke);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cycle_under_the_mouse_stays_there_when_one_comes_closer() {
        let axis = Axis { part: [100.0, 300.0], left: 50.0, width: 400.0 };
        assert_eq!((axis.x(200.0), axis.cycle(250.0)), (250.0, 200.0));
        let part = axis.moved([0.0, 1000.0], 150.0, 2.0, 0.0);
        let closer = Axis { part, ..axis };
        assert!((closer.x(150.0) - axis.x(150.0)).abs() < 1e-3 && part[1] - part[0] == 100.0);
        // The axis never extends beyond the match.
        assert_eq!(axis.moved([0.0, 1000.0], 150.0, 1e-3, 0.0), [0.0, 1000.0]);
        assert_eq!(axis.moved([0.0, 1000.0], 150.0, 1.0, 1e6), [800.0, 1000.0]);
    }

    #[test]
    fn ticks_of_time_are_at_round_times() {
        let words =
            |range_s, most| -> Vec<String> { time_ticks(range_s, most).into_iter().map(|(_, words)| words).collect() };
        assert_eq!(words([60.0, 60.7], 4), ["1:00.0", "1:00.2", "1:00.4", "1:00.6"]);
        assert_eq!(words([0.0, 600.0], 5), ["0:00", "2:00", "4:00", "6:00", "8:00", "10:00"]);
        assert!(words([3.0, 1203.0], 8).len() <= 9);
    }
}
