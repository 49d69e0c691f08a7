//! How much does a keeper gain from the ball's velocity? The same shots at two keepers that differ in nothing else.
//!
//! Both see the ball through the same noisy cameras, and both stand between it and the goal. One uses the velocity that
//! its Kalman filter estimates, and steps to where the shot will cross its line. The other assumes that the ball lies
//! still, and follows it.
//!
//! ```sh
//! cargo run --release --no-default-features --example keeper_intercepts [SHOTS]
//! ```
#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::statistics::share;

/// The distance of the keepers from the goal line, m.
const DEPTH_M: f32 = 0.3;

/// Steps to where the shot will cross its line.
#[derive(Component, Clone, Copy, Default)]
#[require(Belief, SimpleBelief)]
struct Interceptor;

/// Steps to where the ball is.
#[derive(Component, Clone, Copy, Default)]
#[require(Belief, SimpleBelief)]
struct Follower;

fn intercept(mut robots: Query<(&Belief, &mut WalkCommand, &mut HeadCommand), With<Interceptor>>) {
    for (belief, mut walk, mut head) in &mut robots {
        let Some(ball) = belief.ball else { continue };
        let velocity = ball.velocity_mps;
        let time_s = (belief.pose.position.x - ball.position_m.x) / velocity.x.min(-0.1);
        // The ball rolls straight: drag does not turn it.
        let crossing = if velocity.x < -0.1 { ball.position_m.y + velocity.y * time_s } else { guard(ball.position_m) };
        step_to(belief, crossing, &mut walk);
        look_at_ball(belief, &mut head);
    }
}

fn follow(mut robots: Query<(&Belief, &mut WalkCommand, &mut HeadCommand), With<Follower>>) {
    for (belief, mut walk, mut head) in &mut robots {
        let Some(ball) = belief.ball else { continue };
        step_to(belief, guard(ball.position_m), &mut walk);
        look_at_ball(belief, &mut head);
    }
}

/// The point at which the line from the ball to the centre of the goal (3 m from the centre mark) crosses the line of
/// the keeper.
fn guard(ball: Vec2) -> f32 {
    ball.y * DEPTH_M / (ball.x + 3.0).max(DEPTH_M)
}

fn step_to(belief: &Belief, y: f32, walk: &mut WalkCommand) {
    let way = y.clamp(-0.65, 0.65) - belief.pose.position.y;
    *walk = WalkCommand::new(0.0, way, 0.0);
}

fn look_at_ball(belief: &Belief, head: &mut HeadCommand) {
    if let Some(ball) = belief.ball_in_robot() {
        *head = naoisis::teams::look_at(ball);
    }
}

/// A shot at a keeper with this behaviour. The same seed gives the same shot.
fn scenario(keeper: &str, seed: u64) -> String {
    let mut stream = RandomStream::for_match(seed, "shots");
    let from = Vec2::new(-0.8 + 0.8 * stream.uniform(), 2.4 * stream.uniform() - 1.2);
    let target = Vec2::new(-3.0, 1.2 * stream.uniform() - 0.6);
    let way = target - from;
    // The ball reaches the goal: it rolls v / 0.5 per second.
    let velocity = way.normalize() * (0.5 * way.length() + 0.2 + 0.5 * stream.uniform());
    let start_y = guard(from);
    format!(
        r#"{{ "seed": {seed}, "ball": {{ "position_m": [{}, {}], "velocity_mps": [{}, {}] }},
             "robots": [{{ "number": 1, "pose": [{}, {start_y}, 0], "behaviour": "{keeper}" }}] }}"#,
        from.x,
        from.y,
        velocity.x,
        velocity.y,
        DEPTH_M - 3.0,
    )
}

fn add_keepers(app: &mut App) {
    app.add_behaviour::<Interceptor, _>("interceptor", intercept).add_behaviour::<Follower, _>("follower", follow);
}

/// Whether the shot is a goal.
fn is_goal(keeper: &str, seed: u64) -> Result<bool, Box<dyn core::error::Error>> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_keepers(&mut app);
    app.start_match(&Scenario::from_json(&scenario(keeper, seed))?)?;
    Ok(app.run_until(30 * 10, |app| app.events().iter().any(|event| matches!(event, MatchEvent::Goal { .. }))))
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    if common::view(&scenario("interceptor", 1), add_keepers, |_| {})? {
        return Ok(());
    }
    let shots = match std::env::args().nth(1) {
        Some(word) => word.parse().map_err(|_| format!("{word}: expected a number of shots"))?,
        None => 300,
    };
    println!("keeper                     saves, with 95 % interval");
    for (keeper, what) in
        [("follower", "follows the ball"), ("interceptor", "uses its velocity"), ("idle", "stands still")]
    {
        let mut saves = 0;
        for seed in 1..=shots {
            saves += usize::from(!is_goal(keeper, seed)?);
        }
        if let Some(share) = share(saves, shots as usize) {
            let [value, low, high] = [share.value, share.low, share.high].map(|share| 100.0 * share);
            println!("  {what:22} {value:>6.1} %   ({low:.1} to {high:.1})");
        }
    }
    Ok(())
}
