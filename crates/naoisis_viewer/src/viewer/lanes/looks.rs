//! The colours of the lanes, and their legend.

use bevy_egui::egui::{self, Color32, FontId, Rect as Area, Sense, Stroke, WidgetInfo, WidgetType};

use super::tracks::{BallSource, Condition};
use crate::viewer::palette;
use crate::viewer::theme::{dim, text_size};
use naoisis_core::behaviour::drawings::DrawColour;

/// The colours of intentions, each with its strength on the panel and the intention of the built-in teams that has it in every match.
/// Other intentions have the colours that are left, in the order of their first use, and then these colours with stripes.
const WORD_INKS: [(DrawColour, f32, &str); 8] = [
    (DrawColour::Sky, 0.8, "support"),
    (DrawColour::Yellow, 0.55, "attack"),
    (DrawColour::Purple, 0.55, "search"),
    (DrawColour::White, 0.8, "keep"),
    (DrawColour::Green, 0.8, "receive"),
    (DrawColour::Blue, 0.8, "wait"),
    (DrawColour::Yellow, 0.8, "kick"),
    (DrawColour::Green, 0.3, "save"),
];
/// The distance between two stripes, logical pixels.
const STRIPES: f32 = 4.0;

/// The look of an intention or of a condition.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct WordLook {
    colour: Color32,
    is_striped: bool,
    edge: Option<Color32>,
}

impl WordLook {
    /// Fills an area.
    pub(super) fn fill(self, painter: &egui::Painter, area: Area) {
        painter.rect_filled(area, 1.0, self.colour);
        let stripes = if self.is_striped { (area.width() / STRIPES) as usize } else { 0 };
        for stripe in 0..stripes {
            let x = area.left() + STRIPES * (stripe as f32 + 0.5);
            painter.vline(x, area.y_range(), Stroke::new(1.0, Color32::from_black_alpha(130)));
        }
        if let Some(edge) = self.edge {
            painter.rect_stroke(area, 1.0, Stroke::new(1.0, edge), egui::StrokeKind::Inside);
        }
    }

    /// The colour of text on it: black or white, whichever has the higher contrast on this colour on a panel.
    pub(super) fn text(self, panel: Color32) -> Color32 {
        let [r, g, b, _] = panel.blend(self.colour).to_array().map(f32::from);
        // The weights of the perceived brightness (ITU-R BT.601).
        let brightness = 0.299 * r + 0.587 * g + 0.114 * b;
        if brightness > 125.0 { Color32::BLACK } else { Color32::WHITE }
    }
}

/// The looks of intentions. Robots without an intention have the empty one, which has no look of its own.
pub(super) fn word_looks(words: &[String]) -> Vec<WordLook> {
    let own = |word: &str| WORD_INKS.iter().position(|(.., of)| *of == word);
    let is_left = |index: &usize| !words.iter().any(|word| own(word) == Some(*index));
    let mut others = (0..WORD_INKS.len()).filter(is_left).chain(WORD_INKS.len()..);
    let look = |word: &String| {
        let index = if word.is_empty() { 0 } else { own(word).or_else(|| others.next()).unwrap_or(0) };
        let (colour, strength, _) = WORD_INKS[index % WORD_INKS.len()];
        let is_striped = index >= WORD_INKS.len();
        // White is nearly that of a light panel.
        let edge = (colour == DrawColour::White).then_some(Color32::from_gray(120));
        WordLook { is_striped, edge, ..plain(ink(colour).gamma_multiply(strength)) }
    };
    words.iter().map(look).collect()
}

/// Returns a look without stripes and edge.
fn plain(colour: Color32) -> WordLook {
    WordLook { colour, is_striped: false, edge: None }
}

/// Returns the look of a robot that lies on the ground or is penalised.
pub(super) fn condition_look(condition: Condition) -> WordLook {
    let vermilion = ink(DrawColour::Vermilion);
    match condition {
        Condition::Penalised => WordLook { edge: Some(vermilion), ..plain(Color32::from_black_alpha(190)) },
        Condition::Up | Condition::Down => plain(vermilion),
    }
}

/// Returns a colour for a panel.
pub(super) fn ink(ink: DrawColour) -> Color32 {
    palette::in_panel(palette::ink(ink))
}

