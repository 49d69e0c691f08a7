//! Reinforcement learning: a robot learns to score into an empty goal from any position of the ball.
//!
//! The policy is linear: it maps the believed positions of ball and goal to a step and to the decision to kick. The
//! cross-entropy method (Rubinstein, 1999) optimises its fifteen weights: it draws policies from a normal distribution,
//! plays each on a few seeded situations, and moves the distribution to the best of them. The learned policy is saved
//! as JSON, loaded again and played.
//!
//! Run with `cargo run --release --no-default-features --example learn_to_score [POLICY.json]`. With `POLICY.json
//! --view`, and without `--no-default-features`, a learned policy is played in a window.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::math::ops;
use bevy::prelude::*;
use naoisis::geometry::{angle_of, unrotate};
use naoisis::pitch::Pitch;
use naoisis::prelude::*;

/// The number of weights: for dx, dy and the turn, those of five features.
const WEIGHTS: usize = 15;
/// The numbers of policies per generation, of the best ones that the distribution moves to, and of generations.
const POPULATION: usize = 48;
const ELITE: usize = 8;
const GENERATIONS: usize = 24;
/// The numbers of situations for training a policy, and for testing the result.
const TRIALS: u64 = 8;
const TESTS: u64 = 100;
/// The time limit of an episode, s.
const TRY_S: usize = 20;

/// A robot that is controlled by a policy.
#[derive(Component, Default, Clone)]
#[require(SimpleBelief, Belief)]
struct Learner([f32; WEIGHTS]);

/// Looks at the ball, steps as the policy says, and kicks when the ball is in front of its foot and the goal ahead.
fn act(
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    mut robots: Query<(&Belief, &Learner, &mut HeadCommand, &mut WalkCommand, &mut KickCommand)>,
) {
    for (belief, Learner(weights), mut head, mut walk, mut kick) in &mut robots {
        let forward = belief.pose.forward();
        let in_robot = |place: Vec2| unrotate(forward, place - belief.pose.position);
        let Some(ball) = belief.ball.map(|ball| in_robot(ball.position_m)) else {
            (head.yaw, head.pitch) = (0.0, 0.3);
            *walk = WalkCommand::at_velocity(0.0, 0.0, 1.5, &clock);
            continue;
        };
        (head.yaw, head.pitch) = (angle_of(ball), if ball.length() < 1.0 { 0.3 } else { 0.0 });
        let goal = angle_of(in_robot(Vec2::new(pitch.half_length(), 0.0)));
        // The features of the ball are zero where it lies for a straight kick of the right foot.
        let features = [ball.x - 0.16, ball.y + 0.05, goal, ball.length().min(1.0) * goal, angle_of(ball)];
        let command = |row: usize| -> f32 {
            weights[5 * row..5 * row + 5].iter().zip(features).map(|(weight, feature)| weight * feature).sum()
        };
        *walk = WalkCommand::new(0.02 * command(0), 0.02 * command(1), 0.1 * command(2));
        if KickType::RightStraight.admits(ball) && goal.abs() < 0.2 {
            kick.0 = Some(KickRequest::new(KickType::RightStraight, 1.0));
        }
    }
}

/// A situation: random positions of ball and robot.
fn scenario(situation: u64) -> (f32, String) {
    let mut dice = RandomStream::for_match(situation, "situation");
    let mut throw = |low: f32, high: f32| low + (high - low) * dice.uniform();
    let [ball_x, ball_y, x, y, turn] =
        [throw(-0.5, 2.0), throw(-1.2, 1.2), throw(-1.5, 0.5), throw(-1.5, 1.5), throw(-90.0, 90.0)];
    let json = format!(
        r#"{{ "seed": {situation}, "rules": {{ "preset": "naoisis", "stalling": false }},
             "ball": {{ "position_m": [{ball_x}, {ball_y}] }},
             "robots": [{{ "number": 2, "pose": [{x}, {y}, {turn}], "behaviour": "learner" }}] }}"#
    );
    (ball_x, json)
}

fn add_learner(app: &mut App) {
    app.add_behaviour::<Learner, _>("learner", act);
}

/// Sets the policy of the robot.
fn teach(app: &mut App, weights: &[f32; WEIGHTS]) {
    let mut learners = app.world_mut().query::<&mut Learner>();
    for mut learner in learners.iter_mut(app.world_mut()) {
        learner.0 = *weights;
    }
}

