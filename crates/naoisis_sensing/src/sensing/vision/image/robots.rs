//! Robots, detected by their waistbands or jerseys.

use bevy::math::{Vec2, ops};

use super::Look;
use super::blobs::Blob;
use super::colour::ColourClass;
use crate::sensing::vision::RobotPercept;
use naoisis_core::robot::body::Waistband;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::Team;

/// The least number of pixels of a waistband.
const LEAST_AREA: u32 = 8;

/// The least height of the columns used for the edges of the band, as a share of the greatest height.
const HIGH_ENOUGH: f32 = 0.6;

/// A possible robot.
struct Sighted {
    has_lower_edge: bool,
    position_m: Vec2,
    /// The difference between the size of its band and the expected size, as a sum of logarithms.
    misfit: f32,
}

impl Look<'_> {
    /// Finds robots, and whether the lower edges of their waistbands are in the image.
    pub(super) fn find_robots(&self, edges: &mut Vec<[u16; 2]>, found: &mut Vec<(bool, RobotPercept)>) {
        let mut blobs: Vec<&Blob> = self.segmentation.blobs.iter().filter(|blob| blob.area >= LEAST_AREA).collect();
        let has_jersey = |team: Team| self.model.jerseys[team].is_some();
        if Team::BOTH.into_iter().any(has_jersey) {
            // Of a jersey that is divided by an arm or a number, the largest piece counts.
            blobs.sort_by_key(|blob| core::cmp::Reverse(blob.area));
        }
        for blob in blobs {
            let is_of = |team: &Team| class_of(*team, self.model.jerseys[*team]) == Some(blob.class);
            let Some(team) = Team::BOTH.into_iter().find(is_of) else { continue };
            let ends = self.edges(blob, edges);
            let bands = self.model.waistbands[team].iter();
            // Of several kinds of robots, the one whose band fits best is chosen.
            let best = bands
                .filter_map(|band| self.robot(blob, band, ends))
                .reduce(|best, other| if other.misfit < best.misfit { other } else { best });
            if let Some(Sighted { has_lower_edge, position_m, .. }) = best {
                let half_width_m =
                    self.model.waistbands[team].iter().map(|band| band.half_size_m.y).fold(0.0, f32::max);
                let pixel = self.view.project_anywhere(position_m.extend(0.0));
                let percept = self.robot_percept(team, pixel, position_m);
                let same_m = if has_jersey(team) { 1.2 * half_width_m } else { 0.0 };
                insert(found, same_m, has_lower_edge, percept);
            }
        }
    }

    /// The percept of a robot of `team`, with the colour of its jersey.
    pub(super) fn robot_percept(&self, team: Team, pixel: Vec2, position_m: Vec2) -> RobotPercept {
        let colour = self.model.jerseys[team].map(|jersey| jersey.colour_of(team));
        RobotPercept { colour, ..RobotPercept::new(self.camera, team, pixel, position_m) }
    }

    /// The robot with the waistband `band` whose blob has these upper and lower edges, if the size fits.
    fn robot(&self, blob: &Blob, band: &Waistband, [upper, lower]: [f32; 2]) -> Option<Sighted> {
        let (is_cut_above, is_cut_below) = (blob.top == 0, usize::from(blob.bottom) == self.height());
        let column = f32::from(blob.left + blob.right) / 2.0;
        let [low_z, high_z] = band.z_m;
        let half_size = band.half_size_m;
        // The surface of the band is in front of the robot's middle.
        let behind = |place: Vec2| place + place.normalize_or(Vec2::X) * ((half_size.x + half_size.y) / 2.0);
        let by_lower = || self.place(Vec2::new(column, lower), low_z).map(behind);
        let by_upper = || self.place(Vec2::new(column, upper), high_z).map(behind);
        let (place, has_lower) = match (is_cut_above, is_cut_below) {
            (_, false) => (by_lower()?, true),
            (false, true) => (by_upper()?, false),
            (true, true) => return None,
        };
        // The expected size of a band at that position.
        let focal_length = self.view.intrinsics.focal.x;
        let depth = self.depth(place, low_z).max(0.1);
        let across = focal_length * 2.0 * half_size.y / depth;
        let high = self.view.project(place.extend(low_z))?.y - self.view.project(place.extend(high_z))?.y;
        let (width, height) = (f32::from(blob.width()), lower - upper);
        // The difference from the expected size: a band that is cut off or hidden may be smaller.
        let is_cut_aside = blob.left == 0 || usize::from(blob.right) == self.width();
        let [wide, tall] = [(width, across), (height, high)].map(|(is, should)| ops::ln((is + 1.0) / (should + 1.0)));
        let misfit = if is_cut_aside { wide.max(0.0) } else { wide.abs() }
            + if is_cut_above || is_cut_below { tall.max(0.0) } else { tall.abs() };
        let is_no_wider = width < 1.5 * across + 2.0;
        let is_no_higher = height < 1.5 * high + 2.0;
        let is_high_enough = is_cut_above || is_cut_below || height > 0.45 * high - 1.0;
        if is_no_wider && is_no_higher && is_high_enough {
            return Some(Sighted { has_lower_edge: has_lower, position_m: place, misfit });
        }
        // If the lower part is hidden, the band is located by its upper edge.
        if !is_high_enough && !is_cut_above && width < 1.5 * across + 2.0 {
            return by_upper().map(|position_m| Sighted { has_lower_edge: false, position_m, misfit });
        }
        None
    }

    /// The upper and lower edge of a band: the medians over its columns, pixels.
    fn edges(&self, blob: &Blob, edges: &mut Vec<[u16; 2]>) -> [f32; 2] {
        edges.clear();
        edges.resize(usize::from(blob.width()), [u16::MAX, 0]);
        for run in self.segmentation.runs(blob) {
            for edge in &mut edges[usize::from(run.from - blob.left)..usize::from(run.to - blob.left)] {
                edge[0] = edge[0].min(run.row);
                edge[1] = edge[1].max(run.row + 1);
            }
        }
        let highest = edges.iter().map(|edge| edge[1].saturating_sub(edge[0])).max().unwrap_or(0);
        edges.retain(|edge| f32::from(edge[1].saturating_sub(edge[0])) >= HIGH_ENOUGH * f32::from(highest));
        let count = edges.len().max(1);
        [0, 1].map(|end| {
            edges.sort_unstable_by_key(|edge| edge[end]);
            // The mean of the middle half has a finer resolution than the median.
            let middle = &edges[count / 4..(count - count / 4).min(edges.len())];
            middle.iter().map(|edge| f32::from(edge[end])).sum::<f32>() / middle.len().max(1) as f32
        })
    }
}

