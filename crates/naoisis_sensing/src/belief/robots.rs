//! Tracks of other robots in the robot's own frame, from cameras and sonars, by nearest neighbour.
//!
//! A camera measures the direction of a robot well and its distance badly; a sonar measures the distance to centimetres, but hardly the
//! direction (paper, Fig. 7). Together they measure the position.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::RobotBelief;
use super::covariance::inverse;
use super::sighting::{Residual, Sighting};
use naoisis_core::geometry::{Pose, unit, unrotate};
use naoisis_core::team::Team;

/// The distance within which a seen and a reported team-mate are the same robot, m.
const SAME_ROBOT_M: f32 = 0.6;

/// The track of another robot.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct RobotTrack {
    /// Its team, by the waistband.
    pub team: Team,
    /// Position, m, robot frame.
    pub position: Vec2,
    /// Covariance of the position, m².
    pub covariance: Mat2,
    /// The time since the robot was seen, s.
    pub age_s: f32,
    /// The number of sightings.
    pub sightings: u32,
}

/// The model of tracking.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackModel {
    /// A sighting within this distance of a track belongs to it, m; for robots further away than a metre, the limit grows with the square
    /// of the distance, up to four times.
    pub gate_m: f32,
    /// Process noise of the position: variance per second, m²/s.
    pub walk_variance: f32,
    /// A track is removed after this time without a sighting, s.
    pub forget_s: f32,
    /// The time after which a track with a single sighting is removed, s: it is probably false.
    pub forget_unconfirmed_s: f32,
}

impl Default for TrackModel {
    fn default() -> Self {
        Self { gate_m: 0.4, walk_variance: 0.03, forget_s: 4.0, forget_unconfirmed_s: 0.3 }
    }
}

/// Predicts all tracks `duration` seconds later, in the robot frame after a `step` (in the frame before it), and removes old ones.
pub fn advance_tracks(tracks: &mut Vec<RobotTrack>, step: Pose, duration: f32, model: &TrackModel) {
    if tracks.is_empty() {
        return;
    }
    let forward = unit(step.heading);
    let growth = Mat2::from_diagonal(Vec2::splat(model.walk_variance * duration));
    tracks.retain_mut(|track| {
        track.age_s += duration;
        // Only the position is rotated; the covariance of a walking robot is nearly isotropic.
        track.position = unrotate(forward, track.position - step.position);
        track.covariance += growth;
        track.age_s < if track.sightings > 1 { model.forget_s } else { model.forget_unconfirmed_s }
    });
}

/// Updates the tracks by a sighting of a robot of `team`.
pub fn see_robot(tracks: &mut Vec<RobotTrack>, team: Team, sighting: &Sighting, model: &TrackModel) {
    let place = sighting.place;
    let gate = model.gate_m * place.length_squared().clamp(1.0, 4.0);
    let nearest = tracks
        .iter_mut()
        .filter(|track| track.team == team)
        .map(|track| (track.position.distance_squared(place), track))
        .min_by(|(first, _), (second, _)| first.total_cmp(second));
    match nearest {
        Some((distance_squared, track)) if distance_squared < gate * gate => {
            let Residual { difference, noise } = sighting.residual(track.position);
            let gain = track.covariance * inverse(track.covariance + noise);
            track.position += gain * difference;
            track.covariance -= gain * track.covariance;
            track.age_s = 0.0;
            track.sightings = track.sightings.saturating_add(1);
        }
        _ => tracks.push(RobotTrack {
            team,
            position: place,
            covariance: sighting.noise_at(place),
            age_s: 0.0,
            sightings: 1,
        }),
    }
}

/// The measurement model of sonars.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SonarModel {
    /// The mean distance from the nearest point of a robot's torso, which is 30 cm wide and 8 cm deep, to the robot's position, m.
    pub torso_m: f32,
    /// The standard deviation of the sum of that distance and the measured one, m.
    pub distance_sd: f32,
    /// The greatest difference of an echo from the expected distance, m.
    pub gate_m: f32,
    /// The greatest angle of a robot's position beyond the edge of the sector, as its torso is wide, radians.
    pub margin: f32,
    /// The distance within which an echo may come from a goal post, m.
    pub post_range_m: f32,
}

