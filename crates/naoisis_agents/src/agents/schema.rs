//! The messages between a match and a program as JSON Schema, made from the types that are sent and read.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::protocol::{Answer, HelloMessage, Message, PROTOCOL, Turn};

/// What a program says.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is of use")]
enum FromProgram {
    Hello(HelloMessage),
    Answer(Answer),
}

/// What a match says.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "only its schema is of use")]
enum FromMatch<'a> {
    Turn(Turn<'a>),
    Message(Message<'a>),
}

/// A schema (draft 2020-12) of each direction: `from_program`, and `from_match`. What the match reads is described as it reads
/// it, what it says as it says it: a field that is required there is always sent, but for what the `fields` of a hello leave out
/// of perceptions, and others may be added in later versions.
pub fn schema() -> Value {
    let read = SchemaSettings::draft2020_12().for_deserialize().into_generator();
    let said = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut from_program = read.into_root_schema_for::<FromProgram>();
    let mut from_match = said.into_root_schema_for::<FromMatch>();
    for (schema, name) in [(&mut from_program, "from_program"), (&mut from_match, "from_match")] {
        // Each is a document of its own: what it refers to is in it.
        schema.insert("$id".to_owned(), format!("naoisis:protocol-{PROTOCOL}:{name}").into());
    }
    json!({ "protocol": PROTOCOL, "from_program": from_program, "from_match": from_match })
}
