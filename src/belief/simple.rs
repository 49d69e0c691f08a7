//! A simple estimator: odometry carries the robot's pose along, goal posts and marks on the ground correct it; ball
//! and robots are remembered as seen, and team-mates tell of themselves and of the ball.
//!
//! It is honest: it reads what the robot senses and is told, and passes the same
//! [barrier](crate::behaviour::barrier) as behaviours do.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::ball::{BallEstimate, BallModel, LENS_HEIGHT_M};
use super::localisation::{PoseEstimate, Sighting, StepError, pose_from_two};
use super::robots::{RobotTrack, TrackModel, advance_tracks, see_robot};
use super::{BallBelief, Belief, RobotBelief, place_covariance, pose_covariance};
use crate::behaviour::{DecideSystems, barrier};
use crate::communication::{Inbox, ReceivedMessage};
use crate::cycle::{Cycle, CycleClock};
use crate::geometry::Pose;
use crate::knowledge::Knowledge;
use crate::pitch::{End, GoalColour, JunctionShape, Pitch};
use crate::referee::{GameState, GameStatus, Rules, formation};
use crate::robot::head::HeadAngles;
use crate::robot::{RobotId, Team};
use crate::sensing::camera::CameraSettings;
use crate::sensing::odometry::Odometry;
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, Percepts};

/// Updates the [`Belief`] of robots with [`SimpleBelief`] in [`DecideSystems::Believe`].
///
/// Needs the plugins whose sensors it reads to be added before.
pub struct SimpleBeliefPlugin;

impl Plugin for SimpleBeliefPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Belief>().register_type::<SimpleBelief>().register_type::<SimpleBeliefMemory>();
        let mut system = IntoSystem::into_system(estimate);
        match barrier::inspect::<SimpleBelief>("simple belief", &mut system, app.world_mut()) {
            Ok(()) => app.add_systems(Cycle, system.in_set(DecideSystems::Believe)),
            Err(error) => panic!("{error}"),
        };
    }
}

/// The settings of the simple estimator; it keeps the belief of robots that have them.
#[derive(Component, Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[require(Belief, SimpleBeliefMemory)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct SimpleBelief {
    /// How much walking adds to the doubt about the pose.
    pub step_error: StepError,
    /// Expected error of the angle at which a goal post's foot is seen: standard deviation, radians. 3 pixels at 361
    /// pixels of focal length are 0.0083.
    pub goal_post_angle_sd: f32,
    /// The same for marks on the ground, radians.
    pub mark_angle_sd: f32,
    /// The same for the ball, radians.
    pub ball_angle_sd: f32,
    /// The same for robots, radians.
    pub robot_angle_sd: f32,
    /// What is seen further from the expectation than this is not the landmark that it is taken for: squared
    /// Mahalanobis distance.
    pub landmark_gate: f32,
    /// After so many goal posts more out of place than in place, the robot doubts its pose.
    pub contradictions: u32,
    /// How the ball is expected to behave.
    pub ball: BallModel,
    /// A ball not seen for so long is forgotten, s.
    pub ball_forget_s: f32,
    /// A ball not seen where it should be for so long is forgotten, s.
    pub ball_missing_s: f32,
    /// A ball not seen for so long is where a team-mate sees it, s.
    pub ball_trust_s: f32,
    /// How robots are tracked.
    pub robots: TrackModel,
    /// What a team-mate said is forgotten after this time, s.
    pub message_forget_s: f32,
}

impl Default for SimpleBelief {
    fn default() -> Self {
        Self {
            step_error: StepError::default(),
            goal_post_angle_sd: 0.01,
            mark_angle_sd: 0.005,
            ball_angle_sd: 0.005,
            robot_angle_sd: 0.01,
            landmark_gate: 12.0,
            contradictions: 8,
            ball: BallModel::default(),
            ball_forget_s: 6.0,
            ball_missing_s: 1.0,
            ball_trust_s: 1.0,
            robots: TrackModel::default(),
            message_forget_s: 2.0,
        }
    }
}

