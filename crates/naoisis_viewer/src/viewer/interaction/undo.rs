//! Undo and redo of actions by hand: positions, kicks, penalties, strokes of the pen.
//!
//! Interventions that are still pending are removed. Others are undone by another [`Intervention`], which puts the
//! robot or ball back, so the trace contains both and can be replayed.

use bevy::prelude::*;

use super::asked::{asked_ball, asked_pose};
use super::refusal;
use crate::viewer::keyframes::{Keyframes, KeyframesName};
use crate::viewer::pen_marks::{Pen, PenMark};
use crate::viewer::shared::Notice;
use naoisis_core::ball::{Ball, BallVelocity};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Intervention, Interventions, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// The most steps that are remembered.
const MOST: usize = 200;

/// The steps that can be undone and redone.
#[derive(Resource, Clone, Debug, Default)]
pub struct Undo {
    /// Steps that were done, the last one last.
    done: Vec<Step>,
    /// Steps that were undone, the last one last.
    undone: Vec<Step>,
    /// The strokes of the pen that have been noted.
    marks: Vec<PenMark>,
    /// The match of the steps.
    of: Keyframes,
    /// The interventions of other matches and branches, done and undone.
    aside: Vec<(KeyframesName, [Vec<Step>; 2])>,
}

/// A step.
#[derive(Clone, PartialEq, Debug)]
enum Step {
    /// An intervention, and those that undo it; none if it cannot be undone.
    Hand { act: Intervention, back: Vec<Intervention> },
    /// A stroke of the pen.
    Drawn(PenMark),
    /// An erased stroke.
    Erased(PenMark),
}

impl Step {
    fn words(&self) -> String {
        match self {
            Step::Hand { act, .. } => act.to_string(),
            Step::Drawn(PenMark::Arrow(..)) => "an arrow is drawn".to_owned(),
            Step::Drawn(PenMark::Zone(..)) => "a zone is drawn".to_owned(),
            Step::Erased(_) => "a mark is erased".to_owned(),
        }
    }
}

impl Undo {
    /// Returns the number of steps to undo, and to redo.
    pub fn counts(&self) -> [usize; 2] {
        [self.done.len(), self.undone.len()]
    }

    fn note(&mut self, step: Step) {
        self.done.push(step);
        self.undone.clear();
        let surplus = self.done.len().saturating_sub(MOST);
        self.done.drain(..surplus);
    }
}

/// Performs an intervention that can be undone.
pub(super) fn act(world: &mut World, act: Intervention) {
    let back = way_back(world, act);
    act.apply(world);
    world.get_resource_or_init::<Undo>().note(Step::Hand { act, back });
}

/// The interventions that undo `act`, in the state before it.
fn way_back(world: &mut World, act: Intervention) -> Vec<Intervention> {
    match act {
        Intervention::PlaceRobot { robot, .. } => {
            robot_pose(world, robot).map(|pose| Intervention::PlaceRobot { robot, pose }).into_iter().collect()
        }
        Intervention::PlaceBall { .. } | Intervention::DropBall { .. } => ball(world).into_iter().collect(),
        Intervention::Penalise { robot, .. } | Intervention::PickUp { robot } => {
            let place = robot_pose(world, robot).map(|pose| Intervention::PlaceRobot { robot, pose });
            core::iter::once(Intervention::Return { robot }).chain(place).collect()
        }
        Intervention::Return { robot } => {
            let penalty = world.resource::<Roster>().get(robot).and_then(|entity| world.get::<Penalty>(entity)?.0);
            let clock = world.resource::<CycleClock>();
            let again = penalty.map(|penalty| Intervention::Penalise {
                robot,
                reason: penalty.reason,
                duration_s: Some(penalty.left_s(clock) as f32),
            });
            again.into_iter().collect()
        }
        Intervention::Stop => vec![Intervention::Resume],
        Intervention::Resume => vec![Intervention::Stop],
        Intervention::SetScore { .. }
        | Intervention::Whistle
        | Intervention::KickOff { .. }
        | Intervention::Timeout { .. }
        | Intervention::Substitute { .. } => Vec::new(),
    }
}

/// The pose of a robot, including pending interventions.
fn robot_pose(world: &World, wanted: RobotId) -> Option<Pose> {
    let asked = asked_pose(&world.resource::<Interventions>().queue, wanted);
    asked.or_else(|| world.get::<Pose>(world.resource::<Roster>().get(wanted)?).copied())
}

/// The intervention that restores the current or pending position and velocity of the ball.
fn ball(world: &mut World) -> Option<Intervention> {
    let asked = asked_ball(&world.resource::<Interventions>().queue);
    let mut balls = world.query_filtered::<(&Pose, &BallVelocity), With<Ball>>();
    let ball = asked.or_else(|| balls.iter(world).next().map(|(pose, velocity)| (pose.position, velocity.0)));
    ball.map(|(position_m, velocity_mps)| Intervention::PlaceBall { position_m, velocity_mps })
}

