//! The colours of the [appearance](naoisis_sensing::appearance::colours) for Bevy and for the panels.

use bevy::prelude::*;
use bevy_egui::egui::Color32;

use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::pitch::GoalColour;
use naoisis_core::team::Team;
use naoisis_sensing::appearance::colours::{self, Colour};

/// The colour of the light from all sides.
pub const SKY: Color = from_appearance(colours::SKY);
/// The dark of the hall around the pitch, and of its haze.
pub const HALL: Color = Color::srgb(0.125, 0.145, 0.175);
/// Nets.
pub const NET: Color = from_appearance(colours::NET);

/// Converts a colour of the appearance.
pub const fn from_appearance(Colour([red, green, blue]): Colour) -> Color {
    Color::srgb(red as f32 / 255.0, green as f32 / 255.0, blue as f32 / 255.0)
}

/// Returns the colour of a team's waistband.
pub const fn team(team: Team) -> Color {
    from_appearance(colours::team(team))
}

/// Returns the colour of a goal.
pub const fn goal(colour: GoalColour) -> Color {
    from_appearance(colours::goal(colour))
}

/// Returns the colour of overlays and of drawings of behaviours.
pub fn ink(ink: DrawColour) -> Color {
    let [red, green, blue] = ink.rgb();
    Color::srgb_u8(red, green, blue)
}

/// Converts a colour for a panel.
pub fn in_panel(colour: Color) -> Color32 {
    let [red, green, blue, alpha] = colour.to_srgba().to_u8_array();
    Color32::from_rgba_unmultiplied(red, green, blue, alpha)
}