/// What the simple estimator remembers from cycle to cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
pub struct SimpleBeliefMemory {
    /// Whether it has begun.
    begun: bool,
    /// The robot's own pose.
    own: PoseEstimate,
    /// Since a landmark confirmed it, s.
    own_age_s: f32,
    /// The odometry of the last cycle.
    odometry: Pose,
    /// How often the robots had been placed.
    restarts: u32,
    /// Whether the robot was penalised.
    penalised: bool,
    /// How much goal posts contradict the pose and the pose turned by half a turn, while the robot does not know which
    /// of the two it has.
    sides: Option<[f32; 2]>,
    /// Goal posts seen out of place, less those seen in place.
    contradictions: u32,
    /// The ball.
    ball: Option<BallEstimate>,
    /// Other robots.
    tracks: Vec<RobotTrack>,
    /// What team-mates said, ordered by their ids.
    heard: Vec<Heard>,
}

/// What a team-mate said last.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
struct Heard {
    from: RobotId,
    /// Its place, m, team frame.
    position: Option<Vec2>,
    /// Where it sees the ball, m, team frame.
    ball: Option<Vec2>,
    age_s: f32,
}

/// Goal posts seen while it is decided which of two poses the robot has.
const SIDE_DECISION: f32 = 25.0;
/// The doubt about the pose of a robot that was placed, m and radians.
const PLACED_SD: [f32; 2] = [0.03, 0.02];
/// The doubt about the pose of a robot that comes back from a penalty: it may have been put down a little elsewhere.
const RETURNED_SD: [f32; 2] = [0.4, 0.1];
/// The doubt that is added when what is seen contradicts the pose.
const LOST_SD: [f32; 2] = [0.5, 0.4];
/// A post whose foot is not in the image is measured by its top or its width, so much worse.
const HIDDEN_FOOT_FACTOR: f32 = 4.0;
/// Marks on the ground are taken for the nearest of their kind if that is not further away than this, m.
const MARK_GATE_M: f32 = 0.6;
/// A seen and a heard team-mate nearer to each other than this are one, m.
const SAME_ROBOT_M: f32 = 0.6;

/// The places of all marks on the ground. They are the same for both teams, as the pitch looks the same from both ends.
struct Marks {
    junctions: Vec<(JunctionShape, Vec2)>,
    crosses: [Vec2; 2],
    half_width: f32,
    /// Goal posts in the frame of the team that defends -x.
    posts: [(GoalColour, Vec2); 4],
}

impl Marks {
    fn of(pitch: &Pitch) -> Self {
        let [own_cross, cross, _] = pitch.marks();
        Self {
            junctions: pitch.line_junctions().iter().map(|junction| (junction.shape, junction.position)).collect(),
            crosses: [own_cross, cross],
            half_width: pitch.half_width(),
            posts: pitch.goal_posts().map(|post| (post.colour, post.position)),
        }
    }

    /// The goal posts in the frame of the team that defends `own_end`.
    fn posts(&self, own_end: End) -> [(GoalColour, Vec2); 4] {
        self.posts.map(|(colour, place)| (colour, super::point_team_from_pitch(place, own_end)))
    }
}

fn estimate(
    mut marks: Local<Option<Marks>>,
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    rules: Res<Rules>,
    mut robots: Query<(
        &RobotId,
        &SimpleBelief,
        &GameStatus,
        &Odometry,
        &HeadAngles,
        &CameraSettings,
        &Percepts,
        &Inbox,
        &mut SimpleBeliefMemory,
        &mut Belief,
    )>,
) {
    if pitch.is_changed() {
        *marks = None;
    }
    let marks = marks.get_or_insert_with(|| Marks::of(&pitch));
    let period = clock.period();
    for (&id, settings, status, odometry, &head, camera, percepts, inbox, mut memory, mut belief) in &mut robots {
        let place = || formation(&pitch, rules.team_size, id.number, End::NegativeX, id.team == status.kick_off_team);
        memory.begin_cycle(belief.pose, odometry.0, status, marks, place);
        memory.pass_time(odometry.0, settings, period);
        memory.listen(&inbox.0);
        if !status.penalised {
            let image = Vec2::new(camera.width as f32, camera.height as f32);
            memory.localise(percepts, &marks.posts(status.own_end), marks, image, settings);
            memory.watch_ball(percepts, head, settings, period);
            memory.watch_robots(percepts, settings);
        }
        memory.write(&mut belief, id.team, settings);
    }
}