/// Returns the colour of a source of the ball's position.
pub(super) fn ball_colour(source: BallSource) -> Color32 {
    match source {
        BallSource::Seen => ink(DrawColour::Orange),
        BallSource::Remembered => ink(DrawColour::Orange).gamma_multiply(0.4),
        BallSource::Told => ink(DrawColour::Sky),
        BallSource::Lost => Color32::from_black_alpha(120),
    }
}

/// Returns the source in a word.
pub(super) fn ball_words(source: BallSource) -> &'static str {
    match source {
        BallSource::Seen => "seen",
        BallSource::Remembered => "remembered",
        BallSource::Told => "told",
        BallSource::Lost => "lost",
    }
}

/// Shows the colours.
pub(super) fn show_legend(ui: &mut egui::Ui, words: &[String]) {
    let looks = word_looks(words);
    let words: Vec<_> = looks
        .into_iter()
        .zip(words)
        .filter(|(_, word)| !word.is_empty())
        .map(|(look, word)| (look, &word[..]))
        .collect();
    let sources = [BallSource::Seen, BallSource::Remembered, BallSource::Told, BallSource::Lost];
    let sources = sources.map(|source| (plain(ball_colour(source)), ball_words(source)));
    let others = [(condition_look(Condition::Down), "down"), (condition_look(Condition::Penalised), "penalised")];
    ui.horizontal_wrapped(|ui| {
        for (group, entries) in [("intention:", &words[..]), ("edge, ball is:", &sources), ("", &others)] {
            if !(group.is_empty() || entries.is_empty()) {
                ui.label(dim(group).size(text_size::SMALL));
            }
            entries.iter().for_each(|(look, name)| show_entry(ui, *look, name));
        }
        ui.label(dim("empty: no intention; disc: kick, ring: missed; triangle: mistake").size(text_size::SMALL));
    });
}

/// Shows a colour and its meaning, which stay on one line.
fn show_entry(ui: &mut egui::Ui, look: WordLook, name: &str) {
    const PATCH: f32 = 9.0;
    let (font, colour) = (FontId::proportional(text_size::SMALL), ui.visuals().weak_text_color());
    let words = ui.painter().layout_no_wrap(name.to_owned(), font, colour);
    let size = egui::vec2(PATCH + 5.0 + words.size().x, words.size().y);
    let (area, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Label, true, name));
    let patch = Area::from_center_size(area.left_center() + egui::vec2(PATCH / 2.0, 0.0), [PATCH; 2].into());
    look.fill(ui.painter(), patch);
    // The edge shows a patch that is as dark as the panel.
    if look.edge.is_none() {
        ui.painter().rect_stroke(patch, 1.0, Stroke::new(0.6, colour), egui::StrokeKind::Inside);
    }
    ui.painter().galley(area.left_top() + egui::vec2(PATCH + 5.0, 0.0), words, colour);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_intention_has_a_look_of_its_own() {
        let words: Vec<String> = ["keep", "", "search", "attack", "support", "save", "kick", "receive"]
            .into_iter()
            .chain(["clear", "pass", "wait"])
            .map(str::to_owned)
            .collect();
        let looks: Vec<WordLook> = word_looks(&words)
            .into_iter()
            .zip(&words)
            .filter(|(_, word)| !word.is_empty())
            .map(|(look, _)| look)
            .collect();
        for (index, look) in looks.iter().enumerate() {
            assert!(!looks[..index].contains(look), "{index}");
        }
        let striped: Vec<_> = looks.iter().map(|look| look.is_striped).collect();
        assert_eq!(striped, [false, false, false, false, false, false, false, true, true, false]);
    }

    #[test]
    fn an_intention_of_the_built_in_teams_has_one_colour_in_all_matches() {
        let looks = |words: &[&str]| word_looks(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>());
        let [one, other] = [looks(&["attack", "", "own word"]), looks(&["own word", "support", "attack"])];
        assert_eq!(one[0], other[2]);
        assert_ne!(other[0], other[1]);
    }

    #[test]
    fn words_can_be_read_on_their_colour() {
        let text = |colour| plain(colour).text(Color32::BLACK);
        assert_eq!([text(Color32::from_gray(200)), text(Color32::from_gray(60))], [Color32::BLACK, Color32::WHITE]);
        // A faint colour looks like its panel.
        assert_eq!(plain(Color32::from_black_alpha(20)).text(Color32::WHITE), Color32::BLACK);
    }
}
