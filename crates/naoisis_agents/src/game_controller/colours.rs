//! Colours of jerseys.

use naoisis_core::team::PerTeam;

/// The colour of a jersey, with the code of the GameController.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
#[repr(u8)]
pub enum JerseyColour {
    /// Blue.
    #[default]
    Blue,
    /// Red.
    Red,
    /// Yellow.
    Yellow,
    /// Black.
    Black,
    /// White.
    White,
    /// Green.
    Green,
    /// Orange.
    Orange,
    /// Purple.
    Purple,
    /// Brown.
    Brown,
    /// Grey.
    Grey,
}

impl JerseyColour {
    /// All colours with their names, in the order of their codes.
    pub const ALL: [(&'static str, JerseyColour); 10] = [
        ("blue", JerseyColour::Blue),
        ("red", JerseyColour::Red),
        ("yellow", JerseyColour::Yellow),
        ("black", JerseyColour::Black),
        ("white", JerseyColour::White),
        ("green", JerseyColour::Green),
        ("orange", JerseyColour::Orange),
        ("purple", JerseyColour::Purple),
        ("brown", JerseyColour::Brown),
        ("grey", JerseyColour::Grey),
    ];

    /// Returns the colour with this code. Unknown codes are grey.
    pub(super) fn of_code(code: u8) -> Self {
        Self::ALL.get(usize::from(code)).map_or(JerseyColour::Grey, |(_, colour)| *colour)
    }
}

/// The colours of a team's jerseys.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct TeamColours {
    /// Of field players.
    pub players: JerseyColour,
    /// Of the goalkeeper.
    pub goalkeeper: JerseyColour,
}

impl TeamColours {
    /// Blue against red, which are also the colours of the goalkeepers.
    pub const DEFAULT: PerTeam<TeamColours> = PerTeam {
        blue: TeamColours { players: JerseyColour::Blue, goalkeeper: JerseyColour::Blue },
        pink: TeamColours { players: JerseyColour::Red, goalkeeper: JerseyColour::Red },
    };
}
