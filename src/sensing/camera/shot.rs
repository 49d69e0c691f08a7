//! A picture that is asked for.

use super::image::{Image, Layers};
use crate::appearance::robot::RobotDesign;
use crate::appearance::view::View;

/// A picture to be drawn.
#[derive(Debug)]
pub struct Shot {
    /// Where it is taken from, and what it does not show.
    pub view: View,
    /// How robots look.
    pub design: RobotDesign,
    /// What is wanted besides colours.
    pub layers: Layers,
    /// The picture; its memory is used again.
    pub image: Image,
}
