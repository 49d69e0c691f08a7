//! A heat map of the positions of the ball at the end of the repetitions.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::{ManyTimes, Run};
use crate::viewer::keyframes::Keyframes;
use crate::viewer::overlays::Brush;
use crate::viewer::palette;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_record::whatif::Continuation;

/// The side of a cell, m.
const CELL_M: f32 = 0.4;
/// The number of lines in the cell with the most ends.
const MOST_LINES: usize = 6;

/// Draws the heat map while the moment of the repetitions is shown.
pub(super) fn draw(many: Res<ManyTimes>, clock: Res<CycleClock>, keyframes: Res<Keyframes>, mut brush: Brush) {
    let is_of_moment = |run: &&Run| run.cycle == clock.cycle && run.keyframes.is_same(&keyframes);
    let Some(run) = many.run.as_ref().filter(is_of_moment) else { return };
    for (cell, lines) in hatching(&run.rows) {
        let corner = CELL_M * cell.as_vec2();
        let edge = palette::ink(DrawColour::Orange).with_alpha(0.3);
        for (from, to) in [(Vec2::ZERO, Vec2::X), (Vec2::X, Vec2::ONE), (Vec2::ONE, Vec2::Y), (Vec2::Y, Vec2::ZERO)] {
            brush.line(corner + CELL_M * from, corner + CELL_M * to, edge);
        }
        let colour = palette::ink(DrawColour::Orange).with_alpha(0.3 + 0.6 * lines as f32 / MOST_LINES as f32);
        for line in 0..lines {
            let up = CELL_M * (line as f32 + 0.5) / lines as f32;
            brush.line(corner + Vec2::new(0.0, up), corner + Vec2::new(CELL_M, up), colour);
        }
    }
}

/// Says what the lines on the pitch mean.
pub(super) fn legend(rows: &[Continuation]) -> String {
    let most = ends(rows).into_values().max().unwrap_or(0);
    format!(
        "orange squares on the pitch at that moment: where the ball ends; {MOST_LINES} lines: in {most} of {}, 1 line: in at most {}",
        rows.len(),
        (most / MOST_LINES).max(1)
    )
}

/// The number of repetitions whose ball ends in each cell.
fn ends(rows: &[Continuation]) -> BTreeMap<[i32; 2], usize> {
    let mut counts: BTreeMap<[i32; 2], usize> = BTreeMap::new();
    for ball in rows.iter().filter_map(|row| row.ball_m) {
        *counts.entry((ball / CELL_M).floor().as_ivec2().to_array()).or_default() += 1;
    }
    counts
}

/// The cells in which the ball ends, with their number of lines: more lines for more ends.
fn hatching(rows: &[Continuation]) -> Vec<(IVec2, usize)> {
    let counts = ends(rows);
    let most = counts.values().copied().max().unwrap_or(1);
    counts.into_iter().map(|(cell, count)| (cell.into(), (count * MOST_LINES).div_ceil(most))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::many_times::tests::row;

    #[test]
    fn where_the_ball_ends_most_often_there_are_most_lines() {
        let at = |x: f32| row(None, Vec2::new(x, 0.1));
        let rows: Vec<Continuation> = [0.1, 0.2, 0.3, -0.1].map(at).into();
        assert_eq!(hatching(&rows), [(IVec2::new(-1, 0), 2), (IVec2::ZERO, MOST_LINES)]);
        assert!(hatching(&[]).is_empty());
        let words = legend(&rows);
        assert!(words.ends_with("6 lines: in 3 of 4, 1 line: in at most 1"), "{words}");
    }
}
