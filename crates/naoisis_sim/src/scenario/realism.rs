//! Realism: how closely a match follows a real robot, in one word for all parts or for each part.
//!
//! ```
//! # use naoisis::prelude::*;
//! # use naoisis::scenario::{Realism, RealismSettings};
//! let scenario = Scenario::from_json(
//!     r#"{ "model": "nao_v6", "realism": { "all": "ideal", "kicks": "realistic" }, "kicks": { "wind_up_s": 0.1 } }"#,
//! )?;
//! assert_eq!(scenario.realism, RealismSettings { kicks: Realism::Realistic, ..RealismSettings::all(Realism::Ideal) });
//! // What the file says itself counts more than the word.
//! assert_eq!(scenario.settings.kicks.wind_up_s, 0.1);
//! assert!(scenario.settings.kicks.speed_sd > 0.0 && scenario.settings.odometry.noise.translation_sd_m == 0.0);
//! # Ok::<(), naoisis::scenario::ScenarioError>(())
//! ```
//!
//! | word | what it stands for |
//! |---|---|
//! | `paper` | the paper's models, and nothing more: the default of every setting |
//! | `ideal` | the same without noise |
//! | `realistic` | the figures of the scenario's [model](super::RobotModel) of a real robot, each with its source; otherwise the paper's |
//!
//! A part is the scenario's setting of the same name. When a file is read, the word gives the values that the setting itself does not have.
//! Programs that build their scenarios use [`Scenario::with_realism`](super::Scenario::with_realism).

use bevy::prelude::*;
use core::fmt;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::StrDeserializer;
use serde::{Deserialize, Serialize, Serializer};
use std::borrow::Cow;

use super::robot_settings::robot_settings;
use naoisis_core::word_or_object;
use naoisis_sensing::sensing::fidelity::present;

/// How closely a part of the simulation follows a real robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Hash, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Realism {
    /// The paper's models, and nothing more.
    #[default]
    Paper,
    /// The paper's models without noise.
    Ideal,
    /// The figures of a real robot.
    Realistic,
}

impl Realism {
    /// The words in files.
    pub const NAMES: [&'static str; 3] = ["paper", "ideal", "realistic"];

    /// Returns the word in files.
    pub fn name(self) -> &'static str {
        match self {
            Realism::Paper => "paper",
            Realism::Ideal => "ideal",
            Realism::Realistic => "realistic",
        }
    }
}

impl fmt::Display for Realism {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

macro_rules! realisms {
    (
        { $(#[$ball_documentation:meta])* $ball:ident }
        exact $exact:tt
        real { $($(#[$real_documentation:meta])* $real:ident: $real_type:ty [$($error:literal),*],)* }
        messages { $(#[$messages_documentation:meta])* $messages:ident: $messages_type:ty [$($messages_error:literal),*], }
        program $program:tt
    ) => {
        parts! {
            $(#[$ball_documentation])* $ball,
            $($(#[$real_documentation])* $real,)*
            $(#[$messages_documentation])* $messages,
        }
    };
}

macro_rules! parts {
    ($($(#[$documentation:meta])* $part:ident,)*) => {
        /// The realism of each part. In files a word for all of them, or an object with words for some and `all` for the rest.
        #[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect)]
        #[reflect(Serialize, Deserialize)]
        pub struct RealismSettings {
            $($(#[$documentation])* pub $part: Realism,)*
        }

        impl RealismSettings {
            /// Creates a realism that is the same for all parts.
            pub const fn all(realism: Realism) -> Self {
                Self { $($part: realism,)* }
            }

            /// Returns the parts with their names, which are those of the scenario's settings.
            pub fn parts(&self) -> impl Iterator<Item = (&'static str, Realism)> {
                [$((stringify!($part), self.$part),)*].into_iter()
            }
        }

        #[derive(Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        struct RealismFields {
            /// The realism of all parts that are not given.
            #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
            all: Option<Realism>,
            $(
                $(#[$documentation])*
                #[serde(default, deserialize_with = "present", skip_serializing_if = "Option::is_none")]
                $part: Option<Realism>,
            )*
        }

        impl From<RealismFields> for RealismSettings {
            fn from(fields: RealismFields) -> Self {
                let all = fields.all.unwrap_or_default();
                Self { $($part: fields.$part.unwrap_or(all),)* }
            }
        }

        impl From<RealismSettings> for RealismFields {
            fn from(realisms: RealismSettings) -> Self {
                Self { all: None, $($part: Some(realisms.$part),)* }
            }
        }
    };
}

robot_settings! { realisms {
    /// How the ball rolls, its size and its bounce.
    ball
} }

impl RealismSettings {
    /// Returns the word for all parts, if they have the same realism.
    pub fn word(&self) -> Option<Realism> {
        (*self == Self::all(self.ball)).then_some(self.ball)
    }
}

/// Shows the word for all parts, or a word for each part that differs from the paper: `kicks realistic, vision ideal`.
impl fmt::Display for RealismSettings {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(word) = self.word() {
            return word.fmt(formatter);
        }
        let others = self.parts().filter(|(_, realism)| *realism != Realism::Paper);
        for (index, (part, realism)) in others.enumerate() {
            write!(formatter, "{}{part} {realism}", if index > 0 { ", " } else { "" })?;
        }
        Ok(())
    }
}

impl JsonSchema for RealismSettings {
    fn schema_name() -> Cow<'static, str> {
        "RealismSettings".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A word for all parts, or an object with words for some and `all` for the rest.",
            "anyOf": [generator.subschema_for::<Realism>(), generator.subschema_for::<RealismFields>()],
        })
    }
}

impl Serialize for RealismSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.word() {
            Some(word) => word.serialize(serializer),
            None => RealismFields::from(*self).serialize(serializer),
        }
    }
}

word_or_object!(
    RealismSettings,
    RealismFields,
    "`paper`, `ideal`, `realistic`, or an object with one of these for a part, and for `all`",
    |word, E| Realism::deserialize(StrDeserializer::<E>::new(word)).map(RealismSettings::all)
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_for_all_parts_and_an_object_for_some() {
        let read = |json: &str| serde_json::from_str::<RealismSettings>(json);
        assert_eq!(read(r#""realistic""#).unwrap(), RealismSettings::all(Realism::Realistic));
        let some = read(r#"{ "all": "ideal", "kicks": "realistic" }"#).unwrap();
        assert_eq!((some.kicks, some.vision), (Realism::Realistic, Realism::Ideal));
        for realisms in [some, RealismSettings::all(Realism::Ideal), RealismSettings::default()] {
            assert_eq!(read(&serde_json::to_string(&realisms).unwrap()).unwrap(), realisms);
        }
        assert!(read(r#""real""#).unwrap_err().to_string().contains("unknown variant `real`"));
        assert!(read(r#"{ "smell": "ideal" }"#).is_err());
    }

    #[test]
    fn what_is_not_the_papers_is_named() {
        assert_eq!(RealismSettings::all(Realism::Ideal).to_string(), "ideal");
        let some = RealismSettings { kicks: Realism::Realistic, vision: Realism::Ideal, ..default() };
        assert_eq!(some.to_string(), "kicks realistic, vision ideal");
    }
}
