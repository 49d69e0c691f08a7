//! The obstacles of the ball: posts, bars and the bases of walking robots.

use bevy::prelude::*;

use super::footprints::distance_from_segment;
use crate::geometry::{Pose, unit, wrap_angle};
use crate::robot::body::BodyBox;

/// Share of the approach speed that remains after contact with a net, which hangs loosely.
pub(super) const NET_RESTITUTION: f32 = 0.0;

/// The foot of a walking robot, which swings ahead of the body.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct SwingingFoot {
    /// Velocity of the foot relative to the robot, m/s, pitch frame; zero for a robot that stands.
    pub velocity: Vec2,
    /// Angle by which a touched ball leaves to the left of the surface's normal, radians.
    pub deflection: f32,
}

/// An obstacle of the ball.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum BallObstacle {
    /// A post.
    Cylinder {
        /// Its centre, m, pitch frame.
        centre: Vec2,
        /// Radius, m.
        radius: f32,
    },
    /// A bar that lies on the ground and carries a net.
    Bar {
        /// One end of its axis, m.
        start: Vec2,
        /// The other end, m.
        end: Vec2,
        /// Radius, m.
        radius: f32,
    },
    /// The base of a robot that moves from one pose to another during the cycle.
    Base {
        /// The robot's pose at the start of the cycle.
        start: Pose,
        /// The robot's pose at the end of the cycle.
        end: Pose,
        /// The base's box.
        base: BodyBox,
        /// The foot that touches a ball ahead of the base.
        foot: SwingingFoot,
    },
    /// Another ball, which rolls along a line during the cycle.
    Ball {
        /// Its centre at the start of the cycle, m, pitch frame.
        start: Vec2,
        /// Its centre at the end of the cycle, m, pitch frame.
        end: Vec2,
        /// Radius, m.
        radius: f32,
    },
}

impl BallObstacle {
    /// The base of a robot that does not swing its feet.
    pub fn base(start: Pose, end: Pose, base: BodyBox) -> Self {
        BallObstacle::Base { start, end, base, foot: SwingingFoot::default() }
    }

    pub(super) fn pose_at(start: Pose, end: Pose, share: f32) -> Pose {
        if share >= 1.0 {
            return end;
        }
        Pose {
            position: start.position.lerp(end.position, share),
            heading: wrap_angle(start.heading + wrap_angle(end.heading - start.heading) * share),
        }
    }

    /// Distance of a point from the surface (negative inside) and the outward normal, at `share` of the cycle.
    pub(super) fn signed_distance(&self, point: Vec2, share: f32) -> (f32, Vec2) {
        match *self {
            BallObstacle::Cylinder { centre, radius } => {
                let offset = point - centre;
                (offset.length() - radius, offset.normalize_or(Vec2::X))
            }
            BallObstacle::Bar { start, end, radius } => {
                let (distance, normal) = distance_from_segment(start, end, point);
                (distance - radius, normal)
            }
            BallObstacle::Base { start, end, base, .. } => {
                base.footprint(Self::pose_at(start, end, share)).signed_distance(point)
            }
            BallObstacle::Ball { start, end, radius } => {
                let offset = point - start.lerp(end, share);
                (offset.length() - radius, offset.normalize_or(Vec2::X))
            }
        }
    }

    /// Velocity of the obstacle's surface at a point, m/s, for a cycle of `duration` seconds.
    pub(super) fn velocity_at(&self, point: Vec2, share: f32, duration: f32) -> Vec2 {
        let (start, end) = match *self {
            BallObstacle::Base { start, end, .. } => (start, end),
            BallObstacle::Ball { start, end, .. } => return (end - start) / duration,
            BallObstacle::Cylinder { .. } | BallObstacle::Bar { .. } => return Vec2::ZERO,
        };
        let angular = wrap_angle(end.heading - start.heading) / duration;
        let arm = point - start.position.lerp(end.position, share);
        (end.position - start.position) / duration + arm.perp() * angular
    }

    /// The speed at which a swinging foot approaches the ball in addition to the surface, m/s, and the direction in which a touched ball
    /// bounces, for a contact with this normal.
    pub(super) fn foot_at(&self, normal: Vec2) -> (f32, Vec2) {
        match self {
            BallObstacle::Base { foot, .. } if foot.velocity.dot(normal) > 0.0 => {
                (foot.velocity.dot(normal), normal.rotate(unit(foot.deflection)))
            }
            _ => (0.0, normal),
        }
    }

    /// Share of the approach speed that remains after a bounce of a ball with the restitution `ball`: less off a net.
    pub(super) fn restitution(&self, ball: f32) -> f32 {
        if matches!(self, BallObstacle::Bar { .. }) { NET_RESTITUTION } else { ball }
    }

    /// A bound on the speed of any point of the surface, m/s.
    pub(super) fn greatest_speed(&self, duration: f32) -> f32 {
        let (start, end, base) = match *self {
            BallObstacle::Base { start, end, base, .. } => (start, end, base),
            BallObstacle::Ball { start, end, .. } => return start.distance(end) / duration,
            BallObstacle::Cylinder { .. } | BallObstacle::Bar { .. } => return 0.0,
        };
        let turn = wrap_angle(end.heading - start.heading).abs();
        (start.position.distance(end.position) + turn * base.reach()) / duration
    }

    pub(super) fn is_moving(&self) -> bool {
        match self {
            BallObstacle::Base { start, end, .. } => start != end,
            BallObstacle::Ball { start, end, .. } => start != end,
            BallObstacle::Cylinder { .. } | BallObstacle::Bar { .. } => false,
        }
    }

    /// Whether a ball at `place` could touch the obstacle at any time of the cycle.
    pub(super) fn is_near(&self, place: Vec2, ball_radius: f32) -> bool {
        let (centre, radius) = self.bounds();
        let reach = radius + ball_radius;
        centre.distance_squared(place) <= reach * reach
    }

    /// A circle that contains the obstacle during the whole cycle.
    pub(super) fn bounds(&self) -> (Vec2, f32) {
        match *self {
            BallObstacle::Cylinder { centre, radius } => (centre, radius),
            BallObstacle::Bar { start, end, radius } | BallObstacle::Ball { start, end, radius } => {
                (start.midpoint(end), start.distance(end) / 2.0 + radius)
            }
            BallObstacle::Base { start, end, base, .. } => {
                (start.position.midpoint(end.position), start.position.distance(end.position) / 2.0 + base.reach())
            }
        }
    }
}
