//! The look of panels: dark or light, colours, sizes of text.
//!
//! No information is in colours alone: everything with the colour of a team also has its name, and the colours of
//! overlays ([`DrawColour`](naoisis_core::behaviour::drawings::DrawColour)) are those of Okabe and Ito, which can be distinguished
//! with any kind of colour blindness.

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;
use bevy_egui::egui::{
    self, Align2, Color32, CornerRadius, Frame, Margin, RichText, Stroke, Theme, Visuals, WidgetInfo, WidgetType,
};
use bevy_egui::{EguiContexts, EguiPostUpdateSet, EguiPrimaryContextPass};

use core::num::NonZeroUsize;

use super::display_settings::DisplaySettings;
use super::palette;
use naoisis_core::team::Team;
use naoisis_record::record::summary_page;

/// The distance of panels from the edge of the window, logical pixels.
pub const MARGIN: f32 = 10.0;

/// The longest time between press and release of a click, s.
const LONGEST_CLICK_S: f64 = 5.0;

/// The sizes of text in panels, logical pixels.
pub(super) mod text_size {
    pub const SMALL: f32 = 11.5;
    pub const ENTRY: f32 = 12.5;
    pub const IMPORTANT: f32 = 14.0;
    pub const BUTTON: f32 = 16.0;
    pub const TEAM: f32 = 17.0;
    pub const TITLE: f32 = 18.0;
    pub const SCORE: f32 = 24.0;
}

/// The systems that prepare the look of panels; systems that show panels run after them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ThemeSystems;

/// Sets the look of panels.
pub struct ThemePlugin;

impl Plugin for ThemePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            (set_looks.run_if(run_once), choose_theme).chain().in_set(ThemeSystems),
        )
        // Otherwise, letters would be missing in the first frame that uses them.
        .configure_sets(PostUpdate, EguiPostUpdateSet::PostProcessOutput.before(AssetEventSystems));
    }
}

fn set_looks(mut contexts: EguiContexts) -> Result {
    let context = contexts.ctx_mut()?;
    for theme in [Theme::Dark, Theme::Light] {
        context.set_visuals_of(theme, visuals(theme));
    }
    // On a slow display there can be a whole frame between the press and the release of a click.
    context.options_mut(|options| {
        options.input_options.max_click_duration = LONGEST_CLICK_S;
        // A new table in a new panel is in place after three passes; rows would lie over each other in its first frame.
        options.max_passes = const { NonZeroUsize::new(3).unwrap() };
    });
    // Sizes of panels that are chosen by the user need not be whole pixels.
    // Bars that only show under the mouse leave it open whether there is more to see.
    context.all_styles_mut(|style| style.spacing.scroll.dormant_handle_opacity = 0.5);
    // The fade at the edge of a list is dark in either theme.
    context.style_mut_of(Theme::Light, |style| style.spacing.scroll.fade.strength = 0.0);
    #[cfg(debug_assertions)]
    context.all_styles_mut(|style| style.debug.show_unaligned = false);
    Ok(())
}

fn visuals(theme: Theme) -> Visuals {
    let mut visuals = theme.default_visuals();
    let [card, text, strong, weak, selection] = match theme {
        Theme::Dark => [Color32::from_rgb(20, 24, 31), grey(225), grey(240), grey(165), Color32::from_rgb(0, 100, 150)],
        Theme::Light => {
            [Color32::from_rgb(246, 247, 249), grey(40), grey(10), grey(85), Color32::from_rgb(90, 165, 225)]
        }
    };
    visuals.panel_fill = card;
    visuals.window_fill = card;
    visuals.weak_text_color = Some(weak);
    visuals.selection.bg_fill = selection;
    visuals.selection.stroke.color = strong;
    visuals.widgets.noninteractive.fg_stroke = Stroke::new(1.0, text);
    visuals.widgets.inactive.fg_stroke = Stroke::new(1.0, text);
    visuals.widgets.active.fg_stroke = Stroke::new(1.0, strong);
    if theme == Theme::Light {
        // Empty check boxes, and the rails of sliders.
        visuals.widgets.inactive.bg_fill = grey(165);
        visuals.widgets.hovered.bg_fill = grey(150);
        visuals.disabled_alpha = 0.65;
    }
    visuals
}

const fn grey(level: u8) -> Color32 {
    Color32::from_gray(level)
}

fn choose_theme(mut contexts: EguiContexts, windows: Query<&Window>, display: Res<DisplaySettings>) -> Result {
    let context = contexts.ctx_mut()?;
    let theme = if display.light { Theme::Light } else { Theme::Dark };
    if context.theme() != theme {
        context.set_theme(theme);
    }
    context.set_zoom_factor(display.panel_factor(windows.iter().next().map_or(0.0, Window::height)));
    Ok(())
}

