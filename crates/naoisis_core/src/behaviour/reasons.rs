//! Reasons of decisions: the options of a behaviour, their values, and the choice.
//!
//! A behaviour writes the [`Reasons`] of its robots. Robots have this component only on request, for example for a trace with the field
//! `robots.reasons`; a behaviour queries `Option<&mut Reasons>`. The built-in teams give reasons:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::behaviour::reasons::{Reasons, ask_for_reasons};
//! use naoisis::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, NaoisisPlugins));
//! app.start_match(&Scenario::named("match3v3")?)?;
//! let robot = RobotId::new(Team::Blue, 2);
//! ask_for_reasons(app.world_mut());
//! app.run_cycles(150);
//! let reasons = app.robot::<Reasons>(robot).unwrap();
//! println!("{robot}: {:?} of {:?}", reasons.choice(), reasons.options);
//! # assert!(reasons.choice().is_some());
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::knowledge::Knowledge;
use crate::team::RobotId;

/// The options of a behaviour in the last cycle in which it decided, and its choice.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Reasons {
    /// The options.
    #[serde(default)]
    pub options: Vec<Choice>,
    /// The index of the chosen option.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen: Option<usize>,
}

/// An option of a robot.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct Choice {
    /// Name in a word or two.
    pub name: Cow<'static, str>,
    /// Value in a unit of the behaviour's own; more is better.
    #[serde(default)]
    pub value: f32,
    /// Explanation for people.
    #[serde(default)]
    pub why: Cow<'static, str>,
}

impl Choice {
    /// An option with this name, value and explanation.
    pub fn new(name: impl Into<Cow<'static, str>>, value: f32, why: impl Into<Cow<'static, str>>) -> Self {
        Self { name: name.into(), value, why: why.into() }
    }
}

impl Reasons {
    /// These options with the choice `chosen`; of several options with that name, the best is chosen.
    pub fn of(options: Vec<Choice>, chosen: &str) -> Self {
        let named = options.iter().enumerate().filter(|(_, option)| option.name == chosen);
        let chosen =
            named.max_by(|(_, first), (_, second)| first.value.total_cmp(&second.value)).map(|(place, _)| place);
        Self { options, chosen }
    }

    /// The chosen option, if any.
    pub fn choice(&self) -> Option<&Choice> {
        self.options.get(self.chosen?)
    }
}

/// Adds [`Reasons`] to all robots of the match, so that behaviours write them from the next cycle on.
pub fn ask_for_reasons(world: &mut World) {
    let mut silent = world.query_filtered::<Entity, (With<RobotId>, Without<Reasons>)>();
    let robots: Vec<Entity> = silent.iter(world).collect();
    for robot in robots {
        world.entity_mut(robot).insert(Reasons::default());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_options_of_a_name_the_best_was_chosen() {
        let options = ["pass", "shoot", "pass"].into_iter().zip([0.1, 0.4, 0.2]);
        let options: Vec<Choice> = options.map(|(name, value)| Choice::new(name, value, "")).collect();
        assert_eq!(Reasons::of(options.clone(), "pass").choice().map(|choice| choice.value), Some(0.2));
        assert_eq!(Reasons::of(options, "dribble").choice(), None);
    }
}
