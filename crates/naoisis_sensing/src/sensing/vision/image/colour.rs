//! Classification of colours.

use std::sync::LazyLock;

/// The class of a pixel's colour.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
#[repr(u8)]
pub enum ColourClass {
    /// No object.
    #[default]
    Other,
    /// The carpet.
    Green,
    /// Lines, but also robots and footballs.
    White,
    /// The patches of a football, but also joints of robots.
    Black,
    /// A jersey, but also the floor.
    Grey,
    /// A jersey.
    Brown,
    /// The ball.
    Orange,
    /// A goal.
    Yellow,
    /// A goal.
    SkyBlue,
    /// A waistband.
    Pink,
    /// A waistband.
    Blue,
    /// A jersey.
    Red,
    /// A jersey.
    Purple,
}

impl ColourClass {
    /// Whether objects are detected by blobs of this class.
    #[inline]
    pub const fn is_cue(self) -> bool {
        self as u8 >= ColourClass::Orange as u8
    }

    /// The class of a colour, from its hue, saturation and lightness, so that it depends little on light and shadow.
    fn of([red, green, blue]: [f32; 3]) -> Self {
        let most = red.max(green).max(blue);
        let least = red.min(green).min(blue);
        let range = most - least;
        let saturation = range / most;
        if most < 32.0 || most < 72.0 && saturation < 0.35 {
            return ColourClass::Black;
        }
        if saturation < 0.2 {
            return if most >= 135.0 { ColourClass::White } else { ColourClass::Grey };
        }
        let hue_deg = 60.0
            * if most == red {
                ((green - blue) / range).rem_euclid(6.0)
            } else if most == green {
                (blue - red) / range + 2.0
            } else {
                (red - green) / range + 4.0
            };
        // The ball's hue is 24°, the yellow goal's 46°, the carpet's 134°, the sky-blue goal's 199°, the blue band's 223°,
        // the pink one's 332°.
        match hue_deg {
            12.0..40.0 if (0.4..0.75).contains(&saturation) && most < 125.0 => ColourClass::Brown,
            8.0..35.0 if saturation > 0.6 && most >= 90.0 => ColourClass::Orange,
            35.0..64.0 if saturation > 0.5 && most >= 80.0 => ColourClass::Yellow,
            90.0..172.0 if saturation > 0.3 => ColourClass::Green,
            182.0..211.0 if saturation > 0.6 => ColourClass::SkyBlue,
            211.0..250.0 if saturation > 0.55 => ColourClass::Blue,
            250.0..305.0 if saturation > 0.5 => ColourClass::Purple,
            ..8.0 | 352.0.. if saturation > 0.6 && most >= 80.0 => ColourClass::Red,
            305.0..352.0 if saturation > 0.35 && most >= 80.0 => ColourClass::Pink,
            _ => ColourClass::Other,
        }
    }
}

/// The classes of all colours, by the upper five bits of each channel.
pub(super) static TABLE: LazyLock<Box<[ColourClass; 1 << 15]>> = LazyLock::new(|| {
    let classes = (0..1 << 15).map(|index: u32| {
        // The middle of the colours that share those bits.
        let middle = |shift: u32| ((index >> shift & 31) * 8) as f32 + 3.5;
        ColourClass::of([middle(10), middle(5), middle(0)])
    });
    let mut table = Box::new([ColourClass::Other; 1 << 15]);
    for (entry, class) in table.iter_mut().zip(classes) {
        *entry = class;
    }
    table
});

#[inline(always)]
pub(super) fn index_of(red: u8, green: u8, blue: u8) -> usize {
    usize::from(red >> 3) << 10 | usize::from(green >> 3) << 5 | usize::from(blue >> 3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::ball;
    use crate::appearance::colours::{self, Colour};
    use naoisis_core::pitch::GoalColour;
    use naoisis_core::robot::jersey::Jersey;
    use naoisis_core::team::Team;

    fn class_of([red, green, blue]: [u8; 3]) -> ColourClass {
        TABLE[index_of(red, green, blue)]
    }

    #[test]
    fn the_colours_on_the_pitch_have_their_classes_in_light_and_in_shade() {
        let cases = [
            (colours::BALL, ColourClass::Orange),
            (colours::goal(GoalColour::Yellow), ColourClass::Yellow),
            (colours::goal(GoalColour::Blue), ColourClass::SkyBlue),
            (colours::team(Team::Blue), ColourClass::Blue),
            (colours::team(Team::Pink), ColourClass::Pink),
            (colours::CARPET, ColourClass::Green),
            (colours::CHALK, ColourClass::White),
            (colours::worn(Team::Blue, Some(Jersey::Red)), ColourClass::Red),
            (colours::worn(Team::Blue, Some(Jersey::Purple)), ColourClass::Purple),
            (colours::worn(Team::Blue, Some(Jersey::Grey)), ColourClass::Grey),
            (colours::worn(Team::Blue, Some(Jersey::Brown)), ColourClass::Brown),
            (colours::worn(Team::Blue, Some(Jersey::Black)), ColourClass::Black),
            (colours::worn(Team::Blue, Some(Jersey::White)), ColourClass::White),
            (ball::WHITE, ColourClass::White),
            (ball::BLACK, ColourClass::Black),
        ];
        for (Colour(rgb), class) in cases {
            // The least light on a surface is 62 %: from below, without the sun.
            for light in [100, 85, 70, 62] {
                let shaded = rgb.map(|channel| (u32::from(channel) * light / 100) as u8);
                assert_eq!(class_of(shaded), class, "{shaded:?}");
            }
        }
        for other in [colours::SKY, colours::FLOOR, colours::JOINT, colours::EXTRA_POST] {
            assert!(!class_of(other.0).is_cue() && class_of(other.0) != ColourClass::Green);
        }
    }
}