/// Returns the background of all panels.
pub fn card(ui: &egui::Ui) -> Frame {
    Frame::NONE
        .fill(ui.visuals().panel_fill.gamma_multiply(0.88))
        .corner_radius(CornerRadius::same(8))
        .inner_margin(Margin::symmetric(12, 8))
}

/// Returns a panel over the others, at an edge or in the middle of the window.
pub fn panel(name: &str, align: Align2, offset: [f32; 2]) -> egui::Area {
    egui::Area::new(egui::Id::new(name)).anchor(align, offset).order(egui::Order::Foreground)
}

/// Prominent text.
pub fn bright(text: impl Into<String>) -> RichText {
    RichText::new(text).strong()
}

/// Less prominent text.
pub fn dim(text: impl Into<String>) -> RichText {
    RichText::new(text).weak()
}

/// Returns the colour of a team's text.
pub fn team_colour(ui: &egui::Ui, team: Team) -> Color32 {
    team_colour_on(ui.visuals().dark_mode, team)
}

/// Returns the colour of a team's text on a dark or light ground.
pub(super) fn team_colour_on(dark: bool, team: Team) -> Color32 {
    // The colours of the waistbands are too dark or too light for text on panels.
    match (dark, team) {
        (true, Team::Blue) => Color32::from_rgb(112, 165, 255),
        (true, Team::Pink) => Color32::from_rgb(255, 140, 194),
        (false, Team::Blue) => Color32::from_rgb(16, 62, 190),
        (false, Team::Pink) => Color32::from_rgb(176, 14, 98),
    }
}

/// Returns the colour of problems.
pub fn problem_colour(ui: &egui::Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(255, 140, 120) } else { Color32::from_rgb(176, 40, 10) }
}

/// A patch of a team's colour: square for blue, round for pink, for people who cannot tell the colours apart.
pub fn band(ui: &mut egui::Ui, team: Team, size: egui::Vec2) {
    let (area, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    let rounding = if team == Team::Blue { 2.0 } else { size.min_elem() / 2.0 };
    ui.painter().rect_filled(area, rounding, palette::in_panel(palette::team(team)));
}

/// Shows a label that can be clicked. `name` is for screen readers.
pub fn link(ui: &mut egui::Ui, label: egui::Label, name: &str) -> egui::Response {
    let response = ui.add(label.sense(egui::Sense::click())).on_hover_cursor(egui::CursorIcon::PointingHand);
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
    response
}

/// Returns the text of a time in minutes and seconds, as in summaries and pictures.
pub fn minutes(seconds: f32) -> String {
    summary_page::minutes(f64::from(seconds))
}

/// Returns the text of a number of things.
pub(super) fn count(number: usize, name: &str) -> String {
    if number == 1 { format!("1 {name}") } else { format!("{number} {name}s") }
}

/// Returns the text of a time in seconds, with the tenths that have passed.
pub(super) fn tenths(time_s: f64) -> String {
    format!("{:.1} s", (10.0 * time_s + 1e-3).floor() / 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast of two colours (WCAG 2.2, "contrast ratio").
    fn contrast(one: Color32, other: Color32) -> f32 {
        let luminance = |colour: Color32| {
            let [red, green, blue] = [colour.r(), colour.g(), colour.b()].map(|channel| {
                let share = f32::from(channel) / 255.0;
                if share <= 0.04045 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
            });
            0.2126 * red + 0.7152 * green + 0.0722 * blue
        };
        let [darker, lighter] = {
            let [one, other] = [luminance(one), luminance(other)];
            [one.min(other), one.max(other)]
        };
        (lighter + 0.05) / (darker + 0.05)
    }

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!([0, 1, 2].map(|number| count(number, "cycle")), ["0 cycles", "1 cycle", "2 cycles"]);
    }

    #[test]
    fn text_can_be_read_on_its_panel_in_both_themes() {
        for theme in [Theme::Dark, Theme::Light] {
            let visuals = visuals(theme);
            let texts = [visuals.text_color(), visuals.strong_text_color(), visuals.weak_text_color()];
            let teams = Team::BOTH.map(|team| team_colour_on(visuals.dark_mode, team));
            for colour in texts.into_iter().chain(teams) {
                // WCAG's level AA.
                let contrast = contrast(colour, visuals.panel_fill);
                assert!(contrast >= 4.5, "{theme:?}: {colour:?} has a contrast of {contrast}");
            }
            // An empty check box is seen.
            assert!(contrast(visuals.widgets.inactive.bg_fill, visuals.panel_fill) >= 1.5, "{theme:?}");
        }
    }
}
