//! Draws the [summary](MatchSummary) of a match as a picture.

use bevy::prelude::*;

use super::canvas::{Anchor, Canvas, GREY, INK, PAPER, ellipse, shortened, width_of_words};
use super::match_summary::{CELLS_ALONG, HeatMap, MatchSummary};
use super::summary_page::minutes;
use super::summary_rows::{
    BLUE, KickLine, PINK, ROBOT_COLUMNS, TEAM_COLUMNS, kick_maps, maps, mistake_rows, robot_rows, team_rows,
};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::Team;
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::sensing::camera::image::Image;

/// Colour of light lines.
const LINE: Colour = Colour([222, 224, 228]);
/// Width of the picture, its margin, and the height of a line, points.
const WIDTH: f32 = 980.0;
const EDGE: f32 = 40.0;
const ROW: f32 = 24.0;
/// Heights of texts, points.
const TITLE: f32 = 24.0;
const SCORE: f32 = 44.0;
const LETTERS: f32 = 16.0;
/// Number of goals in the list at most.
const MOST_GOALS: usize = 12;
/// Pixels per point.
const PIXELS: f32 = 2.0;

/// A table under a headline. The first row has the names of the columns.
struct Table {
    headline: &'static str,
    rows: Vec<Vec<String>>,
    /// The left edge of the first column and the right edges of the others, points.
    columns: Vec<f32>,
}

/// Draws the summary of a match.
pub fn picture(summary: &MatchSummary) -> Image {
    let mistakes = summary.mistakes();
    let numbers = Table {
        headline: "Teams",
        rows: [vec![TEAM_COLUMNS.map(str::to_owned).to_vec()], team_rows(summary)].concat(),
        columns: vec![EDGE, EDGE + 255.0, EDGE + 400.0],
    };
    let found = Table {
        headline: "Mistakes",
        rows: [vec![TEAM_COLUMNS.map(str::to_owned).to_vec()], mistake_rows(&mistakes)].concat(),
        columns: vec![EDGE + 480.0, EDGE + 770.0, EDGE + 870.0],
    };
    let robots = Table {
        headline: "Robots",
        rows: [vec![ROBOT_COLUMNS.map(str::to_owned).to_vec()], robot_rows(summary)].concat(),
        columns: [0.0, 130.0, 200.0, 270.0, 420.0, 500.0, 560.0, 900.0].map(|column| EDGE + column).to_vec(),
    };
    let map_width = (WIDTH - 2.0 * EDGE - 40.0) / 3.0;
    let map_height = map_width * (summary.pitch.half_width() + 0.3) / (summary.pitch.half_length() + 0.3);
    let goals = summary.goals.len().min(MOST_GOALS);
    let height_of = |table: &Table| ROW * (table.rows.len() as f32 + 1.6);
    let goals_height = if goals > 0 { ROW * (goals as f32 + 1.6) } else { 0.0 };
    let beside = height_of(&numbers).max(height_of(&found));
    let height = 150.0 + goals_height + beside + 2.0 * (map_height + 3.0 * ROW) + height_of(&robots) + EDGE;
    let mut canvas = Canvas::scaled(Vec2::new(WIDTH, height), PIXELS, PAPER);
    let title = format!("{}, seed {}", summary.name, summary.seed);
    canvas.words(&title, Vec2::new(EDGE, 46.0), TITLE, Anchor::Left, INK);
    draw_score(&mut canvas, summary);
    let mut top = 150.0;
    if goals > 0 {
        canvas.words("Goals", Vec2::new(EDGE, top), LETTERS * 1.15, Anchor::Left, INK);
        for (index, (time_s, by)) in summary.goals.iter().take(MOST_GOALS).enumerate() {
            let at = Vec2::new(EDGE, top + ROW * (index as f32 + 1.0));
            let rest = summary.goals.len() - MOST_GOALS.min(summary.goals.len());
            let more = if index + 1 == MOST_GOALS && rest > 0 { format!(", and {rest} more") } else { String::new() };
            canvas.words(&format!("{}  {by}{more}", minutes(*time_s)), at, LETTERS, Anchor::Left, INK);
        }
        top += goals_height;
    }
    draw_table(&mut canvas, &numbers, top);
    draw_table(&mut canvas, &found, top);
    top += beside;
    canvas.words("Where they were", Vec2::new(EDGE, top), LETTERS * 1.15, Anchor::Left, INK);
    for (index, (words, map, colour)) in maps(summary).into_iter().enumerate() {
        let at = Vec2::new(EDGE + (map_width + 20.0) * index as f32, top + 0.6 * ROW);
        draw_map(&mut canvas, &summary.pitch, (map, colour), at, map_width);
        let below = at + Vec2::new(0.0, map_height + 0.8 * ROW);
        canvas.words(words, below, LETTERS, Anchor::Left, colour);
    }
    top += map_height + 3.0 * ROW;
    canvas.words("Passes and shots", Vec2::new(EDGE, top), LETTERS * 1.15, Anchor::Left, INK);
    for (index, (words, lines)) in kick_maps(summary).into_iter().enumerate() {
        let at = Vec2::new(EDGE + (map_width + 20.0) * index as f32, top + 0.6 * ROW);
        draw_kicks(&mut canvas, &summary.pitch, &lines, at, map_width);
        let below = at + Vec2::new(0.0, map_height + 0.8 * ROW);
        canvas.words(words, below, LETTERS, Anchor::Left, GREY);
    }
    top += map_height + 3.0 * ROW;
    draw_table(&mut canvas, &robots, top);
    canvas.into_image()
}

