//! Exports a plot to a file: PNG, SVG, or its numbers as CSV.

use bevy::math::Vec2;
use core::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};

use super::chart::{Chart, ink};
use super::series::Series;
use crate::viewer::new_file::{stem, write_new};
use naoisis_record::record::canvas::{Anchor, Canvas, GREY, INK, PAPER, shortened};
use naoisis_record::record::png_file::{Layer, encode_png};
use naoisis_sensing::appearance::colours::Colour;

/// The size of a picture, points, and its pixels per point.
const SIZE: Vec2 = Vec2::new(900.0, 380.0);
const PIXELS: f32 = 2.0;
/// The margins for values, title, legend and time.
const LEFT: f32 = 74.0;
const ABOVE: f32 = 40.0;
const RIGHT: f32 = 118.0;
const BELOW: f32 = 52.0;
/// The height of letters, points.
const LETTERS: f32 = 15.0;
/// The most ticks of values.
const VALUE_TICKS: usize = 6;
const TIME_TICKS: usize = 9;
/// The colour of the grid.
const GRID: Colour = Colour([222, 224, 228]);

/// The file formats.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FileKind {
    /// A picture of pixels.
    Png,
    /// A picture of lines.
    Svg,
    /// Numbers.
    Csv,
}

impl FileKind {
    /// All formats.
    pub const ALL: [FileKind; 3] = [FileKind::Png, FileKind::Svg, FileKind::Csv];

    /// Returns the name in the window.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Png => "PNG",
            FileKind::Svg => "SVG",
            FileKind::Csv => "CSV",
        }
    }
}

/// Returns the number of columns of an exported curve, in points.
pub fn columns() -> usize {
    ((SIZE.x - LEFT - RIGHT) * PIXELS) as usize
}

/// Writes a plot of a match into a new file in a folder. The name has match, field and robots. `whole` has the curves
/// with all values.
///
/// # Errors
/// When the files cannot be written.
pub fn save(
    folder: &Path,
    match_name: &str,
    chart: &Chart,
    whole: &[(String, &Series)],
    kind: FileKind,
) -> io::Result<PathBuf> {
    let bytes = match kind {
        FileKind::Png => {
            let mut canvas = Canvas::scaled(SIZE, PIXELS, PAPER);
            draw(chart, &mut canvas);
            let mut bytes = Vec::new();
            encode_png(&mut bytes, Layer::Colours, &canvas.into_image())?;
            bytes
        }
        FileKind::Svg => {
            let mut svg = Svg::default();
            draw(chart, &mut svg);
            svg.finish().into_bytes()
        }
        FileKind::Csv => csv(chart, whole).into_bytes(),
    };
    let names: Vec<&str> = chart.lines.iter().map(|line| line.name.as_str()).collect();
    let parts = [match_name, &chart.title].into_iter().chain(names);
    let name = parts.filter(|part| !part.is_empty()).map(stem).collect::<Vec<_>>().join("-");
    write_new(folder, &name, &kind.name().to_lowercase(), &bytes)
}

/// The values of all visible cycles, one column per curve; empty cells where there is no value.
fn csv(chart: &Chart, whole: &[(String, &Series)]) -> String {
    let symbol = chart.unit.symbol();
    let unit = if symbol.is_empty() { String::new() } else { format!(" [{symbol}]") };
    let mut text = "cycle,time [s]".to_owned();
    for (name, _) in whole {
        text.push_str(&format!(",{}", quoted(&format!("{name}: {}{unit}", chart.title))));
    }
    text.push('\n');
    let [first, last] = [chart.cycles[0].ceil().max(0.0) as u64, chart.cycles[1].floor().max(0.0) as u64];
    for cycle in first..=last {
        let values: Vec<Option<f32>> = whole.iter().map(|(_, series)| series.value(cycle)).collect();
        if values.iter().all(Option::is_none) {
            continue;
        }
        _ = write!(text, "{cycle},{:.4}", cycle as f64 * chart.period_s);
        for value in values {
            match value.map(|value| (value, chart.unit.word(f64::from(value)))) {
                Some((_, Some(word))) => _ = write!(text, ",{}", quoted(word)),
                Some((value, None)) => _ = write!(text, ",{value}"),
                None => text.push(','),
            }
        }
        text.push('\n');
    }
    text
}

/// A text quoted for CSV if it needs to be (RFC 4180).
fn quoted(words: &str) -> String {
    if words.contains([',', '"', '\n']) { format!("\"{}\"", words.replace('"', "\"\"")) } else { words.to_owned() }
}

