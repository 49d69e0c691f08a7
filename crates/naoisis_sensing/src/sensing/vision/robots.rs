//! Geometric vision of robots: detected by the waistband in their team's colour, located by their feet or by the height of the band.

use bevy::prelude::*;

use super::measuring::{Cue, on_pitch};
use super::missed::Miss;
use super::noise::HiddenFeet;
use super::observer::{Observer, across_sight};
use super::occlusion::Target;
use super::{JerseyVision, RobotPercept};
use crate::appearance::scene::SceneRobot;
use naoisis_core::camera_model::{CameraView, ViewSide};
use naoisis_core::geometry::wrap_angle;
use naoisis_core::robot::body::{Body, Waistband};
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::Team;

/// The sample points of a waistband across the line of sight, as shares of half its width: 4 cm on a NAO's.
const WAISTBAND_OFFSETS: [f32; 3] = [0.0, -0.04 / 0.074, 0.04 / 0.074];

/// The heights at which the legs of a robot without a visible foot are sampled, as shares of the height of the band's lower edge.
const LEG_HEIGHTS: [f32; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];

/// The least number of visible sample points with which a waistband is in view.
pub(super) const WAISTBAND_POINTS_NEEDED: usize = 3;

/// The number of sample points of a waistband.
pub(super) const WAISTBAND_POINTS: usize = 9;

