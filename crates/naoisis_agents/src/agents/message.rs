//! Encoding and decoding of messages: lines of JSON, or MessagePack with a length prefix. Bytes that are not a valid message become a
//! [`Loss`] with an explanation.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::loss::Loss;
use super::protocol::Encoding;
use naoisis_core::events::AgentLoss;
use naoisis_sim::interface::command::read_value;

/// The deepest nesting of a message.
const DEEPEST: usize = 32;
/// The number of bytes of an invalid message that are shown in its error.
const SHOWN: usize = 100;
/// The longest explanation of an error, bytes. An unknown word in it may be as long as a message.
const LONGEST: usize = 400;

/// Appends a message to `outgoing`, with its end of line or its length prefix.
///
/// # Errors
/// If the message cannot be written in this encoding.
pub fn write_message(encoding: Encoding, message: &impl Serialize, outgoing: &mut Vec<u8>) -> Result<(), Loss> {
    let written = match encoding {
        Encoding::Json => {
            let written = serde_json::to_writer(&mut *outgoing, message).map_err(|error| error.to_string());
            outgoing.push(b'\n');
            written
        }
        Encoding::Msgpack => {
            let begin = outgoing.len() + 4;
            outgoing.extend([0; 4]);
            let mut serializer = rmp_serde::Serializer::new(&mut *outgoing).with_struct_map();
            let written = message.serialize(&mut serializer).map_err(|error| error.to_string());
            let length = u32::try_from(outgoing.len() - begin).unwrap_or(u32::MAX);
            outgoing[begin - 4..begin].copy_from_slice(&length.to_be_bytes());
            written
        }
    };
    written.map_err(|error| Loss::new(AgentLoss::Refused, format!("the message cannot be encoded: {error}")))
}

/// Reads a message from `bytes`, without the end of line or the length prefix.
///
/// # Errors
/// If the bytes are not a message of type `T`. The error states the fault and the beginning of the message.
pub fn read_message<T: DeserializeOwned>(encoding: Encoding, bytes: &[u8]) -> Result<T, Loss> {
    match encoding {
        Encoding::Json => read_json(bytes),
        Encoding::Msgpack => read_message_pack(bytes),
    }
}

fn read_json<T: DeserializeOwned>(line: &[u8]) -> Result<T, Loss> {
    // Read as a value first, as serde alone would accept a list in place of an object.
    match serde_json::from_slice::<Value>(line) {
        Ok(value) => read_value(&value).map_err(|error| malformed(&error.to_string(), line)),
        Err(error) => {
            let what =
                format!("this is not JSON ({error}); a program must print messages for people to standard error");
            Err(malformed(&what, line))
        }
    }
}

fn read_message_pack<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Loss> {
    fn read(bytes: &[u8]) -> Result<Value, rmp_serde::decode::Error> {
        let mut deserializer = rmp_serde::Deserializer::from_read_ref(bytes);
        deserializer.set_max_depth(DEEPEST);
        Value::deserialize(&mut deserializer)
    }
    match read(bytes) {
        Ok(value) => read_value(&value).map_err(|error| malformed(&error.to_string(), value.to_string().as_bytes())),
        Err(error) => Err(malformed(&format!("this is not MessagePack ({error})"), bytes)),
    }
}

/// The loss of a program that sent the message `sent`; `what` is the fault in it.
pub fn malformed(what: &str, sent: &[u8]) -> Loss {
    Loss::new(
        AgentLoss::Malformed,
        format!("it sent `{}`: {}", beginning(sent, SHOWN), beginning(what.as_bytes(), LONGEST)),
    )
}

/// The first `longest` bytes of a text, on one line.
fn beginning(text: &[u8], longest: usize) -> String {
    let mut beginning = String::from_utf8_lossy(&text[..text.len().min(longest)]).into_owned();
    beginning.retain(|letter| !letter.is_control());
    if text.len() > longest {
        beginning.push_str(" ...");
    }
    beginning
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::super::connection::{Connection, Stream};
    use super::super::protocol::Answer;
    use super::*;
    use naoisis_core::random::RandomStream;
    use std::io::Write;
    use std::os::unix::net::UnixStream;

    /// Changes some bytes of a message, duplicates some, or cuts it.
    fn damage(bytes: &mut Vec<u8>, random: &mut RandomStream) {
        let mut any = |most: usize| ((random.uniform() * most as f32) as usize).min(most - 1);
        for _ in 0..=any(4) {
            if bytes.is_empty() {
                return;
            }
            let at = any(bytes.len());
            match any(4) {
                0 => bytes[at] = any(256) as u8,
                1 => bytes.insert(at, b"{}[]\",:-e\n\x00\xff\xdd\xc6"[any(14)]),
                2 => bytes.truncate(at),
                _ => bytes.extend_from_within(at..),
            }
            bytes.truncate(2000);
        }
    }

    #[test]
    fn a_hundred_thousand_hostile_messages_are_each_an_answer_or_a_loss() {
        let json = br#"{"cycle":5,"command":{"walk":[0.006,0,3.0],"head_deg":[20,10],"kick":{"type":"left_side","speed":1},"posture":{"dive":"left"},"say":{"pose":[1,2,30],"ball_m":[1,0],"robots_m":[[1,2]],"intention":"pass","payload":"x"}}}"#;
        let value: Value = serde_json::from_slice(json).unwrap();
        let message_pack = rmp_serde::to_vec_named(&value).unwrap();
        let mut random = RandomStream::for_match(1, "hostile messages");
        let mut answers = 0;
        for round in 0..50_000 {
            for (encoding, message) in [(Encoding::Json, &json[..]), (Encoding::Msgpack, &message_pack)] {
                let mut bytes = message.to_vec();
                damage(&mut bytes, &mut random);
                // A whole message, so that its content is checked.
                match read_message::<Answer>(encoding, &bytes) {
                    Ok(answer) => answers += u32::from(answer.command.checked().is_ok()),
                    Err(loss) => assert!(loss.reason == AgentLoss::Malformed && loss.message.len() < 2500, "{loss}"),
                }
                // The bytes as they come out of the socket.
                if round % 50 == 0 {
                    let mut framed = bytes;
                    match encoding {
                        Encoding::Json => framed.push(b'\n'),
                        Encoding::Msgpack => drop(framed.splice(..0, (message.len() as u32).to_be_bytes())),
                    }
                    damage(&mut framed, &mut random);
                    let (here, mut program) = UnixStream::pair().unwrap();
                    let mut connection = Connection::new(Stream::Unix(here), 1000, None);
                    connection.set_encoding(encoding);
                    program.write_all(&framed).unwrap();
                    drop(program);
                    // The connection ends, however many messages the bytes contain.
                    while connection.receive::<Answer>(None).is_ok() {}
                }
            }
        }
        assert!((1000..99_000).contains(&answers), "{answers}");
    }
}