/// Draws the picture of a plot. Positions are points from the top left corner.
trait Pen {
    fn line(&mut self, places: &[Vec2], colour: Colour, width: f32, is_dashed: bool);
    fn words(&mut self, words: &str, at: Vec2, anchor: Anchor, colour: Colour);
}

impl Pen for Canvas {
    fn line(&mut self, places: &[Vec2], colour: Colour, width: f32, is_dashed: bool) {
        if is_dashed {
            self.dashes(places, colour, width);
        } else {
            Canvas::line(self, places, colour, width);
        }
    }

    fn words(&mut self, words: &str, at: Vec2, anchor: Anchor, colour: Colour) {
        Canvas::words(self, words, at, LETTERS, anchor, colour);
    }
}

/// An SVG picture in progress.
#[derive(Default)]
struct Svg(String);

fn hex(Colour([red, green, blue]): Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

impl Svg {
    fn finish(self) -> String {
        let Vec2 { x, y } = SIZE;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{x}\" height=\"{y}\" viewBox=\"0 0 {x} {y}\" \
             font-family=\"Ubuntu, Helvetica, Arial, sans-serif\" font-size=\"{}\">\n<rect width=\"{x}\" height=\"{y}\" \
             fill=\"#ffffff\"/>\n{}</svg>\n",
            0.86 * LETTERS,
            self.0
        )
    }
}

impl Pen for Svg {
    fn line(&mut self, places: &[Vec2], colour: Colour, width: f32, is_dashed: bool) {
        let dashes = if is_dashed { " stroke-dasharray=\"6 4\"" } else { "" };
        let points: Vec<String> = places.iter().map(|place| format!("{:.1},{:.1}", place.x, place.y)).collect();
        _ = writeln!(
            self.0,
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"{dashes} points=\"{}\"/>",
            hex(colour),
            points.join(" ")
        );
    }

    fn words(&mut self, words: &str, at: Vec2, anchor: Anchor, colour: Colour) {
        let anchor = match anchor {
            Anchor::Left => "start",
            Anchor::Middle => "middle",
            Anchor::Right => "end",
        };
        let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        let (x, y, fill) = (at.x, at.y, hex(colour));
        _ = writeln!(self.0, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{fill}\">{words}</text>");
    }
}

fn draw(chart: &Chart, pen: &mut impl Pen) {
    let (low, high) = (Vec2::new(LEFT, SIZE.y - BELOW), Vec2::new(SIZE.x - RIGHT, ABOVE));
    let (values, times) = (chart.value_ticks(VALUE_TICKS), chart.time_ticks(TIME_TICKS));
    let along = |value: f64, [from, to]: [f64; 2]| ((value - from) / (to - from).max(1e-9)) as f32;
    let x = |time_s: f64| low.x + along(time_s, times.range) * (high.x - low.x);
    let y = |value: f64| low.y + along(value, values.range) * (high.y - low.y);
    for (time_s, words) in &times.at {
        pen.line(&[Vec2::new(x(*time_s), low.y), Vec2::new(x(*time_s), high.y)], GRID, 1.0, false);
        pen.words(words, Vec2::new(x(*time_s), low.y + 20.0), Anchor::Middle, INK);
    }
    for (value, words) in &values.at {
        pen.line(&[Vec2::new(low.x, y(*value)), Vec2::new(high.x, y(*value))], GRID, 1.0, false);
        pen.words(&shortened(words, LETTERS, LEFT - 10.0), Vec2::new(low.x - 8.0, y(*value) + 5.0), Anchor::Right, INK);
    }
    pen.words(&chart.heading(), Vec2::new(low.x, high.y - 14.0), Anchor::Left, INK);
    pen.words("time, min:s", Vec2::new((low.x + high.x) / 2.0, low.y + 42.0), Anchor::Middle, INK);
    for (index, line) in chart.lines.iter().enumerate() {
        let (colour, is_dashed) = ink(index, false);
        for piece in &line.pieces {
            let places: Vec<Vec2> = clipped(piece, chart.cycles)
                .map(|[cycle, value]| Vec2::new(x(cycle * chart.period_s), y(value + chart.shift(index))))
                .collect();
            pen.line(&places, colour, 1.6, is_dashed);
        }
        // Many curves have a denser legend, so that it is complete.
        let step = 20.0_f32.min((low.y - high.y) / chart.lines.len() as f32);
        let at = Vec2::new(high.x + 14.0, high.y + step * (index as f32 + 0.5));
        // Dashes are as long as their line is wide: a thin one shows them.
        pen.line(&[at, at + Vec2::X * 24.0], colour, if is_dashed { 1.6 } else { 2.5 }, is_dashed);
        pen.words(&line.name, at + Vec2::new(30.0, 5.0), Anchor::Left, INK);
    }
    let corners = [low, Vec2::new(low.x, high.y), high, Vec2::new(high.x, low.y), low];
    pen.line(&corners, GREY, 1.2, false);
}

