//! The colours of drawn objects.
//!
//! Blue and pink are far apart in lightness and hue, so that they can be told apart with any kind of colour blindness;
//! the blue of the waistbands and the sky-blue of the goal differ in hue, so that a robot can tell them apart.

use naoisis_core::pitch::GoalColour;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::robot::look::{Look, Rgb};
use naoisis_core::team::Team;

/// A colour: red, green and blue, sRGB.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Colour(pub [u8; 3]);

/// The colour with this hue (degrees), saturation and value (0 to 1).
pub fn hsv(hue_deg: f32, saturation: f32, value: f32) -> Rgb {
    let (saturation, value) = (saturation.clamp(0.0, 1.0), value.clamp(0.0, 1.0));
    [5.0, 3.0, 1.0].map(|shift| {
        let k = (shift + hue_deg / 60.0) % 6.0;
        let share = k.min(4.0 - k).clamp(0.0, 1.0);
        (255.0 * value * (1.0 - saturation * share)).round() as u8
    })
}

/// The wall of the hall, above the horizon.
pub const SKY: Colour = Colour([171, 199, 227]);
/// The floor of the hall.
pub const FLOOR: Colour = Colour([112, 115, 117]);
/// The carpet.
pub const CARPET: Colour = Colour([34, 110, 52]);
/// Lines.
pub const CHALK: Colour = Colour([236, 238, 236]);
/// Nets, and the frames that carry them.
pub const NET: Colour = Colour([228, 230, 232]);
/// The ball: the orange of a street hockey ball (2010 rule book, section 1.4).
pub const BALL: Colour = Colour([255, 112, 16]);
/// The plastic of a NAO.
pub const SHELL: Colour = Colour(Look::NAO.shell);
/// The joints of a NAO.
pub const JOINT: Colour = Colour(Look::NAO.joints);
/// Posts that belong to no goal.
pub const EXTRA_POST: Colour = Colour([140, 143, 153]);

/// The colour of a team's waistband.
pub const fn team(team: Team) -> Colour {
    match team {
        Team::Blue => Colour([24, 78, 220]),
        Team::Pink => Colour([250, 82, 160]),
    }
}

/// The colour in which a robot of a team plays: that of its jersey, or of its waistband without one.
pub const fn worn(of: Team, jersey: Option<Jersey>) -> Colour {
    match jersey {
        None | Some(Jersey::Team) => team(of),
        Some(Jersey::Blue) => Colour([20, 60, 200]),
        Some(Jersey::Red) => Colour([200, 25, 30]),
        Some(Jersey::Yellow) => Colour([240, 205, 30]),
        Some(Jersey::Black) => Colour([25, 25, 28]),
        Some(Jersey::White) => Colour([238, 238, 238]),
        Some(Jersey::Green) => Colour([25, 150, 60]),
        Some(Jersey::Orange) => Colour([245, 120, 20]),
        Some(Jersey::Purple) => Colour([110, 40, 150]),
        Some(Jersey::Brown) => Colour([110, 70, 40]),
        Some(Jersey::Grey) => Colour([125, 125, 128]),
    }
}

/// The colour of the number on a jersey: black on bright jerseys, white on others.
pub const fn number_on(jersey: Jersey) -> Colour {
    match jersey {
        Jersey::Yellow | Jersey::White | Jersey::Orange => Colour([12, 12, 14]),
        _ => Colour([250, 250, 250]),
    }
}

/// The colour of a goal's posts and bar.
pub const fn goal(colour: GoalColour) -> Colour {
    match colour {
        // RAL 1018 and RAL 5015.
        GoalColour::Yellow => Colour([250, 202, 48]),
        GoalColour::Blue => Colour([0, 125, 182]),
        GoalColour::White => Colour([238, 238, 238]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hues_are_those_of_the_colour_wheel() {
        for (hue, expected) in [(0.0, [255, 0, 0]), (60.0, [255, 255, 0]), (120.0, [0, 255, 0]), (240.0, [0, 0, 255])] {
            assert_eq!(hsv(hue, 1.0, 1.0), expected);
        }
        assert_eq!(hsv(77.0, 0.0, 0.5), [128; 3]);
    }
}
