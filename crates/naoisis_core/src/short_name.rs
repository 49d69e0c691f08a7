//! Names as short words that are copied as numbers are: of cameras, of kicks.

/// The most letters of a short name.
pub const LONGEST_NAME: usize = 15;

/// Makes a type of names: short words of small letters, digits and `_`, which files, messages and schemas have as strings.
///
/// Its documentation, its name, its error's, of what it is the name, and what a schema says of it:
/// `short_name! { /// … CameraName, NotACameraName, "a camera", "The name of a camera of the robot's model." }`.
macro_rules! short_name {
    ($(#[$documentation:meta])* $name:ident, $error:ident, $of:literal, $schema:literal) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, bevy::prelude::Reflect)]
        #[reflect(opaque)]
        #[reflect(Clone, PartialEq, Debug, Hash, Serialize, Deserialize)]
        pub struct $name {
            /// Filled up with noughts.
            letters: [u8; $crate::short_name::LONGEST_NAME],
        }

        impl $name {
            /// The most letters of a name.
            pub const LONGEST: usize = $crate::short_name::LONGEST_NAME;

            /// The name as a word.
            pub fn as_str(&self) -> &str {
                let length = self.letters.iter().position(|letter| *letter == 0).unwrap_or(Self::LONGEST);
                core::str::from_utf8(&self.letters[..length]).unwrap_or_default()
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                formatter.pad(self.as_str())
            }
        }

        impl core::fmt::Debug for $name {
            fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                write!(formatter, concat!(stringify!($name), "({})"), self.as_str())
            }
        }

        #[doc = concat!("A word that can be no name of ", $of, ".")]
        #[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
        #[error(
            "{0:?} is no name of {of}: expected a word of 1 to {longest} small letters, digits and `_`",
            of = $of,
            longest = $crate::short_name::LONGEST_NAME
        )]
        pub struct $error(pub String);

        impl core::str::FromStr for $name {
            type Err = $error;

            fn from_str(word: &str) -> Result<Self, $error> {
                let letters = $crate::short_name::letters(word).ok_or_else(|| $error(word.to_owned()))?;
                Ok(Self { letters })
            }
        }

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.serialize_str(self.as_str())
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
            }
        }

        impl schemars::JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
                schemars::json_schema!({ "type": "string", "description": $schema, "pattern": "^[a-z0-9_]{1,15}$" })
            }
        }
    };
}

pub(crate) use short_name;

/// The letters of a short name, filled up with noughts; none of a word that is too long, empty or has other letters.
pub fn letters(word: &str) -> Option<[u8; LONGEST_NAME]> {
    let is_letter = |letter: u8| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == b'_';
    if word.is_empty() || !word.bytes().all(is_letter) {
        return None;
    }
    let mut letters = [0; LONGEST_NAME];
    letters.get_mut(..word.len())?.copy_from_slice(word.as_bytes());
    Some(letters)
}
