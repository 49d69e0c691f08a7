//! Encodes a block of the page: JSON and columns, compressed, as text that cannot be taken for markup.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use miniz_oxide::deflate::compress_to_vec_zlib;
use serde::Serialize;
use serde_json::Value;

use super::columns::Columns;

const LEVEL: u8 = 9;

/// The JSON of a block with the names of its columns.
#[derive(Serialize)]
struct Named<'a> {
    #[serde(flatten)]
    json: &'a Value,
    columns: Vec<(String, usize, u8)>,
}

/// Returns a block of the page with `json`, an object, and `columns`. It contains the length of the JSON (four bytes, little-endian), the
/// JSON, and the columns, compressed with a checksum (zlib) and in base64.
pub(super) fn block(json: &Value, columns: &Columns) -> String {
    let (names, bytes) = columns.packed();
    // Serialising an object of plain values cannot fail.
    let json = serde_json::to_vec(&Named { json, columns: names }).unwrap_or_default();
    let raw = [&(json.len() as u32).to_le_bytes(), json.as_slice(), &bytes].concat();
    let packed = STANDARD.encode(compress_to_vec_zlib(&raw, LEVEL));
    // The full stop tells a whole block from one that is cut off.
    format!("<script type=\"application/octet-stream\">{packed}.</script>\n")
}
