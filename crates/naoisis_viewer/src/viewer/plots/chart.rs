//! A plot independent of the screen: curves, round ticks, and labels. The window and exported files use the same.

use super::wording::Unit;
use crate::viewer::time_axis::time_ticks;
use naoisis_record::record::axis::{number, round_step, ticks};
use naoisis_sensing::appearance::colours::Colour;

/// The colours of curves on dark ground and on light ones; they can be distinguished with any colour vision (Okabe and
/// Ito 2008).
const ON_DARK: [[u8; 3]; 7] =
    [[86, 180, 233], [230, 159, 0], [0, 190, 140], [240, 228, 66], [222, 140, 190], [235, 110, 30], [235, 235, 235]];
const ON_LIGHT: [[u8; 3]; 7] =
    [[0, 114, 178], [213, 94, 0], [0, 125, 92], [150, 110, 0], [170, 70, 130], [120, 60, 10], [30, 30, 30]];

/// Returns the colour of the curve at an index of the legend, and whether it is dashed, because there are more curves than
/// colours.
pub fn ink(index: usize, is_dark: bool) -> (Colour, bool) {
    let colours = if is_dark { ON_DARK } else { ON_LIGHT };
    (Colour(colours[index % colours.len()]), index >= colours.len())
}

/// A curve.
#[derive(Clone, PartialEq, Debug)]
pub struct Line {
    /// The name of its robot, or of the ball.
    pub name: String,
    /// Pieces of (cycle, value).
    pub pieces: Vec<Vec<[f64; 2]>>,
}

/// A plot.
#[derive(Clone, PartialEq, Debug)]
pub struct Chart {
    /// The title.
    pub title: String,
    /// The unit.
    pub unit: Unit,
    /// The curves, in the order of the legend.
    pub lines: Vec<Line>,
    /// The first and the last cycle that are shown.
    pub cycles: [f64; 2],
    /// The duration of a cycle, s.
    pub period_s: f64,
}

/// Ticks of an axis.
#[derive(Clone, PartialEq, Debug)]
pub struct Ticks {
    /// The ends of the axis.
    pub range: [f64; 2],
    /// The values, each with its label.
    pub at: Vec<(f64, String)>,
}

impl Chart {
    /// Returns the title with the unit.
    pub fn heading(&self) -> String {
        match self.unit.symbol() {
            "" => self.title.clone(),
            symbol => format!("{}, {symbol}", self.title),
        }
    }

    /// At most `most` ticks of values, at round numbers around all values.
    pub fn value_ticks(&self, most: usize) -> Ticks {
        let [first, last] = self.cycles;
        let is_shown = |[cycle, _]: &&[f64; 2]| (first..=last).contains(cycle);
        let points = self.lines.iter().flat_map(|line| line.pieces.iter().flatten());
        let nothing = [f64::INFINITY, f64::NEG_INFINITY];
        let extremes =
            points.filter(is_shown).fold(nothing, |[low, high], [_, value]| [low.min(*value), high.max(*value)]);
        if self.unit.is_words() {
            return word_ticks(&self.unit, extremes);
        }
        let [mut low, mut high] = if extremes[0] <= extremes[1] { extremes } else { [0.0, 1.0] };
        // If zero is near, the axis includes it.
        if low > 0.0 && low < 0.6 * high {
            low = 0.0;
        } else if high < 0.0 && high > 0.6 * low {
            high = 0.0;
        }
        if high - low < 1e-6 * high.abs().max(1e-3) {
            let room = 0.5 * high.abs().max(0.2);
            (low, high) = (low - room, high + room);
        }
        let step = round_step((high - low) / most.max(1) as f64);
        let [from, to] = [(low / step + 1e-6).floor(), (high / step - 1e-6).ceil()];
        let range = [from, to].map(|end| end * step);
        Ticks { range, at: ticks(range, step).map(|value| (value, number(value, step))).collect() }
    }

    /// At most `most` ticks of time.
    pub fn time_ticks(&self, most: usize) -> Ticks {
        let range = self.cycles.map(|cycle| cycle * self.period_s);
        Ticks { range, at: time_ticks(range, most) }
    }

    /// Returns the upward shift of a curve, so that curves of discrete values do not cover each other.
    pub fn shift(&self, index: usize) -> f64 {
        /// The shift from one curve to the next, and the greatest one.
        const EACH: f64 = 0.035;
        const ALL: f64 = 0.28;
        let count = self.lines.len();
        if !self.unit.is_words() || count < 2 {
            return 0.0;
        }
        let each = EACH.min(ALL / (count - 1) as f64);
        // The first curve of the legend is the highest.
        each * ((count - 1) as f64 / 2.0 - index as f64)
    }