impl Observer<'_> {
    pub(super) fn see_robot(&mut self, index: usize, robot: &SceneRobot) -> Result<RobotPercept, Miss> {
        let band = &robot.body.waistband;
        let mut percept = self.see_waistband(robot.pose.position, robot.id.team, band, Target::Robot(index))?;
        percept.colour = self.colour_of(&robot.body, robot.id.team);
        self.recognise_jersey(&mut percept, robot);
        Ok(percept)
    }

    /// Fills in the number and the heading of a robot, as far as it is near enough. The number is on chest and back.
    fn recognise_jersey(&mut self, percept: &mut RobotPercept, robot: &SceneRobot) {
        /// The greatest angle between the line of sight and the direction in which a robot faces, or its opposite, at which its number is
        /// read, as its cosine: 60°.
        const LEAST_COSINE: f32 = 0.5;
        let JerseyVision { number_m, number_error, heading_m, heading_sd, .. } = self.noise.jerseys;
        let sight = robot.pose.position - self.pose.position;
        let distance_m = sight.length();
        if distance_m < heading_m {
            let error = self.recognition.gaussian(heading_sd);
            percept.heading = Some(wrap_angle(robot.pose.heading - self.pose.heading + error));
        }
        if distance_m < number_m && sight.dot(robot.pose.forward()).abs() > LEAST_COSINE * distance_m {
            let is_misread = self.recognition.chance(number_error);
            let number = if is_misread { 1 + (9.0 * self.recognition.uniform()) as u8 } else { robot.id.number };
            percept.number = Some(number);
        }
    }

    /// The percept of a false robot of `team` with this body at `position` on the pitch.
    pub(super) fn see_false_robot(&mut self, position: Vec2, team: Team, body: &Body) -> Option<RobotPercept> {
        let percept = self.see_waistband(position, team, &body.waistband, Target::Other).ok()?;
        Some(RobotPercept { colour: self.colour_of(body, team), ..percept })
    }

    /// The colour of a jersey, if the vision recognises colours.
    fn colour_of(&self, body: &Body, team: Team) -> Option<Jersey> {
        body.jersey.filter(|_| self.noise.jerseys.colour_m > 0.0).map(|jersey| jersey.colour_of(team))
    }

    fn see_waistband(
        &mut self,
        position: Vec2,
        team: Team,
        band: &Waistband,
        target: Target,
    ) -> Result<RobotPercept, Miss> {
        let class = &self.noise.robots;
        let place = self.in_robot_frame(position);
        if class.is_too_far(place) || self.side_of(place) != ViewSide::Inside {
            return Err(Miss::NotDetected);
        }
        let threshold = self.may_detect(class, place).ok_or(Miss::NotDetected)?;
        let target = self.judge(target, place, radius_of(band));
        let (camera, cue) = self.waistband_cue(place, band, target).ok_or(Miss::NotDetected)?;
        let counts = (WAISTBAND_POINTS_NEEDED, WAISTBAND_POINTS);
        let is_detected = self.is_detected(class, (place, threshold), counts, |observer| {
            observer.visible_points_of_waistband(camera, place, band, target)
        });
        if !is_detected {
            return Err(Miss::NotDetected);
        }
        let (mut pixel, mut position_m) =
            self.measured_standing_point(camera, place, 0.0, cue, class.pixel_sd).ok_or(Miss::NotMeasured)?;
        if cue != Cue::Foot && self.noise.hidden_feet != HiddenFeet::default() {
            position_m = on_pitch(Some(position_m * self.error_without_feet(camera, place, band, target)))
                .ok_or(Miss::NotMeasured)?;
            pixel = self.believed[camera].project_anywhere(position_m.extend(0.0));
        }
        Ok(RobotPercept::new(self.names[camera], team, pixel, position_m))
    }

    /// The camera and the cue by which a robot at `place` (robot frame, m) is located, if enough of its waistband is visible.
    pub(super) fn waistband_cue(&self, place: Vec2, band: &Waistband, target: Target) -> Option<(usize, Cue)> {
        self.best_cue(place, target, |observer, camera| observer.robot_cue(camera, place, band, target))
    }

    /// The number of the sample points of a waistband at `place` (robot frame, m) that are visible to a camera.
    pub(super) fn visible_points_of_waistband(
        &self,
        camera: usize,
        place: Vec2,
        band: &Waistband,
        target: Target,
    ) -> usize {
        if self.sees_all(camera, place.extend(heights_of(band)[0]), radius_of(band), target) {
            return WAISTBAND_POINTS;
        }
        let points = waistband(&self.actual[camera], place, band);
        let is_visible = |point: &&Vec3| self.is_visible(camera, **point, target);
        // If only the foot is in this image, the waistband is in another image.
        points.as_flattened().iter().filter(is_visible).count().max(WAISTBAND_POINTS_NEEDED)
    }

    /// The factor on the measured distance of a robot without a visible foot. Its error grows with the hidden height.
    fn error_without_feet(&mut self, camera: usize, place: Vec2, band: &Waistband, target: Target) -> f32 {
        let HiddenFeet { bias, sd } = self.noise.hidden_feet;
        let is_visible = |height: &f32| self.is_visible(camera, place.extend(*height), target);
        let [middle_m, lower_m, _] = heights_of(band);
        let hidden_m: f32 = LEG_HEIGHTS.map(|share| share * lower_m).into_iter().find(is_visible).unwrap_or(middle_m);
        let share = hidden_m / middle_m;
        (1.0 + share * (bias + self.recognition.gaussian(sd))).max(0.1)
    }

    /// The cue by which a camera locates a robot, if enough of its waistband is visible.
    fn robot_cue(&self, camera: usize, place: Vec2, band: &Waistband, target: Target) -> Option<Cue> {
        let view = &self.actual[camera];
        let [middle, ..] = heights_of(band);
        let (centre, radius) = (place.extend(middle), radius_of(band));
        if !view.may_see(centre, radius) {
            return None;
        }
        let height = if self.sees_all(camera, centre, radius, target) {
            middle
        } else {
            let points = waistband(view, place, band);
            let is_visible = |point: &&Vec3| self.is_visible(camera, **point, target);
            let mut visible = points.as_flattened().iter().filter(is_visible).map(|point| point.z);
            let height = visible.next()?;
            visible.nth(WAISTBAND_POINTS_NEEDED - 2)?;
            height
        };
        Some(if self.is_visible(camera, place.extend(0.0), target) { Cue::Foot } else { Cue::Height(height) })
    }
}

/// The sample points of the waistband of a robot at `place`.
pub(super) fn waistband(view: &CameraView, place: Vec2, band: &Waistband) -> [[Vec3; 3]; 3] {
    let across = across_sight(view, place);
    // Written out, as arrays mapped within arrays are slow.
    let at = |share: f32| place + (share * band.half_size_m.y) * across;
    let [middle, right, left] = WAISTBAND_OFFSETS;
    let [middle, right, left] = [at(middle), at(right), at(left)];
    let row = |height: f32| [middle.extend(height), right.extend(height), left.extend(height)];
    let [middle, lower, upper] = heights_of(band);
    [row(middle), row(lower), row(upper)]
}

/// The heights of the sample points of a waistband, m: the middle first.
fn heights_of(band: &Waistband) -> [f32; 3] {
    let [lower, upper] = band.z_m;
    [(lower + upper) / 2.0, lower, upper]
}

/// The radius about the middle of a waistband that contains all of its sample points, m, plus a millimetre: 6.4 cm for a NAO.
pub(super) fn radius_of(band: &Waistband) -> f32 {
    Vec2::new(0.5 * band.height(), WAISTBAND_OFFSETS[2] * band.half_size_m.y).length() + 0.001
}
