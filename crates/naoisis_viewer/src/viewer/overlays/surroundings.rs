//! Overlays that belong to no robot: the areas of the rules, and the last touch of the ball.

use bevy::prelude::*;

use super::geometry::corners;
use super::{Brush, Overlays};
use crate::viewer::event_log::EventLog;
use crate::viewer::palette;
use naoisis_core::ball::Ball;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, Rules};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{AreaDimensions, End, Pitch};
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;

pub(super) fn draw_areas(
    overlays: Res<Overlays>,
    pitch: Res<Pitch>,
    rules: Res<Rules>,
    game: Res<Game>,
    balls: Query<&Transform, With<Ball>>,
    mut brush: Brush,
) {
    if !overlays.areas {
        return;
    }
    let field = pitch.outer_half_extents();
    if rules.ball_out {
        brush.outline(corners(Rect { min: -field, max: field }), palette::ink(DrawColour::Yellow));
        brush.words(Vec2::new(0.0, -field.y), "out beyond", palette::ink(DrawColour::Yellow));
    }
    if rules.leaving_field {
        let carpet = pitch.carpet_half_extents();
        brush.outline(corners(Rect { min: -carpet, max: carpet }), palette::ink(DrawColour::Vermilion));
        brush.words(Vec2::new(0.0, -carpet.y), "robots stay inside", palette::ink(DrawColour::Vermilion));
    }
    for end in End::BOTH {
        let (colour, sign) = (palette::team(game.defender_of(end)), end.sign());
        for area in [Some(pitch.penalty_area), pitch.goal_area].into_iter().flatten() {
            brush.outline(corners(area_rectangle(&pitch, area, end)), colour);
        }
        let goal = Rect::from_corners(
            Vec2::new(sign * field.x, -pitch.goal.width_m / 2.0),
            Vec2::new(sign * (pitch.goal_post_x() + pitch.goal.depth_m), pitch.goal.width_m / 2.0),
        );
        brush.outline(corners(goal), palette::ink(DrawColour::White));
        brush.cross(goal.center(), 0.3, palette::ink(DrawColour::White));
    }
    let Some(ball) = balls.iter().next().map(|ball| ball.translation.truncate()) else { return };
    if rules.stalling {
        brush.circle(ball, rules.stall_radius_m, palette::ink(DrawColour::Sky));
        brush.words(ball - Vec2::Y * rules.stall_radius_m, "stalling", palette::ink(DrawColour::Sky));
    }
    if game.set_play.is_some() {
        brush.circle(ball, rules.free_kick_radius_m(&pitch), palette::ink(DrawColour::Vermilion));
        brush.words(
            ball + Vec2::Y * rules.free_kick_radius_m(&pitch),
            "opponents stay outside",
            palette::ink(DrawColour::Vermilion),
        );
    }
}

/// The area in front of the goal at `end`, to the outer edges of its lines, m, pitch frame.
fn area_rectangle(pitch: &Pitch, area: AreaDimensions, end: End) -> Rect {
    let half_line = pitch.line_width_m / 2.0;
    let outer = pitch.half_length() + half_line;
    let inner = pitch.half_length() - area.depth_m - half_line;
    let half_width = area.width_m / 2.0 + half_line;
    Rect::from_corners(Vec2::new(end.sign() * inner, -half_width), Vec2::new(end.sign() * outer, half_width))
}

pub(super) fn draw_last_touch(
    overlays: Res<Overlays>,
    log: Res<EventLog>,
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    robots: Query<(&Transform, &Body), With<RobotId>>,
    balls: Query<&Transform, With<Ball>>,
    poses: Query<&Pose>,
    mut brush: Brush,
) {
    if !overlays.last_touch {
        return;
    }
    let now_s = clock.end_time_s();
    let Some(touch) = log.last_touch(now_s) else { return };
    let Some(robot) = roster.get(touch.robot).filter(|robot| poses.contains(*robot)) else { return };
    let Ok((transform, body)) = robots.get(robot) else { return };
    let (place, around) = (transform.translation.truncate(), body.torso.half_width_m + 0.1);
    let colour = palette::ink(DrawColour::White);
    brush.circle(place, around - 0.01, colour);
    brush.circle(place, around + 0.01, colour);
    if let Some(ball) = balls.iter().next() {
        brush.line(place, ball.translation.truncate(), colour.with_alpha(0.5));
    }
    let how = if touch.kick { "kicked" } else { "touched" };
    brush.words(place + Vec2::Y * 0.3, format!("last {how} the ball {:.1} s ago", now_s - touch.time_s), colour);
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::referee::areas::in_area;

    #[test]
    fn an_area_is_drawn_where_the_rules_have_it() {
        let pitch = Pitch::default();
        for end in End::BOTH {
            let drawn = area_rectangle(&pitch, pitch.penalty_area, end);
            for corner in corners(drawn) {
                let towards_middle = corner.lerp(drawn.center(), 0.01);
                let away = corner.lerp(drawn.center(), -0.01);
                assert!(in_area(&pitch, pitch.penalty_area, end, towards_middle));
                assert!(!in_area(&pitch, pitch.penalty_area, end, away));
            }
        }
    }
}