/// Returns the points of a piece of a curve between two cycles, including the crossings at the ends.
pub fn clipped(piece: &[[f64; 2]], [first, last]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> + '_ {
    let at = move |cycle: f64, one: [f64; 2], other: [f64; 2]| {
        let share = (cycle - one[0]) / (other[0] - one[0]);
        [cycle, one[1] + share * (other[1] - one[1])]
    };
    piece.iter().enumerate().flat_map(move |(index, point)| {
        let before = index.checked_sub(1).map(|before| piece[before]);
        let crossing = |edge: f64| {
            let before = before.filter(|before| (before[0] < edge) != (point[0] < edge) && before[0] != point[0])?;
            (before[0] != edge && point[0] != edge).then(|| at(edge, before, *point))
        };
        let inside = (first..=last).contains(&point[0]).then_some(*point);
        [crossing(first), crossing(last), inside].into_iter().flatten()
    })
}

#[cfg(test)]
mod tests {
    use super::super::chart::Line;
    use super::super::wording::Unit;
    use super::*;

    fn chart(series: &Series) -> Chart {
        let line = Line { name: "blue1".to_owned(), pieces: series.curve([0.0, 9.0], columns(), 15) };
        let title = "error of the ball".to_owned();
        Chart { title, unit: Unit::In("m"), lines: vec![line], cycles: [0.0, 9.0], period_s: 0.1 }
    }

    fn series() -> Series {
        let mut series = Series::default();
        (0..20).filter(|cycle| *cycle != 4).for_each(|cycle| series.set(cycle, cycle as f32 / 8.0));
        series
    }

    #[test]
    fn names_of_files_say_what_is_in_them_and_nothing_is_overwritten() {
        let (folder, series) = (tempfile::tempdir().unwrap(), series());
        let whole = [("blue1".to_owned(), &series)];
        let mut names: Vec<String> = Vec::new();
        for kind in [FileKind::Png, FileKind::Svg, FileKind::Csv, FileKind::Csv] {
            let path = save(folder.path(), "match 3v3", &chart(&series), &whole, kind).unwrap();
            names.push(path.file_name().unwrap().to_str().unwrap().to_owned());
        }
        let stem = "match_3v3-error_of_the_ball-blue1";
        assert_eq!(names, [".png", ".svg", ".csv", "-2.csv"].map(|ending| format!("{stem}{ending}")));
        let png = std::fs::read(folder.path().join(&names[0])).unwrap();
        assert_eq!(&png[1..4], b"PNG");
    }

    #[test]
    fn numbers_are_as_they_were_in_each_cycle_that_is_shown() {
        let series = series();
        let text = csv(&chart(&series), &[("blue1".to_owned(), &series), ("blue2".to_owned(), &Series::default())]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "cycle,time [s],blue1: error of the ball [m],blue2: error of the ball [m]");
        assert_eq!((lines[2], lines.len()), ("1,0.1000,0.125,", 1 + 9));
        assert!(!text.contains("\n4,"), "there was none in that cycle");
        assert_eq!(quoted("ball, position x"), "\"ball, position x\"");
    }

    #[test]
    fn a_picture_of_lines_has_title_curve_and_legend() {
        let mut svg = Svg::default();
        draw(&chart(&series()), &mut svg);
        let svg = svg.finish();
        for words in [">error of the ball, m<", ">blue1<", ">time, min:s<", ">0:00.2<"] {
            assert!(svg.contains(words), "{words}\n{svg}");
        }
        assert_eq!(svg.matches("<svg").count() + svg.matches("</svg>").count(), 2);
        let names = Chart { title: "a < b & c".to_owned(), ..chart(&series()) };
        let mut svg = Svg::default();
        draw(&names, &mut svg);
        assert!(svg.finish().contains("a &lt; b &amp; c"));
    }

    #[test]
    fn curves_end_at_the_edges() {
        let piece = [[0.0, 0.0], [10.0, 10.0], [20.0, 0.0]];
        let inside: Vec<[f64; 2]> = clipped(&piece, [5.0, 15.0]).collect();
        assert_eq!(inside, [[5.0, 5.0], [10.0, 10.0], [15.0, 5.0]]);
        assert_eq!(clipped(&piece, [0.0, 20.0]).count(), 3);
        assert_eq!(clipped(&piece, [12.0, 14.0]).collect::<Vec<_>>(), [[12.0, 8.0], [14.0, 6.0]]);
    }
}
