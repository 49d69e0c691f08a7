//! Names as short words that are `Copy`: of cameras, kicks and custom rules.

/// Defines a type for names, which are words of lower-case letters, digits and `_`, and its parse error. In files, messages and schemas a
/// name is a string.
///
/// The arguments are the type, its error, the most bytes of a name, what it is a name of, and the description and pattern for
/// schemas: `short_name! { /// … CameraName, NotACameraName, 15, "a camera", "The name of a camera.", "^[a-z0-9_]{1,15}$" }`.
macro_rules! short_name {
    ($(#[$documentation:meta])* $name:ident, $error:ident, $longest:literal, $of:literal, $schema:literal, $pattern:literal) => {
        $(#[$documentation])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, bevy::prelude::Reflect)]
        #[reflect(opaque)]
        #[reflect(Clone, PartialEq, Debug, Hash, Serialize, Deserialize)]
        pub struct $name {
            /// The word, padded with zeros.
            letters: [u8; $longest],
        }

        impl $name {
            /// The name as a word.
            pub fn as_str(&self) -> &str {
                let length = self.letters.iter().position(|letter| *letter == 0).unwrap_or($longest);
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

        #[doc = concat!("Error of parsing a [`", stringify!($name), "`]: the word cannot be the name of ", $of, ".")]
        #[derive(Clone, PartialEq, Eq, thiserror::Error)]
        #[error(
            "{0:?} is no name of {of}: expected a word of 1 to {longest} small letters, digits and `_`",
            of = $of,
            longest = $longest
        )]
        pub struct $error(pub String);

        debug_as_displayed!($error);

        impl core::str::FromStr for $name {
            type Err = $error;

            fn from_str(word: &str) -> Result<Self, $error> {
                $crate::short_name::letters(word).map(|letters| Self { letters }).ok_or_else(|| $error(word.to_owned()))
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
                schemars::json_schema!({ "type": "string", "description": $schema, "pattern": $pattern })
            }
        }
    };
}

pub(crate) use short_name;

/// The bytes of a short name, padded with zeros; `None` if `word` is empty, too long, or contains any other character.
pub(crate) fn letters<const LONGEST: usize>(word: &str) -> Option<[u8; LONGEST]> {
    let is_letter = |letter: u8| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == b'_';
    if word.is_empty() || !word.bytes().all(is_letter) {
        return None;
    }
    let mut letters = [0; LONGEST];
    letters.get_mut(..word.len())?.copy_from_slice(word.as_bytes());
    Some(letters)
}
