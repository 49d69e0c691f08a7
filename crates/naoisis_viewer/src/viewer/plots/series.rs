//! A number over the cycles of a match, with a hierarchy of extremes: drawing any part costs the same.

/// The number of values, or groups, in a group of the next level.
const GROUP: usize = 4;
/// The extremes of no values.
const NOTHING: [f32; 2] = [f32::INFINITY, f32::NEG_INFINITY];

/// A number in some cycles.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Series {
    /// The values by cycle; NaN where there is none.
    values: Vec<f32>,
    /// The least and greatest values of each group, of each group of groups, and so on.
    levels: Vec<Vec<[f32; 2]>>,
}

impl Series {
    /// Returns the value in a cycle.
    pub fn value(&self, cycle: u64) -> Option<f32> {
        self.values.get(usize::try_from(cycle).ok()?).copied().filter(|value| !value.is_nan())
    }

    /// Returns the value in a cycle, or the last one at most `longest_gap` cycles before it.
    pub fn value_about(&self, cycle: u64, longest_gap: u64) -> Option<f32> {
        (cycle.saturating_sub(longest_gap)..=cycle).rev().find_map(|cycle| self.value(cycle))
    }

    /// Returns whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.values.iter().all(|value| value.is_nan())
    }

    /// Sets the value in a cycle.
    pub fn set(&mut self, cycle: u64, value: f32) {
        let Ok(mut index) = usize::try_from(cycle) else { return };
        if !value.is_finite() {
            return;
        }
        if self.values.len() <= index {
            self.values.resize(index + 1, f32::NAN);
        }
        self.values[index] = value;
        let mut below = self.values.len();
        for level in 0.. {
            if below <= GROUP {
                return;
            }
            index /= GROUP;
            let groups = below.div_ceil(GROUP);
            if self.levels.len() == level {
                // A new level summarises all values so far.
                let all = (0..groups).map(|group| self.extremes(level, group)).collect();
                self.levels.push(all);
            } else {
                self.levels[level].resize(groups, NOTHING);
                self.levels[level][index] = self.extremes(level, index);
            }
            below = groups;
        }
    }

    /// The extremes of a group, from the level below.
    fn extremes(&self, level: usize, group: usize) -> [f32; 2] {
        let join = |one: [f32; 2], other: [f32; 2]| [one[0].min(other[0]), one[1].max(other[1])];
        let range = |length: usize| GROUP * group..(GROUP * (group + 1)).min(length);
        match level.checked_sub(1) {
            None => {
                let values = self.values[range(self.values.len())].iter();
                values.filter(|value| !value.is_nan()).fold(NOTHING, |so_far, value| join(so_far, [*value, *value]))
            }
            Some(below) => {
                let below = &self.levels[below];
                below[range(below.len())].iter().fold(NOTHING, |so_far, pair| join(so_far, *pair))
            }
        }
    }

    /// Returns the curve from `first` to `last` in `columns` columns of pixels: pieces of (cycle, value), split where more than
    /// `longest_gap` cycles have no value. Each column has at most two points: its least and its greatest value.
    pub fn curve(&self, [first, last]: [f64; 2], columns: usize, longest_gap: u64) -> Vec<Vec<[f64; 2]>> {
        let length = (last - first).max(1e-9);
        let each = length / columns.max(1) as f64;
        let mut level = 0;
        let mut width = 1_usize;
        while level < self.levels.len() && (width * GROUP) as f64 <= each {
            (level, width) = (level + 1, width * GROUP);
        }
        let count = if level == 0 { self.values.len() } else { self.levels[level - 1].len() };
        // One more on each side, so that the curve reaches the edge.
        let from = ((first.max(0.0) / width as f64).floor() as usize).saturating_sub(1);
        let until = ((last.max(0.0) / width as f64).ceil() as usize + 2).min(count);
        let pair = |index: usize| match level.checked_sub(1) {
            None => [self.values[index]; 2],
            Some(level) => self.levels[level][index],
        };
        let mut pieces =
            Pieces { longest_gap: longest_gap.max(width as u64) as f64 + width as f64, ..Pieces::default() };
        for index in from..until {
            let [low, high] = pair(index);
            // Groups without values have no extremes: their `low` is greater than `high`.
            if low <= high {
                let cycle = (index * width) as f64;
                let column = if each > 1.0 { ((cycle - first) / each).floor() as i64 } else { index as i64 };
                pieces.add(column, cycle, [f64::from(low), f64::from(high)]);
            }
        }
        pieces.finish()
    }
}

