//! What is written down of a match: its trace, what robots believe against what is true, and pictures of it; and how a trace
//! is read again.

pub mod album;
pub mod beliefs;
pub(crate) mod canvas;
mod colour_description;
mod cycle_record;
pub mod encoder;
mod error;
pub mod film;
pub mod frames;
pub mod history;
pub mod photographer;
pub mod picture;
mod png_file;
pub mod read;
pub mod sheet;
pub mod trace;
pub mod video;
mod video_file;