fn draw_score(canvas: &mut Canvas, summary: &MatchSummary) {
    let name = |team: Team| summary.teams.as_ref().map_or(team.name().to_owned(), |teams| teams[team].clone());
    let parts = [
        (format!("{} {}", name(Team::Blue), summary.score.blue), BLUE),
        (" : ".to_owned(), GREY),
        (format!("{} {}", summary.score.pink, name(Team::Pink)), PINK),
    ];
    let mut x = EDGE;
    for (words, colour) in parts {
        canvas.words(&words, Vec2::new(x, 92.0), SCORE, Anchor::Left, colour);
        x += width_of_words(&words, SCORE);
    }
    if let Some(how) = &summary.how {
        canvas.words(how, Vec2::new(x + EDGE, 92.0), LETTERS, Anchor::Left, INK);
    }
    let (played, in_play) = (minutes(summary.duration_s), minutes(summary.counts.play_s()));
    let played = format!("{played} min played, {in_play} min of them in play, realism {}", summary.realism);
    let played = shortened(&played, LETTERS, WIDTH - 2.0 * EDGE);
    canvas.words(&played, Vec2::new(EDGE, 116.0), LETTERS, Anchor::Left, GREY);
}

fn draw_table(canvas: &mut Canvas, table: &Table, top: f32) {
    let [left, right] = [table.columns.first(), table.columns.last()].map(|edge| edge.copied().unwrap_or(EDGE));
    canvas.words(table.headline, Vec2::new(left, top), LETTERS * 1.15, Anchor::Left, INK);
    for (index, row) in table.rows.iter().enumerate() {
        let y = top + ROW * (index as f32 + 1.0);
        for (column, (words, x)) in row.iter().zip(&table.columns).enumerate() {
            let anchor = if column == 0 { Anchor::Left } else { Anchor::Right };
            let room = x - table.columns[column.saturating_sub(1)] - 10.0;
            let words = if column == 0 { words.clone() } else { shortened(words, LETTERS, room) };
            canvas.words(&words, Vec2::new(*x, y), LETTERS, anchor, if index == 0 { GREY } else { INK });
        }
        let below = y + 0.3 * ROW;
        canvas.line(&[Vec2::new(left, below), Vec2::new(right, below)], LINE, 1.0);
    }
}

/// A plan of the pitch on the canvas, with +y up.
struct Plan {
    /// The corner at the top left, points.
    at: Vec2,
    /// Half of the length and of the width of the pitch, m.
    half_m: Vec2,
    /// Points per metre.
    points: f32,
}

impl Plan {
    fn new(pitch: &Pitch, at: Vec2, width: f32) -> Self {
        let half_m = Vec2::new(pitch.half_length(), pitch.half_width());
        Self { at, half_m, points: width / (2.0 * half_m.x + 0.6) }
    }

    fn place(&self, x: f32, y: f32) -> Vec2 {
        self.at + self.points * (Vec2::new(x, -y) + self.half_m + 0.3)
    }
}

/// Draws passes or shots; those with success are thicker and end with a dot.
fn draw_kicks(canvas: &mut Canvas, pitch: &Pitch, lines: &[KickLine], at: Vec2, width: f32) {
    let plan = Plan::new(pitch, at, width);
    draw_lines(canvas, pitch, &plan);
    for line in lines {
        let colour = if line.team == Team::Blue { BLUE } else { PINK };
        let [from, to] = [line.from_m, line.to_m].map(|place| plan.place(place.x, place.y));
        canvas.line(&[from, to], colour, if line.is_success { 2.5 } else { 1.0 });
        if line.is_success {
            canvas.disc(to, 4.0, colour, 1.0);
        }
    }
}