impl SimpleBeliefMemory {
    /// Takes note of having been placed for a kick-off, sent off, or let in again.
    fn begin_cycle(
        &mut self,
        start: Pose,
        odometry: Pose,
        status: &GameStatus,
        marks: &Marks,
        kick_off_place: impl FnOnce() -> Pose,
    ) {
        if !self.begun {
            self.begun = true;
            self.odometry = odometry;
            self.restarts = status.restarts;
            self.own = PoseEstimate::new(start, PLACED_SD[0], PLACED_SD[1]);
        }
        if status.restarts != self.restarts {
            self.restarts = status.restarts;
            if !status.penalised {
                self.place_for_kick_off(kick_off_place());
            }
        }
        if self.penalised && !status.penalised && status.state != GameState::Finished {
            self.come_back(marks.half_width);
        }
        self.penalised = status.penalised;
    }

    fn place_for_kick_off(&mut self, pose: Pose) {
        self.own = PoseEstimate::new(pose, PLACED_SD[0], PLACED_SD[1]);
        self.own_age_s = 0.0;
        self.sides = None;
        self.contradictions = 0;
        self.tracks.clear();
        // The ball lies on the centre mark; a look will tell.
        let sighting = Sighting {
            place_in_robot: pose.inverse_transform_point(Vec2::ZERO),
            variance_along: 0.01,
            variance_across: 0.01,
        };
        self.ball = Some(BallEstimate::first_seen(&sighting, &BallModel { start_speed_sd: 0.05, ..default() }));
    }

    /// Back from a penalty: at the halfway line's end on the side away from the ball, facing the other side (2010 rule
    /// book, section 4). Where the ball is may not be known, so which end it is must be seen.
    fn come_back(&mut self, half_width: f32) {
        let ball = self.heard.iter().find_map(|heard| heard.ball);
        let side = if ball.is_some_and(|ball| ball.y > 0.0) { -1.0 } else { 1.0 };
        let pose = Pose::new(0.0, side * half_width, -side * core::f32::consts::FRAC_PI_2);
        self.own = PoseEstimate::new(pose, RETURNED_SD[0], RETURNED_SD[1]);
        self.sides = Some([0.0; 2]);
        self.contradictions = 0;
        self.tracks.clear();
        self.ball = None;
    }

    /// Everything moves and ages by a cycle.
    fn pass_time(&mut self, odometry: Pose, settings: &SimpleBelief, period: f32) {
        let moved = odometry != self.odometry;
        let step = if moved { self.odometry.relative(odometry) } else { Pose::default() };
        self.odometry = odometry;
        if moved && !self.penalised {
            self.own = self.own.moved_by(step, &settings.step_error);
        }
        self.own_age_s += period;
        self.ball = self.ball.map(|ball| ball.advanced(step, period, &settings.ball));
        advance_tracks(&mut self.tracks, step, period, &settings.robots);
        self.heard.retain_mut(|heard| {
            heard.age_s += period;
            heard.age_s < settings.message_forget_s
        });
    }

    fn listen(&mut self, messages: &[ReceivedMessage]) {
        for message in messages {
            let said = Heard {
                from: message.from,
                position: message.say.pose.map(|pose| pose.position),
                ball: message.say.ball_m,
                age_s: 0.0,
            };
            match self.heard.binary_search_by_key(&message.from, |heard| heard.from) {
                Ok(index) => self.heard[index] = said,
                Err(index) => self.heard.insert(index, said),
            }
        }
    }

    /// Corrects the pose by what is seen of the pitch.
    fn localise(
        &mut self,
        percepts: &Percepts,
        posts: &[(GoalColour, Vec2); 4],
        marks: &Marks,
        image: Vec2,
        settings: &SimpleBelief,
    ) {
        if !percepts.goal_posts.is_empty() {
            if self.sides.is_some() {
                self.choose_side(&percepts.goal_posts, posts, settings);
            }
            self.see_goal_posts(&percepts.goal_posts, posts, image, settings);
        }
        for mark in &percepts.landmarks {
            let seen = match mark.kind {
                LandmarkKind::Junction { shape } => {
                    let alike = marks.junctions.iter().filter(|(other, _)| *other == shape);
                    self.nearest(mark.position_m, alike.map(|(_, place)| *place))
                }
                LandmarkKind::PenaltyCross => self.nearest(mark.position_m, marks.crosses),
                LandmarkKind::CentreCircle => self.nearest(mark.position_m, [Vec2::ZERO]),
                LandmarkKind::Line { .. } => None,
            };
            let Some((place, distance)) = seen else { continue };
            if distance < MARK_GATE_M {
                let sighting = Sighting::on_ground(mark.position_m, settings.mark_angle_sd, LENS_HEIGHT_M);
                self.correct(place, &sighting, settings.landmark_gate);
            }
        }
    }

