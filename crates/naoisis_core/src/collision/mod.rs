//! Collisions between robots, posts and ball (paper, section 3.2).
//!
//! In [`CycleSystems::Collide`] first the collisions of robots are resolved, then those of the ball along its path. Torsos collide
//! with torsos and posts; the ball collides with bases, posts and the goals' frames. See [`robots`] and [`ball`] for the two
//! models.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;

pub mod ball;
pub mod ball_obstacle;
mod balls;
mod bodies;
mod flight;
pub mod footprints;
pub mod robots;

use crate::ball::flight::BallFlight;
use crate::ball::{Ball, BallPath, BallPhysics, BallVelocity, ExtraBall, REST_SPEED_MPS, RollingBall};
use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::{CollisionPartner, CollisionType, Contacts, CycleEvents, MatchEvent};
use crate::game::{Penalty, Rules};
use crate::geometry::{Pose, wrap_angle};
use crate::pitch::{Pitch, Post};
use crate::random::RandomStreams;
use crate::robot::body::{Body, BodyBox};
use crate::robot::gait::GaitState;
use crate::robot::motion::MotionSettings;
use crate::robot::posture::Posture;
use crate::robot::{PreviousPose, Roster, Velocity};
use crate::team::RobotId;
use ball::{BallContact, roll_ball};
use ball_obstacle::{BallObstacle, SwingingFoot};
use balls::MovingBall;
use flight::{Solid, fly_ball, solids_of_goals, solids_of_robot};
use robots::{Cylinder, RobotBody, RobotContact, SeparationWorkspace, Touched, hold_back_from_end, resolve_robots};

/// Collisions of robots, posts and ball, in [`CycleSystems::Collide`].
pub struct CollisionPlugin;

impl Plugin for CollisionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Contacts>()
            .register_type::<Contacts>()
            .add_systems(Cycle, collide.in_set(CycleSystems::Collide));
    }
}

/// A collision in the current cycle.
#[derive(Clone, Copy, Debug)]
struct Collision {
    robot: Option<RobotId>,
    with: CollisionPartner,
    collision_type: CollisionType,
    speed: f32,
    position: Vec2,
}

/// The buffers of [`collide`], kept between cycles so that a steady match allocates nothing.
#[derive(Default)]
struct Scratch {
    ids: Vec<RobotId>,
    entities: Vec<Entity>,
    bases: Vec<BodyBox>,
    feet: Vec<SwingingFoot>,
    bodies: Vec<RobotBody>,
    cylinders: Vec<Cylinder>,
    obstacles: Vec<BallObstacle>,
    solids: Vec<Solid>,
    workspace: SeparationWorkspace,
    robot_contacts: Vec<RobotContact>,
    /// The contacts of all balls with robots and posts, and those of the ball that has just moved.
    ball_contacts: Vec<BallContact>,
    new_contacts: Vec<BallContact>,
    balls: Vec<MovingBall>,
    /// The indices of the balls that are in the way of the one that moves.
    others: Vec<usize>,
    held: Vec<bool>,
    /// Strips that dives and lying robots block: the index of the body, the pose of the strip in the robot frame, and its box.
    strips: Vec<(usize, Pose, BodyBox)>,
    collisions: Vec<Collision>,
}

/// A robot that may collide.
#[derive(QueryData)]
#[query_data(mutable)]
struct CollidingRobot {
    pose: &'static mut Pose,
    previous: &'static PreviousPose,
    bounds: &'static Body,
    motion: &'static MotionSettings,
    penalty: &'static Penalty,
    posture: &'static Posture,
    velocity: &'static mut Velocity,
    gait: &'static GaitState,
    streams: &'static mut RandomStreams,
}

/// A ball that may collide.
#[derive(QueryData)]
#[query_data(mutable)]
struct CollidingBall {
    entity: Entity,
    which: Option<&'static ExtraBall>,
    pose: &'static mut Pose,
    previous: &'static PreviousPose,
    physics: &'static BallPhysics,
    velocity: &'static mut BallVelocity,
    flight: &'static mut BallFlight,
    path: &'static mut BallPath,
}