/// Draws a heat map.
fn draw_map(canvas: &mut Canvas, pitch: &Pitch, (map, colour): (&HeatMap, Colour), at: Vec2, width: f32) {
    let plan = Plan::new(pitch, at, width);
    let (half, points) = (plan.half_m, plan.points);
    let cell = 2.0 * half / Vec2::new(CELLS_ALONG as f32, map.rows as f32);
    let most_s = map.most_s().max(1e-6);
    for (index, time_s) in map.time_s.iter().enumerate().filter(|(_, time_s)| **time_s > 0.0) {
        let least = Vec2::new((index % CELLS_ALONG) as f32, (index / CELLS_ALONG) as f32) * cell - half;
        // Square roots of the shares make differences easier to see.
        canvas.rectangle(plan.place(least.x, least.y + cell.y), points * cell, colour, (time_s / most_s).sqrt());
    }
    draw_lines(canvas, pitch, &plan);
}

/// Draws the lines of the pitch.
fn draw_lines(canvas: &mut Canvas, pitch: &Pitch, plan: &Plan) {
    let (half, points) = (plan.half_m, plan.points);
    let place = |x: f32, y: f32| plan.place(x, y);
    let stroke = (points * pitch.line_width_m).max(1.0);
    let mut frame = |low: Vec2, high: Vec2| {
        let corners = [place(low.x, low.y), place(high.x, low.y), place(high.x, high.y), place(low.x, high.y)];
        canvas.outline(&corners, GREY, stroke);
    };
    frame(-half, half);
    for area in [Some(pitch.penalty_area), pitch.goal_area].into_iter().flatten() {
        let side = area.width_m / 2.0;
        frame(Vec2::new(-half.x, -side), Vec2::new(area.depth_m - half.x, side));
        frame(Vec2::new(half.x - area.depth_m, -side), Vec2::new(half.x, side));
    }
    canvas.line(&[place(0.0, -half.y), place(0.0, half.y)], GREY, stroke);
    let radius = points * pitch.centre_circle_diameter_m / 2.0;
    canvas.outline(&ellipse(place(0.0, 0.0), radius * Vec2::X, radius * Vec2::Y), GREY, stroke);
}

#[cfg(test)]
mod tests {
    use super::super::summary_rows::BALL;
    use super::*;
    use naoisis_sim::interface::cycle_record::{BallRecord, CycleRecord};
    use naoisis_sim::scenario::Scenario;

    /// Counts the pixels that have approximately this colour.
    fn count(image: &Image, Colour(wanted): Colour) -> usize {
        let is_near = |pixel: &&[u8]| pixel.iter().zip(wanted).all(|(one, other)| one.abs_diff(other) < 12);
        image.rgb.chunks_exact(3).filter(is_near).count()
    }

    #[test]
    fn a_picture_has_the_score_in_the_teams_colours_and_where_the_ball_was() {
        let scenario = Scenario::named("match3v3").unwrap();
        let mut summary = MatchSummary::new(&scenario);
        let before = picture(&summary);
        assert!(count(&before, BLUE) > 200 && count(&before, PINK) > 200, "the score");
        for cycle in 0..60 {
            let ball = Some(BallRecord { position_m: Vec3::new(1.0, 0.5, 0.0), velocity_mps: Vec3::ZERO });
            let game = naoisis_sim::interface::cycle_record::GameRecord {
                state: naoisis_core::game::GameState::Playing,
                ..default()
            };
            summary.look(&CycleRecord { cycle, time_s: f64::from(cycle as u32) / 30.0, ball, game, ..default() });
        }
        let after = picture(&summary);
        // The ball is in one cell of its map all the time.
        assert!(count(&after, BALL) > count(&before, BALL) + 100);
        assert_eq!((after.width, before.width), (1960, 1960));
    }

    #[test]
    fn long_words_are_cut_to_their_column() {
        let cut = shortened("leaving the field, pushing, and more of it", LETTERS, 100.0);
        assert!(cut.ends_with('…') && width_of_words(&cut, LETTERS) <= 110.0, "{cut}");
        assert_eq!(shortened("3", LETTERS, 100.0), "3");
    }
}
