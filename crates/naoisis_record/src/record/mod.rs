//! Records matches and reads traces: traces, [counts](match_counts), summaries, mistakes, errors of beliefs, [pages](page), [MCAP
//! files](mcap), pictures and films.
//!
//! All outputs are made from a single [record of each cycle](naoisis_sim::interface::cycle_record::CycleRecord), which is
//! [gathered](naoisis_sim::interface::gather) once and passed to every [`Recorder`](recorder::Recorder).

pub mod axis;
pub mod beliefs;
pub mod canvas;
mod colour_description;
pub mod convert;
pub mod encoder;
mod error;
mod event_words;
pub mod film;
pub mod formats;
pub mod frames;
pub mod game_controller_log;
pub mod history;
#[cfg(feature = "live")]
pub mod live;
pub mod live_control;
pub mod marks;
pub mod match_counts;
pub mod match_marks;
pub mod match_renderer;
pub mod match_summary;
pub mod mcap;
pub mod mcap_records;
mod mcap_trace;
pub mod minari;
pub mod mistake_recorder;
pub mod mistakes;
pub mod output_file;
pub mod overlay;
pub mod page;
pub mod picture;
pub mod picture_recorder;
mod plugin;
pub mod png_file;
pub mod read;
pub mod read_trace;
pub mod recorder;
pub mod sheet;
pub mod summary_page;
pub mod summary_picture;
pub mod summary_recorder;
pub mod summary_rows;
pub mod tables;
pub mod team_names;
pub mod trace;
mod trace_lines;
pub mod video;
mod video_file;

pub use plugin::RecordPlugin;
