//! Bookmarks: moments with captions, shown one after the other like slides, each with its view, strokes of the pen and
//! robot's world.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, FontId, Key, KeyboardShortcut, Modifiers, TextEdit, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::pen::{Pen, PenMark};
use crate::viewer::camera::{CameraMode, ViewerCamera, in_another_area};
use crate::viewer::commands::{TeachAction, TimelineCommand};
use crate::viewer::display_settings::is_teaching;
use crate::viewer::event_log::EventLog;
use crate::viewer::keyframes::Keyframes;
use crate::viewer::layout::{self, FreeArea, LayoutSystems};
use crate::viewer::shared::{CameraSystems, KeysSystems, Notice, Playback, RobotsWorld, Selection};
use crate::viewer::theme::{card, dim, minutes};
use crate::viewer::timeline::Timeline;
use crate::viewer::watch::large_letters;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::RobotId;

/// The height of a caption's letters relative to the score's, and its width relative to that of the free area.
const LETTERS: f32 = 0.7;
const WIDTH: f32 = 0.7;
/// The key for a new line in a caption; Enter alone ends editing.
const NEW_LINE: KeyboardShortcut = KeyboardShortcut::new(Modifiers::SHIFT, Key::Enter);

/// Keeps and shows the [`Bookmarks`].
pub struct BookmarksPlugin;

impl Plugin for BookmarksPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, (forget, keep_strokes, apply).chain().in_set(BookmarkSystems))
            .configure_sets(Update, BookmarkSystems.after(KeysSystems).before(CameraSystems))
            .add_systems(EguiPrimaryContextPass, show_caption.run_if(is_teaching).in_set(LayoutSystems::Floating));
    }
}

/// The systems that add and show bookmarks.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct BookmarkSystems;

/// A bookmark.
#[derive(Clone, PartialEq, Debug)]
pub struct Bookmark {
    /// The cycle that had just ended.
    pub cycle: u64,
    /// The caption.
    pub caption: String,
    /// The strokes of the pen.
    pub(super) marks: Vec<PenMark>,
    /// The selected robot.
    pub(super) selected: Option<RobotId>,
    /// Whether only the world of the selected robot was shown.
    pub(super) robots_world: bool,
    /// The camera, and the aspect (width by height) of the area in which it was chosen, if that is known.
    pub(super) camera: ViewerCamera,
    pub(super) aspect: Option<f32>,
}

/// The bookmarks in the order of the match.
#[derive(Resource, Clone, Debug, Default)]
pub struct Bookmarks {
    list: Vec<Bookmark>,
    /// The bookmark that is shown.
    shown: Option<usize>,
    /// The match of the bookmarks.
    of: Keyframes,
    /// Whether they are stored in a file.
    pub(super) are_stored: bool,
}

impl Bookmarks {
    /// Returns all bookmarks.
    pub fn list(&self) -> &[Bookmark] {
        &self.list
    }

    /// Returns the index of the bookmark that is shown.
    pub fn shown(&self) -> Option<usize> {
        self.shown
    }

    /// The number of the bookmark that is shown, and how many there are.
    fn shown_words(&self) -> String {
        format!("Bookmark {} of {}", self.shown.map_or(0, |shown| shown + 1), self.list.len())
    }

    /// What is said of a new bookmark. One of a match without a file is lost with the window.
    fn added_words(&self) -> String {
        let kept =
            if self.are_stored { "" } else { ". Ctrl S saves the match with it; else it is lost with the window" };
        format!("{}: click below to write its caption; J: next one, Shift J: previous one{kept}", self.shown_words())
    }

    /// Replaces the bookmarks by those stored for a match.
    pub(super) fn take_in(&mut self, list: Vec<Bookmark>, of: &Keyframes) {
        *self = Bookmarks { list, shown: None, of: of.clone(), are_stored: self.are_stored };
    }

    /// Adds a bookmark; replaces one of the same moment, but not its caption. Returns whether there was one.
    fn add(&mut self, bookmark: Bookmark) -> bool {
        let at = self.list.partition_point(|other| other.cycle < bookmark.cycle);
        let same = self.list.get_mut(at).filter(|other| other.cycle == bookmark.cycle);
        let is_replaced = same.is_some();
        match same {
            Some(other) => *other = Bookmark { caption: core::mem::take(&mut other.caption), ..bookmark },
            None => self.list.insert(at, bookmark),
        }
        self.shown = Some(at);
        is_replaced
    }

