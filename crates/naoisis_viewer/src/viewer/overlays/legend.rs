//! The legend of the overlays that are drawn, for a projector.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, RichText, Sense};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::beliefs::robot_ink;
use super::senses::camera_colour;
use super::{Overlay, Showing};
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::floating::place_beside;
use crate::viewer::layout::{self, LARGE_SCORE, LayoutSystems, shown_at};
use crate::viewer::palette;
use crate::viewer::theme::{MARGIN, card, team_colour, text_size};
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::camera_model::CameraName;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};

/// The greatest height of the legend, as a share of that of the free area.
const MOST_HEIGHT: f32 = 0.34;

/// The size of a patch, logical pixels.
pub(super) const PATCH: f32 = 9.0;
/// The width and the height of the free area below which letters are small, logical pixels.
const NARROW: f32 = 700.0;
const LOW: f32 = 350.0;

/// Shows the legend.
pub(super) struct LegendPlugin;

impl Plugin for LegendPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            EguiPrimaryContextPass,
            show_legend.run_if(|display: Res<DisplaySettings>| display.projector).in_set(LayoutSystems::Floating),
        );
    }
}

fn show_legend(mut contexts: EguiContexts, showing: Showing, roster: Res<Roster>) -> Result {
    let shown: Vec<Overlay> = match showing.shows_truth() {
        true => Overlay::ALL.into_iter().filter(|overlay| showing.any(*overlay)).collect(),
        false => vec![Overlay::Beliefs],
    };
    let robot = the_only_robot(&shown, &showing, &roster);
    let marks: Vec<_> = shown.into_iter().flat_map(marks).collect();
    let context = contexts.ctx_mut()?;
    let free = layout::free_area(context).size();
    let last = context.memory(|memory| memory.area_rect("legend")).map_or(egui::Vec2::ZERO, |area| area.size());
    // Panels may leave too little of the match for it.
    if marks.is_empty() || last.y > MOST_HEIGHT * free.y {
        return Ok(());
    }
    let is_small = free.x < NARROW || free.y < LOW;
    let (width, size) = if is_small { (free.x, text_size::SMALL) } else { (0.6 * free.x, text_size::IMPORTANT) };
    // A narrow picture has the pitch in its upper half.
    let is_low = free.x < NARROW && !(showing.is_watched() && shown_at(context, LARGE_SCORE).is_some());
    let align = if is_low { Align2::LEFT_BOTTOM } else { Align2::LEFT_TOP };
    let area = layout::floating(context, "legend", align).fixed_pos(corner_of(context, align, showing.is_watched()));
    area.interactable(false).show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).show(ui, |ui| {
            ui.set_max_width(width - 40.0);
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing.x = 5.0;
                if let Some(robot) = robot {
                    ui.label(RichText::new(format!("{robot}:")).size(size).strong().color(team_colour(ui, robot.team)));
                }
                for (colour, words) in marks {
                    // A patch stays on one line with its words.
                    let font = egui::FontId::proportional(size);
                    let words = ui.painter().layout_no_wrap(words.to_owned(), font, ui.visuals().text_color());
                    if ui.available_size_before_wrap().x < PATCH + 5.0 + words.size().x {
                        ui.end_row();
                    }
                    patch(ui, colour, words.size().y);
                    ui.label(words);
                    ui.add_space(6.0);
                }
            });
        });
    });
    Ok(())
}

/// The corner of the legend with this alignment: below the score in the use for watching, and above what is at the lower edge.
fn corner_of(context: &egui::Context, align: Align2, is_watched: bool) -> egui::Pos2 {
    if let Some(score) = shown_at(context, LARGE_SCORE).filter(|_| is_watched) {
        return egui::pos2(layout::free_area(context).left() + MARGIN, score.bottom() + MARGIN);
    }
    align.pos_in_rect(&place_beside(context, "legend", align, &["caption", "goal replay", "driver"]))
}

/// Returns the robot of which overlays are shown, if it is only one. In the world of one robot, it is that one.
fn the_only_robot(shown: &[Overlay], showing: &Showing, roster: &Roster) -> Option<RobotId> {
    if !showing.shows_truth() {
        return showing.selection.0;
    }
    let is_shown = |robot: &RobotId| shown.iter().any(|overlay| showing.wants(*overlay, *robot));
    let mut robots = roster.iter().map(|(id, _)| id).filter(is_shown);
    robots.next().filter(|_| robots.next().is_none())
}

/// Shows a patch of a colour in the middle of a line of this height, logical pixels.
pub(super) fn patch(ui: &mut egui::Ui, colour: Color, height: f32) -> egui::Response {
    let (line, response) = ui.allocate_exact_size(egui::vec2(PATCH, height.max(PATCH)), Sense::hover());
    let area = egui::Rect::from_center_size(line.center(), egui::Vec2::splat(PATCH));
    // The edge shows white on a light panel.
    let edge = (1.0, ui.visuals().weak_text_color());
    ui.painter().rect(area, 2.0, palette::in_panel(colour), edge, egui::StrokeKind::Inside);
    response
}

/// Returns the colours of an overlay with their meanings.
pub(super) fn marks(overlay: Overlay) -> Vec<(Color, &'static str)> {
    use DrawColour::{Orange, Purple, Sky, Vermilion, White, Yellow};
    let inks = |inks: &[(DrawColour, &'static str)]| {
        inks.iter().map(|(ink, words)| (palette::ink(*ink), *words)).collect::<Vec<_>>()
    };
    let teams =
        |words: [&'static str; 2]| [(palette::team(Team::Blue), words[0]), (palette::team(Team::Pink), words[1])];
    match overlay {
        Overlay::FieldsOfView => vec![
            (camera_colour(CameraName::TOP), "seen by the upper camera"),
            (camera_colour(CameraName::BOTTOM), "seen by the lower camera"),
        ],
        Overlay::Sonar => inks(&[(Sky, "sonar"), (Vermilion, "sonar echo")]),
        Overlay::Percepts => {
            let robots = teams(["recognises a blue robot", "recognises a pink robot"]);
            [inks(&[(Orange, "recognises the ball"), (White, "recognises lines")]), robots.to_vec()].concat()
        }
        Overlay::Beliefs => inks(&[
            (Purple, "believes itself there; ellipses have 95 % of the probability"),
            (Orange, "believes the ball there; arrow: its motion"),
            (robot_ink(Team::Blue), "believes a blue robot there"),
            (robot_ink(Team::Pink), "believes a pink robot there"),
        ]),
        Overlay::Targets => inks(&[(White, "walks there within a second"), (Sky, "looks there")]),
        Overlay::Drawings => Vec::new(),
        Overlay::Bounds => inks(&[(Yellow, "bounds of the base"), (Sky, "bounds of the torso")]),
        Overlay::KickAreas => inks(&[
            (White, "area of a kick forwards"),
            (Sky, "area of a kick to the side"),
            (Vermilion, "the ball is in the area"),
        ]),
        Overlay::Trails => {
            [teams(["path of blue", "path of pink"]).to_vec(), inks(&[(Orange, "path of the ball")])].concat()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meanings_of_one_overlay_have_colours_that_differ() {
        for overlay in Overlay::ALL {
            let marks = marks(overlay);
            for (index, (colour, words)) in marks.iter().enumerate() {
                assert!(marks[..index].iter().all(|(other, _)| other != colour), "{overlay:?}: {words}");
            }
        }
    }
}
