//! JSON Schema of the messages between a match and a program, derived from their types.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::protocol::{Answer, HelloMessage, Message, PROTOCOL, Perceive};

/// A message from a program.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, clippy::large_enum_variant, reason = "only its schema is of use")]
enum FromProgram {
    Hello(HelloMessage),
    Answer(Answer),
}

/// A message from a match.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is of use")]
enum FromMatch<'a> {
    Perceive(Perceive<'a>),
    Message(Message<'a>),
}

/// The schemas (draft 2020-12) of both directions: `from_program` and `from_match`. The former describes the messages that the match
/// accepts, the latter those that it sends. A required field of `from_match` is always sent, except for parts of perceptions that the
/// `fields` of a hello leave out. Later versions may add fields.
pub fn schema() -> Value {
    let read = SchemaSettings::draft2020_12().for_deserialize().into_generator();
    let said = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut from_program = read.into_root_schema_for::<FromProgram>();
    let mut from_match = said.into_root_schema_for::<FromMatch>();
    for (schema, name) in [(&mut from_program, "from_program"), (&mut from_match, "from_match")] {
        // Each schema is a separate document that contains everything it refers to.
        schema.insert("$id".to_owned(), format!("naoisis:protocol-{PROTOCOL}:{name}").into());
    }
    json!({ "protocol": PROTOCOL, "from_program": from_program, "from_match": from_match })
}
