//! What a kick is worth: which team will have the ball afterwards, where, and how far that is from a goal.

use bevy::math::ops;
use bevy::prelude::*;

use super::kicking::room_along;
use super::passing::meet;
use super::player::Player;
use super::{knob};
use crate::belief::RobotBelief;
use crate::pitch::Pitch;

/// How the ball slows down, per second: as it does by default.
const DRAG_PER_S: f32 = 0.5;

/// Everybody who could go for the ball, as a player sees it.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The pitch.
    pub pitch: &'a Pitch,
    /// Team-mates with the time until they can go, m, team frame, and s.
    pub ours: Vec<(Vec2, f32)>,
    /// Opponents.
    pub theirs: &'a [RobotBelief],
    /// How fast everybody walks, m/s.
    pub walk_mps: f32,
}

impl Scene<'_> {
    /// The chance that the own team is first at a ball that rolls so, and where it is met, m.
    pub fn control(&self, ball: Vec2, velocity: Vec2) -> (f32, Vec2) {
        let goal = Vec2::new(self.pitch.half_length(), 0.0);
        let arrival = |from: Vec2, delay_s: f32, goal: Vec2| {
            let (place, time_s) = meet(ball, velocity, from, self.walk_mps);
            let forwards = (place - from).normalize_or(Vec2::X).dot((goal - place).normalize_or(Vec2::X));
            (time_s + delay_s + knob("around", 1.0) * (1.0 - forwards), place)
        };
        let sooner = |best: (f32, Vec2), next: (f32, Vec2)| if next.0 < best.0 { next } else { best };
        let far = (60.0, ball);
        let ours = self.ours.iter().map(|(from, delay_s)| arrival(*from, *delay_s, goal)).fold(far, sooner);
        let theirs = self.theirs.iter().map(|other| arrival(other.position_m, 0.0, -goal)).fold(far, sooner);
        let share = 1.0 / (1.0 + ops::exp((ours.0 - theirs.0) / knob("soft", 1.5)));
        (share, if ours.0 < theirs.0 { ours.1 } else { theirs.1 })
    }

    /// What it is worth for a team to have the ball at a place, m, in the frame of that team: about the chance of a goal.
    pub fn place_value(&self, place: Vec2) -> f32 {
        let goal = Vec2::new(self.pitch.half_length(), 0.0);
        let way = goal - place;
        let distance = way.length();
        let near = ((distance - 0.8) / knob("near", 1.1)).max(0.0);
        let width = (way.x / distance.max(0.1)).clamp(0.0, 1.0);
        let front = knob("vgoal", 0.4) * ops::exp(-near * near) * (0.3 + 0.7 * width);
        0.03 + front + knob("slope", 0.02) * place.x / self.pitch.half_length()
    }

    /// The expected value of a kick that would send the ball so far, m, in this direction.
    pub fn kick_value(&self, ball: Vec2, direction: Vec2, distance_m: f32) -> f32 {
        let (half_length, half_width) = (self.pitch.half_length(), self.pitch.half_width());
        let line_m = (half_length - ball.x) / direction.x.max(1e-3);
        let half_goal = self.pitch.goal.width_m / 2.0;
        let y = ball.y + direction.y * line_m;
        if direction.x > 0.05 && line_m < 0.95 * distance_m && y.abs() < half_goal + 0.3 {
            let room_of_posts = (half_goal - 0.05 - y.abs()) * direction.x - 0.04;
            let room = room_along(ball, direction, line_m, self.theirs).min(room_of_posts);
            let far = line_m / knob("shotfar", 2.4);
            let goal = knob("pshot", 0.7) * ((room + 0.03) / knob("room", 0.25)).clamp(0.0, 1.0) * ops::exp(-far * far);
            return goal + (1.0 - goal) * knob("fail", 0.0);
        }
        let velocity = direction * (distance_m * DRAG_PER_S);
        let rest = ball + direction * distance_m;
        let (share, place) = self.control(ball, velocity);
        let out = (rest.y.abs() - half_width + 0.15).max(rest.x.abs() - half_length + 0.15).max(0.0);
        let end = place.clamp(Vec2::new(-half_length, -half_width), Vec2::new(half_length, half_width));
        let value = share * self.place_value(end) - (1.0 - share) * self.place_value(-end);
        if out > 0.0 { value.min(knob("out", -0.05)) } else { value }
    }
}

/// The scene as `player` sees it: team-mates heard of of late, and itself after `own_delay_s`.
pub fn scene<'a>(player: &Player<'a>, theirs: &'a [RobotBelief], own_delay_s: f32) -> Scene<'a> {
    let mates = player.belief.team_mates.iter().filter(|mate| mate.age_s < 1.0).map(|mate| (mate.position_m, 0.0));
    let ours = mates.chain([(player.position(), own_delay_s)]).collect();
    Scene { pitch: player.pitch, ours, theirs, walk_mps: player.limits.max_linear_mps }
}
