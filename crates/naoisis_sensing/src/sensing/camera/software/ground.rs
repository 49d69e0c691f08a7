//! Drawing of sky, floor, carpet and markings.

use bevy::math::Vec3;

use super::conic::Conic;
use super::coverage::{self, Levels, NOTHING, SUB_ROWS, Span};
use super::frame::{Frame, first_sample};
use super::polygon::Outline;
use super::prepared::PreparedScene;
use crate::appearance::field::GroundShape;
use crate::appearance::view::View;

/// Fills the whole frame with sky, floor, carpet and markings.
#[inline(always)]
pub(super) fn draw(frame: &mut Frame, outline: &mut Outline, scene: &PreparedScene, view: &View) {
    let [sky, floor] = scene.backdrop;
    let (width, height) = (frame.width, frame.height);
    if view.eye.z <= 0.0 {
        frame.pixels.fill(sky);
        return;
    }
    for row in 0..height {
        let [from, to] = below_horizon(frame, view, row);
        let pixels = &mut frame.pixels[row * width..(row + 1) * width];
        pixels[..from].fill(sky);
        pixels[from..to].fill(floor);
        pixels[to..].fill(sky);
    }
    // With several samples per pixel, their mean is taken later.
    let is_smooth = view.antialiasing && view.supersampling <= 1;
    let levels = Levels::get();
    for (mark, paint) in &scene.ground {
        match mark.shape {
            GroundShape::Quadrilateral(corners) => {
                if !outline.project(frame, corners.iter().map(|corner| (corner.extend(0.0), 0.0))) {
                    continue;
                }
                if is_smooth {
                    draw_smoothly(frame, outline, *paint, levels);
                    continue;
                }
                let (first, end) = outline.scan(width, height, &(0..height));
                for row in first..end {
                    let (from, to) = outline.span(row, width);
                    if from < to {
                        frame.pixels[row * width + from..row * width + to].fill(*paint);
                    }
                }
            }
            GroundShape::Ring { centre, inner, outer } => {
                let circles = [outer, inner].map(|radius| circle(view, centre.extend(0.0), radius));
                if is_smooth {
                    draw_ring_smoothly(frame, view, circles, *paint, levels);
                } else {
                    draw_ring(frame, view, circles, *paint);
                }
            }
        }
    }
}

/// Fills the projected quadrilateral. Each pixel is mixed by the share of it that is covered.
#[inline(always)]
fn draw_smoothly(frame: &mut Frame, outline: &mut Outline, paint: u32, levels: &Levels) {
    let (width, height) = (frame.width, frame.height);
    outline.divide_rows(SUB_ROWS);
    let (first, end) = outline.scan(width, height * SUB_ROWS, &(0..height * SUB_ROWS));
    for row in first / SUB_ROWS..end.div_ceil(SUB_ROWS) {
        let spans = core::array::from_fn(|part| {
            let part = row * SUB_ROWS + part;
            if first <= part && part < end { outline.ends(part, width) } else { [0.0; 2] }
        });
        coverage::paint(&mut frame.pixels[row * width..(row + 1) * width], &spans, &[], paint, levels);
    }
}

/// The range of samples of a row that show the ground.
#[inline(always)]
fn below_horizon(frame: &Frame, view: &View, row: usize) -> [usize; 2] {
    let width = frame.width;
    ground_in_row(frame, view, frame.slope(row, 1)).map(|end| first_sample(end, width))
}

/// The span of the ground in the row whose rays have this slope.
#[inline(always)]
fn ground_in_row(frame: &Frame, view: &View, slope: f32) -> Span {
    // A ray looks down where forward.z + u right.z + v down.z is negative.
    let constant = view.forward.z + slope * view.down.z;
    let width = frame.width as f32;
    if view.right.z == 0.0 {
        return if constant < 0.0 { [0.0, width] } else { [0.0; 2] };
    }
    let crossing = frame.centre[0] - constant / view.right.z * frame.focal_length;
    let crossing = if crossing > 0.0 { if crossing < width { crossing } else { width } } else { 0.0 };
    if view.right.z < 0.0 { [crossing, width] } else { [0.0, crossing] }
}

