//! Directions of the head for actions that command only walks and kicks.

use bevy::prelude::*;

use naoisis_core::pitch::Pitch;
use naoisis_core::robot::head::HeadCommand;
use naoisis_sensing::belief::Belief;
use naoisis_sim::teams::Head;

/// The time between two looks at landmarks, s.
const EVERY_S: f32 = 2.0;
/// The duration of a look at landmarks, s.
const FOR_S: f32 = 0.5;
/// A pose that landmarks confirmed within this time needs no others, s.
const FRESH_POSE_S: f32 = 1.0;

/// Looks at the ball, or around if `ball` is `None`. `ball` is in the robot frame, m; `now_s` in s.
pub fn at_what_is_seen(head: &Head, ball: Option<Vec2>, now_s: f32) -> HeadCommand {
    ball.map_or_else(|| head.search(now_s), |ball| head.look_at(ball))
}

/// Looks at the believed ball, or around if it is unknown. If landmarks have not confirmed the pose recently, looks at
/// a goal post now and then.
pub fn at_what_is_believed(head: &Head, belief: &Belief, pitch: &Pitch, now_s: f32) -> HeadCommand {
    let is_time = now_s.rem_euclid(EVERY_S) < FOR_S;
    let post = (is_time && belief.pose_age_s > FRESH_POSE_S).then(|| post_ahead(head, belief, pitch)).flatten();
    post.map_or_else(|| at_what_is_seen(head, belief.ball_in_robot(), now_s), |post| head.look_at(post))
}

/// The goal post that needs the smallest turn of the head, robot frame, m; `None` if none is in reach.
fn post_ahead(head: &Head, belief: &Belief, pitch: &Pitch) -> Option<Vec2> {
    /// The least distance at which the foot of a post is easily seen, m.
    const NEAR_M: f32 = 0.5;
    let (x, y) = (pitch.goal_post_x(), pitch.goal.width_m / 2.0);
    let posts = [Vec2::new(x, y), Vec2::new(x, -y), Vec2::new(-x, y), Vec2::new(-x, -y)];
    let ahead = |post: &Vec2| post.x / post.length();
    posts
        .map(|post| belief.pose.inverse_transform_point(post))
        .into_iter()
        .filter(|post| post.length() > NEAR_M && ahead(post) > head.reach_cosine())
        .max_by(|first, second| ahead(first).total_cmp(&ahead(second)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_sensing::belief::BallBelief;

    #[test]
    fn the_ball_is_looked_at_unless_the_robot_must_see_where_it_is() {
        let (head, pitch) = (Head::default(), Pitch::default());
        let ball = BallBelief { position_m: Vec2::new(0.0, 1.0), ..default() };
        let mut belief = Belief { ball: Some(ball), ..Belief::at(Pose::default()) };
        let looks = |belief: &Belief, now_s| at_what_is_believed(&head, belief, &pitch, now_s);
        let at_ball = head.look_at(ball.position_m);
        assert_eq!(looks(&belief, 0.2), at_ball);
        belief.pose_age_s = 2.0;
        // A post of the goal ahead, 0.7 m beside its middle, 3 m away.
        assert!((looks(&belief, 0.2).yaw.abs() - 0.23).abs() < 0.02, "{:?}", looks(&belief, 0.2));
        assert_eq!(looks(&belief, 1.0), at_ball);
        belief.ball = None;
        assert_eq!(looks(&belief, 1.0), head.search(1.0));
    }
}
