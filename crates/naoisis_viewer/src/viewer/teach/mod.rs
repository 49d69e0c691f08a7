//! Presenting a match: a pen on the pitch, the world of one robot without the truth, and bookmarks with captions.

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

pub(super) mod believed_bodies;
pub mod bookmark_file;
pub mod bookmarks;
pub mod pen;
mod robots_world;

use super::commands::{TeachAction, ViewerCommand};
use super::display_settings::is_teaching;
use super::overlays::OverlaySystems;
use super::pitch_frame::PitchFrameSystems;
use super::shared::{
    CameraSystems, KeysSystems, Notice, OpenedTrace, Playback, RobotsWorld, SelectionSystems, TraceSaved,
};
use believed_bodies::BelievedBodies;
use bookmarks::Bookmarks;
use pen::Pen;

/// Tells what a key has done to the time: there is no bar that shows it.
fn tell_time(mut commands: MessageReader<ViewerCommand>, playback: Res<Playback>, mut notice: ResMut<Notice>) {
    for command in commands.read() {
        let speed = match command {
            ViewerCommand::TogglePause => {
                notice.tell(if playback.paused { "Goes on" } else { "Paused" });
                continue;
            }
            ViewerCommand::Faster => playback.speed.neighbour(1),
            ViewerCommand::Slower => playback.speed.neighbour(-1),
            ViewerCommand::SetSpeed(speed) => *speed,
            _ => continue,
        };
        notice.tell(format!("Speed {speed}"));
    }
}

/// The tools for presenting a match.
pub struct TeachPlugin;

impl Plugin for TeachPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Pen>()
            .init_resource::<Bookmarks>()
            .init_resource::<RobotsWorld>()
            .init_resource::<BelievedBodies>()
            .add_message::<TeachAction>()
            .init_resource::<OpenedTrace>()
            .init_resource::<bookmark_file::BookmarkFile>()
            .add_plugins(bookmarks::BookmarksPlugin)
            .add_message::<TraceSaved>()
            .add_systems(Update, (bookmark_file::keep, bookmark_file::keep_beside_trace).chain())
            .add_systems(
                Update,
                (pen::apply, robots_world::apply, pen::draw).chain().after(KeysSystems).before(CameraSystems),
            )
            .add_systems(Update, tell_time.run_if(is_teaching).after(KeysSystems))
            .add_systems(
                Update,
                (robots_world::tell_whose, robots_world::leave)
                    .chain()
                    .after(bookmarks::BookmarkSystems)
                    .after(SelectionSystems)
                    .after(CameraSystems),
            )
            .add_systems(
                PostUpdate,
                (
                    robots_world::hide_ball,
                    believed_bodies::show
                        .run_if(believed_bodies::is_needed)
                        .in_set(PitchFrameSystems)
                        .before(TransformSystems::Propagate),
                    (pen::show, robots_world::draw).after(OverlaySystems).before(EguiPostUpdateSet::EndPass),
                ),
            );
    }
}