fn collide(
    mut scratch: Local<Scratch>,
    roster: Res<Roster>,
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    mut contacts: ResMut<Contacts>,
    mut events: ResMut<CycleEvents>,
    posts: Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
    rules: Res<Rules>,
    mut robots: Query<CollidingRobot, With<RobotId>>,
    mut balls: Query<CollidingBall, (Without<RobotId>, Without<Post>)>,
) {
    let scratch = &mut *scratch;
    let duration = clock.period();
    scratch.gather(&roster, &posts, robots.as_readonly(), rules.dive_reach_m, duration);
    resolve_robots(&mut scratch.bodies, &scratch.cylinders, &mut scratch.workspace, &mut scratch.robot_contacts);
    scratch.gather_balls(balls.iter());
    scratch.swing_feet(&mut robots);
    for index in 0..scratch.balls.len() {
        if let Ok(ball) = balls.get_mut(scratch.balls[index].entity) {
            scratch.move_ball(index, ball, &pitch, &posts, robots.as_readonly(), duration);
        }
    }
    for ball in &mut scratch.balls {
        let push = ball.take_push();
        if let (true, Ok(mut ball)) = (push != Vec2::ZERO, balls.get_mut(ball.entity)) {
            ball.velocity.0 += push;
        }
    }
    scratch.describe_collisions(duration);
    let began = contacts.update(scratch.collisions.iter().map(|collision| (collision.robot, collision.with)));
    let collisions = began.iter().map(|index| scratch.collisions[*index]);
    events.extend(collisions.map(|collision| MatchEvent::Collision {
        robot: collision.robot,
        with: collision.with,
        collision_type: collision.collision_type,
        speed_mps: collision.speed,
        position_m: collision.position,
    }));
    for (entity, body) in scratch.entities.iter().zip(&scratch.bodies) {
        let Ok(mut robot) = robots.get_mut(*entity) else { continue };
        if *robot.pose != body.end {
            *robot.pose = body.end;
        }
        *robot.velocity = Velocity {
            linear: (body.end.position - body.start.position) / duration,
            angular: wrap_angle(body.end.heading - body.start.heading) / duration,
        };
    }
}

impl Scratch {
    fn gather(
        &mut self,
        roster: &Roster,
        posts: &Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
        robots: Query<CollidingRobotReadOnly, With<RobotId>>,
        dive_reach_m: f32,
        duration: f32,
    ) {
        self.ids.clear();
        self.entities.clear();
        self.bases.clear();
        self.bodies.clear();
        self.held.clear();
        self.strips.clear();
        for (id, entity) in roster.iter() {
            let Ok(robot) = robots.get(entity) else { continue };
            if robot.penalty.is_off_pitch() {
                continue;
            }
            if let Some((middle, strip)) = robot.posture.strip(robot.bounds, dive_reach_m) {
                self.strips.push((self.bodies.len(), middle, strip));
            }
            if robot.posture.is_fallen() {
                self.strips.push((self.bodies.len(), Pose::default(), robot.bounds.lying_box()));
            }
            self.ids.push(id);
            self.entities.push(entity);
            self.bases.push(robot.bounds.base);
            self.held.push(false);
            self.bodies.push(RobotBody {
                start: robot.previous.0,
                end: *robot.pose,
                torso: robot.bounds.torso,
                most_way: robot.motion.max_linear_mps * duration,
            });
        }
        self.cylinders.clear();
        self.cylinders.extend(posts.iter().map(|(pose, post)| Cylinder { centre: pose.position, radius: post.radius }));
        // Posts have no ids, so they are ordered by position.
        self.cylinders.sort_by(|a, b| a.centre.x.total_cmp(&b.centre.x).then(a.centre.y.total_cmp(&b.centre.y)));
    }

    /// Sets the feet of the robots that walk near a ball.
    fn swing_feet(&mut self, robots: &mut Query<CollidingRobot, With<RobotId>>) {
        self.feet.clear();
        for ((entity, body), base) in self.entities.iter().zip(&self.bodies).zip(&self.bases) {
            let is_near = |ball: &MovingBall| ball.is_within(body.end.position, base.reach());
            let near = self.balls.iter().any(is_near).then(|| robots.get_mut(*entity).ok());
            let foot = near.flatten().and_then(|mut robot| {
                let gait = robot.motion.gait.as_ref()?;
                let velocity = robot.gait.foot_velocity(gait);
                if velocity == Vec2::ZERO {
                    return None;
                }
                let deflection = gait.touch.deflection(&mut robot.streams.kick);
                Some(SwingingFoot { velocity: body.end.forward().rotate(velocity), deflection })
            });
            self.feet.push(foot.unwrap_or_default());
        }
    }

