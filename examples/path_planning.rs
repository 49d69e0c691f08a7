//! Path planning among moving obstacles: a grid planner and a reactive planner on the same seeds. Both know only the
//! obstacles that the robot sees.
//!
//! Run with `cargo run --release --no-default-features --example path_planning`.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::geometry::{angle_of, unrotate};
use naoisis::prelude::*;
use naoisis::statistics::mean;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The goal of the robot, m.
const GOAL: Vec2 = Vec2::new(2.4, 0.0);
/// The distance at which two robots touch, m.
const CLEARANCE_M: f32 = 0.38;
/// The number of walks of each planner.
const WALKS: u64 = 40;

/// A robot that walks to the goal, with its planner.
#[derive(Component, Default, Clone, Copy, PartialEq)]
#[require(SimpleBelief, Belief)]
enum Planner {
    #[default]
    Grid,
    Reactive,
}

fn walk_to_goal(clock: Res<CycleClock>, mut robots: Query<(&Belief, &Planner, &mut WalkCommand, &mut HeadCommand)>) {
    for (belief, planner, mut walk, mut head) in &mut robots {
        let here = belief.pose.position;
        let obstacles: Vec<Vec2> = belief.opponents.iter().map(|opponent| opponent.position_m).collect();
        let way = match planner {
            Planner::Grid => grid::way(here, GOAL, &obstacles),
            Planner::Reactive => reactive_way(here, GOAL, &obstacles),
        };
        let forward = belief.pose.forward();
        let velocity = 0.2 * unrotate(forward, way.normalize_or_zero());
        let turn = 3.0 * angle_of(unrotate(forward, GOAL - here));
        *walk = WalkCommand::at_velocity(velocity.x, velocity.y, turn, &clock);
        // Sweeps its head from side to side, to see obstacles.
        head.yaw = if head.yaw >= 0.9 { -1.0 } else { head.yaw + 0.1 };
    }
}

/// Steers towards the goal, and away from and around near robots: a potential field with a swirl.
fn reactive_way(here: Vec2, goal: Vec2, obstacles: &[Vec2]) -> Vec2 {
    let mut way = (goal - here).normalize_or_zero();
    for obstacle in obstacles {
        let away = here - obstacle;
        let distance = away.length().max(0.05);
        let strength = ((0.9 - distance) / 0.5).clamp(0.0, 2.0);
        let around = if away.perp_dot(goal - here) > 0.0 { away.perp() } else { -away.perp() };
        way += strength * (away + 0.8 * around) / distance;
    }
    way
}

/// The shortest path on a grid (Hart, Nilsson, Raphael: A*, 1968).
mod grid {
    use super::*;

    const CELL_M: f32 = 0.1;
    const SIZE: [i32; 2] = [64, 44];

    fn cell(place: Vec2) -> [i32; 2] {
        [((place.x + 3.2) / CELL_M) as i32, ((place.y + 2.2) / CELL_M) as i32]
    }

    fn place([x, y]: [i32; 2]) -> Vec2 {
        Vec2::new(x as f32 + 0.5, y as f32 + 0.5) * CELL_M - Vec2::new(3.2, 2.2)
    }

    /// The first section of the path.
    pub fn way(here: Vec2, goal: Vec2, obstacles: &[Vec2]) -> Vec2 {
        let index = |[x, y]: [i32; 2]| (y * SIZE[0] + x) as usize;
        let inside = |[x, y]: [i32; 2]| (0..SIZE[0]).contains(&x) && (0..SIZE[1]).contains(&y);
        // Near an obstacle every step costs more, so a robot inside its clearance leaves it.
        let cost = |cell: [i32; 2]| -> u32 {
            let nearest = obstacles.iter().map(|obstacle| obstacle.distance(place(cell))).fold(f32::MAX, f32::min);
            if nearest < CLEARANCE_M + 0.1 { 30 } else { 1 }
        };
        let [start, end] = [cell(here), cell(goal)];
        let guess = |cell: [i32; 2]| (10.0 * place(cell).distance(place(end)) / CELL_M) as u32;
        let mut best = vec![u32::MAX; (SIZE[0] * SIZE[1]) as usize];
        let mut from = vec![[-1, -1]; best.len()];
        let mut open = BinaryHeap::new();
        if inside(start) {
            best[index(start)] = 0;
            open.push((Reverse(guess(start)), start));
        }
        while let Some((_, now)) = open.pop() {
            if now == end {
                break;
            }
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)] {
                let next = [now[0] + dx, now[1] + dy];
                if !inside(next) {
                    continue;
                }
                let length = if dx * dy == 0 { 10 } else { 14 };
                let reached = best[index(now)] + length * cost(next);
                if reached < best[index(next)] {
                    best[index(next)] = reached;
                    from[index(next)] = now;
                    open.push((Reverse(reached + guess(next)), next));
                }
            }
        }
        // Back from the goal to the cell that is three steps from here.
        let mut trail = vec![end];
        while let Some(&last) = trail.last() {
            if last == start || !inside(last) || from[index(last)] == [-1, -1] {
                break;
            }
            trail.push(from[index(last)]);
        }
        let ahead = trail.len().saturating_sub(4).min(trail.len() - 1);
        place(trail[ahead]) - here
    }
}

