//! Deciding under uncertainty: where to shoot, past a keeper whose position is uncertain.
//!
//! One robot shoots at the centre of the goal. The other draws samples from its beliefs (its own pose, the ball and the
//! keeper, each with its covariance) and from the spread of its kicks, counts for each direction how often the ball
//! would go in, and chooses the best one.
//!
//! Run with `cargo run --release --no-default-features --example decision_making`.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::belief::PlaceCovariance;
use naoisis::geometry::{angle_of, unit, unrotate, wrap_angle};
use naoisis::pitch::Pitch;
use naoisis::prelude::*;
use naoisis::statistics::{mean, share};

/// The number of situations in which both are tried.
const SITUATIONS: u64 = 1000;
/// The number of samples for each direction, and of directions.
const DRAWS: usize = 100;
const DIRECTIONS: usize = 15;
/// The standard deviation of the direction of kicks, radians, which the robot knows.
const KICK_SD: f32 = 0.07;
/// Half of the width that a standing keeper covers, and the radius of the ball, m.
const KEEPER_M: f32 = 0.15 + 0.03;

/// How a robot decides where to shoot.
#[derive(Component, Default, Clone, Copy, PartialEq)]
#[require(SimpleBelief, Belief, Aim)]
enum Shooter {
    #[default]
    AtTheMiddle,
    Weighing,
}

/// The chosen direction, and the random numbers of the robot.
#[derive(Component, Default)]
struct Aim {
    direction: Option<f32>,
    dice: Option<RandomStream>,
}

fn shoot(
    pitch: Res<Pitch>,
    clock: Res<CycleClock>,
    mut robots: Query<(&RobotId, &Belief, &Shooter, &mut Aim, &mut WalkCommand, &mut HeadCommand, &mut KickCommand)>,
) {
    for (id, belief, shooter, mut aim, mut walk, mut head, mut kick) in &mut robots {
        let Some(ball) = belief.ball else {
            head.pitch = 0.3;
            continue;
        };
        let forward = belief.pose.forward();
        let in_robot = unrotate(forward, ball.position_m - belief.pose.position);
        // Looks at the goal and the ball alternately, for two seconds before it decides.
        let looks_up = clock.cycle % 60 < 20;
        (head.yaw, head.pitch) = if looks_up { (0.0, 0.0) } else { (angle_of(in_robot), 0.3) };
        if clock.cycle < 60 {
            continue;
        }
        let goal = Vec2::new(pitch.half_length(), 0.0);
        let direction = match (aim.direction, shooter) {
            (Some(direction), _) => direction,
            (None, Shooter::AtTheMiddle) => angle_of(goal - ball.position_m),
            (None, Shooter::Weighing) => {
                let dice = aim.dice.get_or_insert_with(|| RandomStream::new(0, *id, "aim"));
                best_direction(belief, ball.position_m, &pitch, dice)
            }
        };
        aim.direction = Some(direction);
        // Walks to where the ball lies in front of the right foot, facing along the shot.
        let along = unit(direction);
        let place = ball.position_m - along * 0.16 + along.perp() * 0.05;
        let way = unrotate(forward, place - belief.pose.position);
        let turn = wrap_angle(direction - belief.pose.heading);
        // The ball leaves along the line from the foot to it: straight only if it lies straight ahead of the foot.
        let straight = (in_robot.y + 0.05).abs() < 0.01 && turn.abs() < 0.05;
        if KickType::RightStraight.admits(in_robot) && straight {
            kick.0 = Some(KickRequest::new(KickType::RightStraight, 1.0));
        } else {
            *walk = WalkCommand::new(0.2 * way.x, 0.2 * way.y, 0.2 * turn);
        }
    }
}

/// The direction with the most goals among the samples.
fn best_direction(belief: &Belief, ball: Vec2, pitch: &Pitch, dice: &mut RandomStream) -> f32 {
    let (line, post) = (pitch.half_length(), pitch.goal.width_m / 2.0 - 0.08);
    let [left, right] = [post, -post].map(|y| angle_of(Vec2::new(line, y) - ball));
    let heading_sd = belief.pose_covariance[5].max(0.0).sqrt();
    let keeper = belief.opponents.iter().min_by(|a, b| b.position_m.x.total_cmp(&a.position_m.x));
    let scored = |direction: f32, dice: &mut RandomStream| {
        let goals = (0..DRAWS).filter(|_| {
            // The same error of the heading rotates the shot and everything that the robot sees.
            let shot = direction + dice.gaussian(KICK_SD) + dice.gaussian(heading_sd);
            let ahead = unit(shot);
            let crosses = ball.y + ahead.y / ahead.x * (line - ball.x);
            let stopped = keeper.is_some_and(|keeper| {
                let place = draw(keeper.position_m, keeper.covariance, dice) - ball;
                place.dot(ahead) > 0.0 && place.perp_dot(ahead).abs() < KEEPER_M
            });
            crosses.abs() < post && !stopped
        });
        goals.count()
    };
    let candidates = (0..DIRECTIONS).map(|index| right + (left - right) * (index as f32 + 0.5) / DIRECTIONS as f32);
    let best = candidates.map(|direction| (scored(direction, dice), direction)).max_by_key(|(goals, _)| *goals);
    best.map_or((left + right) / 2.0, |(_, direction)| direction)
}

