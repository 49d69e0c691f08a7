//! The world of one robot: its beliefs are shown, and the true robots and ball are hidden.

use bevy::prelude::*;

use crate::viewer::camera::{CameraMode, ViewerCamera};
use crate::viewer::commands::{SelectionCommand, TeachAction};
use crate::viewer::display_settings::{DisplaySettings, Workspace};
use crate::viewer::overlays::{Brush, draw_world_of};
use crate::viewer::palette;
use crate::viewer::shared::{Notice, RobotsWorld, Selection};
use naoisis_core::ball::BallPhysics;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::game::Game;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;

pub(super) fn apply(
    mut actions: MessageReader<TeachAction>,
    selection: Res<Selection>,
    roster: Res<Roster>,
    mut world: ResMut<RobotsWorld>,
    mut choices: MessageWriter<SelectionCommand>,
    mut notice: ResMut<Notice>,
) {
    for _ in actions.read().filter(|action| **action == TeachAction::RobotsWorld) {
        world.0 = !world.0;
        let whose = selection.0.or_else(|| roster.iter().next().map(|(id, _)| id));
        let Some(whose) = whose.filter(|_| world.0) else {
            world.0 = false;
            notice.tell("The truth");
            continue;
        };
        choices.write(SelectionCommand::Robot(whose));
        notice.tell(world_words(whose));
    }
}

fn world_words(whose: RobotId) -> String {
    format!("The world as {whose} believes it; Y: the truth")
}

/// Says whose world it is when another robot is selected.
pub(super) fn tell_whose(
    selection: Res<Selection>,
    mut before: Local<Option<RobotId>>,
    world: Res<RobotsWorld>,
    mut notice: ResMut<Notice>,
) {
    let selected = selection.0;
    if selected != core::mem::replace(&mut *before, selected)
        && let Some(whose) = selected.filter(|_| world.0)
    {
        notice.tell(world_words(whose));
    }
}

/// Returns to the truth when no robot is selected, in the use for watching, and in the view through a robot's camera, which has no beliefs
/// in it.
pub(super) fn leave(
    (selection, display): (Res<Selection>, Res<DisplaySettings>),
    mut before: Local<Option<Workspace>>,
    camera: Single<&ViewerCamera>,
    mut world: ResMut<RobotsWorld>,
    mut notice: ResMut<Notice>,
) {
    let is_camera = matches!(camera.mode, CameraMode::RobotCamera(_));
    let is_watched = display.workspace == Workspace::Watch && *before != Some(Workspace::Watch);
    *before = Some(display.workspace);
    if world.0 && (selection.0.is_none() || is_camera || is_watched) {
        world.0 = false;
        notice.tell(match (is_camera, is_watched) {
            (true, _) => "The truth, as cameras see it",
            (false, true) => "The truth; Y: one robot's world",
            (false, false) => "No robot is selected: the truth",
        });
    }
}

/// Hides or shows the true balls. Robots are hidden by the same system as the robot whose camera is used.
pub(super) fn hide_ball(world: Res<RobotsWorld>, mut balls: Query<&mut Visibility, With<BallPhysics>>) {
    let wanted = if world.0 { Visibility::Hidden } else { Visibility::Inherited };
    for mut visibility in &mut balls {
        visibility.set_if_neq(wanted);
    }
}

pub(super) fn draw(
    world: Res<RobotsWorld>,
    selection: Res<Selection>,
    roster: Res<Roster>,
    game: Res<Game>,
    robots: Query<(&RobotId, Option<&Belief>, &Body)>,
    mut brush: Brush,
) {
    let robot = selection.0.filter(|_| world.0).and_then(|id| robots.get(roster.get(id)?).ok());
    let Some((id, belief, body)) = robot else { return };
    match belief {
        Some(belief) => {
            let own_end = game.own_end(id.team);
            draw_world_of(*id, body, belief, own_end, &mut brush);
            let here = belief.pose_in_pitch(own_end).position;
            let (place, white) = (here + 0.25 * Vec2::Y, palette::ink(DrawColour::White));
            brush.words_above(place, body.height_m, format!("{id}, itself"), white);
        }
        None => brush.words(Vec2::ZERO, format!("{id} has no belief"), palette::ink(DrawColour::White)),
    }
}
