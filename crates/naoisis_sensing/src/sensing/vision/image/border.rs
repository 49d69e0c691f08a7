//! Points along the edge of the carpet: the highest green of every few columns of an image.

use bevy::math::Vec2;

use super::Look;
use super::colour::ColourClass;
use crate::sensing::vision::{GroundPoint, RobotPercept};

/// The distance between searched columns, pixels.
const SPACING: usize = 20;
/// The number of rows below the edge that are examined.
const ROWS: usize = 10;
/// The least number of them that are green or white, as carpet and lines are.
const LEAST_CARPET: usize = 7;
/// The number of rows above the edge in which the colours of a goal show that a post or a net stands before the edge.
const ROWS_ABOVE: usize = 4;
/// Points within this distance of a robot's body may be at its feet instead, m.
const BESIDE_ROBOT_M: f32 = 0.15;

impl Look<'_> {
    /// Finds points along the edge of the carpet. Columns that are green up to the upper edge of the image have none, and neither have those
    /// in which a goal or a robot hides the edge.
    pub(super) fn find_border(&self, robots: &[(bool, RobotPercept)], found: &mut Vec<GroundPoint>) {
        let reach_m = self.model.robot_reach + BESIDE_ROBOT_M;
        for column in (SPACING / 2..self.width()).step_by(SPACING) {
            let Some(row) = self.highest_green(column).filter(|row| *row > 0) else { continue };
            if (row.saturating_sub(ROWS_ABOVE)..row).any(|row| self.is_of_goal(column, row)) {
                continue;
            }
            let pixel = Vec2::new(column as f32 + 0.5, row as f32);
            let Some(position_m) = self.place(pixel, 0.0) else { continue };
            if robots.iter().all(|(_, robot)| robot.position_m.distance(position_m) > reach_m) {
                found.push(GroundPoint { camera: self.camera, pixel, position_m });
            }
        }
    }

    /// Whether a pixel has a colour of goals.
    fn is_of_goal(&self, column: usize, row: usize) -> bool {
        matches!(self.class(column, row), ColourClass::White | ColourClass::Yellow | ColourClass::SkyBlue)
    }

    /// The highest row of a column with carpet below it.
    fn highest_green(&self, column: usize) -> Option<usize> {
        let is_green = |row: &usize| self.class(column, *row) == ColourClass::Green;
        let is_carpet = |row: &usize| matches!(self.class(column, *row), ColourClass::Green | ColourClass::White);
        let last = self.height().checked_sub(ROWS)?;
        (0..last).find(|row| is_green(row) && (*row..*row + ROWS).filter(is_carpet).count() >= LEAST_CARPET)
    }
}