/// Undoes the last step. Returns a notice for the user.
pub(super) fn undo(world: &mut World) -> String {
    change_match(world);
    let Some(step) = world.get_resource_or_init::<Undo>().done.pop() else {
        return "Nothing to undo".to_owned();
    };
    let why_not = why_it_cannot_be(world, &step);
    if let Some(why) = why_not {
        world.resource_mut::<Undo>().done.push(step);
        return why;
    }
    match &step {
        Step::Hand { act, back } => {
            let mut interventions = world.resource_mut::<Interventions>();
            if let Some(index) = interventions.queue.iter().rposition(|asked| asked == act) {
                interventions.queue.remove(index);
            } else if back.is_empty() {
                let words =
                    format!("Cannot be undone: {}. Go to a moment before it (Left), and branch (F)", step.words());
                // What was done before stays, too: since then, the referee has placed robots and the ball. A whistle moves nothing.
                if *act != Intervention::Whistle {
                    world.resource_mut::<Undo>().done.push(step);
                }
                return words;
            } else {
                interventions.queue.extend(back);
            }
        }
        Step::Drawn(_) => change_marks(world, None),
        Step::Erased(mark) => change_marks(world, Some(*mark)),
    }
    let words = format!("Undone: {}", step.words());
    world.resource_mut::<Undo>().undone.push(step);
    words
}

/// Redoes the last undone step. Returns a notice for the user.
pub(super) fn redo(world: &mut World) -> String {
    change_match(world);
    let Some(step) = world.get_resource_or_init::<Undo>().undone.pop() else {
        return "Nothing to redo".to_owned();
    };
    if let Some(why) = why_it_cannot_be(world, &step) {
        world.resource_mut::<Undo>().undone.push(step);
        return why;
    }
    let step = match step {
        Step::Hand { act, .. } => {
            // The way back starts from the current places.
            let back = way_back(world, act);
            act.apply(world);
            Step::Hand { act, back }
        }
        Step::Drawn(mark) => {
            change_marks(world, Some(mark));
            step
        }
        Step::Erased(_) => {
            change_marks(world, None);
            step
        }
    };
    let words = format!("Redone: {}", step.words());
    world.resource_mut::<Undo>().done.push(step);
    words
}

/// Returns the reason if a step cannot be undone or redone now: in the past and after the end of a match, only strokes of the pen can be.
fn why_it_cannot_be(world: &World, step: &Step) -> Option<String> {
    matches!(step, Step::Hand { .. }).then(|| refusal(world).map(str::to_owned)).flatten()
}

/// Puts the interventions of another match or branch aside, and takes those of the one that is shown out again, if it was shown before. Strokes of
/// the pen stay.
fn change_match(world: &mut World) {
    let now = world.get_resource_or_init::<Keyframes>().clone();
    let mut undo = world.get_resource_or_init::<Undo>();
    if undo.of.is_same(&now) {
        return;
    }
    let undo = &mut *undo;
    let is_hand = |step: &mut Step| matches!(step, Step::Hand { .. });
    let aside = [&mut undo.done, &mut undo.undone].map(|steps| steps.extract_if(.., is_hand).collect());
    undo.aside.push((undo.of.name(), aside));
    undo.aside.retain(|(name, _)| name.is_kept());
    if let Some(index) = undo.aside.iter().position(|(name, _)| name.is_of(&now)) {
        let (_, [done, undone]) = undo.aside.swap_remove(index);
        undo.done.extend(done);
        undo.undone.extend(undone);
    }
    undo.of = now;
}

/// Adds a stroke, or removes the last one.
fn change_marks(world: &mut World, drawn: Option<PenMark>) {
    let Some(mut pen) = world.get_resource_mut::<Pen>() else { return };
    match drawn {
        Some(mark) => pen.marks.push(mark),
        None => {
            pen.marks.pop();
        }
    }
    let marks = pen.marks.clone();
    world.resource_mut::<Undo>().marks = marks;
}

/// Notes new strokes of the pen.
pub(super) fn note_marks(pen: Option<Res<Pen>>, mut undo: ResMut<Undo>) {
    let Some(pen) = pen.filter(|pen| pen.is_changed() && pen.marks != undo.marks) else { return };
    let (known, now) = (undo.marks.clone(), &pen.marks);
    if now.len() > known.len() && now.starts_with(&known) {
        now[known.len()..].iter().for_each(|mark| undo.note(Step::Drawn(*mark)));
    } else if known.len() == now.len() + 1 && known.starts_with(now) {
        undo.note(Step::Erased(known[now.len()]));
    } else {
        // A bookmark brings its own marks, so steps of the pen can no longer be undone.
        undo.done.retain(|step| matches!(step, Step::Hand { .. }));
        undo.undone.retain(|step| matches!(step, Step::Hand { .. }));
    }
    undo.marks.clone_from(&pen.marks);
}

/// Has the steps of the match that is shown.
pub(super) fn reset(world: &mut World) {
    change_match(world);
}

/// Performs an undo or redo that a key or button asked for.
pub(super) fn apply(world: &mut World, is_undo: bool) {
    let words = if is_undo { undo(world) } else { redo(world) };
    world.resource_mut::<Notice>().tell(words);
}
