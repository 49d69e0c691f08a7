//! A saved match, packed, as scenarios that go on from one have it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::message_pack::MessagePackError;

/// The ending of the file names of saved matches.
pub const EXTENSION: &str = "naoisis";
/// The format's name in files.
pub const FORMAT: &str = "naoisis-snapshot";
/// The format's version in files.
pub const VERSION: u32 = 8;
/// A larger file is no match: with the images of 22 robots, and their depths, it has half of that.
pub const LARGEST_FILE_BYTES: u64 = 256 << 20;
/// How hard the match is packed: more would be felt when a test is read, and save little.
const PACKING: i32 = 9;

/// Why bytes are no saved match.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SavedMatchError {
    /// They are not MessagePack.
    #[error(transparent)]
    Structure(#[from] MessagePackError),
    /// They are MessagePack of something else, or of types that are not registered here.
    #[error("{0}")]
    Content(String),
    /// There are more bytes than the match has.
    #[error("there is something behind its end")]
    Trailing,
    /// They were damaged after they had been packed.
    #[error("it is damaged")]
    Damaged,
    /// They cannot be packed.
    #[error("{0}")]
    Packing(String),
}

/// A saved match, packed.
#[derive(Clone, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SavedMatch {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// The file's bytes, packed by zstd, in base64.
    #[serde(rename = "match")]
    packed: String,
}

impl SavedMatch {
    /// Packs the bytes of a file.
    ///
    /// # Errors
    /// Why they cannot be packed.
    pub(super) fn pack(cycle: u64, bytes: &[u8]) -> Result<SavedMatch, SavedMatchError> {
        let packed =
            zstd::bulk::compress(bytes, PACKING).map_err(|error| SavedMatchError::Packing(error.to_string()))?;
        Ok(SavedMatch { cycle, packed: STANDARD.encode(packed) })
    }

    /// The bytes of the file that it was.
    ///
    /// # Errors
    /// When it was damaged since.
    pub fn bytes(&self) -> Result<Vec<u8>, SavedMatchError> {
        let packed = STANDARD.decode(&self.packed).map_err(|_| SavedMatchError::Damaged)?;
        let size = zstd::bulk::Decompressor::upper_bound(&packed).unwrap_or(LARGEST_FILE_BYTES as usize);
        zstd::bulk::decompress(&packed, size.min(LARGEST_FILE_BYTES as usize)).map_err(|_| SavedMatchError::Damaged)
    }
}
