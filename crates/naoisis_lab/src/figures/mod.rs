//! The eight figures of the paper, drawn from running matches: with the paper's robot, or with any other
//! [model](RobotModel).
//!
//! A figure that shows something that the robot does not have is left out ([`FigureError::Lacking`]).
//!
//! Each figure plays its own scenario with a fixed seed and draws what happened; no data are made up. Figures are drawn
//! in software, so they are the same in every run, and need neither display nor graphics card. Sizes in a figure are
//! points; the scale of [`draw`](Figure::draw) is the number of pixels per point.

use naoisis_record::record::encoder::RecordError;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::{RobotModel, ScenarioError, ScenarioFault};

mod axes;
mod beliefs;
mod cameras;
mod collision;
mod field;
mod figure_match;
mod game;
mod kicks;
pub mod model_sheet;
mod robots;
mod sonar;

/// Why a figure cannot be drawn.
#[derive(thiserror::Error)]
pub enum FigureError {
    /// The scenario of the figure is invalid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The scenario of the figure cannot be started.
    #[error(transparent)]
    Start(#[from] ScenarioFault),
    /// The figure cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The robot does not have something that the figure shows.
    #[error("figure {figure} shows {what}, and the robot has none")]
    Lacking {
        /// Number of the figure in the paper.
        figure: u8,
        /// What the robot lacks.
        what: &'static str,
    },
    /// The robot is so large that parts of the figure would overlap.
    #[error("figure {figure} has no room for a robot of this size: {problem}")]
    TooLarge {
        /// Number of the figure in the paper.
        figure: u8,
        /// What overlaps.
        problem: String,
    },
    /// The event that the figure shows did not happen.
    #[error("figure {figure} has nothing to show: {missing}")]
    Missing {
        /// Number of the figure in the paper.
        figure: u8,
        /// The event.
        missing: &'static str,
    },
}

naoisis_core::debug_as_displayed!(FigureError);

/// A figure of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Number in the paper.
    pub number: u8,
    /// Subject, in a word.
    pub name: &'static str,
    draw: fn(&RobotModel, f32) -> Result<Image, FigureError>,
}

/// All figures, in the order of the paper.
pub const FIGURES: [Figure; 8] = [
    Figure { number: 1, name: "field", draw: field::draw },
    Figure { number: 2, name: "robots", draw: robots::draw },
    Figure { number: 3, name: "cameras", draw: cameras::draw },
    Figure { number: 4, name: "sonar", draw: sonar::draw },
    Figure { number: 5, name: "kicks", draw: kicks::draw },
    Figure { number: 6, name: "collision", draw: collision::draw },
    Figure { number: 7, name: "belief", draw: beliefs::draw },
    Figure { number: 8, name: "match", draw: game::draw },
];

impl Figure {
    /// Returns the name of its file.
    pub fn file_name(&self) -> String {
        format!("figure_{}_{}.png", self.number, self.name)
    }

    /// Draws the figure with robots of `model`. `scale` is the number of pixels per point.
    ///
    /// # Errors
    /// If its match cannot be played, or the robot does not have what the figure shows.
    pub fn draw(&self, model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
        (self.draw)(model, scale).map_err(|error| {
            let problem = match &error {
                FigureError::Scenario(error) => error.message().to_owned(),
                FigureError::Start(fault) => fault.message.clone(),
                _ => return error,
            };
            // A fault of the model itself is reported as such.
            if model.scenario().is_ok() { FigureError::TooLarge { figure: self.number, problem } } else { error }
        })
    }
}
