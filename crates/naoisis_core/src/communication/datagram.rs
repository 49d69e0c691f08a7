//! A team message in the format of the team's program.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bevy::prelude::*;
use core::fmt;
use schemars::JsonSchema;
use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Bytes in the format of the team's program: base64 in files and on the wire.
#[derive(Clone, PartialEq, Eq, Debug, Default, Reflect, JsonSchema)]
#[schemars(with = "String")]
pub struct Datagram(pub Vec<u8>);

impl Serialize for Datagram {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&STANDARD.encode(&self.0))
    }
}

impl<'de> Deserialize<'de> for Datagram {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Text;

        impl Visitor<'_> for Text {
            type Value = Datagram;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("bytes in base64, such as \"aGVsbG8=\"")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Datagram, E> {
                STANDARD.decode(text).map(Datagram).map_err(|_| E::invalid_value(Unexpected::Str(text), &self))
            }
        }

        deserializer.deserialize_str(Text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_base64_in_files() {
        let datagram = Datagram(vec![0, 255, b'a']);
        assert_eq!(serde_json::to_string(&datagram).unwrap(), "\"AP9h\"");
        assert_eq!(serde_json::from_str::<Datagram>("\"AP9h\"").unwrap(), datagram);
        let wrong = serde_json::from_str::<Datagram>("\"no!\"").unwrap_err().to_string();
        assert!(wrong.contains("expected bytes in base64"), "{wrong}");
    }
}
