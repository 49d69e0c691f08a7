//! The thread that replays the match.

use bevy::prelude::*;
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};

use super::{PlayAgain, RebuiltMoment, Reply, Request, Wanted};
use crate::viewer::behaviour_state::all_states;
use crate::viewer::keyframes::{Keyframes, MakeApp, keep_if_due};
use naoisis_core::behaviour::REMOTE;
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::cycle::{CycleClock, run_cycle};
use naoisis_core::game::{Game, GameState};
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_record::whatif::{Moment, is_same};
use naoisis_sensing::sensing::jobs::SensingThreads;
use naoisis_sensing::sensing::vision::{MissedObject, Percepts, Unrecognised};
use naoisis_sim::scenario::BehaviourSpec;
use naoisis_sim::simulation::{MatchApp, situation};

/// The number of cycles between two checks for requests.
const AT_ONCE: usize = 10;

/// Serves requests until the sender is dropped.
pub(super) fn serve(simulator: MakeApp, requests: &Receiver<Request>, replies: &Sender<Reply>) {
    let mut again: Option<Again> = None;
    let mut moments = Moments { simulator, app: None };
    let mut wanted: Option<Wanted> = None;
    loop {
        let is_busy = again.as_ref().is_some_and(|again| !again.is_over);
        let request = if is_busy {
            match requests.try_recv() {
                Ok(request) => Some(request),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => return,
            }
        } else {
            match requests.recv() {
                Ok(request) => Some(request),
                Err(_) => return,
            }
        };
        match request {
            Some(Request::Play(play)) => {
                wanted = None;
                again = Again::begin(simulator(), *play, replies);
            }
            Some(Request::More(records)) => {
                if let Some(again) = &mut again {
                    again.play.records = records;
                    again.is_over = again.is_other;
                }
            }
            Some(Request::Rebuild(new)) => wanted = Some(*new),
            Some(Request::Forget) => (again, wanted) = (None, None),
            None => {}
        }
        if let Some(again) = again.as_mut().filter(|again| !again.is_over) {
            again.go_on(replies);
        }
        // If the match is being played again, only the cycles reached so far can be rebuilt.
        let reached = again.as_ref().filter(|again| !again.is_over).map_or(u64::MAX, |again| again.until());
        if let Some(wanted) = wanted.take_if(|wanted| wanted.cycle <= reached) {
            let rebuilt = moments.rebuild(&wanted);
            if replies.send(rebuilt.map_or_else(Reply::Failed, |moment| Reply::Moment(Box::new(moment)))).is_err() {
                return;
            }
        }
    }
}

/// The match of a trace while it is replayed.
struct Again {
    app: App,
    play: PlayAgain,
    /// Whether there is nothing to replay at present.
    is_over: bool,
    /// Whether it has become another match.
    is_other: bool,
}

impl Again {
    fn begin(mut app: App, play: PlayAgain, replies: &Sender<Reply>) -> Option<Self> {
        app.insert_resource(SensingThreads(1)).insert_resource(play.keyframes.clone());
        let fail = |message: String| {
            let _nobody_listens = replies.send(Reply::Failed(message));
            None
        };
        // The programs are not even started.
        if play.scenario.robots.iter().any(|robot| is_from_outside(&robot.behaviour)) {
            return fail("robots of this match were played by programs, whose state is not recorded".to_owned());
        }
        if let Err(fault) = app.start_match(&play.scenario) {
            return fail(fault.to_string());
        }
        keep_if_due(app.world_mut());
        match play.keyframes.fault() {
            Some(fault) => fail(fault),
            None => Some(Self { app, play, is_over: false, is_other: false }),
        }
    }

    /// The cycle until which it has been replayed.
    fn until(&self) -> u64 {
        self.app.world().resource::<CycleClock>().cycle
    }

    /// Replays some cycles, and compares them with the trace.
    fn go_on(&mut self, replies: &Sender<Reply>) {
        let last = self.play.records.last_cycle().unwrap_or_default();
        for _ in 0..AT_ONCE {
            if self.until() >= last || self.app.world().resource::<Game>().state == GameState::Finished {
                self.is_over = true;
                let _nobody_listens = replies.send(Reply::PlayedAgain(self.until()));
                return;
            }
            run_cycle(self.app.world_mut());
            keep_if_due(self.app.world_mut());
        }
        // Only some cycles are compared, because reading a record takes longer than playing a cycle.
        let cycle = self.until();
        let record = self.play.records.record(cycle).ok().flatten().filter(|record| record.cycle == cycle);
        self.is_other = record.is_some_and(|record| !is_same(&self.app, &record, &self.play.fields));
        self.is_over = self.is_other;
        let reply = if self.is_other { Reply::Differs(cycle) } else { Reply::PlayedAgain(cycle) };
        let _nobody_listens = replies.send(reply);
    }
}

/// Whether a robot is controlled from outside this program.
fn is_from_outside(behaviour: &BehaviourSpec) -> bool {
    match behaviour {
        BehaviourSpec::Program(_) => true,
        // Booster programs connect over DDS.
        BehaviourSpec::Named(name) => name == REMOTE || name == "booster",
        BehaviourSpec::Script(_) | BehaviourSpec::Policy(_) => false,
    }
}