/// Pieces of a curve in progress.
#[derive(Default)]
struct Pieces {
    longest_gap: f64,
    done: Vec<Vec<[f64; 2]>>,
    piece: Vec<[f64; 2]>,
    /// The current column, its cycles and its extremes.
    column: Option<(i64, [f64; 2], [f64; 2])>,
}

impl Pieces {
    fn add(&mut self, column: i64, cycle: f64, [low, high]: [f64; 2]) {
        if let Some((now, cycles, extremes)) = &mut self.column {
            let is_gap = cycle - cycles[1] > self.longest_gap;
            if *now == column && !is_gap {
                cycles[1] = cycle;
                *extremes = [extremes[0].min(low), extremes[1].max(high)];
                return;
            }
            self.end_column();
            if is_gap {
                self.end_piece();
            }
        }
        self.column = Some((column, [cycle; 2], [low, high]));
    }

    fn end_column(&mut self) {
        let Some((_, [first, last], [low, high])) = self.column.take() else { return };
        if low == high {
            self.piece.push([first, low]);
            return;
        }
        // The nearer extreme comes first, so that the line does not cross itself.
        let is_up = self.piece.last().is_none_or(|[_, before]| (before - low).abs() <= (before - high).abs());
        let [start, end] = if is_up { [low, high] } else { [high, low] };
        self.piece.extend([[first, start], [last, end]]);
    }

    fn end_piece(&mut self) {
        if !self.piece.is_empty() {
            self.done.push(core::mem::take(&mut self.piece));
        }
    }

    fn finish(mut self) -> Vec<Vec<[f64; 2]>> {
        self.end_column();
        self.end_piece();
        self.done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_match_the_extremes_of_each_column_are_drawn() {
        let mut series = Series::default();
        for cycle in 0..20_000 {
            series.set(cycle, if cycle == 5_003 { 9.0 } else { (cycle % 7) as f32 });
        }
        let pieces = series.curve([0.0, 20_000.0], 300, 15);
        assert_eq!(pieces.len(), 1);
        assert!(pieces[0].len() <= 2 * 302, "{}", pieces[0].len());
        assert!(pieces[0].iter().any(|[_, value]| *value == 9.0), "a single high value is seen");
        let (low, high) = (|value: f64| value == 0.0, |value: f64| value >= 6.0);
        assert!(pieces[0].iter().any(|[_, value]| low(*value)) && pieces[0].iter().any(|[_, value]| high(*value)));
        // At close range, every value is a point.
        let near = series.curve([5_000.0, 5_010.0], 300, 15).concat();
        assert!(near.contains(&[5_003.0, 9.0]) && near.contains(&[5_004.0, 6.0]), "{near:?}");
    }

    #[test]
    fn the_extremes_are_those_of_the_values_in_whatever_order_they_came() {
        let value = |cycle: u64| ((cycle * 7_919) % 1_000) as f32;
        let (mut forwards, mut backwards) = (Series::default(), Series::default());
        for cycle in 0..5_000 {
            forwards.set(cycle, value(cycle));
            backwards.set(4_999 - cycle, value(4_999 - cycle));
        }
        assert_eq!(forwards, backwards);
        let all = (0..5_000).map(value);
        let highest = all.fold(0.0_f32, f32::max);
        let drawn = forwards.curve([0.0, 5_000.0], 10, 15).concat();
        assert_eq!(drawn.iter().map(|[_, value]| *value).fold(0.0, f64::max), f64::from(highest));
    }

    #[test]
    fn there_is_no_line_where_there_was_no_value() {
        let mut series = Series::default();
        for cycle in (0..100).chain(300..400) {
            series.set(cycle, 1.0);
        }
        series.set(350, f32::NAN);
        assert_eq!(series.curve([0.0, 400.0], 800, 15).len(), 2);
        assert_eq!(series.curve([0.0, 400.0], 20, 15).len(), 2);
        assert_eq!((series.value(100), series.value(350)), (None, Some(1.0)));
        assert_eq!((series.value_about(105, 15), series.value_about(150, 15)), (Some(1.0), None));
        // Values of every few cycles are joined to one curve.
        let mut sparse = Series::default();
        (0..50).for_each(|index| sparse.set(10 * index, 2.0));
        assert_eq!(sparse.curve([0.0, 500.0], 500, 15).len(), 1);
        assert!(Series::default().curve([0.0, 500.0], 500, 15).is_empty() && Series::default().is_empty());
    }
}
