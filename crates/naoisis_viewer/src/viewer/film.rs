//! Records the window, with or without its panels, as a video or a folder of PNG files.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use std::path::PathBuf;
use std::thread::{self, JoinHandle};

use super::commands::ToggleFilm;
use super::layout::HiddenPanels;
use super::picture::{FITTING_S, PictureSystems, picture_of};
use super::shared::Notice;
use naoisis_core::cycle::CycleClock;
use naoisis_record::record::encoder::RecordError;
use naoisis_record::record::film::{FRAME_S, Film};

/// Said when a recording ends, until it is written.
const WRITING: &str = "Writing the recording…";
/// The most files of one name.
const MOST_OF_ONE_NAME: u32 = 1000;

/// Records what is shown.
pub struct FilmPlugin;

impl Plugin for FilmPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Filming>()
            .add_message::<ToggleFilm>()
            .init_resource::<HiddenPanels>()
            .add_systems(Update, (toggle, hide_panels, take_pictures, tell_of_ends).chain().after(PictureSystems))
            .add_systems(Last, finish_at_exit);
    }
}

/// The recording in progress, and recordings that are still being written.
#[derive(Resource, Debug, Default)]
pub struct Filming {
    film: Option<(Film, f64)>,
    /// When a picture was last requested, s of real time.
    asked_at_s: Option<f64>,
    /// Whether panels are hidden.
    is_without_panels: bool,
    /// Whether the recording ends after the first picture, which has not arrived yet.
    ends_soon: bool,
    ending: Vec<(PathBuf, JoinHandle<Result<u64, RecordError>>)>,
}

impl Filming {
    /// Returns whether a recording is in progress.
    pub fn is_on(&self) -> bool {
        self.film.is_some()
    }

    /// Starts a recording with panels whose first picture is taken at `start_s`, s of real time.
    pub fn begin(&mut self, film: Film, start_s: f64) {
        self.film = Some((film, start_s));
        self.is_without_panels = false;
        self.asked_at_s = None;
        self.ends_soon = false;
    }

    /// Ends the recording; it is written in the background.
    fn end(&mut self) {
        if let Some((film, _)) = self.film.take() {
            let path = film.path().to_owned();
            self.ending.push((path, thread::spawn(move || film.finish())));
        }
    }
}

fn toggle(
    mut toggles: MessageReader<ToggleFilm>,
    clock: Res<CycleClock>,
    time: Res<Time<Real>>,
    mut filming: ResMut<Filming>,
    mut notice: ResMut<Notice>,
) {
    for kind in toggles.read() {
        if let Some((film, _)) = &filming.film {
            // Pictures arrive some frames after they are requested.
            if film.is_empty() {
                filming.ends_soon = true;
            } else {
                filming.end();
            }
            notice.tell(WRITING);
            continue;
        }
        match create(*kind, clock.cycle) {
            Ok(film) => {
                let is_without_panels = *kind == ToggleFilm::VideoOfMatch;
                // Notices are hidden with the panels.
                if !is_without_panels {
                    notice.tell(format!("Recording {}", film.path().display()));
                }
                let fitting_s = if is_without_panels { FITTING_S } else { 0.0 };
                filming.begin(film, time.elapsed_secs_f64() + fitting_s);
                filming.is_without_panels = is_without_panels;
            }
            Err(error) => notice.tell(format!("Cannot record: {error}")),
        }
    }
}

/// A recording in the current folder, with a free name.
fn create(kind: ToggleFilm, cycle: u64) -> Result<Film, RecordError> {
    let mut attempt = 1;
    loop {
        let suffix = if attempt == 1 { String::new() } else { format!("-{attempt}") };
        let name = format!("naoisis-{cycle:06}{suffix}");
        let film = match kind {
            ToggleFilm::Video | ToggleFilm::VideoOfMatch => Film::create_video(&PathBuf::from(name + ".mp4")),
            ToggleFilm::Frames => Film::create_frames(&PathBuf::from(name)),
        };
        match film {
            Err(RecordError::Exists(_) | RecordError::NotEmpty(_)) if attempt < MOST_OF_ONE_NAME => attempt += 1,
            film => return film,
        }
    }
}

fn hide_panels(filming: Res<Filming>, mut hidden: ResMut<HiddenPanels>) {
    let for_film = filming.is_on() && filming.is_without_panels;
    if hidden.for_film != for_film {
        hidden.for_film = for_film;
    }
}

/// Marks the pictures of a recording.
#[derive(Component)]
struct OfFilm;

/// Requests a picture of the window when one is due.
fn take_pictures(
    time: Res<Time<Real>>,
    mut filming: ResMut<Filming>,
    pictures: Query<(), (Added<Screenshot>, Without<OfFilm>)>,
    mut commands: Commands,
) {
    // There is one picture of a frame at most: one that was asked for comes first.
    if !pictures.is_empty() {
        return;
    }
    let now_s = time.elapsed_secs_f64();
    if filming.film.as_ref().is_none_or(|(_, start_s)| now_s < *start_s) {
        return;
    }
    // A little less than the time between pictures, so that no frame is missed on a display with exactly that rate.
    if filming.asked_at_s.is_some_and(|asked_at_s| now_s - asked_at_s < 0.9 * FRAME_S) {
        return;
    }
    filming.asked_at_s = Some(now_s);
    let keep = move |captured: On<ScreenshotCaptured>, mut filming: ResMut<Filming>, mut notice: ResMut<Notice>| {
        let Some((film, began_at_s)) = &mut filming.film else { return };
        let Some(picture) = picture_of(&captured.image) else { return };
        if !film.add((now_s - *began_at_s).max(0.0), picture) {
            notice.tell("The size of the window has changed: the recording ends here");
            filming.end();
        } else if filming.ends_soon {
            filming.end();
        }
    };
    commands.spawn((Screenshot::primary_window(), OfFilm)).observe(keep);
}

fn tell_of_ends(mut filming: ResMut<Filming>, mut notice: ResMut<Notice>) {
    if filming.film.as_ref().is_some_and(|(film, _)| film.has_failed()) {
        filming.end();
    }
    let (ended, going_on): (Vec<_>, Vec<_>) =
        core::mem::take(&mut filming.ending).into_iter().partition(|(_, thread)| thread.is_finished());
    filming.ending = going_on;
    for (path, thread) in ended {
        notice.tell(match thread.join() {
            Ok(Ok(pictures)) => format!("Saved {}: {:.1} s", path.display(), pictures as f64 * FRAME_S),
            Ok(Err(error)) => format!("The recording ended early: {error}"),
            Err(_) => format!("The recording ended early: {}", path.display()),
        });
    }
}

/// Completes the recordings when the window is closed.
fn finish_at_exit(mut exits: MessageReader<AppExit>, mut filming: ResMut<Filming>) {
    if exits.read().next().is_none() {
        return;
    }
    filming.end();
    for (path, thread) in core::mem::take(&mut filming.ending) {
        if !matches!(thread.join(), Ok(Ok(_))) {
            warn!("{}: the recording is incomplete", path.display());
        }
    }
}