impl Default for SonarModel {
    fn default() -> Self {
        Self { torso_m: 0.08, distance_sd: 0.04, gate_m: 0.3, margin: 0.2, post_range_m: 0.35 }
    }
}

/// Updates the tracks by a sonar echo at `distance`, m, in the sector with the direction `heading` (to the left) and the half opening angle
/// `half_angle`. The echo belongs to the track nearest to that distance. Only the variance along the line of sight is reduced.
pub fn hear_robot(tracks: &mut [RobotTrack], distance: f32, heading: f32, half_angle: f32, model: &SonarModel) {
    let axis = unit(heading);
    let least_dot = ops::cos(half_angle + model.margin);
    let heard = tracks
        .iter_mut()
        .filter_map(|track| {
            let away = track.position.length();
            let off = distance + model.torso_m - away;
            (away > 0.05 && track.position.dot(axis) > least_dot * away && off.abs() < model.gate_m)
                .then_some((off, track))
        })
        .min_by(|(first, _), (second, _)| first.abs().total_cmp(&second.abs()));
    let Some((off, track)) = heard else { return };
    // The measurement is scalar, along the line of sight.
    let direction = track.position.normalize_or(axis);
    let cross = track.covariance * direction;
    let spread = direction.dot(cross) + model.distance_sd * model.distance_sd;
    let gain = cross / spread;
    track.position += gain * off;
    track.covariance -= Mat2::from_cols(gain * cross.x, gain * cross.y);
    track.age_s = 0.0;
}

