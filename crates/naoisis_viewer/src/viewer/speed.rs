//! The speeds of playback.

use core::fmt;

/// A speed of playback.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Speed {
    /// This many simulated seconds per second.
    Times(f64),
    /// As fast as possible.
    Unlimited,
}

impl Speed {
    /// All speeds that can be chosen, in order.
    pub const ALL: [Speed; 9] = [
        Speed::Times(0.1),
        Speed::Times(0.25),
        Speed::Times(0.5),
        Speed::Times(1.0),
        Speed::Times(2.0),
        Speed::Times(4.0),
        Speed::Times(8.0),
        Speed::Times(16.0),
        Speed::Unlimited,
    ];

    /// Returns the next of [`Speed::ALL`] in a direction; the same at the ends.
    pub fn neighbour(self, steps: isize) -> Speed {
        let index = Speed::ALL.iter().position(|speed| *speed == self).unwrap_or(3);
        index.checked_add_signed(steps).and_then(|index| Speed::ALL.get(index)).copied().unwrap_or(self)
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Speed::Times(factor) => write!(formatter, "{factor}×"),
            Speed::Unlimited => formatter.write_str("max"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_fastest_and_the_slowest_there_is_nothing() {
        assert_eq!(Speed::Times(16.0).neighbour(1), Speed::Unlimited);
        assert_eq!(Speed::Unlimited.neighbour(1), Speed::Unlimited);
        assert_eq!(Speed::Times(0.1).neighbour(-1), Speed::Times(0.1));
    }
}