/// Plays a situation. The reward is 1 for a goal and up to 0.5 more for a quick one; without a goal, a little for
/// approaching the ball and for moving it forward.
fn play(weights: &[f32; WEIGHTS], situation: u64) -> f32 {
    let (ball_x, json) = scenario(situation);
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_learner(&mut app);
    let scenario = Scenario::from_json(&json);
    let started = scenario
        .map_err(|error| error.to_string())
        .and_then(|scenario| app.start_match(&scenario).map(|_| ()).map_err(|fault| fault.to_string()));
    // The robot may be placed onto the ball by chance; such a situation is of no use.
    if started.is_err() {
        return 0.0;
    }
    let robot = RobotId::new(Team::Blue, 2);
    teach(&mut app, weights);
    let mut nearest = f32::MAX;
    let mut best_x = ball_x;
    let mut out = false;
    let over = app.run_until(TRY_S * 30, |app| {
        let ball = app.ball().unwrap_or_default().position;
        nearest = nearest.min(app.robot_pose(robot).unwrap_or_default().position.distance(ball));
        out = app.events().iter().any(|event| matches!(event, MatchEvent::BallOut { .. }));
        let goal = app.game().score.blue > 0;
        if !goal && !out {
            best_x = best_x.max(ball.x);
        }
        goal || out
    });
    if over && !out {
        return 1.5 - 0.5 * app.cycle() as f32 / (TRY_S * 30) as f32;
    }
    0.2 * ops::exp(-2.0 * (nearest - 0.15).max(0.0)) + 0.2 * (best_x - ball_x).clamp(0.0, 3.0) / 3.0
}

/// The mean reward of every policy on these situations, on all cores.
fn rewards(policies: &[[f32; WEIGHTS]], situations: core::ops::Range<u64>) -> Vec<f32> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mean = |policy: &[f32; WEIGHTS]| {
        let count = (situations.end - situations.start) as f32;
        situations.clone().map(|situation| play(policy, situation)).sum::<f32>() / count
    };
    std::thread::scope(|scope| {
        let chunks = policies.chunks(policies.len().div_ceil(threads));
        let workers: Vec<_> = chunks.map(|chunk| scope.spawn(|| chunk.iter().map(mean).collect::<Vec<_>>())).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap_or_default()).collect()
    })
}

/// The success rate of a policy in the test situations, which are not used for learning.
fn score(policy: &[f32; WEIGHTS]) -> f32 {
    let situations: Vec<u64> = (10_000..10_000 + TESTS).collect();
    let scored = std::thread::scope(|scope| {
        let workers: Vec<_> = situations
            .chunks(situations.len().div_ceil(2))
            .map(|chunk| scope.spawn(move || chunk.iter().filter(|situation| play(policy, **situation) >= 1.0).count()))
            .collect();
        workers.into_iter().map(|worker| worker.join().unwrap_or_default()).sum::<usize>()
    });
    scored as f32 / TESTS as f32
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().skip(1).find(|word| word != "--view").unwrap_or_else(|| "policy.json".to_owned());
    let learned_before = || -> Result<[f32; WEIGHTS], String> {
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{path}: {error}; learn a policy first"))?;
        serde_json::from_str(&text).map_err(|error| format!("{path}: {error}; expected a learned policy"))
    };
    if std::env::args().any(|argument| argument == "--view") {
        let policy = learned_before()?;
        common::view(&scenario(1).1, add_learner, |app| teach(app, &policy))?;
        return Ok(());
    }
    // Fails now rather than after minutes of learning.
    std::fs::OpenOptions::new().append(true).create(true).open(&path).map_err(|error| format!("{path}: {error}"))?;
    let mut dice = RandomStream::for_match(1, "policies");
    let (mut mean, mut spread) = ([0.0_f32; WEIGHTS], [1.0_f32; WEIGHTS]);
    let random: [f32; WEIGHTS] = core::array::from_fn(|_| dice.gaussian(1.0));
    println!("a random policy scores in {:.0} % of the situations", 100.0 * score(&random));
    println!("generation   best   mean");
    for generation in 0..GENERATIONS {
        let policies: Vec<[f32; WEIGHTS]> =
            (0..POPULATION).map(|_| core::array::from_fn(|index| mean[index] + dice.gaussian(spread[index]))).collect();
        // New situations in every generation, to avoid overfitting.
        let first = generation as u64 * TRIALS;
        let rewards = rewards(&policies, first..first + TRIALS);
        let mut order: Vec<usize> = (0..POPULATION).collect();
        order.sort_by(|a, b| rewards[*b].total_cmp(&rewards[*a]));
        let average = rewards.iter().sum::<f32>() / POPULATION as f32;
        let bar = "#".repeat((40.0 * average.max(0.0)) as usize);
        println!("{generation:10}   {:.2}   {average:.2}  {bar}", rewards[order[0]]);
        for index in 0..WEIGHTS {
            let elite = || order[..ELITE].iter().map(|best| policies[*best][index]);
            mean[index] = elite().sum::<f32>() / ELITE as f32;
            let squared = |weight: f32| (weight - mean[index]) * (weight - mean[index]);
            let variance = elite().map(squared).sum::<f32>() / ELITE as f32;
            // Adds some variance, which decreases, so that the distribution does not converge too early.
            spread[index] = variance.sqrt() + 0.3 * (1.0 - generation as f32 / GENERATIONS as f32);
        }
    }
    std::fs::write(&path, serde_json::to_string_pretty(&mean)?)?;
    println!("the learned policy, in {path}, scores in {:.0} %", 100.0 * score(&learned_before()?));
    Ok(())
}
