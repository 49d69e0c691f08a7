//! The labels of an image: boxes, outlines and key points of the objects in it.

use bevy::math::Vec2;
use serde::{Deserialize, Serialize};

use super::names::{Class, KEYPOINTS};
use super::outline;
use super::ranges::LabelLimits;
use super::shot::Shot;
use naoisis_core::pitch::Markings;
use naoisis_sensing::appearance::Label;

/// A labelled object in an image.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Annotation {
    /// Its class.
    pub class: Class,
    /// Name of the object, such as `pink3`.
    pub object: String,
    /// The box around its visible pixels: left, top, width and height.
    pub bbox: [u32; 4],
    /// The number of its visible pixels.
    pub area: u32,
    /// Share of the object's area in the image that nothing hides, from 0 to 1.
    pub visible: f32,
    /// Whether the object reaches the edge of the image.
    pub truncated: bool,
    /// Distance of the object from the camera, m.
    pub distance_m: f32,
    /// The outlines of its visible pixels.
    pub polygons: Vec<Vec<[u32; 2]>>,
    /// The key points of a robot: pixel and visibility (2 visible, 1 hidden, 0 outside the image, with pixel 0). Empty for other objects.
    pub keypoints: Vec<(f32, f32, u8)>,
}

/// The number of pixels of an object, and the box around them.
#[derive(Clone, Copy)]
struct Extent {
    count: u32,
    least: [u32; 2],
    most: [u32; 2],
}

/// Returns the labels of the objects and of the markings in an image.
pub fn annotations(shot: &Shot, markings: &Markings, limits: &LabelLimits) -> Vec<Annotation> {
    let mut found = objects(shot, limits);
    let crossings = markings.junctions.iter().map(|junction| (junction.position, Class::from(junction.shape)));
    let marks = markings.penalty_crosses.iter().map(|place| (*place, Class::PenaltyMark));
    found.extend(crossings.chain(marks).filter_map(|(place, class)| crossing(shot, place, class, limits)));
    found
}

fn extents(shot: &Shot) -> Vec<Extent> {
    let mut extents = vec![Extent { count: 0, least: [u32::MAX; 2], most: [0; 2] }; 256];
    let width = shot.image.width.max(1) as usize;
    for (row, numbers) in shot.image.labels.chunks_exact(width).enumerate() {
        for (column, number) in numbers.iter().enumerate() {
            let extent = &mut extents[usize::from(*number)];
            extent.count += 1;
            let [column, row] = [column as u32, row as u32];
            extent.least = [extent.least[0].min(column), extent.least[1].min(row)];
            extent.most = [extent.most[0].max(column), extent.most[1].max(row)];
        }
    }
    extents
}

fn objects(shot: &Shot, limits: &LabelLimits) -> Vec<Annotation> {
    let extents = extents(shot);
    let (width, height) = (shot.image.width, shot.image.height);
    let annotation = |(object, visible): (&super::staging::Object, &Option<f32>)| {
        let class = object.class?;
        let visible = (*visible)?;
        let Extent { count, least, most } = extents[usize::from(object.number)];
        if count == 0 {
            return None;
        }
        let size = [most[0] + 1 - least[0], most[1] + 1 - least[1]];
        if size.iter().any(|size| (*size as f32) < limits.least_px) || visible < limits.least_visible {
            return None;
        }
        let labels = &shot.image.labels;
        let is_inside = |u: usize, v: usize| labels[v * width as usize + u] == object.number;
        let polygons = outline::polygons(least.map(|it| it as usize), size.map(|it| it as usize), is_inside);
        let pixels =
            |polygon: &outline::Polygon| polygon.iter().map(|point| [point.x as u32, point.y as u32]).collect();
        Some(Annotation {
            class,
            object: object.name.clone(),
            bbox: [least[0], least[1], size[0], size[1]],
            area: count,
            visible: rounded(visible),
            truncated: least.contains(&0) || most[0] + 1 == width || most[1] + 1 == height,
            distance_m: rounded(object.place.distance(shot.view.eye)),
            polygons: polygons.iter().map(pixels).collect(),
            keypoints: keypoints(shot, object),
        })
    };
    shot.objects.iter().zip(&shot.visible).filter_map(annotation).collect()
}

fn keypoints(shot: &Shot, object: &super::staging::Object) -> Vec<(f32, f32, u8)> {
    let point = |point: &bevy::math::Vec3| {
        let pixel = shot.pixel(*point)?;
        let number = shot.number_at(pixel)?;
        Some((rounded(pixel.x), rounded(pixel.y), if number == object.number { 2 } else { 1 }))
    };
    debug_assert!(object.keypoints.is_empty() || object.keypoints.len() == KEYPOINTS.len());
    object.keypoints.iter().map(|place| point(place).unwrap_or_default()).collect()
}

/// Returns the label of a crossing of lines or of a penalty mark: the box around a square on the ground.
fn crossing(shot: &Shot, place: Vec2, class: Class, limits: &LabelLimits) -> Option<Annotation> {
    let centre = place.extend(0.0);
    let distance_m = centre.distance(shot.view.eye);
    if distance_m > limits.crossing_reach_m || shot.number_at(shot.pixel(centre)?)? != Label::Line as u8 {
        return None;
    }
    let half = limits.crossing_m;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| place + half * Vec2::new(x, y));
    let (mut least, mut most) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for corner in corners {
        let pixel = shot.pixel(corner.extend(0.0))?;
        (least, most) = (least.min(pixel), most.max(pixel));
    }
    let size = Vec2::new(shot.image.width as f32, shot.image.height as f32);
    let truncated = least.cmplt(Vec2::ZERO).any() || most.cmpgt(size).any();
    let [least, most] = [least.floor(), most.ceil()].map(|pixel| pixel.clamp(Vec2::ZERO, size));
    let [left, top, right, bottom] = [least.x, least.y, most.x, most.y].map(|side| side as u32);
    let (width, height) = (right - left, bottom - top);
    if (width.min(height) as f32) < limits.least_px {
        return None;
    }
    let row = |v: u32| {
        let start = (v * shot.image.width + left) as usize;
        &shot.image.labels[start..start + width as usize]
    };
    let is_ground = |number: &&u8| **number <= Label::Line as u8;
    let on_ground: usize = (top..bottom).map(|v| row(v).iter().filter(is_ground).count()).sum();
    let visible = on_ground as f32 / (width * height) as f32;
    (visible >= limits.least_visible).then(|| Annotation {
        class,
        object: format!("at {:.2} {:.2}", place.x, place.y),
        bbox: [left, top, width, height],
        area: width * height,
        visible: rounded(visible),
        truncated,
        distance_m: rounded(distance_m),
        polygons: vec![vec![[left, top], [right, top], [right, bottom], [left, bottom]]],
        keypoints: Vec::new(),
    })
}

/// Rounds to a hundredth.
fn rounded(value: f32) -> f32 {
    (value * 100.0).round() / 100.0
}
