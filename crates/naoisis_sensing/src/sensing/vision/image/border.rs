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
/// Points within this distance of a robot's body may be at its feet instead, m.
const BESIDE_ROBOT_M: f32 = 0.15;

impl Look<'_> {
    /// Finds points along the edge of the carpet. Columns that are green up to the upper edge of the image have none.
    pub(super) fn find_border(&self, robots: &[(bool, RobotPercept)], found: &mut Vec<GroundPoint>) {
        let reach_m = self.model.robot_reach + BESIDE_ROBOT_M;
        for column in (SPACING / 2..self.width()).step_by(SPACING) {
            let Some(row) = self.highest_green(column).filter(|row| *row > 0) else { continue };
            let pixel = Vec2::new(column as f32 + 0.5, row as f32);
            let Some(position_m) = self.place(pixel, 0.0) else { continue };
            if robots.iter().all(|(_, robot)| robot.position_m.distance(position_m) > reach_m) {
                found.push(GroundPoint { camera: self.camera, pixel, position_m });
            }
        }
    }

    /// The highest row of a column with carpet below it.
    fn highest_green(&self, column: usize) -> Option<usize> {
        let is_green = |row: &usize| self.class(column, *row) == ColourClass::Green;
        let is_carpet = |row: &usize| matches!(self.class(column, *row), ColourClass::Green | ColourClass::White);
        let last = self.height().checked_sub(ROWS)?;
        (0..last).find(|row| is_green(row) && (*row..*row + ROWS).filter(is_carpet).count() >= LEAST_CARPET)
    }
}
