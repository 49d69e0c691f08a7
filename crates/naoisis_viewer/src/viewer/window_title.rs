//! The title of the window: the file or the scenario of the match.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use std::path::Path;

use super::drive::PlayedFile;
use super::shared::OpenedTrace;
use super::timeline::Timeline;
use naoisis_sim::scenario::Scenario;

/// Sets the title of the window.
pub(super) struct WindowTitlePlugin;

impl Plugin for WindowTitlePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OpenedTrace>().add_systems(Last, set_title);
    }
}

fn set_title(
    (trace, timeline): (Res<OpenedTrace>, Res<Timeline>),
    played: Option<Res<PlayedFile>>,
    scenario: Option<Res<Scenario>>,
    mut windows: Query<&mut Window, With<PrimaryWindow>>,
) {
    let source = played.as_ref().and_then(|played| played.0.as_ref()).map(|file| Path::new(&file.source.name));
    let shown = trace.0.as_deref().filter(|_| timeline.is_replay());
    let title = title(shown.or(source), scenario.as_deref());
    for mut window in &mut windows {
        if window.title != title {
            window.title.clone_from(&title);
        }
    }
}

/// The title for a file and its scenario. What distinguishes two windows is in front.
fn title(file: Option<&Path>, scenario: Option<&Scenario>) -> String {
    let file = file.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let name = scenario.map(|scenario| scenario.name.clone()).filter(|name| !name.is_empty());
    let seed = scenario.map(|scenario| format!("seed {}", scenario.seed));
    let parts: Vec<String> = file.or(name).into_iter().chain(seed).collect();
    if parts.is_empty() { "naoisis".to_owned() } else { format!("{} – naoisis", parts.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_title_has_the_file_or_the_name_and_the_seed() {
        let scenario = Scenario { name: "match3v3".to_owned(), seed: 7, ..default() };
        let path = Path::new("/tmp/final.jsonl.zst");
        assert_eq!(title(Some(path), Some(&scenario)), "final.jsonl.zst, seed 7 – naoisis");
        assert_eq!(title(None, Some(&scenario)), "match3v3, seed 7 – naoisis");
        assert_eq!(title(None, None), "naoisis");
    }
}