/// The area of the rays that meet the ground inside a circle.
fn circle(view: &View, centre: Vec3, radius: f32) -> Conic {
    // A ray d from the eye e meets the ground at e - d e.z / d.z. This is within r of the centre c if |(e - c) d.z - d e.z|² <= r² d.z², on
    // the ground.
    let eye = (view.eye - centre).as_dvec3();
    let on_ground = |direction: Vec3| {
        let direction = direction.as_dvec3();
        [eye.x * direction.z - direction.x * eye.z, eye.y * direction.z - direction.y * eye.z, direction.z]
    };
    let radius = f64::from(radius);
    Conic::of_cone(on_ground(view.forward), on_ground(view.right), on_ground(view.down), radius * radius)
}

/// Fills the area inside the first circle and outside the second.
#[inline(always)]
fn draw_ring(frame: &mut Frame, view: &View, [outer, inner]: [Conic; 2], paint: u32) {
    let (width, height) = (frame.width, frame.height);
    let focal_length = f64::from(frame.focal_length);
    let [centre_u, centre_v] = frame.centre.map(f64::from);
    let [top, bottom] = outer.rows().map(|slope| first_sample((slope * focal_length + centre_v) as f32, height));
    for row in top..bottom {
        let slope = f64::from(frame.slope(row, 1));
        let ground = below_horizon(frame, view, row);
        let to_samples = |span: [f64; 2]| {
            let [from, to] = span.map(|slope| first_sample((slope * focal_length + centre_u) as f32, width));
            [from.max(ground[0]), to.min(ground[1])]
        };
        let holes = inner.spans(slope).map(|hole| hole.map_or([0, 0], to_samples));
        for span in outer.spans(slope).into_iter().flatten() {
            let [mut from, to] = to_samples(span);
            let pixels = &mut frame.pixels[row * width..(row + 1) * width];
            for [hole_from, hole_to] in holes {
                if hole_from < hole_to && hole_to > from && hole_from < to {
                    if from < hole_from {
                        pixels[from..hole_from].fill(paint);
                    }
                    from = hole_to;
                }
            }
            if from < to {
                pixels[from..to].fill(paint);
            }
        }
    }
}

/// Like [`draw_ring`], but each pixel is mixed by the share of it that is covered.
#[inline(always)]
fn draw_ring_smoothly(frame: &mut Frame, view: &View, [outer, inner]: [Conic; 2], paint: u32, levels: &Levels) {
    let (width, height) = (frame.width, frame.height);
    let focal_length = f64::from(frame.focal_length);
    let [centre_u, centre_v] = frame.centre.map(f64::from);
    let [top, bottom] = outer.rows().map(|slope| (slope * focal_length + centre_v) as f32);
    // A part of a row is added on either side.
    let (top, bottom) = (first_sample(top - 0.5, height), first_sample(bottom + 1.5, height));
    for row in top..bottom {
        let mut areas = [NOTHING; 2];
        let mut holes = [[NOTHING; 2]; 2];
        let mut are_holes = false;
        for part in 0..SUB_ROWS {
            let down = (row as f32 + (part as f32 + 0.5) / SUB_ROWS as f32 - frame.centre[1]) / frame.focal_length;
            let ground = ground_in_row(frame, view, down);
            let within = |span: Option<[f64; 2]>, [least, most]: Span| {
                let [from, to] = span.unwrap_or([0.0; 2]).map(|slope| (slope * focal_length + centre_u) as f32);
                let (from, to) = (if from > least { from } else { least }, if to < most { to } else { most });
                if from < to { [from, to] } else { [0.0; 2] }
            };
            let spans = outer.spans(f64::from(down)).map(|span| within(span, ground));
            for (index, span) in spans.into_iter().enumerate() {
                areas[index][part] = span;
                for (hole, inside) in inner.spans(f64::from(down)).into_iter().enumerate() {
                    let hole_span = within(inside, span);
                    holes[index][hole][part] = hole_span;
                    are_holes |= hole_span[0] < hole_span[1];
                }
            }
        }
        let pixels = &mut frame.pixels[row * width..(row + 1) * width];
        for (area, holes) in areas.iter().zip(&holes) {
            coverage::paint(pixels, area, if are_holes { holes } else { &[] }, paint, levels);
        }
    }
}
