//! Positions of the goal posts and the bars of the goals.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::{End, GoalColour, LineSegment, Pitch, Post};

/// A goal post: a vertical cylinder on the ground.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct GoalPost {
    /// Centre on the ground, m, pitch frame.
    pub position: Vec2,
    /// Radius, m.
    pub radius: f32,
    /// Height, m.
    pub height: f32,
    /// The end whose goal it belongs to.
    pub end: End,
    /// Its colour.
    pub colour: GoalColour,
}

impl From<GoalPost> for Post {
    fn from(post: GoalPost) -> Self {
        Self { radius: post.radius, height: post.height, colour: Some(post.colour) }
    }
}

impl Pitch {
    /// The x coordinate of the goal posts' centres, m: their rear is flush with the outer edge of the goal line.
    pub fn goal_post_x(&self) -> f32 {
        self.half_length() + self.line_width_m / 2.0 - self.goal.post_diameter_m / 2.0
    }

    /// The four goal posts: the goal at -x first, in each the post at -y first.
    pub fn goal_posts(&self) -> [GoalPost; 4] {
        let post = |end: End, side: f32| GoalPost {
            position: Vec2::new(end.sign() * self.goal_post_x(), side * self.goal.width_m / 2.0),
            radius: self.goal.post_diameter_m / 2.0,
            height: self.goal.height_m,
            end,
            colour: self.goal_colour(end),
        };
        [post(End::NegativeX, -1.0), post(End::NegativeX, 1.0), post(End::PositiveX, -1.0), post(End::PositiveX, 1.0)]
    }

    /// The bars on the ground that carry the nets: for each goal its two sides and its rear. Their radius is half
    /// the crossbar's diameter. See [`GoalDimensions::ground_bars`](super::GoalDimensions::ground_bars).
    pub fn ground_bars(&self) -> [LineSegment; 6] {
        let bars = |end: End| {
            let front = end.sign() * self.goal_post_x();
            let rear = end.sign() * (self.goal_post_x() + self.goal.depth_m);
            let half_width = self.goal.width_m / 2.0;
            let segment = |x1, y1, x2, y2| LineSegment { start: Vec2::new(x1, y1), end: Vec2::new(x2, y2) };
            [
                segment(front, -half_width, rear, -half_width),
                segment(front, half_width, rear, half_width),
                segment(rear, -half_width, rear, half_width),
            ]
        };
        let [a, b, c] = bars(End::NegativeX);
        let [d, e, f] = bars(End::PositiveX);
        [a, b, c, d, e, f]
    }
}