/// Adds a seen team-mate to the known ones, of which the first `heard_count` have reported their positions. If the seen team-mate is one of
/// these, the id is kept, with the newer of both positions.
pub fn add_seen_mate(team_mates: &mut Vec<RobotBelief>, heard_count: usize, seen: RobotBelief) {
    let is_same = |told: &&mut RobotBelief| told.position_m.distance(seen.position_m) <= SAME_ROBOT_M;
    match team_mates.iter_mut().take(heard_count).find(is_same) {
        Some(told) if seen.age_s < told.age_s => *told = RobotBelief { id: told.id, ..seen },
        Some(_) => {}
        None => team_mates.push(seen),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    const PERIOD: f32 = 1.0 / 30.0;

    fn sighting(x: f32, y: f32) -> Sighting {
        Sighting::new(Vec2::new(x, y), 0.009)
    }

    #[test]
    fn one_robot_seen_often_is_one_track_and_two_are_two() {
        let model = TrackModel::default();
        let mut tracks = Vec::new();
        for cycle in 0..30 {
            let wobble = if cycle % 2 == 0 { 0.05 } else { -0.05 };
            see_robot(&mut tracks, Team::Pink, &sighting(1.5 + wobble, 0.5), &model);
            see_robot(&mut tracks, Team::Pink, &sighting(1.5 - wobble, -0.7), &model);
            see_robot(&mut tracks, Team::Blue, &sighting(1.5, 0.5), &model);
            advance_tracks(&mut tracks, Pose::default(), PERIOD, &model);
        }
        assert_eq!(tracks.len(), 3);
        assert_abs_diff_eq!(tracks[0].position, Vec2::new(1.5, 0.5), epsilon = 0.03);
        assert_abs_diff_eq!(tracks[1].position, Vec2::new(1.5, -0.7), epsilon = 0.03);
    }

    #[test]
    fn what_was_seen_once_only_is_soon_forgotten() {
        let model = TrackModel::default();
        let mut tracks = Vec::new();
        see_robot(&mut tracks, Team::Pink, &sighting(1.0, 0.0), &model);
        see_robot(&mut tracks, Team::Pink, &sighting(2.0, 1.0), &model);
        see_robot(&mut tracks, Team::Pink, &sighting(2.0, 1.0), &model);
        for _ in 0..30 {
            advance_tracks(&mut tracks, Pose::default(), PERIOD, &model);
        }
        assert_eq!(tracks.len(), 1);
        for _ in 0..120 {
            advance_tracks(&mut tracks, Pose::default(), PERIOD, &model);
        }
        assert!(tracks.is_empty());
    }

    #[test]
    fn tracks_move_against_the_robots_own_steps() {
        let mut tracks = Vec::new();
        see_robot(&mut tracks, Team::Pink, &sighting(1.0, 0.0), &TrackModel::default());
        let step = Pose::new(0.5, 0.0, core::f32::consts::FRAC_PI_2);
        advance_tracks(&mut tracks, step, PERIOD, &TrackModel::default());
        assert_abs_diff_eq!(tracks[0].position, Vec2::new(0.0, -0.5), epsilon = 1e-6);
    }

    #[test]
    fn an_echo_tells_the_distance_of_a_robot_that_was_seen_and_nothing_across() {
        let mut tracks = Vec::new();
        see_robot(&mut tracks, Team::Pink, &sighting(0.65, 0.2), &TrackModel::default());
        tracks[0].covariance = Mat2::from_diagonal(Vec2::splat(0.01));
        let before = tracks[0];
        hear_robot(&mut tracks, 0.5, 0.34, 0.314, &SonarModel::default());
        // The robot is √(0.65² + 0.2²) = 0.680 m away and heard at 0.5 + 0.08 m; of the difference the share 0.01 / (0.01 + 0.0016) is
        // applied, so that it ends at 0.594 m. Across, the variance stays; along, 0.01 * 0.0016 / 0.0116 = 0.00138 remain.
        assert_abs_diff_eq!(tracks[0].position.length(), 0.594, epsilon = 1e-3);
        assert_abs_diff_eq!(tracks[0].position.normalize(), before.position.normalize(), epsilon = 1e-6);
        let along = before.position.normalize();
        assert_abs_diff_eq!(along.dot(tracks[0].covariance * along), 0.00138, epsilon = 1e-5);
        assert_abs_diff_eq!(along.perp().dot(tracks[0].covariance * along.perp()), 0.01, epsilon = 1e-6);
    }

    #[test]
    fn an_echo_from_elsewhere_says_nothing_of_a_robot() {
        let mut tracks = Vec::new();
        see_robot(&mut tracks, Team::Pink, &sighting(0.5, -0.3), &TrackModel::default());
        let before = tracks.clone();
        // The left sonar, and a robot too far away.
        hear_robot(&mut tracks, 0.5, 0.34, 0.314, &SonarModel::default());
        hear_robot(&mut tracks, 0.15, -0.34, 0.314, &SonarModel::default());
        assert_eq!(tracks, before);
    }

    #[test]
    fn a_team_mate_that_is_seen_after_its_report_is_where_it_is_seen() {
        let id = Some(naoisis_core::team::RobotId::new(Team::Blue, 3));
        let robot =
            |id, x, age_s| RobotBelief { id, position_m: Vec2::new(x, 0.0), covariance: [0.01, 0.0, 0.01], age_s };
        let known = |told_s: f32, seen_m: f32, seen_s: f32| {
            let mut team_mates = vec![robot(id, 1.0, told_s)];
            add_seen_mate(&mut team_mates, 1, robot(None, seen_m, seen_s));
            team_mates
        };
        assert_eq!(known(4.0, 1.5, 0.0), [robot(id, 1.5, 0.0)]);
        assert_eq!(known(0.5, 1.5, 2.0), [robot(id, 1.0, 0.5)], "what it told is news");
        assert_eq!(known(4.0, 2.0, 0.0), [robot(id, 1.0, 4.0), robot(None, 2.0, 0.0)], "another one");
    }
}
