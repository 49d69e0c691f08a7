//! Who goes for the ball? Four robots agree by messages, and agree less the more messages are lost.
//!
//! Each robot sends its distance to the ball, its bid, once a cycle, and goes to the ball if it has received no lower
//! bid recently. The ball is moved every few seconds, and the example counts how many robots go to it: one is right,
//! two get in each other's way, none leaves the ball to the opponents. Bids expire, so a robot that is not heard any
//! more is forgotten.
//!
//! ```sh
//! cargo run --release --no-default-features --example coordination
//! ```
#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::teams;
use std::collections::BTreeMap;

/// The time after which a bid expires, s.
const FRESH_S: f32 = 0.5;
/// The number of rounds with a new position of the ball, and the duration of each, s.
const ROUNDS: u64 = 40;
const ROUND_S: usize = 4;

/// A robot that bids for the ball.
#[derive(Component, Clone, Default)]
#[require(Belief, SimpleBelief)]
struct Bidder {
    /// The last bids of the others, m, and when they were received, s.
    heard: BTreeMap<RobotId, (f32, f32)>,
    /// Whether the robot goes to the ball.
    goes: bool,
}

fn bid(
    mut robots: Query<(
        &RobotId,
        &Belief,
        &GameStatus,
        &Inbox,
        &mut Bidder,
        &mut Outbox,
        &mut WalkCommand,
        &mut HeadCommand,
    )>,
) {
    for (id, belief, status, inbox, mut bidder, mut outbox, mut walk, mut head) in &mut robots {
        let now = status.time_s;
        for message in &inbox.0 {
            if let Some(bid) = message.say.payload.as_ref().and_then(|text| text.parse().ok()) {
                bidder.heard.insert(message.from, (bid, now));
            }
        }
        let Some(ball) = belief.ball_in_robot() else {
            *head = teams::search(now);
            bidder.goes = false;
            continue;
        };
        *head = teams::look_at(ball);
        let own = ball.length();
        // Of equal bids, that of the robot with the lower number wins.
        bidder.goes = bidder
            .heard
            .iter()
            .filter(|(_, (_, heard_at))| now - heard_at < FRESH_S)
            .all(|(other, (bid, _))| (own, id) < (*bid, other));
        outbox.0 = Some(TeamMessage { payload: Some(format!("{own:.2}").into()), ..default() });
        if bidder.goes && own > 0.4 {
            *walk = WalkCommand::new(ball.x, ball.y, ball.to_angle());
        }
    }
}

fn scenario(loss: f32) -> String {
    format!(
        r#"{{ "rules": "free", "messages": {{ "loss": {loss} }}, "ball": {{ "position_m": [0.5, 0.5] }}, "robots": [
             {{ "number": 1, "pose": [-2, 1.2, 0], "behaviour": "bidder" }},
             {{ "number": 2, "pose": [-2, -1.2, 0], "behaviour": "bidder" }},
             {{ "number": 3, "pose": [2, 1.2, 180], "behaviour": "bidder" }},
             {{ "number": 4, "pose": [2, -1.2, 180], "behaviour": "bidder" }} ] }}"#,
    )
}

fn add_bidder(app: &mut App) {
    app.add_behaviour::<Bidder, _>("bidder", bid);
}

/// The shares of the time in which no robot, one and several went to the ball.
fn shares(loss: f32) -> Result<[f64; 3], Box<dyn core::error::Error>> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_bidder(&mut app);
    app.start_match(&Scenario::from_json(&scenario(loss))?)?;
    let mut stream = RandomStream::for_match(1, "places");
    let mut counts = [0_u32; 3];
    for _ in 0..ROUNDS {
        let position_m = Vec2::new(3.0 * stream.uniform() - 1.5, 2.4 * stream.uniform() - 1.2);
        app.world_mut().commands().queue(Intervention::PlaceBall { position_m, velocity_mps: Vec2::ZERO });
        app.world_mut().flush();
        for _ in 0..30 * ROUND_S {
            app.run_cycles(1);
            let robots = (1..=4).map(|number| RobotId::new(Team::Blue, number));
            let going = robots.filter(|id| app.robot::<Bidder>(*id).is_some_and(|bidder| bidder.goes)).count();
            counts[going.min(2)] += 1;
        }
    }
    let all: u32 = counts.iter().sum();
    Ok(counts.map(|count| 100.0 * f64::from(count) / f64::from(all)))
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    if common::view(&scenario(0.0), add_bidder, |_| {})? {
        return Ok(());
    }
    println!("messages lost     none goes    one goes   several go");
    for loss in [0.0, 0.2, 0.5, 0.8, 0.9, 0.95, 1.0] {
        let [nobody, one, several] = shares(loss)?;
        println!("{:>10.0} %   {nobody:>9.1} %   {one:>7.1} %   {several:>8.1} %", 100.0 * loss);
    }
    Ok(())
}