    /// Moves a ball among robots, posts and the other balls.
    fn move_ball(
        &mut self,
        index: usize,
        ball: CollidingBallItem,
        pitch: &Pitch,
        posts: &Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
        robots: Query<CollidingRobotReadOnly, With<RobotId>>,
        duration: f32,
    ) {
        let CollidingBallItem { mut pose, previous, physics, mut velocity, mut flight, mut path, .. } = ball;
        let push = self.balls[index].take_push();
        if push != Vec2::ZERO {
            path.start_velocity += push;
        }
        let is_flying = path.start_flight.is_airborne();
        self.set_other_balls(index, is_flying);
        let first_ball = if is_flying {
            let start = physics.flying_ball(previous.0.position, path.start_velocity, path.start_flight);
            let first_ball = self.set_solids(pitch, posts, robots);
            let BallPath { corners, heights_m, .. } = &mut *path;
            let end = fly_ball(start, &self.solids, duration, &mut self.new_contacts, corners, heights_m);
            (pose.position, velocity.0) = (end.position.truncate(), end.velocity.truncate());
            *flight = end.flight();
            first_ball
        } else {
            let start = physics.rolling_ball(previous.0.position, path.start_velocity);
            let first_ball = self.set_obstacles(pitch, start.position);
            let rolled = roll_ball(start, &self.obstacles, duration, &mut self.new_contacts, &mut path.corners);
            let end = rolled.unwrap_or_else(|| {
                self.hold_back_from_wedged_ball(start.position, start.radius);
                path.corners.clear();
                path.corners.extend([start.position; 2]);
                RollingBall { velocity: Vec2::ZERO, ..start }
            });
            (pose.position, velocity.0) = (end.position, end.velocity);
            first_ball
        };
        self.balls[index].end = pose.position;
        let change = self.share_motion(first_ball, physics.restitution);
        if change != Vec2::ZERO && velocity.0 != Vec2::ZERO {
            velocity.0 += change;
        }
    }

    /// Collects the obstacles of a ball at `ball`: the robots' bases, in the order of the bodies, then the strips that dives and lying
    /// robots block, then posts and bars, then the other balls. Returns the index of the first of these.
    fn set_obstacles(&mut self, pitch: &Pitch, ball: Vec2) -> usize {
        self.obstacles.clear();
        let parts = self.bodies.iter().zip(&self.bases).zip(&self.feet);
        self.obstacles.extend(parts.map(|((body, base), foot)| BallObstacle::Base {
            start: body.start,
            end: body.end,
            base: *base,
            foot: *foot,
        }));
        self.obstacles.extend(self.strips.iter().map(|(body, middle, strip)| {
            let pose = self.bodies[*body].end.compose(*middle);
            // A ball on which a robot has fallen may roll out: only the base stops it.
            let is_under = strip.footprint(pose).signed_distance(ball).0 < 0.0;
            let shape = if is_under { self.bases[*body] } else { *strip };
            BallObstacle::base(pose, pose, shape)
        }));
        self.obstacles.extend(
            self.cylinders
                .iter()
                .map(|cylinder| BallObstacle::Cylinder { centre: cylinder.centre, radius: cylinder.radius }),
        );
        if pitch.goal.ground_bars {
            let radius = pitch.goal.bar_diameter_m / 2.0;
            self.obstacles.extend(pitch.ground_bars().map(|bar| BallObstacle::Bar {
                start: bar.start,
                end: bar.end,
                radius,
            }));
        }
        let first_ball = self.obstacles.len();
        self.obstacles.extend(self.others.iter().map(|&other| self.balls[other].outline().0));
        first_ball
    }

