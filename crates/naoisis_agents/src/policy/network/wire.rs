//! A check of a file's Protocol Buffers structure, made before the file is decoded.
//!
//! The decoder trusts lengths at the top level and follows graphs within graphs to any depth. After this check every
//! length lies within its message and the nesting is bounded, so hostile bytes give an error. It also finds the parts
//! of a model that the decoder skips although they matter, such as sparse tensors.

/// The deepest nesting of graphs in attributes; deeper ones belong to no operator that is supported anyway.
const DEEPEST: usize = 4;

/// A kind of message in an ONNX file, as far as its fields are looked into.
#[derive(Clone, Copy)]
enum Message {
    Model,
    Graph,
    Node,
    Attribute,
    Tensor,
    Value,
    Type,
    TensorType,
    Shape,
    Leaf,
}

/// Checks that `bytes` are a model whose parts nest properly and are all supported.
pub(super) fn check(bytes: &[u8]) -> Result<(), String> {
    check_message(bytes, Message::Model, 0)
}

fn check_message(mut bytes: &[u8], message: Message, depth: usize) -> Result<(), String> {
    if depth > DEEPEST {
        return Err("graphs nest too deeply".into());
    }
    while !bytes.is_empty() {
        let key = varint(&mut bytes)?;
        match key & 7 {
            0 => drop(varint(&mut bytes)?),
            1 => drop(take(&mut bytes, 8)?),
            5 => drop(take(&mut bytes, 4)?),
            2 => {
                let length = varint(&mut bytes)?;
                let content = take(&mut bytes, length)?;
                let deeper = usize::from(matches!((message, key >> 3), (Message::Attribute, 6)));
                if let Some(inner) = field(message, key >> 3)? {
                    check_message(content, inner, depth + deeper)?;
                }
            }
            kind => return Err(format!("unknown wire type {kind}")),
        }
    }
    Ok(())
}

/// The kind of message in the field `number` of a `message`, if it holds a message that the decoder reads.
fn field(message: Message, number: u64) -> Result<Option<Message>, String> {
    Ok(Some(match (message, number) {
        (Message::Model, 7) => Message::Graph,
        (Message::Model, 8 | 14) | (Message::Tensor, 13) | (Message::Shape, 1) => Message::Leaf,
        (Message::Graph, 1) => Message::Node,
        (Message::Graph, 5) | (Message::Attribute, 5) => Message::Tensor,
        (Message::Graph, 11..=13) => Message::Value,
        (Message::Graph, 15) | (Message::Attribute, 22 | 23) => return Err("sparse tensors are not supported".into()),
        (Message::Node, 5) => Message::Attribute,
        (Message::Attribute, 6) => Message::Graph,
        (Message::Value, 2) => Message::Type,
        (Message::Type, 1) => Message::TensorType,
        (Message::Type, 4 | 5 | 8 | 9) => return Err("only dense tensors are supported as values".into()),
        (Message::TensorType, 2) => Message::Shape,
        _ => return Ok(None),
    }))
}

/// The next number of variable length, taken from the front of `bytes`.
fn varint(bytes: &mut &[u8]) -> Result<u64, String> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, rest) = bytes.split_first().ok_or("it ends within a number")?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("a number is too long".into())
}

/// The next `length` bytes, taken from the front of `bytes`.
fn take<'a>(bytes: &mut &'a [u8], length: u64) -> Result<&'a [u8], String> {
    let split = usize::try_from(length).ok().and_then(|length| bytes.split_at_checked(length));
    let (content, rest) = split.ok_or("it ends within a field")?;
    *bytes = rest;
    Ok(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field `number` that holds `content`.
    fn wrap(number: u8, content: &[u8]) -> Vec<u8> {
        let mut bytes = vec![number << 3 | 2];
        let mut length = content.len();
        while length >= 0x80 {
            bytes.push((length & 0x7f) as u8 | 0x80);
            length >>= 7;
        }
        bytes.push(length as u8);
        bytes.extend(content);
        bytes
    }

    #[test]
    fn lengths_past_the_end_are_refused() {
        assert!(check(&[]).is_ok());
        assert!(
            check(&[0x12, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f]).unwrap_err().contains("ends within")
        );
        assert!(check(&[0x12]).is_err());
        assert!(check(&[0xff; 12]).is_err());
        assert!(check(&[0x0b]).unwrap_err().contains("wire type"));
    }

    #[test]
    fn deep_nesting_is_refused() {
        let mut graph = Vec::new();
        for _ in 0..100 {
            graph = wrap(1, &wrap(5, &wrap(6, &graph)));
        }
        assert!(check(&wrap(7, &graph)).unwrap_err().contains("deeply"));
    }

    #[test]
    fn sparse_tensors_are_refused() {
        assert!(check(&wrap(7, &wrap(15, &[]))).unwrap_err().contains("sparse"));
    }
}
