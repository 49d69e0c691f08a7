//! How robots are seen: by the bands in their team's colour, and where they stand by their feet, or by how high the band is.

use bevy::prelude::*;

use super::RobotPercept;
use super::geometric::{Cue, Observer, across_sight, on_pitch};
use super::noise::HiddenFeet;
use super::occlusion::Target;
use crate::appearance::scene::SceneRobot;
use naoisis_core::camera_model::{CameraView, ViewSide};
use naoisis_core::robot::body::Waistband;
use naoisis_core::team::Team;

/// Where across the line of sight a waistband is looked at, as shares of half its width: 4 cm on a NAO's.
const WAISTBAND_OFFSETS: [f32; 3] = [0.0, -0.04 / 0.074, 0.04 / 0.074];

/// Heights from the foot up to the waistband at which a robot whose foot is not seen may be seen, as shares of that of the
/// band's lower edge.
const LEG_HEIGHTS: [f32; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];

/// Visible points that make a waistband seen.
const WAISTBAND_POINTS_NEEDED: usize = 3;

/// Points at which a waistband is looked for.
const WAISTBAND_POINTS: usize = 9;

impl Observer<'_> {
    pub(super) fn see_robot(&mut self, index: usize, robot: &SceneRobot) -> Option<RobotPercept> {
        self.see_waistband(robot.pose.position, robot.id.team, &robot.body.waistband, Target::Robot(index))
    }

    /// Something at a place on the pitch that looks like a robot of this team with such a waistband.
    pub(super) fn see_like_robot(&mut self, position: Vec2, team: Team, band: &Waistband) -> Option<RobotPercept> {
        self.see_waistband(position, team, band, Target::Other)
    }

    fn see_waistband(&mut self, position: Vec2, team: Team, band: &Waistband, target: Target) -> Option<RobotPercept> {
        let class = &self.noise.robots;
        let place = self.in_robot_frame(position);
        if class.is_too_far(place) || self.side_of(place) != ViewSide::Inside {
            return None;
        }
        let odds = self.may_recognise(class, place)?;
        let target = self.judge(target, place, radius_of(band));
        let (side, cue) =
            self.best_cue(place, target, |observer, side| observer.robot_cue(side, place, band, target))?;
        let is_noticed =
            self.is_noticed(class, (place, odds), (WAISTBAND_POINTS_NEEDED, WAISTBAND_POINTS), |observer| {
                if observer.sees_all(side, place.extend(heights_of(band)[0]), radius_of(band), target) {
                    return WAISTBAND_POINTS;
                }
                let points = waistband(&observer.actual[side], place, band);
                let is_visible = |point: &&Vec3| observer.is_visible(side, **point, target);
                // Of a robot whose foot alone is in this image, the waistband is in the other.
                points.as_flattened().iter().filter(is_visible).count().max(WAISTBAND_POINTS_NEEDED)
            });
        if !is_noticed {
            return None;
        }
        let (mut pixel, mut position_m) = self.measured_standing_point(side, place, 0.0, cue, class.pixel_sd)?;
        if cue != Cue::Foot && self.noise.hidden_feet != HiddenFeet::default() {
            position_m = on_pitch(Some(position_m * self.error_without_feet(side, place, band, target)))?;
            pixel = self.believed[side].project_anywhere(position_m.extend(0.0));
        }
        Some(RobotPercept { camera: self.names[side], team, pixel, position_m })
    }

    /// By which factor a robot seems further away whose foot is not seen: the more, the higher it is hidden.
    fn error_without_feet(&mut self, side: usize, place: Vec2, band: &Waistband, target: Target) -> f32 {
        let HiddenFeet { bias, sd } = self.noise.hidden_feet;
        let is_visible = |height: &f32| self.is_visible(side, place.extend(*height), target);
        let [middle_m, lower_m, _] = heights_of(band);
        let hidden_m: f32 = LEG_HEIGHTS.map(|share| share * lower_m).into_iter().find(is_visible).unwrap_or(middle_m);
        let share = hidden_m / middle_m;
        (1.0 + share * (bias + self.recognition.gaussian(sd))).max(0.1)
    }

    /// By what one camera sees a robot, if it sees enough of its waistband.
    fn robot_cue(&self, side: usize, place: Vec2, band: &Waistband, target: Target) -> Option<Cue> {
        let view = &self.actual[side];
        let [middle, ..] = heights_of(band);
        let (centre, radius) = (place.extend(middle), radius_of(band));
        if !view.may_see(centre, radius) {
            return None;
        }
        let height = if self.sees_all(side, centre, radius, target) {
            middle
        } else {
            let points = waistband(view, place, band);
            let is_visible = |point: &&Vec3| self.is_visible(side, **point, target);
            let mut visible = points.as_flattened().iter().filter(is_visible).map(|point| point.z);
            let height = visible.next()?;
            visible.nth(WAISTBAND_POINTS_NEEDED - 2)?;
            height
        };
        Some(if self.is_visible(side, place.extend(0.0), target) { Cue::Foot } else { Cue::Height(height) })
    }
}

/// Where the waistband of a robot at `place` is looked at.
fn waistband(view: &CameraView, place: Vec2, band: &Waistband) -> [[Vec3; 3]; 3] {
    let across = across_sight(view, place);
    // Written out, as arrays mapped within arrays are slow.
    let at = |share: f32| place + (share * band.half_size_m.y) * across;
    let [middle, right, left] = WAISTBAND_OFFSETS;
    let [middle, right, left] = [at(middle), at(right), at(left)];
    let row = |height: f32| [middle.extend(height), right.extend(height), left.extend(height)];
    let [middle, lower, upper] = heights_of(band);
    [row(middle), row(lower), row(upper)]
}

/// Heights on a waistband at which a robot is looked for, m: the middle first.
fn heights_of(band: &Waistband) -> [f32; 3] {
    let [lower, upper] = band.z_m;
    [(lower + upper) / 2.0, lower, upper]
}

/// All points at which a waistband is looked for are within this distance of its middle, m: 6.4 cm of a NAO's. With a
/// millimetre to spare.
fn radius_of(band: &Waistband) -> f32 {
    Vec2::new(0.5 * band.height(), WAISTBAND_OFFSETS[2] * band.half_size_m.y).length() + 0.001
}
