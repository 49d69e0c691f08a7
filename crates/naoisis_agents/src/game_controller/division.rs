//! The divisions of the Humanoid Soccer League. Version 19 of the protocol sends the division, so that robots know the
//! size of their pitch.

use naoisis_core::pitch::Pitch;

/// The longest pitches of the small and of the middle division, m: halfway between the pitches of the leagues, which are 9, 14 and 22 m
/// long.
const LONGEST_SMALL_M: f32 = 11.5;
const LONGEST_MIDDLE_M: f32 = 18.0;

/// A division of the Humanoid Soccer League.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Division {
    /// Small robots.
    #[default]
    Small,
    /// Middle robots.
    Middle,
    /// Large robots.
    Large,
}

impl Division {
    /// The division that plays on `pitch`, by its length.
    pub fn on(pitch: &Pitch) -> Self {
        match pitch.length_m {
            length_m if length_m <= LONGEST_SMALL_M => Division::Small,
            length_m if length_m <= LONGEST_MIDDLE_M => Division::Middle,
            _ => Division::Large,
        }
    }

    /// Its code on the wire.
    pub(super) fn code(self) -> u8 {
        match self {
            Division::Small => 0,
            Division::Middle => 1,
            Division::Large => 2,
        }
    }

    /// The division with this code.
    pub(super) fn of_code(code: u8) -> Option<Self> {
        [Division::Small, Division::Middle, Division::Large].into_iter().find(|division| division.code() == code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::Scenario;

    #[test]
    fn the_pitch_of_each_league_tells_its_division() {
        for (league, division) in [
            ("hsl2026_small", Division::Small),
            ("hsl2026_middle", Division::Middle),
            ("hsl2026_middle_foundation", Division::Middle),
            ("hsl2026_large", Division::Large),
            ("spl2025", Division::Small),
        ] {
            let scenario = Scenario::from_json(&format!(r#"{{ "league": "{league}" }}"#)).unwrap();
            assert_eq!(Division::on(&scenario.field), division, "{league}");
        }
    }
}
