//! Checks invariants of the true state and of what robots sense, hear and believe, after every cycle. A violation is a bug. It is reported
//! as an event and a warning, and the match continues, so that its record can be examined.

use bevy::ecs::query::QueryData;
use bevy::log::warn;
use bevy::prelude::*;

use naoisis_core::ball::flight::BallFlight;
use naoisis_core::ball::{BallPath, BallPhysics, BallVelocity};
use naoisis_core::communication::Inbox;
use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems};
use naoisis_core::events::{CycleEvents, MatchEvent, PublishEvents};
use naoisis_core::game::Penalty;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::Post;
use naoisis_core::robot::body::{Body, BodyBox};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::{PreviousPose, Roster, Velocity};
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::vision::Percepts;

/// Depth from which on an overlap is a violation, m.
const TOLERANCE: f32 = 1e-4;
/// Depth by which the ball may get deeper into a base or a post in a cycle, m.
const BALL_TOLERANCE: f32 = 1e-3;

/// Checks the invariants in [`CycleSystems::CheckInvariants`].
pub struct InvariantPlugin;

impl Plugin for InvariantPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Cycle, check_invariants.in_set(CycleSystems::CheckInvariants).before(PublishEvents));
    }
}

/// The state of a robot for the invariants.
#[derive(Clone, Copy, Debug)]
pub struct RobotState {
    /// Team and number.
    pub id: RobotId,
    /// Pose at the end of the cycle, pitch frame.
    pub pose: Pose,
    /// Pose at the start of the cycle, pitch frame.
    pub previous: Pose,
    /// Velocity at the end of the cycle, m/s, pitch frame.
    pub velocity: Velocity,
    /// The box that collides with robots and posts, robot frame.
    pub torso: BodyBox,
    /// The box that collides with the ball, robot frame.
    pub base: BodyBox,
}

/// The values that a robot senses, hears and believes, which must be finite.
#[derive(QueryData)]
struct EstimatedState {
    head: &'static HeadAngles,
    odometry: &'static Odometry,
    sonar: &'static SonarReading,
    percepts: &'static Percepts,
    inbox: &'static Inbox,
    belief: Option<&'static Belief>,
}

/// The state of the ball for the invariants.
#[derive(Clone, Copy, Debug)]
pub struct BallState {
    /// Its centre at the end of the cycle, m, pitch frame.
    pub position: Vec2,
    /// Its centre at the start of the cycle, m, pitch frame.
    pub previous: Vec2,
    /// Its velocity at the end of the cycle, m/s, pitch frame.
    pub velocity: Vec2,
    /// Its radius, m.
    pub radius: f32,
    /// Whether the ball was on the ground during the whole cycle. In the air it may be above a robot or post.
    pub is_on_ground: bool,
}

fn check_invariants(
    (mut robots_now, mut posts_now, mut balls_now): (
        Local<Vec<RobotState>>,
        Local<Vec<(Vec2, f32)>>,
        Local<Vec<BallState>>,
    ),
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    mut events: ResMut<CycleEvents>,
    robots: Query<(&Pose, &PreviousPose, &Velocity, &Body, &Penalty, Option<EstimatedState>)>,
    posts: Query<(&Pose, &Post)>,
    balls: Query<(&Pose, &PreviousPose, &BallVelocity, &BallPhysics, &BallFlight, &BallPath)>,
) {
    let mut report = |message| {
        warn!("cycle {}: {message}", clock.cycle);
        events.push(MatchEvent::InvariantBroken { message });
    };
    robots_now.clear();
    robots_now.extend(roster.iter().filter_map(|(id, entity)| {
        let (pose, previous, velocity, body, penalty, estimated) = robots.get(entity).ok()?;
        if let Some(what) = estimated.and_then(|state| state.first_not_finite()) {
            report(format!("{id}: a number in its {what} is not finite"));
        }
        (!penalty.is_off_pitch()).then_some(RobotState {
            id,
            pose: *pose,
            previous: previous.0,
            velocity: *velocity,
            torso: body.torso,
            base: body.base,
        })
    }));
    balls_now.clear();
    balls_now.extend(balls.iter().map(|(pose, previous, velocity, physics, flight, path)| BallState {
        position: pose.position,
        previous: previous.0.position,
        velocity: velocity.0,
        radius: physics.radius_m,
        is_on_ground: !flight.is_airborne() && !path.start_flight.is_airborne(),
    }));
    posts_now.clear();
    posts_now.extend(posts.iter().map(|(pose, post)| (pose.position, post.radius)));
    broken_invariants(&robots_now, &posts_now, &balls_now, &mut report);
}

