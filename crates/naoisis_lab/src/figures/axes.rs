//! Axes with ticks and labels, and plans of the pitch in them.

use bevy::math::{Vec2, Vec2Swizzles};

use super::figure_match::view_from_above;
use naoisis_record::record::axis;
use naoisis_record::record::canvas::{Anchor, Canvas, INK, PAPER, width_of_words};
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::appearance::scene::Scene;

/// Height of numbers at axes, points.
const NUMBERS: f32 = 17.0;
/// The height of labels of axes, points.
const LABELS: f32 = 19.0;
/// The length of a tick, points.
const TICK: f32 = 6.0;

/// The area of a figure in which two quantities are plotted.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Axes {
    /// Its top left corner, points.
    pub at: Vec2,
    /// Its width and height, points.
    pub size: Vec2,
    /// The values at its left and right edge.
    pub across: [f32; 2],
    /// The values at its lower and upper edge.
    pub up: [f32; 2],
}

impl Axes {
    /// Returns the point of a pair of values (across, up).
    pub fn place(&self, values: Vec2) -> Vec2 {
        let share = |value: f32, [from, to]: [f32; 2]| (value - from) / (to - from);
        self.at + self.size * Vec2::new(share(values.x, self.across), 1.0 - share(values.y, self.up))
    }

    /// Draws light lines at the ticks.
    pub fn grid(&self, canvas: &mut Canvas, [across, up]: [f32; 2]) {
        for value in ticks(self.across, across) {
            let x = self.place(Vec2::new(value, self.up[0])).x;
            canvas.line(&[Vec2::new(x, self.at.y), Vec2::new(x, self.at.y + self.size.y)], GRID, 1.0);
        }
        for value in ticks(self.up, up) {
            let y = self.place(Vec2::new(self.across[0], value)).y;
            canvas.line(&[Vec2::new(self.at.x, y), Vec2::new(self.at.x + self.size.x, y)], GRID, 1.0);
        }
    }

    /// Draws the frame with ticks and labels. Labels are outside, on the left and below.
    pub fn frame(&self, canvas: &mut Canvas, [across_step, up_step]: [f32; 2], [across, up]: [&str; 2]) {
        let low = self.at + self.size;
        canvas.outline(&[self.at, Vec2::new(low.x, self.at.y), low, Vec2::new(self.at.x, low.y)], INK, 1.5);
        for value in ticks(self.across, across_step) {
            let x = self.place(Vec2::new(value, self.up[0])).x;
            canvas.line(&[Vec2::new(x, low.y), Vec2::new(x, low.y + TICK)], INK, 1.5);
            let at = Vec2::new(x, low.y + TICK + NUMBERS);
            canvas.words(&number(value, across_step), at, NUMBERS, Anchor::Middle, INK);
        }
        for value in ticks(self.up, up_step) {
            let y = self.place(Vec2::new(self.across[0], value)).y;
            canvas.line(&[Vec2::new(self.at.x - TICK, y), Vec2::new(self.at.x, y)], INK, 1.5);
            let at = Vec2::new(self.at.x - TICK - 4.0, y + 0.32 * NUMBERS);
            canvas.words(&number(value, up_step), at, NUMBERS, Anchor::Right, INK);
        }
        let middle = self.at + self.size / 2.0;
        let below = Vec2::new(middle.x, low.y + TICK + NUMBERS + LABELS + 3.0);
        canvas.words(across, below, LABELS, Anchor::Middle, INK);
        let beside = Vec2::new(self.at.x - TICK - 40.0, middle.y);
        canvas.words_upwards(up, beside, LABELS, Anchor::Middle, INK);
    }
}

/// The colour of the grid.
const GRID: Colour = Colour([222, 224, 228]);

/// The ticks `step` apart on an axis.
fn ticks(range: [f32; 2], step: f32) -> impl Iterator<Item = f32> {
    axis::ticks(range.map(f64::from), step.into()).map(|value| value as f32)
}

/// Writes `value` with the decimal places of `step`.
pub fn number(value: f32, step: f32) -> String {
    axis::number(value.into(), step.into())
}

/// A plan of a part of the pitch from above.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plan {
    /// The axes, in metres of the pitch frame relative to `origin`.
    pub axes: Axes,
    /// The origin of the axes, m, pitch frame.
    pub origin: Vec2,
    /// Whether +x is up and +y to the left, as a robot sees it; else +x is to the right and +y up.
    pub x_is_up: bool,
}

impl Plan {
    /// Creates a plan in an area of points, with `centre` (pitch frame) in the middle.
    pub fn new(at: Vec2, size: Vec2, centre: Vec2, points_per_metre: f32, x_is_up: bool) -> Plan {
        let half = size / points_per_metre / 2.0;
        let [across, up] = if x_is_up {
            [[centre.y + half.x, centre.y - half.x], [centre.x - half.y, centre.x + half.y]]
        } else {
            [[centre.x - half.x, centre.x + half.x], [centre.y - half.y, centre.y + half.y]]
        };
        Plan { axes: Axes { at, size, across, up }, origin: Vec2::ZERO, x_is_up }
    }