    fn see_goal_posts(
        &mut self,
        seen: &[GoalPostPercept],
        posts: &[(GoalColour, Vec2); 4],
        image: Vec2,
        settings: &SimpleBelief,
    ) {
        for post in seen {
            let alike = posts.iter().filter(|(colour, _)| *colour == post.colour);
            let Some((place, _)) = self.nearest(post.position_m, alike.map(|(_, place)| *place)) else { continue };
            let foot_in_image = post.pixel.cmpge(Vec2::ZERO).all() && post.pixel.cmple(image).all();
            let factor = if foot_in_image { 1.0 } else { HIDDEN_FOOT_FACTOR };
            let mut sighting = Sighting::on_ground(post.position_m, settings.goal_post_angle_sd, LENS_HEIGHT_M);
            sighting.variance_along *= factor * factor;
            if self.correct(place, &sighting, settings.landmark_gate) {
                self.contradictions = self.contradictions.saturating_sub(1);
            } else {
                self.contradictions += 1;
            }
        }
        if self.contradictions > settings.contradictions {
            self.contradictions = 0;
            self.own = self.own.doubted(LOST_SD[0], LOST_SD[1]);
            self.start_from_goal(seen, posts);
        }
    }

    /// A lost robot that sees both posts of a goal knows where it is.
    fn start_from_goal(&mut self, seen: &[GoalPostPercept], posts: &[(GoalColour, Vec2); 4]) {
        let [first, second] = match seen {
            [first, second] if first.colour == second.colour => [first, second],
            _ => return,
        };
        // The left one, seen from inside the pitch, is at the left in the image.
        let left_first = first.position_m.perp_dot(second.position_m) < 0.0;
        let [left, right] = if left_first { [first, second] } else { [second, first] };
        let doubt = self.own.doubted(LOST_SD[0], LOST_SD[1]);
        // Posts come in pairs: the one with lower y first (pitch frame), so that both orders occur in the team frame.
        for goal in posts.chunks_exact(2).filter(|goal| goal[0].0 == left.colour) {
            let outwards = goal[0].1.x.signum();
            let left_is_first = goal[0].1.y * outwards > goal[1].1.y * outwards;
            let places = if left_is_first { [goal[0].1, goal[1].1] } else { [goal[1].1, goal[0].1] };
            let pose = pose_from_two(places, [left.position_m, right.position_m]);
            // With two goals of one colour, that in front of which the robot thinks that it is.
            let turned = pose.forward().dot(self.own.pose.forward()) < 0.0;
            let unique = posts.iter().filter(|(colour, _)| *colour == left.colour).count() == 2;
            if unique || !turned {
                self.own = PoseEstimate { pose, covariance: doubt.covariance };
                return;
            }
        }
    }

    /// Weighs the pose against the pose turned by half a turn.
    fn choose_side(&mut self, seen: &[GoalPostPercept], posts: &[(GoalColour, Vec2); 4], settings: &SimpleBelief) {
        let Some(mut evidence) = self.sides else { return };
        for post in seen {
            let sighting = Sighting::on_ground(post.position_m, settings.goal_post_angle_sd, LENS_HEIGHT_M);
            for (pose, sum) in [self.own.pose, self.own.pose.turned_half()].into_iter().zip(&mut evidence) {
                let own = PoseEstimate { pose, ..self.own };
                let forward = pose.forward();
                let least = posts
                    .iter()
                    .filter(|(colour, _)| *colour == post.colour)
                    .map(|(_, place)| own.innovation(forward, *place, &sighting).distance_squared)
                    .fold(SIDE_DECISION, f32::min);
                *sum += least;
            }
        }
        self.sides = Some(evidence);
        let [this, other] = evidence;
        if (this - other).abs() > SIDE_DECISION {
            self.sides = None;
            if other < this {
                self.own.pose = self.own.pose.turned_half();
            }
        }
    }

    /// The nearest of some places to where something is seen, and how far from there it is, m.
    fn nearest(&self, place_in_robot: Vec2, places: impl IntoIterator<Item = Vec2>) -> Option<(Vec2, f32)> {
        let seen = self.own.pose.transform_point(place_in_robot);
        places
            .into_iter()
            .map(|place| (place, place.distance_squared(seen)))
            .min_by(|(_, first), (_, second)| first.total_cmp(second))
            .map(|(place, distance_squared)| (place, distance_squared.sqrt()))
    }

