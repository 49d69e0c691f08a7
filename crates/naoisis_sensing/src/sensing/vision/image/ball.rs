//! Detection of an orange ball: a blob that fits the circle of a ball at its position.

use bevy::math::Vec2;

use super::Look;
use super::blobs::{Blob, Run};
use super::colour::ColourClass;
use crate::sensing::vision::BallPercept;

/// The least number of pixels of a ball.
const LEAST_AREA: u32 = 6;

/// The least share of the outline on the circle.
const LEAST_ON_CIRCLE: f32 = 0.5;

/// The least share of orange in the part of the circle in the image.
const LEAST_FILLED: f32 = 0.18;

impl Look<'_> {
    /// The largest orange blob that may be a ball, with its number of pixels.
    pub(super) fn find_ball(&self, contour: &mut Vec<Vec2>) -> Option<(u32, BallPercept)> {
        let mut best: Option<(u32, BallPercept)> = None;
        for blob in &self.segmentation.blobs {
            let is_larger = best.is_none_or(|(area, _)| blob.area > area);
            if blob.class == ColourClass::Orange && blob.area >= LEAST_AREA && is_larger {
                best = self.ball(blob, contour).map(|ball| (blob.area, ball)).or(best);
            }
        }
        best
    }

    fn ball(&self, blob: &Blob, contour: &mut Vec<Vec2>) -> Option<BallPercept> {
        trace(self.segmentation.runs(blob), [self.width(), self.height()], contour);
        let middle = Vec2::new(f32::from(blob.left + blob.right), f32::from(blob.top + blob.bottom)) / 2.0;
        let (centre, radius) = self.fit(middle, contour)?;
        // The outline is a circle, except where the ball is hidden.
        let tolerance = (0.12 * radius).max(1.0);
        let on_circle = contour.iter().filter(|point| (point.distance(centre) - radius).abs() <= tolerance).count();
        if (on_circle as f32) < LEAST_ON_CIRCLE * contour.len() as f32 {
            return None;
        }
        // The blob has about the size of a ball at that position.
        let widest = f32::from(blob.width().max(blob.height()));
        let visible = self.area_in_image(centre, radius);
        let filled = blob.area as f32 / visible.max(1.0);
        if widest > 2.3 * radius + 2.0 || !(LEAST_FILLED..1.5 + 4.0 / radius).contains(&filled) {
            return None;
        }
        let position_m = self.place(centre, self.model.ball_radius)?;
        Some(BallPercept::new(self.camera, self.view.clamp_to_image(centre), position_m))
    }

    /// The radius in pixels of a ball whose centre is at the pixel `centre`.
    pub(super) fn radius_at(&self, centre: Vec2) -> Option<f32> {
        let radius = self.model.ball_radius;
        let place = self.place(centre, radius)?;
        Some(self.view.intrinsics.focal.x * radius / self.depth(place, radius).max(radius))
    }

    /// Fits the circle of a ball to an outline by the Gauss-Newton method, with the radius that follows from the centre. Later steps ignore
    /// points far from the circle, where the ball is hidden.
    pub(super) fn fit(&self, start: Vec2, contour: &[Vec2]) -> Option<(Vec2, f32)> {
        let mut centre = start;
        let mut radius = self.radius_at(centre)?;
        for step in 0..10 {
            // Normal equations of the residuals |p - c| - r.
            let (mut xx, mut xy, mut yy) = (1e-3, 0.0, 1e-3);
            let mut right = Vec2::ZERO;
            for &point in contour {
                let offset = point - centre;
                let distance = offset.length().max(1e-3);
                let residual = distance - radius;
                if step >= 4 && residual.abs() > (0.25 * radius).max(1.5) {
                    continue;
                }
                let direction = offset / distance;
                xx += direction.x * direction.x;
                xy += direction.x * direction.y;
                yy += direction.y * direction.y;
                right += residual * direction;
            }
            let determinant = xx * yy - xy * xy;
            if determinant < 1e-6 {
                return None;
            }
            let change = Vec2::new(yy * right.x - xy * right.y, xx * right.y - xy * right.x) / determinant;
            centre += change.clamp_length_max(radius);
            radius = self.radius_at(centre)?;
        }
        centre.is_finite().then_some((centre, radius))
    }

    /// The area of a circle in the image, pixels².
    fn area_in_image(&self, centre: Vec2, radius: f32) -> f32 {
        let (first, end) = ((centre.y - radius).max(0.0) as usize, ((centre.y + radius).max(0.0) as usize + 1));
        let mut area = 0.0;
        for row in first..end.min(self.height()) {
            let up = row as f32 + 0.5 - centre.y;
            let squared = radius * radius - up * up;
            if squared > 0.0 {
                let half = squared.sqrt();
                area += ((centre.x + half).min(self.width() as f32) - (centre.x - half).max(0.0)).max(0.0);
            }
        }
        area
    }
}

/// Collects the points on the outline of a blob, except those on the edges of the image.
fn trace(runs: &[Run], [width, height]: [usize; 2], contour: &mut Vec<Vec2>) {
    contour.clear();
    for (index, run) in runs.iter().enumerate() {
        let middle = f32::from(run.row) + 0.5;
        if run.from > 0 {
            contour.push(Vec2::new(f32::from(run.from), middle));
        }
        if usize::from(run.to) < width {
            contour.push(Vec2::new(f32::from(run.to), middle));
        }
        // Columns above and below that no run of the blob touches.
        if run.row > 0 {
            bare(
                run,
                runs[..index].iter().rev().take_while(|other| other.row + 1 >= run.row),
                |column| {
                    contour.push(Vec2::new(column, f32::from(run.row)));
                },
                run.row.wrapping_sub(1),
            );
        }
        if usize::from(run.row) + 1 < height {
            bare(
                run,
                runs[index + 1..].iter().take_while(|other| other.row <= run.row + 1),
                |column| {
                    contour.push(Vec2::new(column, f32::from(run.row + 1)));
                },
                run.row + 1,
            );
        }
    }
}

/// Calls `push` with the columns of a run that no other run of the given row touches.
fn bare<'a>(run: &Run, others: impl Iterator<Item = &'a Run> + Clone, mut push: impl FnMut(f32), row: u16) {
    for column in run.from..run.to {
        let is_covered = others.clone().any(|other| other.row == row && other.from <= column && column < other.to);
        if !is_covered {
            push(f32::from(column) + 0.5);
        }
    }
}
