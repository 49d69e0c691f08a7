//! Presenting a match: a pen on the pitch, the world of one robot without the truth, and bookmarks with captions.

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

pub(super) mod believed_bodies;
pub mod bookmark_file;
pub mod bookmarks;
pub mod pen;
mod robots_world;

use super::overlays::OverlaySystems;
use super::pitch_frame::PitchFrameSystems;
use super::shared::{CameraSystems, KeysSystems, OpenedTrace, RobotsWorld, TeachAction};
use believed_bodies::BelievedBodies;
use bookmarks::Bookmarks;
use pen::Pen;

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
            .add_systems(Update, bookmark_file::keep)
            .add_systems(
                Update,
                (pen::apply, robots_world::apply, pen::draw).chain().after(KeysSystems).before(CameraSystems),
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
