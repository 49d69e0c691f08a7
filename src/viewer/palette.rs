//! The colours of what is shown.
//!
//! Blue and pink are far apart in lightness and hue, so that they can be told apart with any kind of colour blindness.

use bevy::prelude::*;
use bevy_egui::egui::Color32;

use crate::pitch::GoalColour;
use crate::robot::Team;

/// The sky, and what fades into it.
pub const SKY: Color = Color::srgb(0.67, 0.78, 0.89);
/// The floor of the hall.
pub const FLOOR: Color = Color::srgb(0.44, 0.45, 0.46);
/// The carpet.
pub const CARPET: Color = Color::srgb(0.13, 0.40, 0.19);
/// Lines and nets.
pub const CHALK: Color = Color::srgb(0.90, 0.91, 0.90);
/// The ball: the orange of a street hockey ball (2010 rule book, section 1.4).
pub const BALL: Color = Color::srgb(1.0, 0.42, 0.05);
/// The plastic of a NAO.
pub const SHELL: Color = Color::srgb(0.80, 0.81, 0.83);
/// Its joints.
pub const JOINT: Color = Color::srgb(0.20, 0.21, 0.23);
/// Its eyes.
pub const EYE: Color = Color::srgb(0.15, 0.75, 0.85);
/// Posts that belong to no goal.
pub const EXTRA_POST: Color = Color::srgb(0.55, 0.56, 0.60);

/// The colour of a team's waistband.
pub fn team(team: Team) -> Color {
    match team {
        Team::Blue => Color::srgb(0.08, 0.30, 0.85),
        Team::Pink => Color::srgb(0.98, 0.32, 0.62),
    }
}

/// The colour of a goal's posts and bar.
pub fn goal(colour: GoalColour) -> Color {
    match colour {
        // RAL 1018 and RAL 5015.
        GoalColour::Yellow => Color::srgb(0.98, 0.79, 0.19),
        GoalColour::Blue => Color::srgb(0.0, 0.49, 0.69),
        GoalColour::White => Color::srgb(0.93, 0.93, 0.93),
    }
}

/// The same colour in a panel.
pub fn in_panel(colour: Color) -> Color32 {
    let [red, green, blue, alpha] = colour.to_srgba().to_u8_array();
    Color32::from_rgba_unmultiplied(red, green, blue, alpha)
}
