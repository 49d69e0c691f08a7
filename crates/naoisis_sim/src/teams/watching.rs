//! Where a player looks while it walks: at the ball, around for landmarks, along its way.

use bevy::prelude::*;

use super::attack::FACE_BALL_M;
use super::lookout::place_to_check;
use super::player::{Player, PlayerMemory};
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::robot::motion::WalkCommand;

/// Where to look when nothing else is decided: at the ball, now and then around for landmarks, and where `walk` leads.
pub fn watch(player: &Player, memory: &mut PlayerMemory, walk: &WalkCommand) -> HeadCommand {
    /// A pose that was not confirmed for so long needs a look around, s.
    const OLD_POSE_S: f32 = 1.0;
    /// How long a look around takes, s.
    const GLANCE_S: f32 = 0.5;
    /// Between two looks around the ball is watched for so long, s.
    const WATCH_S: f32 = 1.5;
    /// After so long, the robot looks around even if it thinks that it knows where it is, s.
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
    // Who walks step by step cannot stop when it touches, and looks out for it.
    let besides = match player.limits.gait {
        Some(_) => place_to_check(player, &memory.looked_around, walk),
        None => way_to_look_along(player, ball, walk),
    };
    player.head.look_at(besides.unwrap_or(ball))
}

/// A place on the way (m, robot frame) of a player that walks elsewhere than it looks, when it is time to look there: whoever is in
/// the way is seen so.
fn way_to_look_along(player: &Player, ball: Vec2, walk: &WalkCommand) -> Option<Vec2> {
    /// How often it looks there, and how long, s.
    const EVERY_S: f32 = 1.6;
    const FOR_S: f32 = 0.6;
    /// How far ahead it looks, as the time to walk there, and at least and at most, s and m.
    const AHEAD_S: f32 = 3.0;
    const AHEAD_M: [f32; 2] = [0.8, 1.6];
    /// The cosine of the angle within which what is beside the gaze is seen as well: less than half of a NAO's image.
    const IN_VIEW: f32 = 0.9;
    /// Who has less than this to walk to the ball watches nothing else, s.
    const NEAR_BALL_S: f32 = 3.0;
    let speed_mps = walk.translation().length() / player.period;
    let way = walk.translation().normalize_or_zero();
    let walks = speed_mps > 0.3 * player.limits.max_linear_mps;
    let is_seen = way.dot(ball.normalize_or(Vec2::X)) > IN_VIEW;
    let is_near_ball = ball.length() < NEAR_BALL_S * player.limits.max_linear_mps;
    let is_time = player.status.time_s.rem_euclid(EVERY_S) < FOR_S;
    let ahead_m = (AHEAD_S * player.limits.max_linear_mps).clamp(AHEAD_M[0], AHEAD_M[1]);
    (player.head.turns() && walks && !is_seen && !is_near_ball && is_time).then_some(way * ahead_m)
}

/// The goal post (m, robot frame) for which the head turns least, of those that can be seen well.
fn post_to_look_at(player: &Player) -> Option<Vec2> {
    /// Further away, a post tells little, m.
    const FAR_M: f32 = 6.0;
    /// Nearer, its foot is hard to see, m.
    const NEAR_M: f32 = 0.5;
    /// The cosine of the greatest angle from the front, 115°: what the head reaches, less half of the image.
    const REACH: f32 = -0.42;
    let (x, y) = (player.pitch.goal_post_x(), player.pitch.goal.width_m / 2.0);
    [Vec2::new(x, y), Vec2::new(x, -y), Vec2::new(-x, y), Vec2::new(-x, -y)]
        .into_iter()
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
    fn who_walks_where_it_does_not_look_looks_there_now_and_then() {
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
