//! The columns of all tables: each row is a structure, and the documentation of its fields describes the columns.

use super::column::{Cell, Column, ColumnValues, TableRow, table_row};

table_row! {
    /// The ball and the game after a cycle.
    CycleRow {
        /// Cycles since the start.
        cycle: i64,
        /// Time since the start, s.
        time_s: f64,
        /// The true position of the ball's centre, m, pitch frame.
        ball_x_m: Option<f32>,
        /// The same along the y axis.
        ball_y_m: Option<f32>,
        /// The same above the ground.
        ball_z_m: Option<f32>,
        /// The true velocity of the ball, m/s, pitch frame.
        ball_vx_mps: Option<f32>,
        /// The same along the y axis.
        ball_vy_mps: Option<f32>,
        /// The same upwards.
        ball_vz_mps: Option<f32>,
        /// The state of the game: `playing`.
        state: Option<String>,
        /// Goals of the blue team.
        score_blue: Option<i64>,
        /// Goals of the pink team.
        score_pink: Option<i64>,
        /// The half, from 1.
        half: Option<i64>,
        /// Time left in the half, s.
        time_left_s: Option<f64>,
        /// The end that the blue team defends: `negative_x` or `positive_x`.
        blue_end: Option<String>,
        /// The team that the ball belongs to.
        kicking_team: Option<String>,
        /// The free kick or kick-off under way: `corner_kick`.
        set_play: Option<String>,
    }
}

table_row! {
    /// A robot after a cycle, with its readings and commands.
    RobotRow {
        /// Cycles since the start.
        cycle: i64,
        /// Time since the start, s.
        time_s: f64,
        /// Its team and number: `blue1`.
        robot: String,
        /// Its team.
        team: String,
        /// Its number in the team.
        number: i64,
        /// Its true position, m, pitch frame.
        x_m: Option<f32>,
        /// The same along the y axis.
        y_m: Option<f32>,
        /// Its true heading, degrees counter-clockwise from the x axis of the pitch.
        heading_deg: Option<f32>,
        /// Its true velocity, m/s, pitch frame.
        vx_mps: Option<f32>,
        /// The same along the y axis.
        vy_mps: Option<f32>,
        /// Its true turning speed, degrees a second.
        turn_degps: Option<f32>,
        /// The yaw of its head, degrees to the left.
        head_yaw_deg: Option<f32>,
        /// The pitch of its head, degrees downwards.
        head_pitch_deg: Option<f32>,
        /// Its true posture: `upright`, `fallen`, `getting_up` or `diving`.
        posture: Option<String>,
        /// The offence whose penalty it serves.
        penalty: Option<String>,
        /// Time of play until it may come back, s.
        penalty_left_s: Option<f64>,
        /// Its displacement since the start by its own steps, m, in the frame of its start.
        odometry_x_m: Option<f32>,
        /// The same along the y axis.
        odometry_y_m: Option<f32>,
        /// Its turn since the start by its own steps, degrees.
        odometry_heading_deg: Option<f32>,
        /// The distance that its left sonar measured, m.
        sonar_left_m: Option<f32>,
        /// The distance that its right sonar measured, m.
        sonar_right_m: Option<f32>,
        /// The state of its body as it knows: `walking`.
        body: Option<String>,
        /// The commanded step forward, m.
        walk_x_m: Option<f32>,
        /// The commanded step to the left, m.
        walk_y_m: Option<f32>,
        /// The commanded turn, degrees to the left.
        walk_turn_deg: Option<f32>,
        /// The type of the commanded kick.
        kick: Option<String>,
        /// The share of the greatest speed of that kick.
        kick_speed: Option<f32>,
        /// The commanded direction of that kick, degrees to the left.
        kick_direction_deg: Option<f32>,
    }
}