/// A position drawn from its distribution, by the Cholesky factor of its covariance.
fn draw(place: Vec2, [xx, xy, yy]: PlaceCovariance, dice: &mut RandomStream) -> Vec2 {
    let a = xx.max(1e-6).sqrt();
    let b = xy / a;
    let c = (yy - b * b).max(0.0).sqrt();
    let (x, y) = (dice.gaussian(1.0), dice.gaussian(1.0));
    place + Vec2::new(a * x, b * x + c * y)
}

/// A situation: random positions of ball and keeper, and the robot behind the ball.
fn situation_of(situation: u64) -> String {
    let mut dice = RandomStream::for_match(situation, "situation");
    let mut throw = |low: f32, high: f32| low + (high - low) * dice.uniform();
    let [ball_x, ball_y, keeper_y] = [throw(0.8, 1.6), throw(-0.8, 0.8), throw(-0.15, 0.15)];
    format!(
        r#"{{ "seed": {situation}, "rules": {{ "preset": "naoisis", "stalling": false }},
             "kicks": {{ "direction_sd_deg": 4 }}, "ball": {{ "position_m": [{ball_x}, {ball_y}] }},
             "robots": [{{ "number": 2, "pose": [{}, {ball_y}, 0], "behaviour": "shooter" }},
                        {{ "team": "pink", "number": 1, "pose": [2.7, {keeper_y}, 180] }}] }}"#,
        ball_x - 0.45
    )
}

fn add_shooter(app: &mut App) {
    app.add_behaviour::<Shooter, _>("shooter", shoot);
}

/// Makes all shooters decide in this way.
fn choose(app: &mut App, shooter: Shooter) {
    let mut shooters = app.world_mut().query::<&mut Shooter>();
    shooters.iter_mut(app.world_mut()).for_each(|mut chosen| *chosen = shooter);
}

/// Whether a shot in a situation is a goal.
fn scores(shooter: Shooter, situation: u64) -> Result<bool, Box<dyn std::error::Error>> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_shooter(&mut app);
    app.start_match(&Scenario::from_json(&situation_of(situation))?)?;
    choose(&mut app, shooter);
    let mut out = false;
    app.run_until(30 * 20, |app| {
        out = app.events().iter().any(|event| matches!(event, MatchEvent::BallOut { .. }));
        out || app.game().score.blue > 0
    });
    Ok(app.game().score.blue > 0)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if common::view(&situation_of(1), add_shooter, |app| choose(app, Shooter::Weighing))? {
        return Ok(());
    }
    let results = [Shooter::AtTheMiddle, Shooter::Weighing]
        .map(|shooter| (1..=SITUATIONS).map(|situation| scores(shooter, situation)).collect::<Result<Vec<bool>, _>>());
    let [middle, weighing] = results;
    let (middle, weighing) = (middle?, weighing?);
    for (name, goals) in [("at the centre of the goal", &middle), ("in the best direction", &weighing)] {
        if let Some(share) = share(goals.iter().filter(|goal| **goal).count(), goals.len()) {
            println!(
                "shooting {name:31} scores in {:3.0} % of {SITUATIONS} situations ({:.0} to {:.0} % with 95 % confidence)",
                100.0 * share.value,
                100.0 * share.low,
                100.0 * share.high
            );
        }
    }
    // The situations are the same, so they can be compared in pairs.
    let gains: Vec<f64> =
        middle.iter().zip(&weighing).map(|(one, other)| f64::from(*other) - f64::from(*one)).collect();
    if let Some(gain) = mean(&gains) {
        let [low, high] = [gain.low, gain.high].map(|value| 100.0 * value);
        let verdict = if gain.low > 0.0 { "deciding pays" } else { "it is not significant" };
        println!(
            "the difference is {:.0} points ({low:.0} to {high:.0} with 95 % confidence): {verdict}",
            100.0 * gain.value
        );
    }
    Ok(())
}
