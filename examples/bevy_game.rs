//! A match in a Bevy game of one's own: a stadium with a scoreboard, a camera that follows the ball, and a crowd.
//!
//! The match is run by `FixedUpdate`; the rest of the game are plain components and systems, and hears of goals by an observer.
//!
//! Run with `cargo run --release --no-default-features --example bevy_game`. Without a window, frames are not drawn and follow
//! each other at once. In a game that is seen, `DefaultPlugins` takes the place of `MinimalPlugins`, `app.run()` that of the loop.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis::prelude::*;

/// The game: everything of it but the window.
struct StadiumPlugin;

impl Plugin for StadiumPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(NaoisisPlugins::in_schedule(FixedUpdate))
            .add_systems(Startup, (build_stadium, kick_off))
            .add_systems(Update, (follow_ball, calm_down))
            .add_observer(write_down_goal)
            .add_observer(cheer)
            .add_observer(close_stadium)
            .add_observer(refund);
    }
}

/// What the people in the stadium read.
#[derive(Component, Default)]
struct Scoreboard {
    lines: Vec<String>,
    is_over: bool,
}

/// A camera that turns to the ball.
#[derive(Component)]
struct BallCamera;

/// How loud the spectators are, from 0 to 1.
#[derive(Component, Default)]
struct Crowd {
    noise: f32,
    loudest: f32,
}

fn build_stadium(mut commands: Commands) {
    commands.spawn(Scoreboard::default());
    // A game that is seen adds a `Camera3d` here.
    commands.spawn((BallCamera, Transform::from_xyz(0.0, -4.0, 3.0)));
    commands.spawn(Crowd::default());
}

fn kick_off(mut commands: Commands) -> Result {
    let scenario = Scenario::named("match3v3")?;
    commands.start_match(Scenario { duration_s: Some(120.0), seed: 3, ..scenario });
    Ok(())
}

fn follow_ball(ball: Query<&Pose, With<Ball>>, mut cameras: Query<&mut Transform, With<BallCamera>>) {
    let Ok(ball) = ball.single() else { return };
    for mut camera in &mut cameras {
        // As the pitch has it: x and y on the ground, z up.
        camera.look_at(ball.position.extend(0.0), Vec3::Z);
    }
}

fn write_down_goal(goal: On<GoalScored>, clock: Res<CycleClock>, mut boards: Query<&mut Scoreboard>) {
    for mut board in &mut boards {
        let scorer = goal.scorer.map_or("nobody".to_owned(), |robot| robot.to_string());
        let (time_s, score) = (clock.end_time_s(), goal.score);
        board.lines.push(format!("{time_s:.0} s: {scorer} scores, {} : {}", score.blue, score.pink));
    }
}

fn cheer(_goal: On<GoalScored>, mut crowds: Query<&mut Crowd>) {
    for mut crowd in &mut crowds {
        crowd.noise = 1.0;
        crowd.loudest = 1.0;
    }
}

fn calm_down(time: Res<Time>, mut crowds: Query<&mut Crowd>) {
    for mut crowd in &mut crowds {
        crowd.noise = (crowd.noise - 0.2 * time.delta_secs()).max(0.0);
    }
}

fn close_stadium(end: On<MatchEnded>, mut boards: Query<&mut Scoreboard>) {
    for mut board in &mut boards {
        board.lines.push(format!("the end: {} : {}", end.score.blue, end.score.pink));
        board.is_over = true;
    }
}

/// What happens instead of a match whose scenario has an error.
fn refund(refused: On<MatchNotStarted>, mut boards: Query<&mut Scoreboard>) {
    for mut board in &mut boards {
        board.lines.push(format!("no match today: {}", refused.fault));
        board.is_over = true;
    }
}

/// Lets the game run until the scoreboard says that it is over, at most so many frames of 50 ms.
fn play(app: &mut App, frames: usize) -> Vec<String> {
    // The clock of the game advances by as much in each frame, however long the frame took.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(50)));
    for _frame in 0..frames {
        app.update();
        let mut boards = app.world_mut().query::<&Scoreboard>();
        if let Ok(board) = boards.single(app.world())
            && board.is_over
        {
            return board.lines.clone();
        }
    }
    Vec::new()
}

fn main() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, StadiumPlugin));
    for line in play(&mut app, 3000) {
        println!("{line}");
    }
    let mut crowds = app.world_mut().query::<&Crowd>();
    for crowd in crowds.iter(app.world()) {
        println!("the crowd was at its loudest at {:.0} %", 100.0 * crowd.loudest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scoreboard_has_the_goals_of_the_same_match_without_a_game_around_it() {
        let mut game = App::new();
        game.add_plugins((MinimalPlugins, StadiumPlugin));
        let lines = play(&mut game, 3000);
        let mut alone = App::new();
        alone.add_plugins(NaoisisPlugins);
        let scenario = Scenario { seed: 3, ..Scenario::named("match3v3").expect("a built-in scenario") };
        alone.start_match(&scenario).expect("it can be started").run_cycles(3600);
        let score = alone.game().score;
        assert_eq!(lines.last(), Some(&format!("the end: {} : {}", score.blue, score.pink)));
        assert_eq!(lines.len() as u32, score.blue + score.pink + 1);
        assert_eq!((game.ball(), game.cycle()), (alone.ball(), 3600));
    }
}