    /// Collects the obstacles of a flying ball: robots, the strips that dives block, posts, crossbars, nets and the other balls. Returns
    /// the index of the first of these.
    fn set_solids(
        &mut self,
        pitch: &Pitch,
        posts: &Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
        robots: Query<CollidingRobotReadOnly, With<RobotId>>,
    ) -> usize {
        self.solids.clear();
        for (index, (entity, moved)) in self.entities.iter().zip(&self.bodies).enumerate() {
            let Ok(robot) = robots.get(*entity) else { continue };
            let body = robot.bounds.in_posture(*robot.posture);
            let is_low = body.height_m < robot.bounds.height_m;
            self.solids.extend(solids_of_robot(index, &body, [moved.start, moved.end], is_low));
        }
        self.solids.extend(self.strips.iter().enumerate().map(|(strip, (body, middle, shape))| {
            let pose = self.bodies[*body].end.compose(*middle);
            let outline = BallObstacle::base(pose, pose, *shape);
            Solid::prism(self.bodies.len() + strip, outline, shape.z_m)
        }));
        let no_robot = self.bodies.len() + self.strips.len();
        let first_post = self.solids.len();
        self.solids.extend(posts.iter().map(|(pose, post)| {
            let outline = BallObstacle::Cylinder { centre: pose.position, radius: post.radius };
            Solid::prism(no_robot, outline, [0.0, post.height])
        }));
        // Posts have no ids, so they are ordered by position.
        self.solids[first_post..].sort_by(|a, b| {
            let [(a, _), (b, _)] = [a, b].map(|solid| solid.outline.bounds());
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
        });
        self.solids.extend(solids_of_goals(no_robot, pitch));
        let first_ball = no_robot + 1;
        self.solids.extend(self.others.iter().zip(first_ball..).map(|(&other, obstacle)| {
            let (outline, z_m) = self.balls[other].outline();
            Solid::prism(obstacle, outline, z_m)
        }));
        first_ball
    }

    /// The index of the body of an obstacle; `None` for posts and bars.
    fn owner_of(&self, obstacle: usize) -> Option<usize> {
        match obstacle.checked_sub(self.bodies.len()) {
            None => Some(obstacle),
            Some(strip) => self.strips.get(strip).map(|(body, ..)| *body),
        }
    }

    /// Holds back robots that would walk into a wedged ball. The ball does not move.
    fn hold_back_from_wedged_ball(&mut self, ball: Vec2, radius: f32) {
        for (held, obstacle) in self.held.iter_mut().zip(&self.obstacles) {
            let (before, after) = (obstacle.signed_distance(ball, 0.0).0, obstacle.signed_distance(ball, 1.0).0);
            *held = after < before.min(radius);
        }
        hold_back_from_end(&mut self.bodies, &self.cylinders, &mut self.held);
    }

    fn describe_collisions(&mut self, duration: f32) {
        self.collisions.clear();
        for contact in &self.robot_contacts {
            let (robot, with, collision_type) = match contact.touched {
                Touched::Cylinder(_) => (contact.robot, CollisionPartner::Post, CollisionType::RobotAndPost),
                Touched::Robot(other) => {
                    let both = contact.robot_moved && contact.touched_moved;
                    let (robot, with) =
                        if contact.robot_moved { (contact.robot, other) } else { (other, contact.robot) };
                    let collision_type =
                        if both { CollisionType::MovingRobots } else { CollisionType::MovingAndStaticRobot };
                    (robot, CollisionPartner::Robot(self.ids[with]), collision_type)
                }
            };
            self.collisions.push(Collision {
                robot: Some(self.ids[robot]),
                with,
                collision_type,
                speed: contact.approach / duration,
                position: contact.point,
            });
        }
        for contact in &self.ball_contacts {
            let rolling = contact.ball_speed > REST_SPEED_MPS;
            let owner = self.owner_of(contact.obstacle);
            let (robot, with, collision_type) = match owner.map(|body| (body, &self.bodies[body])) {
                None => (None, CollisionPartner::Post, CollisionType::BallAndPost),
                Some((index, body)) => {
                    let collision_type = match (body.is_moving(), rolling) {
                        (true, true) => CollisionType::MovingRobotAndMovingBall,
                        (true, false) => CollisionType::MovingRobotAndStaticBall,
                        (false, _) => CollisionType::StandingRobotAndBall,
                    };
                    (Some(self.ids[index]), CollisionPartner::Ball, collision_type)
                }
            };
            self.collisions.push(Collision {
                robot,
                with,
                collision_type,
                speed: contact.approach_speed,
                position: contact.position,
            });
        }
    }
}