    /// The index of the next or previous bookmark, relative to the one that is shown, else to `cycle`.
    fn neighbour(&self, forward: bool, cycle: u64) -> Option<usize> {
        let index = match (self.shown, forward) {
            (Some(shown), true) => shown + 1,
            (Some(shown), false) => shown.checked_sub(1)?,
            (None, true) => self.list.partition_point(|bookmark| bookmark.cycle < cycle),
            (None, false) => self.list.partition_point(|bookmark| bookmark.cycle < cycle).checked_sub(1)?,
        };
        (index < self.list.len()).then_some(index)
    }
}

/// Removes the bookmarks of another match, and the strokes of a bookmark when another moment is shown.
fn forget(keyframes: Res<Keyframes>, clock: Res<CycleClock>, mut pen: ResMut<Pen>, mut bookmarks: ResMut<Bookmarks>) {
    if !bookmarks.of.is_same(&keyframes) {
        if bookmarks.list.iter().any(|bookmark| !bookmark.marks.is_empty()) {
            pen.marks.retain(|mark| !bookmarks.list.iter().any(|bookmark| bookmark.marks.contains(mark)));
        }
        *bookmarks = Bookmarks { of: keyframes.clone(), ..default() };
    }
    // Once the bookmark's moment was shown, going to another moment ends it.
    let shown = bookmarks.shown.and_then(|shown| bookmarks.list.get(shown));
    if let Some(left) = shown.filter(|shown| shown.cycle.abs_diff(clock.cycle) > 1)
        && !bookmarks.is_changed()
    {
        pen.marks.retain(|mark| !left.marks.contains(mark));
        bookmarks.shown = None;
    }
}

/// Strokes that are drawn or erased while a bookmark is shown are the bookmark's.
fn keep_strokes(clock: Res<CycleClock>, pen: Res<Pen>, mut bookmarks: ResMut<Bookmarks>) {
    let Some(shown) = bookmarks.shown.and_then(|shown| bookmarks.list.get(shown)) else { return };
    if pen.is_changed() && shown.cycle.abs_diff(clock.cycle) <= 1 && shown.marks != pen.marks {
        let index = bookmarks.shown.unwrap_or_default();
        bookmarks.list[index].marks.clone_from(&pen.marks);
    }
}

fn apply(
    mut actions: MessageReader<TeachAction>,
    (clock, timeline, log): (Res<CycleClock>, Res<Timeline>, Res<EventLog>),
    mut bookmarks: ResMut<Bookmarks>,
    (mut camera, free, window): (Single<&mut ViewerCamera>, Res<FreeArea>, Query<&Window>),
    mut pen: ResMut<Pen>,
    (mut world, mut selection): (ResMut<RobotsWorld>, ResMut<Selection>),
    mut playback: ResMut<Playback>,
    mut notice: ResMut<Notice>,
    mut moments: MessageWriter<TimelineCommand>,
) {
    let aspect =
        free.aspect(window.iter().next().map_or(Vec2::ONE, |window| Vec2::new(window.width(), window.height())));
    for action in actions.read() {
        match action {
            TeachAction::Bookmark => {
                playback.paused = true;
                let cycle = timeline.cursor().map_or(clock.cycle, |cursor| cursor.round() as u64);
                let is_replaced = bookmarks.add(Bookmark {
                    cycle,
                    caption: caption(&log, cycle, clock.period_s),
                    marks: pen.marks.clone(),
                    selected: selection.0,
                    robots_world: world.0,
                    camera: **camera,
                    aspect: Some(aspect),
                });
                notice.tell(match is_replaced {
                    true => format!("{} has this view and these strokes now", bookmarks.shown_words()),
                    false => bookmarks.added_words(),
                });
            }
            TeachAction::NextBookmark | TeachAction::PreviousBookmark => {
                let forward = *action == TeachAction::NextBookmark;
                let Some(index) = bookmarks.neighbour(forward, clock.cycle) else {
                    notice.tell(if bookmarks.list.is_empty() {
                        "No bookmarks; K: add one at this moment"
                    } else {
                        match forward {
                            true => "No bookmark after this moment; Shift J: the one before",
                            false => "No bookmark before this moment; J: the next one",
                        }
                    });
                    continue;
                };
                let bookmark = bookmarks.list[index].clone();
                bookmarks.shown = Some(index);
                notice.tell(bookmarks.shown_words());
                playback.paused = true;
                pen.marks = bookmark.marks;
                selection.0 = bookmark.selected;
                world.0 = bookmark.robots_world;
                camera.wanted = in_another_area(bookmark.camera.wanted, bookmark.aspect.unwrap_or(aspect), aspect);
                camera.mode = match bookmark.camera.mode {
                    // The camera must stay where it is, so it follows nothing.
                    CameraMode::Ball | CameraMode::Play | CameraMode::Robot { .. } => CameraMode::Orbit,
                    mode => mode,
                };
                moments.write(TimelineCommand::GoTo(bookmark.cycle));
            }
            _ => {}
        }
    }
}

