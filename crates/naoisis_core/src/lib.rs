//! The match itself: pitch, ball, bodies, walking, kicks, falls, collisions, messages, the game and its referee, and how
//! behaviours are registered.
//!
//! Nothing here knows what robots see or believe, how a scenario is written, or what is recorded: those are the crates above.
#![cfg_attr(
    test,
    expect(
        clippy::disallowed_methods,
        reason = "tests may compute what they expect with the platform's own functions"
    )
)]

/// Gives an error type its text as its `Debug` form, as `main` and tests that return an error print that.
#[macro_export]
macro_rules! debug_as_displayed {
    ($error:ty) => {
        impl core::fmt::Debug for $error {
            fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                core::fmt::Display::fmt(self, formatter)
            }
        }
    };
}

/// Reads a type that is a word or an object in files. An untagged enum would lose the place of errors.
///
/// `$fields` is the form of the object, from which the type can be made. `$of_word` is the value of a word, or an error of the type `$error`.
/// `$expected` describes both forms.
#[macro_export]
macro_rules! word_or_object {
    ($type:ty, $fields:ty, $expected:literal, |$word:ident, $error:ident| $of_word:expr) => {
        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                struct WordOrObject;

                impl<'de> serde::de::Visitor<'de> for WordOrObject {
                    type Value = $type;

                    fn expecting(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                        formatter.write_str($expected)
                    }

                    fn visit_str<$error: serde::de::Error>(self, $word: &str) -> Result<$type, $error> {
                        $of_word
                    }

                    fn visit_map<A: serde::de::MapAccess<'de>>(self, map: A) -> Result<$type, A::Error> {
                        let map = serde::de::value::MapAccessDeserializer::new(map);
                        <$fields as serde::Deserialize>::deserialize(map).map(<$type>::from)
                    }
                }

                deserializer.deserialize_any(WordOrObject)
            }
        }
    };
}

pub mod ball;
pub mod behaviour;
pub mod camera_model;
pub mod collision;
pub mod communication;
pub mod cycle;
pub mod events;
pub mod game;
pub mod geometry;
pub mod kick_geometry;
pub mod knowledge;
pub mod named_values;
pub mod pitch;
pub mod random;
pub mod read_file;
pub mod referee;
pub mod replace_file;
pub mod robot;
pub mod short_name;
pub mod statistics;
pub mod team;