    /// Returns the plan with axes that count from `origin`.
    pub fn counted_from(self, origin: Vec2) -> Plan {
        let [across, up] = if self.x_is_up { [origin.y, origin.x] } else { [origin.x, origin.y] };
        let axes = Axes {
            across: self.axes.across.map(|value| value - across),
            up: self.axes.up.map(|value| value - up),
            ..self.axes
        };
        Plan { axes, origin: self.origin + origin, ..self }
    }

    /// Points in a metre.
    pub fn points_per_metre(&self) -> f32 {
        self.axes.size.x / (self.axes.across[1] - self.axes.across[0]).abs()
    }

    /// Returns the point of a position in the pitch frame.
    pub fn place(&self, point: Vec2) -> Vec2 {
        let offset = point - self.origin;
        self.axes.place(if self.x_is_up { offset.yx() } else { offset })
    }

    /// Returns the points of positions in the pitch frame.
    pub fn places(&self, points: impl IntoIterator<Item = Vec2>) -> Vec<Vec2> {
        points.into_iter().map(|point| self.place(point)).collect()
    }

    /// Draws a scene as the background of the plan.
    pub fn picture(&self, canvas: &mut Canvas, scene: &Scene) {
        let middle =
            Vec2::new((self.axes.across[0] + self.axes.across[1]) / 2.0, (self.axes.up[0] + self.axes.up[1]) / 2.0);
        let centre = self.origin + if self.x_is_up { middle.yx() } else { middle };
        let view = view_from_above(centre, self.points_per_metre(), self.x_is_up, self.axes.size, canvas.scale());
        canvas.pixels(&super::figure_match::draw(scene, &view), self.axes.at);
    }

    /// Draws axes in metres with ticks every `step_m`.
    pub fn frame(&self, canvas: &mut Canvas, step_m: f32) {
        let labels = if self.x_is_up { ["y, m", "x, m"] } else { ["x, m", "y, m"] };
        self.axes.frame(canvas, [step_m; 2], labels);
    }

    /// Draws a frame without axes.
    pub fn outline(&self, canvas: &mut Canvas) {
        let low = self.axes.at + self.axes.size;
        let corners = [self.axes.at, Vec2::new(low.x, self.axes.at.y), low, Vec2::new(self.axes.at.x, low.y)];
        canvas.outline(&corners, INK, 1.5);
    }

    /// Draws a scale bar of this length in the lower right corner.
    pub fn ruler(&self, canvas: &mut Canvas, length_m: f32, words: &str) {
        let right = self.axes.at + self.axes.size - Vec2::new(18.0, 16.0);
        let left = right - Vec2::X * length_m * self.points_per_metre();
        let ink = PAPER;
        canvas.line(&[left, right], ink, 2.5);
        for end in [left, right] {
            canvas.line(&[end - Vec2::Y * 5.0, end + Vec2::Y * 5.0], ink, 2.5);
        }
        canvas.words(words, (left + right) / 2.0 - Vec2::Y * 8.0, NUMBERS, Anchor::Middle, ink);
    }
}

/// Draws the letter and the caption above a panel.
pub fn caption(canvas: &mut Canvas, letter: &str, words: &str, at: Vec2) {
    let letter = format!("({letter})");
    canvas.words(&letter, at, 21.0, Anchor::Left, INK);
    let width = width_of_words(&letter, 21.0);
    canvas.words(words, at + Vec2::X * (width + 8.0), 21.0, Anchor::Left, INK);
}

/// The colour of remarks.
const REMARK: Colour = Colour([88, 92, 98]);

/// Draws the second line of a caption.
pub fn remark(canvas: &mut Canvas, words: &str, at: Vec2) {
    canvas.words(words, at, 18.0, Anchor::Left, REMARK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_puts_places_where_its_axes_do() {
        let plan = Plan::new(Vec2::new(10.0, 20.0), Vec2::new(400.0, 200.0), Vec2::new(1.0, -0.5), 100.0, false);
        assert_eq!(plan.points_per_metre(), 100.0);
        assert!(plan.place(Vec2::new(1.0, -0.5)).abs_diff_eq(Vec2::new(210.0, 120.0), 1e-3));
        assert!(plan.place(Vec2::new(2.0, 0.0)).abs_diff_eq(Vec2::new(310.0, 70.0), 1e-3));
        let turned = Plan { ..Plan::new(Vec2::ZERO, Vec2::splat(200.0), Vec2::ZERO, 100.0, true) };
        assert!(turned.place(Vec2::new(0.5, 0.25)).abs_diff_eq(Vec2::new(75.0, 50.0), 1e-3));
        // The origin of the axes has moved, but the places stay.
        let moved = turned.counted_from(Vec2::new(0.3, 0.1));
        assert!(moved.place(Vec2::new(0.5, 0.25)).abs_diff_eq(Vec2::new(75.0, 50.0), 1e-3));
        assert!((moved.axes.up[0] + 1.3).abs() < 1e-6 && (moved.axes.across[0] - 0.9).abs() < 1e-6);
    }
}