impl EstimatedStateItem<'_, '_> {
    /// Returns the first part that has a number which is not finite.
    fn first_not_finite(&self) -> Option<&'static str> {
        let parts = [
            ("head angles", self.head.yaw.is_finite() && self.head.pitch.is_finite()),
            ("odometry", self.odometry.0.is_finite()),
            ("sonars", [self.sonar.left, self.sonar.right].into_iter().flatten().all(f32::is_finite)),
            ("percepts", self.percepts.is_finite()),
            ("inbox", self.inbox.0.iter().all(|message| message.say.is_finite())),
            ("belief", self.belief.is_none_or(Belief::is_finite)),
        ];
        parts.into_iter().find(|(_, is_finite)| !is_finite).map(|(what, _)| what)
    }
}

/// Reports every violated invariant: numbers must be finite, torsos must not overlap each other or posts, and the ball must not get deeper
/// into a base or a post.
pub fn broken_invariants(
    robots: &[RobotState],
    posts: &[(Vec2, f32)],
    balls: &[BallState],
    mut report: impl FnMut(String),
) {
    // Most robots are far apart. A look at the widest one needs no rectangles.
    let widest = robots.iter().map(|robot| robot.torso.reach()).fold(0.0, f32::max);
    for (index, robot) in robots.iter().enumerate() {
        let finite = robot.pose.is_finite() && robot.velocity.linear.is_finite() && robot.velocity.angular.is_finite();
        if !finite {
            report(format!("{}: pose or velocity is not finite", robot.id));
            continue;
        }
        let torso = &robot.torso;
        for other in &robots[index + 1..] {
            if !is_within(robot.pose.position, other.pose.position, 2.0 * widest) {
                continue;
            }
            if let Some(overlap) = torso.footprint(robot.pose).overlap(&other.torso.footprint(other.pose))
                && overlap.depth > TOLERANCE
            {
                report(format!("{} and {} overlap by {} m", robot.id, other.id, overlap.depth));
            }
        }
        for &(centre, radius) in posts {
            if is_within(robot.pose.position, centre, widest + radius)
                && let Some(overlap) = torso.footprint(robot.pose).overlap_disc(centre, radius)
                && overlap.depth > TOLERANCE
            {
                report(format!("{} overlaps the post at {centre} by {} m", robot.id, overlap.depth));
            }
        }
        let in_reach = |ball: &&BallState| {
            ball.is_on_ground && is_within(robot.pose.position, ball.position, robot.base.reach() + ball.radius)
        };
        for ball in balls.iter().filter(in_reach) {
            let now = robot.base.footprint(robot.pose).signed_distance(ball.position).0;
            let before = robot.base.footprint(robot.previous).signed_distance(ball.previous).0;
            if now < before.min(ball.radius) - BALL_TOLERANCE {
                report(format!("the ball got {} m into {}", ball.radius - now, robot.id));
            }
        }
    }
    for ball in balls {
        if !(ball.position.is_finite() && ball.velocity.is_finite()) {
            report("the ball's position or velocity is not finite".to_owned());
        }
        // A ball in the air may be above a post.
        for &(centre, radius) in posts.iter().filter(|_| ball.is_on_ground) {
            let [now, before] = [ball.position, ball.previous].map(|place| place.distance(centre) - radius);
            if now < before.min(ball.radius) - BALL_TOLERANCE {
                report(format!("the ball got {} m into the post at {centre}", ball.radius - now));
            }
        }
    }
}

fn is_within(place: Vec2, other: Vec2, distance: f32) -> bool {
    place.distance_squared(other) < distance * distance
}
