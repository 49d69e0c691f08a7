//! The paper's eight figures, drawn from the running system: with its robot, or with any other [model](RobotModel).
//!
//! What a robot does not have is in no figure of it: those that show it are left out ([`FigureError::Lacking`]).
//!
//! Each figure plays its own scenario with a fixed seed, looks at what happened, and draws it: nothing in them is made up.
//! They are drawn in software, so that they are the same, bit by bit, on every run, and need neither display nor graphics
//! card. Sizes in a figure are points; a point is as many pixels as [`draw`](Figure::draw) is told.

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

/// Why a figure is not drawn.
#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    /// Its scenario is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// Its scenario cannot be started.
    #[error(transparent)]
    Start(#[from] ScenarioFault),
    /// It cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// It shows what the robot does not have.
    #[error("figure {figure} shows {what}, and the robot has none")]
    Lacking {
        /// Its number in the paper.
        figure: u8,
        /// What the robot lacks.
        what: &'static str,
    },
    /// The robot is so large that it or what is beside it would be where something else is.
    #[error("figure {figure} has no room for a robot of this size: {problem}")]
    TooLarge {
        /// Its number in the paper.
        figure: u8,
        /// What stands in the way.
        problem: String,
    },
    /// What it should show did not happen.
    #[error("figure {figure} has nothing to show: {missing}")]
    Missing {
        /// Its number in the paper.
        figure: u8,
        /// What did not happen.
        missing: &'static str,
    },
}

/// One of the paper's figures.
#[derive(Clone, Copy, Debug)]
pub struct Figure {
    /// Its number in the paper.
    pub number: u8,
    /// What it shows, in a word.
    pub name: &'static str,
    draw: fn(&RobotModel, f32) -> Result<Image, FigureError>,
}

/// All figures, in the paper's order.
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
    /// The name of its file.
    pub fn file_name(&self) -> String {
        format!("figure_{}_{}.png", self.number, self.name)
    }

    /// Draws it with robots of a model, with so many pixels to a point.
    ///
    /// # Errors
    /// When its match cannot be played, or the robot lacks what it shows.
    pub fn draw(&self, model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
        (self.draw)(model, scale).map_err(|error| {
            let problem = match &error {
                FigureError::Scenario(error) => error.message().to_owned(),
                FigureError::Start(fault) => fault.message.clone(),
                _ => return error,
            };
            // What is wrong with the model itself is said as such.
            if model.scenario().is_ok() { FigureError::TooLarge { figure: self.number, problem } } else { error }
        })
    }
}