/// A walk among other walking robots.
fn scenario(seed: u64) -> String {
    // Four robots walk to and fro across the path, each at its own place and time.
    let crossing = |index: u64| {
        let x = -1.2 + 0.8 * index as f32;
        let phase = (seed * 7 + index * 3) % 10;
        let y = -1.6 + 0.3 * phase as f32;
        let strides: Vec<String> = (0..8)
            .map(|leg| {
                let (from, dx) = (leg as f32 * 10.0, if (leg + phase).is_multiple_of(2) { 0.005 } else { -0.005 });
                format!(r#"{{ "from_s": {from}, "until_s": {}, "walk": [{dx}, 0, 0] }}"#, from + 10.0)
            })
            .collect();
        format!(
            r#"{{ "team": "pink", "number": {}, "pose": [{x}, {y}, 90], "behaviour": {{ "script": [{}] }} }}"#,
            index + 1,
            strides.join(", ")
        )
    };
    let obstacles: Vec<String> = (0..4).map(crossing).collect();
    format!(
        r#"{{ "seed": {seed}, "rules": "free", "ball": null,
             "robots": [{{ "number": 1, "pose": [-2.5, 0, 0], "behaviour": "walker" }}, {}] }}"#,
        obstacles.join(", ")
    )
}

fn add_walker(app: &mut App) {
    app.add_behaviour::<Planner, _>("walker", walk_to_goal);
}

/// The results of a walk: its duration if it arrived, and the number of collisions.
fn walk(planner: Planner, seed: u64) -> Result<(Option<f64>, u32), Box<dyn std::error::Error>> {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    add_walker(&mut app);
    app.start_match(&Scenario::from_json(&scenario(seed))?)?;
    let mut planners = app.world_mut().query::<&mut Planner>();
    planners.iter_mut(app.world_mut()).for_each(|mut chosen| *chosen = planner);
    let robot = RobotId::new(Team::Blue, 1);
    let mut collisions = 0;
    let arrived = app.run_until(30 * 75, |app| {
        collisions += app.events().iter().filter(|event| matches!(event, MatchEvent::Collision { .. })).count() as u32;
        app.robot_pose(robot).unwrap_or_default().position.distance(GOAL) < 0.2
    });
    Ok((arrived.then(|| app.cycle() as f64 / 30.0), collisions))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    if common::view(&scenario(1), add_walker, |_| {})? {
        return Ok(());
    }
    println!(
        "{WALKS} walks of 4.9 m, which take 24.5 s without obstacles\nplanner    arrived  time, s        collisions"
    );
    for (planner, name) in [(Planner::Grid, "grid"), (Planner::Reactive, "reactive")] {
        let (mut times, mut collisions) = (Vec::new(), Vec::new());
        for seed in 1..=WALKS {
            let (time, collided) = walk(planner, seed)?;
            times.extend(time);
            collisions.push(f64::from(collided));
        }
        let show = |values: &[f64]| {
            mean(values).map_or("-".to_owned(), |mean| format!("{:.2} ± {:.2}", mean.value, mean.margin()))
        };
        println!("{name:10} {:7}  {:14} {}", times.len(), show(&times), show(&collisions));
    }
    Ok(())
}