/// The proposed caption of the moment after a cycle: the last event if it has just happened.
fn caption(log: &EventLog, cycle: u64, period_s: f64) -> String {
    /// The greatest age of the event, s.
    const LONGEST_AGO_S: f64 = 2.0;
    let time_s = cycle as f64 * period_s;
    let mut until_now = log.until(time_s + 1.5 * period_s).iter().filter(|entry| entry.shown_cycle(period_s) <= cycle);
    let last = until_now.next_back().filter(|entry| entry.time_s >= time_s - LONGEST_AGO_S);
    last.map(|entry| entry.text.clone()).unwrap_or_default()
}

/// Shows the caption of the current bookmark in large letters, as an editable text. An empty one leaves the pitch free.
fn show_caption(
    mut contexts: EguiContexts,
    clock: Res<CycleClock>,
    mut bookmarks: ResMut<Bookmarks>,
    mut asked_to_remove: Local<Option<u64>>,
) -> Result {
    let Some(index) = bookmarks.shown else { return Ok(()) };
    let count = bookmarks.list.len();
    let Some(bookmark) = bookmarks.list.get(index) else { return Ok(()) };
    let context = contexts.ctx_mut()?;
    let letters = LETTERS * large_letters(context);
    let width = WIDTH * layout::free_area(context).width();
    let mut caption = bookmark.caption.clone();
    let mut is_removed = false;
    let at = minutes((bookmark.cycle as f64 * clock.period_s) as f32);
    let id = egui::Id::new("text of the caption");
    let is_edited = context.memory(|memory| memory.has_focus(id));
    let is_written = is_edited || !caption.is_empty();
    layout::floating(context, "caption", Align2::CENTER_BOTTOM).show(context, |ui| {
        card(ui).show(ui, |ui| {
            if is_written {
                // Whatever the width was without a text.
                ui.set_width(width);
                let text = TextEdit::multiline(&mut caption).id(id).font(FontId::proportional(letters)).desired_rows(1);
                let text = text.return_key(NEW_LINE).frame(egui::Frame::NONE).hint_text("Caption of this moment");
                let text = ui.add(text.desired_width(width));
                text.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Caption"));
                if is_edited && ui.input(|input| input.key_pressed(Key::Enter) && !input.modifiers.shift) {
                    text.surrender_focus();
                }
            }
            ui.horizontal(|ui| {
                ui.label(dim(format!("{} of {count}, at {at}", index + 1)));
                if is_edited {
                    ui.label(dim("Enter: done, Shift Enter: new line"));
                    return;
                }
                let edit = if is_written { "Edit" } else { "Write a caption" };
                if ui.small_button(edit).clicked() {
                    ui.memory_mut(|memory| memory.request_focus(id));
                }
                // It cannot be undone, so it takes two clicks.
                let is_asked = *asked_to_remove == Some(bookmark.cycle);
                if ui.small_button(if is_asked { "Remove it for good" } else { "Remove" }).clicked() {
                    (is_removed, *asked_to_remove) = (is_asked, (!is_asked).then_some(bookmark.cycle));
                }
            });
        });
    });
    if is_removed {
        bookmarks.list.remove(index);
        bookmarks.shown = None;
    } else if caption != bookmarks.list[index].caption {
        bookmarks.list[index].caption = caption;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::camera::viewpoint::Viewpoint;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::Team;

    fn bookmark(cycle: u64, caption: &str) -> Bookmark {
        let view = Viewpoint::behind(Pose::default());
        let camera = ViewerCamera { current: view, wanted: view, mode: CameraMode::Orbit };
        let (caption, marks, aspect) = (caption.to_owned(), Vec::new(), None);
        Bookmark { cycle, caption, marks, selected: None, robots_world: false, camera, aspect }
    }

    #[test]
    fn a_caption_is_an_event_of_this_moment_and_no_old_one() {
        let mut log = EventLog::default();
        log.note(10.0, [&MatchEvent::FinalWhistle]);
        assert_eq!(
            [99, 100, 115, 130].map(|cycle| caption(&log, cycle, 0.1)),
            ["", "Final whistle", "Final whistle", ""]
        );
        // A jump to a goal shows the cycle before it.
        log.note(20.0, [&MatchEvent::Goal { team: Team::Blue, scorer: None, own_goal: false, evidence: default() }]);
        assert_eq!([198, 199].map(|cycle| caption(&log, cycle, 0.1)), ["", "Goal for blue"]);
    }

    #[test]
    fn strokes_drawn_at_a_bookmark_are_its_own_and_not_those_of_the_next() {
        let stroke = |x| PenMark::Arrow(Vec2::ZERO, Vec2::new(x, 0.0));
        let mut app = App::new();
        app.insert_resource(CycleClock { cycle: 50, ..default() }).init_resource::<Pen>();
        let mut bookmarks = Bookmarks::default();
        bookmarks.add(bookmark(50, "pass"));
        app.insert_resource(bookmarks).init_resource::<Keyframes>();
        app.world_mut().resource_mut::<Bookmarks>().of = app.world().resource::<Keyframes>().clone();
        app.add_systems(Update, (forget, keep_strokes).chain());
        for cycle in [50, 80] {
            app.world_mut().resource_mut::<CycleClock>().cycle = cycle;
            (0..2).for_each(|_| app.update());
            app.world_mut().resource_mut::<Pen>().marks.push(stroke(cycle as f32));
            app.update();
        }
        let bookmarks = app.world().resource::<Bookmarks>();
        assert_eq!(bookmarks.list[0].marks, [stroke(50.0)], "the second one is drawn at another moment");
        let pen = &app.world().resource::<Pen>().marks;
        assert_eq!(pen, &[stroke(80.0)], "its strokes go with the bookmark");
        assert_eq!(bookmarks.shown, None);
    }

    #[test]
    fn strokes_of_a_bookmark_end_with_its_match() {
        let stroke = |x| PenMark::Arrow(Vec2::ZERO, Vec2::new(x, 0.0));
        let mut app = App::new();
        app.insert_resource(CycleClock { cycle: 50, ..default() }).init_resource::<Keyframes>();
        let mut bookmarks = Bookmarks { of: app.world().resource::<Keyframes>().clone(), ..default() };
        bookmarks.add(Bookmark { marks: vec![stroke(1.0)], ..bookmark(50, "pass") });
        app.insert_resource(bookmarks).add_systems(Update, forget);
        app.init_resource::<Pen>().world_mut().resource_mut::<Pen>().marks = vec![stroke(1.0), stroke(2.0)];
        app.insert_resource(Keyframes::default()).update();
        assert_eq!(app.world().resource::<Pen>().marks, [stroke(2.0)]);
    }

    #[test]
    fn a_bookmark_that_is_not_stored_is_said_to_be_lost() {
        let mut bookmarks = Bookmarks::default();
        bookmarks.add(bookmark(50, "pass"));
        assert!(bookmarks.added_words().contains("Ctrl S saves"));
        bookmarks.are_stored = true;
        assert_eq!(
            bookmarks.added_words(),
            "Bookmark 1 of 1: click below to write its caption; J: next one, Shift J: previous one"
        );
    }

    #[test]
    fn bookmarks_are_in_the_order_of_the_match_and_are_stepped_through() {
        let mut bookmarks = Bookmarks::default();
        for cycle in [50, 10, 90] {
            bookmarks.add(bookmark(cycle, "seen"));
        }
        assert_eq!(bookmarks.list.iter().map(|bookmark| bookmark.cycle).collect::<Vec<_>>(), [10, 50, 90]);
        assert_eq!(bookmarks.neighbour(true, 0), None, "the last one is shown");
        assert_eq!(bookmarks.neighbour(false, 0), Some(1));
        bookmarks.shown = None;
        assert_eq!([bookmarks.neighbour(true, 20), bookmarks.neighbour(false, 20)], [Some(1), Some(0)]);
        assert_eq!([bookmarks.neighbour(true, 91), bookmarks.neighbour(false, 5)], [None, None]);
        // If a bookmark of the same moment is made again, the caption stays.
        bookmarks.add(Bookmark { robots_world: true, ..bookmark(50, "") });
        assert!(bookmarks.list.len() == 3 && bookmarks.list[1].caption == "seen" && bookmarks.list[1].robots_world);
    }
}
