//! What is written down of a match: its trace, what robots believe against what is true, and pictures of it; and how a trace
//! is read again.
//!
//! Everything begins with one [record of each cycle](cycle_record::CycleRecord), in the [words](vocabulary) of all doors. It
//! is [gathered](gather) once, and every [`Recorder`](recorder::Recorder) makes of it what it likes.

pub mod beliefs;
pub mod canvas;
mod colour_description;
pub mod encoder;
mod error;
pub mod film;
pub mod formats;
pub mod frames;
pub mod history;
pub mod kick_outcomes;
mod lean;
pub mod marks;
pub mod match_renderer;
pub mod match_summary;
pub mod mistake_recorder;
pub mod mistakes;
pub mod output_file;
pub mod overlay;
pub mod picture;
pub mod picture_recorder;
mod plugin;
pub mod png_file;
pub mod read;
pub mod recorder;
mod scaling;
pub mod sheet;
pub mod summary_page;
pub mod summary_picture;
pub mod summary_recorder;
pub mod trace;
pub mod video;
mod video_file;

pub use lean::{lean_double, lean_single};
pub use plugin::RecordPlugin;
