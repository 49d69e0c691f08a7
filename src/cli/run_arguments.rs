//! The arguments of `naoisis run`.

use clap::{Args, ValueEnum};
use std::path::PathBuf;

use super::pictures::PictureArguments;
use crate::scenario::Setting;
use crate::sensing::camera::CameraRendering;

/// What `--cameras` may say.
#[derive(ValueEnum, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Cameras {
    /// No images
    Off,
    /// On the processor
    Software,
    /// On a graphics card
    Gpu,
}

impl From<Cameras> for CameraRendering {
    fn from(cameras: Cameras) -> Self {
        match cameras {
            Cameras::Off => CameraRendering::Off,
            Cameras::Software => CameraRendering::Software,
            Cameras::Gpu => CameraRendering::Gpu,
        }
    }
}

/// Arguments of `naoisis run`.
#[derive(Args, Debug, Clone, Default)]
pub struct RunArguments {
    /// A scenario file (.ron or .json), the name of a built-in scenario (see `naoisis list scenarios`), or a saved match
    /// to go on with (.naoisis)
    pub scenario: String,
    /// Seed of all random numbers, instead of the scenario's
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Set a field of the scenario: messages.loss=0.2
    #[arg(long, value_name = "PATH=VALUE")]
    pub set: Vec<Setting>,
    /// Stop after this many simulated seconds
    #[arg(long, value_name = "S", value_parser = positive_seconds, allow_negative_numbers = true)]
    pub duration: Option<f32>,
    /// Whether, and by what, the robots' camera images are rendered, instead of the scenario's word
    #[arg(long, value_enum, value_name = "off|software|gpu")]
    pub cameras: Option<Cameras>,
    /// Write a trace: a .jsonl file, .jsonl.zst for a compressed one, - for standard output
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write what the robots believe against what is true: a .csv file, and a summary at the end
    #[arg(long, value_name = "FILE")]
    pub beliefs: Option<PathBuf>,
    #[command(flatten)]
    pub pictures: PictureArguments,
    /// Save the match (.naoisis), to go on with it later
    #[arg(long, value_name = "FILE")]
    pub save: Option<PathBuf>,
    /// Save it at this time, rather than at the end
    #[arg(long, value_name = "S", value_parser = positive_seconds, allow_negative_numbers = true, requires = "save")]
    pub save_at: Option<f32>,
    /// Print the match report: every decision of the referee, and why
    #[arg(long)]
    pub explain: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub quiet: bool,
}

pub(super) fn positive_seconds(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(seconds) if seconds.is_finite() && seconds > 0.0 => Ok(seconds),
        _ => Err("expected a positive number of seconds".to_owned()),
    }
}
