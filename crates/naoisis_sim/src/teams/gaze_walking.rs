//! The gaze of a player that walks: at the ball, at landmarks, and along its way.

use bevy::prelude::*;

use super::attack::FACE_BALL_M;
use super::gaze_obstacles::place_to_check;
use super::player::{Player, PlayerMemory};
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::robot::motion::WalkCommand;

/// Chooses where to look: at the ball, from time to time at a goal post, and where `walk` leads.
pub fn watch(player: &Player, memory: &mut PlayerMemory, walk: &WalkCommand) -> HeadCommand {
    /// A pose that was not confirmed for this time needs a look at landmarks, s.
    const OLD_POSE_S: f32 = 1.0;
    /// How long a look at landmarks takes, s.
    const GLANCE_S: f32 = 0.5;
    /// The least time between two looks at landmarks, s.
    const WATCH_S: f32 = 1.5;
    /// After this time, the robot looks at landmarks even if its pose is confirmed, s.
    const CHECK_S: f32 = 6.0;
    let now = player.status.time_s;
    let Some(ball) = player.belief.ball_in_robot() else { return player.head.search(now) };
    memory.lost_left = ball.y > 0.0;
    let is_at_ball = ball.length_squared() < FACE_BALL_M * FACE_BALL_M;
    let watched_s = now - memory.last_glance_s;
    let is_lost = player.belief.pose_age_s > OLD_POSE_S && watched_s > WATCH_S;
    if now > memory.glance_until_s && (is_lost || (!is_at_ball && watched_s > CHECK_S)) {
        memory.glance_until_s = now + GLANCE_S;
        memory.last_glance_s = now + GLANCE_S;
    }
    if now < memory.glance_until_s
        && let Some(post) = post_to_look_at(player)
    {
        return player.head.look_at(post);
    }
    // A robot that walks step by step cannot stop at the moment of contact, and looks for opponents in time.
    let besides = match player.motion.gait {
        Some(_) => place_to_check(player, &memory.looked_around, walk),
        None => way_to_look_along(player, ball, walk),
    };
    player.head.look_at(besides.unwrap_or(ball))
}

/// A place on the way (m, robot frame) of a player that does not look where it walks, when it is time to look there, so that it sees
/// robots in the way.
fn way_to_look_along(player: &Player, ball: Vec2, walk: &WalkCommand) -> Option<Vec2> {
    /// The player looks there for [`FOR_S`] of each such period, s.
    const EVERY_S: f32 = 1.6;
    const FOR_S: f32 = 0.6;
    /// A walking player looks at the point that it reaches after this time, s.
    const AHEAD_S: f32 = 3.0;
    /// The least and greatest distance of this point, m.
    const AHEAD_M: [f32; 2] = [0.8, 1.6];
    /// The cosine of the angle from the gaze within which objects are in view: less than half of a NAO's image.
    const IN_VIEW: f32 = 0.9;
    /// A player with less than this to walk to the ball looks only at the ball, s.
    const NEAR_BALL_S: f32 = 3.0;
    let speed_mps = walk.translation().length() / player.period;
    let way = walk.translation().normalize_or_zero();
    let walks = speed_mps > 0.3 * player.motion.max_linear_mps;
    let is_seen = way.dot(ball.normalize_or(Vec2::X)) > IN_VIEW;
    let is_near_ball = ball.length() < NEAR_BALL_S * player.motion.max_linear_mps;
    let is_time = player.status.time_s.rem_euclid(EVERY_S) < FOR_S;
    let ahead_m = (AHEAD_S * player.motion.max_linear_mps).clamp(AHEAD_M[0], AHEAD_M[1]);
    (player.head.turns() && walks && !is_seen && !is_near_ball && is_time).then_some(way * ahead_m)
}

/// The goal post (m, robot frame) for which the head turns least, among those that can be seen well.
fn post_to_look_at(player: &Player) -> Option<Vec2> {
    /// The greatest useful distance of a post, m.
    const FAR_M: f32 = 6.0;
    /// Nearer than this, the foot of a post is hard to see, m.
    const NEAR_M: f32 = 0.5;
    /// The cosine of the greatest angle from straight ahead, 115°: the reach of the head less half of the image.
    const REACH: f32 = -0.42;
    // The opponents' posts come first: of equals, the last one is chosen.
    player
        .goal_posts()
        .into_iter()
        .rev()
        .filter_map(|post| {
            let place = player.in_robot(post);
            let distance = place.length();
            let ahead = place.x / distance.max(NEAR_M);
            (ahead > REACH.max(player.head.reach_cosine()) && distance > NEAR_M && distance < FAR_M)
                .then_some((ahead, place))
        })
        .max_by(|(first, _), (second, _)| first.total_cmp(second))
        .map(|(_, place)| place)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::geometry::Pose;

    #[test]
    fn a_player_looks_from_time_to_time_where_it_walks() {
        let mut situation = PlayerFixture::new(Pose::default(), Vec2::new(0.0, 3.0));
        let mut looks = |walk: WalkCommand, ball: Vec2| {
            situation.belief.ball.as_mut().unwrap().position_m = ball;
            let mut there = 0;
            for cycle in 0..96 {
                situation.status.time_s = cycle as f32 / 30.0;
                let player = situation.player();
                let ball = player.in_robot(ball);
                there += usize::from(way_to_look_along(&player, ball, &walk).is_some());
            }
            there
        };
        let ahead = WalkCommand::new(0.006, 0.0, 0.0);
        // 0.6 of 1.6 s.
        assert!((30..42).contains(&looks(ahead, Vec2::new(0.0, 3.0))));
        assert_eq!(looks(ahead, Vec2::new(3.0, 0.3)), 0, "the ball is on the way");
        assert_eq!(looks(ahead, Vec2::new(0.0, 0.4)), 0, "the ball is at its feet");
        assert_eq!(looks(WalkCommand::default(), Vec2::new(0.0, 3.0)), 0, "it stands");
    }
}
