//! The list of built-in scenarios: matches first, then experiments.

use bevy_egui::egui::{ComboBox, Response, Ui};
use std::sync::OnceLock;

use super::theme::{dim, text_size};
use naoisis_sim::scenario::{LIBRARY, ScenarioFile};

/// The greatest height of the list, logical pixels.
const HEIGHT: f32 = 460.0;

/// Shows a list of the built-in scenarios; `choose` receives the chosen one.
pub fn show(ui: &mut Ui, list: ComboBox, current: &str, mut choose: impl FnMut(&'static str)) -> Response {
    let shown = list.height(HEIGHT).show_ui(ui, |ui| {
        for (heading, names) in [("Matches", &in_order().matches), ("Experiments", &in_order().experiments)] {
            ui.label(dim(heading).size(text_size::SMALL));
            for name in names {
                if ui.selectable_label(*name == current, *name).clicked() {
                    choose(name);
                }
            }
        }
    });
    shown.response
}

/// The built-in scenarios by kind, each sorted by name.
struct InOrder {
    /// Matches of two teams.
    matches: Vec<&'static str>,
    /// All others.
    experiments: Vec<&'static str>,
}

/// Reads the scenarios when the list is opened for the first time.
fn in_order() -> &'static InOrder {
    static IN_ORDER: OnceLock<InOrder> = OnceLock::new();
    IN_ORDER.get_or_init(|| {
        let is_match = |name: &&str| ScenarioFile::named(name).is_ok_and(|file| file.scenario.teams.is_some());
        let (matches, experiments) = LIBRARY.iter().map(|entry| entry.name).partition(is_match);
        InOrder { matches, experiments }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scenario_is_listed_once_and_matches_come_first() {
        let InOrder { matches, experiments } = in_order();
        assert_eq!(matches.len() + experiments.len(), LIBRARY.len());
        assert!(matches.contains(&"match3v3") && matches.contains(&"match7v7"));
        assert!(experiments.contains(&"kick_left_side"));
    }
}