/// The match in which single moments are rebuilt.
struct Moments {
    simulator: MakeApp,
    /// Created for the first moment, with the keyframes of its match.
    app: Option<(App, Keyframes)>,
}

impl Moments {
    fn rebuild(&mut self, wanted: &Wanted) -> Result<RebuiltMoment, String> {
        // A keyframe of this very moment has no reasons. They need the last cycle to be played.
        let latest = wanted.cycle.saturating_sub(1);
        let played = self.play_from(wanted, latest)?;
        match wanted.keyframes.before(wanted.cycle) {
            // The result of interventions by hand in that cycle is only in the keyframe after it.
            Some((kept, _)) if kept == wanted.cycle && !played.is_same => self.play_from(wanted, wanted.cycle),
            _ => Ok(self.with_older_reasons(wanted, latest, played)),
        }
    }

    /// Adds the objects that were not recognised in images from before the last keyframe, by a replay from the one before it.
    /// Everything else stays: that replay leaves out interventions by hand at the last keyframe.
    fn with_older_reasons(&mut self, wanted: &Wanted, latest: u64, played: RebuiltMoment) -> RebuiltMoment {
        let last = wanted.keyframes.before(latest).map_or(0, |(kept, _)| kept);
        let earlier = last.checked_sub(1).filter(|earlier| wanted.keyframes.before(*earlier).is_some());
        let (Some(earlier), Some((app, _))) = (earlier, &self.app) else { return played };
        if !lacks_reasons(app.world(), &played.unrecognised) {
            return played;
        }
        let longer = self.play_from(wanted, earlier);
        // The next moment is rebuilt from a keyframe, and not from this replay.
        if let Some((_, of_match)) = &mut self.app {
            *of_match = Keyframes::default();
        }
        match longer {
            Ok(longer) if longer.is_same => RebuiltMoment { unrecognised: longer.unrecognised, ..played },
            _ => played,
        }
    }

    /// Rebuilds a moment from a keyframe before it.
    fn play_from(&mut self, wanted: &Wanted, latest: u64) -> Result<RebuiltMoment, String> {
        let nothing = || "the match is not kept from before this moment".to_owned();
        let kept = wanted.keyframes.before(latest).or_else(|| wanted.keyframes.before(wanted.cycle));
        let (kept, moment) = kept.ok_or_else(nothing)?;
        let (app, of_match) = self.app.get_or_insert_with(|| {
            let mut app = (self.simulator)();
            app.insert_resource(SensingThreads(1)).init_resource::<Unrecognised>();
            (app, Keyframes::default())
        });
        let now = app.world().resource::<CycleClock>().cycle;
        // If the app is at a moment between the keyframe and the wanted one, fewer cycles have to be played from there.
        if !of_match.is_same(&wanted.keyframes) || now > latest || now < kept {
            moment.put_back(app.world_mut()).map_err(|error| error.to_string())?;
            app.world_mut().resource_mut::<Unrecognised>().clear();
        }
        of_match.clone_from(&wanted.keyframes);
        while app.world().resource::<CycleClock>().cycle < wanted.cycle {
            // Reasons are only needed for the last cycle.
            if app.world().resource::<CycleClock>().cycle + 1 == wanted.cycle {
                ask_for_reasons(app.world_mut());
            }
            run_cycle(app.world_mut());
        }
        let states = all_states(app.world());
        forget_reasons(app.world_mut());
        Ok(RebuiltMoment {
            cycle: wanted.cycle,
            keyframes: wanted.keyframes.clone(),
            is_same: is_same(app, &wanted.record, &wanted.fields),
            states,
            unrecognised: all_unrecognised(app.world()),
            moment: Moment::of(app.world_mut()).map_err(|error| error.to_string())?,
            situation: situation(app.world_mut()).map_err(|fault| fault.to_string()),
        })
    }
}

/// The objects that each robot did not recognise. Not known if their images are older than the first cycle that was played.
fn all_unrecognised(world: &World) -> BTreeMap<RobotId, Vec<MissedObject>> {
    let unrecognised = world.resource::<Unrecognised>();
    let of = |id, robot| unrecognised.of(id, world.get::<Percepts>(robot)?);
    world.resource::<Roster>().iter().filter_map(|(id, robot)| Some((id, of(id, robot)?))).collect()
}

/// Whether a robot has percepts of the last second without the objects that it did not recognise.
fn lacks_reasons(world: &World, unrecognised: &BTreeMap<RobotId, Vec<MissedObject>>) -> bool {
    const LATELY_S: f64 = 1.0;
    let now_s = world.resource::<CycleClock>().end_time_s();
    let has_percepts = |robot| world.get::<Percepts>(robot).is_some_and(|percepts| now_s - percepts.time_s < LATELY_S);
    world.resource::<Roster>().iter().any(|(id, robot)| !unrecognised.contains_key(&id) && has_percepts(robot))
}

/// Makes all robots record their reasons in the next cycle.
fn ask_for_reasons(world: &mut World) {
    let robots: Vec<Entity> = world.resource::<Roster>().entities().collect();
    for robot in robots {
        world.entity_mut(robot).insert(Reasons::default());
    }
}

/// Stops recording reasons: the match continues as without them.
fn forget_reasons(world: &mut World) {
    let robots: Vec<Entity> = world.resource::<Roster>().entities().collect();
    for robot in robots {
        world.entity_mut(robot).remove::<Reasons>();
    }
}