    /// Returns a value as text.
    pub fn value_words(&self, value: f32) -> String {
        match self.unit.word(f64::from(value)) {
            Some(word) => word.to_owned(),
            None if value.fract() == 0.0 && self.unit.symbol().is_empty() => format!("{value}"),
            None if value.abs() >= 100.0 => format!("{value:.0}"),
            None if value.abs() >= 10.0 => format!("{value:.1}"),
            None => format!("{value:.2}"),
        }
    }
}

/// Ticks at the discrete values that occur, with a margin.
fn word_ticks(unit: &Unit, extremes: [f64; 2]) -> Ticks {
    let [low, high] = if *unit == Unit::YesNo || extremes[0] > extremes[1] { [0.0, 1.0] } else { extremes };
    let words = (low as usize..=high as usize).map(|value| value as f64);
    let at = words.filter_map(|value| Some((value, unit.word(value)?.to_owned()))).collect();
    Ticks { range: [low - 0.2, high + 0.2], at }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(values: &[f64], unit: Unit) -> Chart {
        let piece = values.iter().enumerate().map(|(cycle, value)| [cycle as f64, *value]).collect();
        let line = Line { name: "blue1".to_owned(), pieces: vec![piece] };
        let last = values.len().saturating_sub(1).max(1) as f64;
        Chart { title: "speed".to_owned(), unit, lines: vec![line], cycles: [0.0, last], period_s: 0.1 }
    }

    fn words(ticks: &Ticks) -> Vec<&str> {
        ticks.at.iter().map(|(_, words)| words.as_str()).collect()
    }

    #[test]
    fn ticks_are_at_round_numbers_around_all_values() {
        let ticks = chart(&[0.02, 0.27], Unit::In("m")).value_ticks(4);
        assert_eq!(words(&ticks), ["0.0", "0.1", "0.2", "0.3"]);
        assert!((ticks.range[1] - 0.3).abs() < 1e-9);
        assert_eq!(words(&chart(&[-170.0, 160.0], Unit::In("°")).value_ticks(4)), ["−200", "−100", "0", "100", "200"]);
        // Far from zero, the axis does not start at zero. Around a constant, it leaves room.
        assert_eq!(
            words(&chart(&[101.0, 103.0], Unit::Plain).value_ticks(4)),
            ["101.0", "101.5", "102.0", "102.5", "103.0"]
        );
        let same = chart(&[3.0, 3.0], Unit::Plain).value_ticks(4);
        assert!(same.range[0] < 3.0 && same.range[1] > 3.0 && same.at.len() >= 2, "{same:?}");
        let nothing = Chart { lines: Vec::new(), ..chart(&[], Unit::Plain) }.value_ticks(4);
        assert_eq!(nothing.range, [0.0, 1.0]);
    }

    #[test]
    fn what_stands_for_words_has_them_as_ticks() {
        let plans = Unit::OneOf(["wait", "go", "kick"].map(str::to_owned).to_vec());
        let chart = chart(&[0.0, 2.0, 1.0], plans);
        assert_eq!(words(&chart.value_ticks(4)), ["wait", "go", "kick"]);
        assert_eq!((chart.value_words(2.0), chart.heading()), ("kick".to_owned(), "speed".to_owned()));
    }

    #[test]
    fn curves_that_stand_for_words_lie_beside_each_other_and_others_where_they_are() {
        let one = chart(&[0.0, 1.0], Unit::YesNo);
        assert_eq!(one.shift(0), 0.0);
        let many = Chart { lines: vec![one.lines[0].clone(); 14], ..one };
        let shifts: Vec<f64> = (0..14).map(|index| many.shift(index)).collect();
        assert!(
            shifts.windows(2).all(|pair| pair[0] > pair[1]) && shifts[0] < 0.15 && shifts[13] > -0.15,
            "{shifts:?}"
        );
        assert_eq!(Chart { unit: Unit::In("m"), ..many }.shift(3), 0.0);
    }

    #[test]
    fn time_has_tenths_only_from_near() {
        let near = Chart { cycles: [600.0, 606.0], ..chart(&[0.0], Unit::Plain) };
        assert_eq!(words(&near.time_ticks(4)), ["1:00.0", "1:00.2", "1:00.4", "1:00.6"]);
        let far = Chart { cycles: [0.0, 6000.0], ..near };
        assert_eq!(words(&far.time_ticks(5)), ["0:00", "2:00", "4:00", "6:00", "8:00", "10:00"]);
        assert_eq!(Chart { unit: Unit::In("m"), ..far }.heading(), "speed, m");
    }
}