table_row! {
    /// An object that a robot's cameras detected in a cycle.
    PerceptRow {
        /// Cycles since the start.
        cycle: i64,
        /// Time since the start, s.
        time_s: f64,
        /// The robot that detected it.
        robot: String,
        /// The time of the exposure of the image, s since the start.
        exposed_s: f64,
        /// What it is: `ball`, `goal_post`, `robot`, `line`, `junction`, `penalty_cross`, `centre_circle` or `corner_arc`.
        kind: String,
        /// The camera.
        camera: String,
        /// Its pixel, from the left edge of the image.
        u_px: f32,
        /// Its pixel, from the upper edge of the image.
        v_px: f32,
        /// Its estimated place on the ground, m ahead of the robot.
        x_m: f32,
        /// The same, m to the left of the robot.
        y_m: f32,
        /// The pixel of the other end of a line, from the left edge.
        end_u_px: Option<f32>,
        /// The same from the upper edge.
        end_v_px: Option<f32>,
        /// The place of the other end of a line, m ahead of the robot.
        end_x_m: Option<f32>,
        /// The same, m to the left of the robot.
        end_y_m: Option<f32>,
        /// The colour of a goal post, the team of a robot, or the shape of a junction.
        detail: Option<String>,
    }
}

table_row! {
    /// A pose or place that a robot believed in a cycle.
    BeliefRow {
        /// Cycles since the start.
        cycle: i64,
        /// Time since the start, s.
        time_s: f64,
        /// The robot that believed it.
        robot: String,
        /// What it is about: `self`, `ball`, `team_mate` or `opponent`.
        about: String,
        /// The team-mate, if its number is known.
        id: Option<String>,
        /// The place, m, team frame: the own goal is at negative x.
        x_m: f32,
        /// The same along the y axis.
        y_m: f32,
        /// The heading, degrees, team frame.
        heading_deg: Option<f32>,
        /// The place, m, pitch frame.
        pitch_x_m: Option<f32>,
        /// The same along the y axis.
        pitch_y_m: Option<f32>,
        /// The heading, degrees, pitch frame.
        pitch_heading_deg: Option<f32>,
        /// The velocity of the ball, m/s, team frame.
        vx_mps: Option<f32>,
        /// The same along the y axis.
        vy_mps: Option<f32>,
        /// The variance of x, m².
        variance_xx: f32,
        /// The covariance of x and y, m².
        covariance_xy: f32,
        /// The variance of y, m².
        variance_yy: f32,
        /// The standard deviation of the heading, degrees.
        heading_sd_deg: Option<f32>,
        /// The time since it was seen, confirmed or reported, s.
        age_s: f32,
        /// The team-mate that reported the ball, if the robot has not seen it itself.
        heard_from: Option<String>,
    }
}

table_row! {
    /// An event of the match.
    EventRow {
        /// Cycles since the start, of the record that has the event.
        cycle: i64,
        /// Time since the start, s, of the record that has the event.
        time_s: f64,
        /// Its kind: `goal`.
        kind: String,
        /// The robot that it is about.
        robot: Option<String>,
        /// The team that it is about.
        team: Option<String>,
        /// The whole event, as JSON.
        json: String,
    }
}

table_row! {
    /// A message that a robot received in a cycle.
    MessageRow {
        /// Cycles since the start.
        cycle: i64,
        /// Time since the start, s.
        time_s: f64,
        /// The receiver.
        robot: String,
        /// The sender.
        from: String,
        /// The cycle in which it was sent.
        sent_cycle: i64,
        /// The believed position of the sender, m, team frame.
        x_m: Option<f32>,
        /// The same along the y axis.
        y_m: Option<f32>,
        /// The believed heading of the sender, degrees, team frame.
        heading_deg: Option<f32>,
        /// The believed position of the ball, m, team frame.
        ball_x_m: Option<f32>,
        /// The same along the y axis.
        ball_y_m: Option<f32>,
        /// The intention of the sender.
        intention: Option<String>,
        /// The whole content, as JSON.
        json: String,
    }
}
