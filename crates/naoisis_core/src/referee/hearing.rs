//! How robots hear the referee's whistle: they miss some, and take other sounds for a whistle.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cycle::CycleClock;
use crate::game::Game;
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};

/// The errors of a robot's recognition of whistles. By default there are none.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Hearing {
    /// Probability that the robot misses a whistle.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub miss_probability: f32,
    /// Number of other sounds, such as the whistles of a neighbouring field, that the robot takes for a whistle in an hour.
    #[schemars(range(min = 0.0, max = 3600.0), extend("unit" = "/h"))]
    pub false_per_hour: f32,
}

impl Hearing {
    /// Whether the robot hears every whistle and nothing else.
    pub fn is_perfect(&self) -> bool {
        *self == Self::default()
    }
}

/// The whistles that a robot has heard.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct HeardWhistles {
    /// The number of whistles that the referee has blown.
    blown: u32,
    /// The number that the robot believes it has heard.
    heard: u32,
}

impl HeardWhistles {
    /// The number of whistles that the robot believes it has heard.
    pub fn heard(&self) -> u32 {
        self.heard
    }

    /// Updates the number of heard whistles after `period_s` seconds, in which the referee's whistles became `blown`.
    fn hear(&mut self, hearing: &Hearing, blown: u32, period_s: f32, stream: &mut RandomStream) {
        let new = blown.saturating_sub(self.blown);
        let heard = (0..new).filter(|_| !stream.chance(hearing.miss_probability)).count() as u32;
        let is_mistaken = stream.chance(hearing.false_per_hour * period_s / 3600.0);
        self.heard = self.heard.saturating_add(heard).saturating_add(u32::from(is_mistaken));
        self.blown = blown;
    }

    /// Updates the number for a robot that hears every whistle.
    fn hear_all(&mut self, blown: u32) {
        *self = Self { heard: self.heard.saturating_add(blown.saturating_sub(self.blown)), blown };
    }
}

/// Lets the robots hear the whistles of the last cycle.
pub(super) fn hear_whistles(
    game: Res<Game>,
    clock: Res<CycleClock>,
    mut robots: Query<(&Hearing, &mut HeardWhistles, Option<&mut RandomStreams>)>,
) {
    for (hearing, mut whistles, streams) in &mut robots {
        match streams {
            Some(mut streams) if !hearing.is_perfect() => {
                whistles.hear(hearing, game.whistles, clock.period(), streams.own("hearing"));
            }
            _ => whistles.bypass_change_detection().hear_all(game.whistles),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whistles_are_missed_and_others_heard_at_their_rates() {
        let hearing = Hearing { miss_probability: 0.25, false_per_hour: 360.0 };
        let mut stream = RandomStream::for_match(5, "hearing");
        let mut whistles = HeardWhistles::default();
        for blown in 1..=10_000 {
            whistles.hear(&hearing, blown, 1.0, &mut stream);
        }
        // 7500 and 1000, with standard deviations of 43 and 30: four of the root of their squares' sum are 211.
        assert!((f64::from(whistles.heard) - 8500.0).abs() < 211.0, "{whistles:?}");
    }

    #[test]
    fn without_errors_nothing_is_drawn_and_every_whistle_counts() {
        let mut stream = RandomStream::for_match(5, "hearing");
        let before = stream.clone();
        let mut whistles = HeardWhistles::default();
        whistles.hear(&Hearing::default(), 3, 0.1, &mut stream);
        assert_eq!((whistles.heard(), stream), (3, before));
        whistles.hear_all(5);
        assert_eq!(whistles, HeardWhistles { blown: 5, heard: 5 });
    }
}
