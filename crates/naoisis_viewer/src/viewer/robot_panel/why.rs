//! The section "Why": the options of the behaviour with their values, and the robot's last kick.

use bevy_egui::egui::{self, Grid, RichText};

use super::last_kick::LastKick;
use crate::viewer::rebuild::ShownState;
use crate::viewer::theme::{dim, text_size};
use naoisis_core::cycle::CycleClock;

/// Shows the options of the behaviour, each with a bar for its value; the chosen one is bold.
pub(super) fn show_reasons(ui: &mut egui::Ui, state: &ShownState, (cycle, is_past, is_penalised): (u64, bool, bool)) {
    /// The width of the longest bar, logical pixels.
    const BAR: f32 = 70.0;

    let reasons = state.0.as_ref().ok().and_then(|state| state.reasons.as_ref());
    let Some(reasons) = reasons else {
        let words = match (&state.0, is_past) {
            _ if cycle == 0 => "The match has not begun: its behaviour has not decided yet.",
            (Err(why), _) => why,
            _ if is_penalised => "There are no options while it is penalised.",
            (Ok(_), true) => "Its behaviour recorded no options in this cycle.",
            (Ok(_), false) => "Options are known for moments of the past: go one cycle back (Left).",
        };
        ui.add(egui::Label::new(dim(words).size(text_size::SMALL)).wrap());
        return;
    };
    let values: Vec<f32> = reasons.options.iter().map(|option| option.value).collect();
    Grid::new("reasons").num_columns(3).spacing([8.0, 2.0]).show(ui, |ui| {
        for (index, option) in reasons.options.iter().enumerate() {
            let is_chosen = reasons.chosen == Some(index);
            let name = RichText::new(option.name.as_ref()).size(text_size::ENTRY);
            ui.label(if is_chosen { name.strong() } else { name.weak() });
            let (area, response) = ui.allocate_exact_size(egui::vec2(BAR, 9.0), egui::Sense::hover());
            let length = bar_length(option.value, &values) * BAR;
            let bar = egui::Rect::from_min_size(area.min, egui::vec2(length, area.height()));
            let visuals = ui.visuals();
            let colour = if is_chosen { visuals.strong_text_color() } else { visuals.weak_text_color() };
            ui.painter().rect_filled(bar, 1.0, colour);
            response.on_hover_text(format!("{:.2}", option.value));
            ui.add(egui::Label::new(dim(option.why.as_ref()).size(text_size::SMALL)).wrap());
            ui.end_row();
        }
    });
}

/// Shows the last kick with buttons to its cycles. Returns the cycle that was clicked.
pub(super) fn show_kick(ui: &mut egui::Ui, kick: &LastKick, clock: &CycleClock) -> Option<u64> {
    let ago_s = clock.cycle.saturating_sub(kick.cycle) as f64 * clock.period_s;
    let when = if ago_s > 0.0 { format!("Last kick, {ago_s:.1} s ago") } else { "Kicks now".to_owned() };
    let words = RichText::new(format!("{when}: {}", kick.words)).size(text_size::ENTRY);
    ui.add(egui::Label::new(words).wrap());
    let places = [("Go to the decision", kick.decided), ("Go to the kick", Some(kick.cycle))];
    let places = places.into_iter().filter_map(|(name, cycle)| cycle.map(|cycle| (name, cycle)));
    let button = |ui: &mut egui::Ui, name: &str, cycle: u64| {
        let button = ui.add_enabled(cycle != clock.cycle, egui::Button::new(name).small());
        button.on_disabled_hover_text("This is the moment that is shown").clicked().then_some(cycle)
    };
    ui.horizontal(|ui| places.filter_map(|(name, cycle)| button(ui, name, cycle)).last()).inner
}

/// The length of the bar of an option with this value, 0 to 1: from zero or, if some values are negative, from slightly
/// below the least, so that each option has a bar.
fn bar_length(value: f32, all: &[f32]) -> f32 {
    let finite = all.iter().copied().filter(|value| value.is_finite());
    let (least, most) = finite.fold((f32::MAX, f32::MIN), |(least, most), value| (least.min(value), most.max(value)));
    let from = if least < 0.0 { least - 0.1 * (most - least) } else { 0.0 };
    if most <= from {
        return 1.0;
    }
    ((value - from) / (most - from)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_option_has_a_bar_and_the_best_the_longest() {
        let of = |values: &[f32]| values.iter().map(|value| bar_length(*value, values)).collect::<Vec<_>>();
        assert_eq!(of(&[1.0, 4.0]), [0.25, 1.0]);
        // Costs: the more expensive option is worse, but still has a bar.
        let bars = of(&[-1.2, -6.5]);
        assert!(bars[0] == 1.0 && (0.05..0.2).contains(&bars[1]), "{bars:?}");
        assert_eq!(of(&[-2.0, -2.0]), [1.0, 1.0]);
        assert_eq!(of(&[0.0, 3.0])[0], 0.0, "what is worth nothing has none");
        assert_eq!(bar_length(f32::NEG_INFINITY, &[f32::NEG_INFINITY, 1.0]), 0.0);
    }
}