    /// Corrects the pose by a landmark, unless that is too unlikely. Returns whether it was.
    fn correct(&mut self, landmark: Vec2, sighting: &Sighting, gate: f32) -> bool {
        let innovation = self.own.innovation(self.own.pose.forward(), landmark, sighting);
        let likely = innovation.distance_squared < gate;
        if likely {
            self.own = self.own.corrected(&innovation);
            self.own_age_s = 0.0;
        }
        likely
    }

    fn watch_ball(&mut self, percepts: &Percepts, head: HeadAngles, settings: &SimpleBelief, period: f32) {
        if let Some(seen) = &percepts.ball {
            let sighting = Sighting::on_ground(seen.position_m, settings.ball_angle_sd, LENS_HEIGHT_M);
            self.ball = Some(match &self.ball {
                Some(ball) => ball.seen(&sighting, &settings.ball),
                None => BallEstimate::first_seen(&sighting, &settings.ball),
            });
        } else if let Some(ball) = &mut self.ball {
            if ball.should_be_seen(head.yaw, head.pitch) {
                ball.missing_s += period;
            }
            if ball.age_s > settings.ball_forget_s || ball.missing_s > settings.ball_missing_s {
                self.ball = None;
            }
        }
    }

    fn watch_robots(&mut self, percepts: &Percepts, settings: &SimpleBelief) {
        for seen in &percepts.robots {
            let sighting = Sighting::on_ground(seen.position_m, settings.robot_angle_sd, LENS_HEIGHT_M);
            see_robot(&mut self.tracks, seen.team, &sighting, &settings.robots);
        }
    }

    fn write(&self, belief: &mut Belief, team: Team, settings: &SimpleBelief) {
        let pose = self.own.pose;
        let forward = pose.forward();
        let turn = Mat2::from_cols(forward, forward.perp());
        let turned = |covariance: Mat2| place_covariance(turn * covariance * turn.transpose());
        let to_team = |place: Vec2| pose.position + forward.rotate(place);
        belief.pose = pose;
        belief.pose_covariance = pose_covariance(self.own.covariance);
        belief.pose_age_s = self.own_age_s;
        let seen = self.ball.map(|ball| BallBelief {
            position_m: to_team(ball.position),
            velocity_mps: forward.rotate(ball.credible_velocity(&settings.ball)),
            position_covariance: turned(ball.position_covariance),
            velocity_covariance: turned(ball.velocity_covariance),
            age_s: ball.age_s,
            heard_from: None,
        });
        belief.ball = match seen {
            Some(ball) if ball.age_s < settings.ball_trust_s => seen,
            _ => self.heard_ball(settings).or(seen),
        };
        belief.team_mates.clear();
        belief.opponents.clear();
        belief.team_mates.extend(self.heard.iter().filter_map(|heard| {
            Some(RobotBelief {
                id: Some(heard.from),
                position_m: heard.position?,
                covariance: [0.04, 0.0, 0.04],
                age_s: heard.age_s,
            })
        }));
        let heard_count = belief.team_mates.len();
        for track in self.tracks.iter().filter(|track| track.sightings > 1) {
            let robot = RobotBelief {
                id: None,
                position_m: to_team(track.position),
                covariance: turned(track.covariance),
                age_s: track.age_s,
            };
            if track.team != team {
                belief.opponents.push(robot);
                continue;
            }
            let told = &belief.team_mates[..heard_count];
            if told.iter().all(|told| told.position_m.distance_squared(robot.position_m) > SAME_ROBOT_M * SAME_ROBOT_M)
            {
                belief.team_mates.push(robot);
            }
        }
    }

    /// The ball as the team-mate says who is nearest to it.
    fn heard_ball(&self, settings: &SimpleBelief) -> Option<BallBelief> {
        let distance = |heard: &Heard| {
            heard.ball.zip(heard.position).map_or(f32::MAX, |(ball, position)| ball.distance_squared(position))
        };
        let nearest = self
            .heard
            .iter()
            .filter(|heard| heard.ball.is_some() && heard.age_s < settings.ball_trust_s)
            .min_by(|first, second| distance(first).total_cmp(&distance(second)))?;
        Some(BallBelief {
            position_m: nearest.ball?,
            velocity_mps: Vec2::ZERO,
            position_covariance: [0.06, 0.0, 0.06],
            velocity_covariance: [0.25, 0.0, 0.25],
            age_s: nearest.age_s,
            heard_from: Some(nearest.from),
        })
    }
}
