//! Beliefs of robots compared with the truth.

use bevy::prelude::*;

use super::{Brush, Overlay, Showing};
use crate::viewer::palette;
use naoisis_core::ball::Ball;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::robot::PreviousPose;
use naoisis_core::robot::body::Body;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{Belief, point_pitch_from_team};

/// The circle at a believed pose is this much smaller than the robot, m.
const WITHIN_BODY_M: f32 = 0.02;
/// The time for which the path of a believed ball is drawn, s.
const ROLLS_FOR_S: f32 = 1.0;
/// The height of words above a believed ball, m: above the balls of all leagues.
const ABOVE_BALL_M: f32 = 0.25;
/// The age up to which a ball is one that the robot sees now, s.
pub const SEEN_LATELY_S: f32 = 0.5;

pub(super) fn draw_beliefs(
    showing: Showing,
    game: Res<Game>,
    robots: Query<(&RobotId, &Pose, &PreviousPose, &Penalty, &Belief, &Body)>,
    balls: Query<(&Pose, &PreviousPose), (With<Ball>, Without<RobotId>)>,
    mut brush: Brush,
) {
    if !showing.any(Overlay::Beliefs) {
        return;
    }
    let ball = balls.iter().next().map(|(pose, previous)| showing.place(pose, previous).position);
    for (id, pose, previous, penalty, belief, body) in &robots {
        if showing.shows(Overlay::Beliefs, *id, penalty) {
            let place = showing.place(pose, previous);
            let radius = body.torso.half_width_m - WITHIN_BODY_M;
            draw_belief(*id, (place, radius), belief, ball, game.own_end(id.team), &mut brush);
        }
    }
}

fn draw_belief(
    id: RobotId,
    (truth, radius): (Pose, f32),
    belief: &Belief,
    ball: Option<Vec2>,
    own_end: End,
    brush: &mut Brush,
) {
    draw_believed(id, radius, belief, own_end, brush);
    let white = palette::ink(DrawColour::White);
    brush.line(belief.pose_in_pitch(own_end).position, truth.position, white);
    if let (Some(believed), Some(ball)) = (&belief.ball, ball) {
        brush.line(point_pitch_from_team(believed.position_m, own_end), ball, white);
    }
}

/// Draws the world as a robot believes it, without the truth.
pub fn draw_world_of(id: RobotId, body: &Body, belief: &Belief, own_end: End, brush: &mut Brush) {
    draw_believed(id, body.torso.half_width_m - WITHIN_BODY_M, belief, own_end, brush);
}

fn draw_believed(id: RobotId, radius: f32, belief: &Belief, own_end: End, brush: &mut Brush) {
    let on_pitch = |place: Vec2| point_pitch_from_team(place, own_end);
    // The covariance needs no rotation, because half a turn does not change it.
    let own = belief.pose_in_pitch(own_end);
    let colour = palette::ink(DrawColour::Purple);
    let [xx, xy, yy, ..] = belief.pose_covariance;
    brush.pose(own, radius, colour);
    brush.ellipse(own.position, [xx, xy, yy], colour);
    if let Some(believed) = &belief.ball {
        let (at, rolls) = (on_pitch(believed.position_m), on_pitch(believed.velocity_mps));
        let colour = palette::ink(DrawColour::Orange).with_alpha(faded(believed.age_s));
        brush.circle(at, 0.05, colour);
        brush.circle(at, 0.035, colour);
        brush.ellipse(at, believed.position_covariance, colour);
        brush.line(own.position, at, colour.with_alpha(0.25));
        if rolls.length() > 0.05 {
            brush.arrow(at, at + ROLLS_FOR_S * rolls, colour);
        }
        // A ball that the robot sees now needs no text.
        if let Some(from) = believed.heard_from {
            brush.words_above(at, ABOVE_BALL_M, format!("from {from}, {:.1} s ago", believed.age_s), colour);
        } else if believed.age_s > SEEN_LATELY_S {
            brush.words_above(at, ABOVE_BALL_M, format!("seen {:.1} s ago", believed.age_s), colour);
        }
    }
    let others = [(&belief.opponents, id.team.opponent()), (&belief.team_mates, id.team)];
    for (robots, team) in others {
        for robot in robots {
            let at = on_pitch(robot.position_m);
            let colour = palette::ink(robot_ink(team)).with_alpha(faded(robot.age_s));
            brush.cross(at, 0.2, colour);
            brush.ellipse(at, robot.covariance, colour);
        }
    }
}

/// The colour of a believed robot of a team.
pub(super) fn robot_ink(team: Team) -> DrawColour {
    match team {
        Team::Blue => DrawColour::Sky,
        Team::Pink => DrawColour::Vermilion,
    }
}

/// Returns the opacity of an estimate of this age, s.
pub fn faded(age_s: f32) -> f32 {
    (1.0 - age_s / 6.0).clamp(0.35, 1.0)
}