/// The colour class of a team's waistbands or jerseys. `None` for green ones, which the carpet hides.
pub(super) fn class_of(team: Team, jersey: Option<Jersey>) -> Option<ColourClass> {
    let of_team = match team {
        Team::Blue => ColourClass::Blue,
        Team::Pink => ColourClass::Pink,
    };
    match jersey {
        None | Some(Jersey::Team) => Some(of_team),
        Some(Jersey::Blue) => Some(ColourClass::Blue),
        Some(Jersey::Red) => Some(ColourClass::Red),
        Some(Jersey::Yellow) => Some(ColourClass::Yellow),
        Some(Jersey::Orange) => Some(ColourClass::Orange),
        Some(Jersey::Purple) => Some(ColourClass::Purple),
        Some(Jersey::Black) => Some(ColourClass::Black),
        Some(Jersey::White) => Some(ColourClass::White),
        Some(Jersey::Brown) => Some(ColourClass::Brown),
        Some(Jersey::Grey) => Some(ColourClass::Grey),
        Some(Jersey::Green) => None,
    }
}

/// Adds a robot, unless it is a part of one that was found already: at about the same position, or less than `aside_m` beside the line of
/// sight to it.
fn insert(found: &mut Vec<(bool, RobotPercept)>, aside_m: f32, has_lower: bool, percept: RobotPercept) {
    let is_same = |other: &RobotPercept| {
        let apart = other.position_m.distance(percept.position_m);
        let aside = other.position_m.normalize_or(Vec2::X).perp_dot(percept.position_m).abs();
        other.team == percept.team && (apart < 0.15 + 0.1 * percept.position_m.length() || aside < aside_m)
    };
    match found.iter_mut().find(|(_, other)| is_same(other)) {
        Some(other) if has_lower && !other.0 && aside_m == 0.0 => *other = (has_lower, percept),
        Some(_) => {}
        None => found.push((has_lower, percept)),
    }
}
