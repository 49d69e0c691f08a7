//! A running match: its world, recent events and renderer.

use bevy::ecs::world::World;
use naoisis::agents;
use naoisis::behaviour::Program;
use naoisis::camera_model::CameraName;
use naoisis::cycle::{CycleClock, PendingHalf, perceive, try_run_cycle};
use naoisis::events::{CycleEvents, MatchEvent};
use naoisis::game::{Game, GameState};
use naoisis::interface::cycle_record::CycleRecord;
use naoisis::interface::gather::{CurrentRecord, record_now};
use naoisis::record::match_renderer::MatchRenderer;
use naoisis::record::page::PageSoFar;
use naoisis::record::recorder::Recorders;
use naoisis::robot::Roster;
use naoisis::scenario::Scenario;
use naoisis::sensing::camera::CameraSettings;
use naoisis::sensing::camera::image::{Image, Layers};
use naoisis::team::RobotId;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::time::{Duration, Instant};

use crate::errors::match_error;

/// The time between two checks for an interrupt of Python.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);
/// The number of cycles between two readings of the wall clock.
const CYCLES_PER_LOOK: u64 = 8;

/// A running match.
pub struct Played {
    pub world: World,
    pub renderer: MatchRenderer,
    /// The cycle of the renderer's state.
    seen: Option<u64>,
    /// Times, s, and events since the last call began.
    pub events: Vec<(f64, MatchEvent)>,
    /// The page that is or was recorded.
    pub page: Option<PageSoFar>,
    /// The panic that ended the match.
    pub panic: Option<String>,
}

impl Played {
    pub fn new(world: World) -> Self {
        Self { world, renderer: MatchRenderer::default(), seen: None, events: Vec::new(), page: None, panic: None }
    }

    /// The number of finished cycles. In an unfinished one, robots have perceived, and nothing else has happened.
    pub fn cycle(&self) -> u64 {
        self.world.resource::<CycleClock>().cycle - u64::from(self.is_under_way())
    }

    pub fn time_s(&self) -> f64 {
        self.cycle() as f64 * self.world.resource::<CycleClock>().period_s
    }

    /// Whether robots have perceived in a cycle and not acted yet.
    fn is_under_way(&self) -> bool {
        *self.world.resource::<PendingHalf>() == PendingHalf::Act
    }

    /// The robots that Python commands; no program plays them.
    pub fn control(&self) -> Vec<RobotId> {
        let roster = self.world.resource::<Roster>();
        let has_program =
            |id: &RobotId| roster.get(*id).is_some_and(|robot| self.world.get::<Program>(robot).is_some());
        agents::remote_robots(&self.world).into_iter().filter(|id| !has_program(id)).collect()
    }

    /// Runs the sensors of the next cycle, so that Python can answer with commands. Does nothing in a match without robots that Python commands.
    pub fn perceive(&mut self) {
        if !self.is_under_way() && !self.is_finished() && !self.control().is_empty() {
            // The record of the cycle that is over, before the next one begins.
            record_now(&mut self.world);
            perceive(&mut self.world);
        }
    }

    /// The record of the last finished cycle.
    pub fn record(&mut self) -> &CycleRecord {
        if self.is_under_way() { &self.world.resource::<CurrentRecord>().record } else { record_now(&mut self.world) }
    }

    /// Whether the match has ended, or the time of the scenario is over.
    pub fn is_finished(&self) -> bool {
        let last_cycle = self.world.get_resource::<Scenario>().and_then(Scenario::last_cycle);
        self.world.resource::<Game>().state == GameState::Finished
            || last_cycle.is_some_and(|last| self.cycle() >= last)
    }

    fn is_recording_broken(&self) -> bool {
        self.world.get_resource::<Recorders>().is_some_and(Recorders::has_failed)
    }

    /// Plays up to `most` cycles, until the match ends or it is time to check for an interrupt. Returns the number of cycles played.
    pub fn play(&mut self, most: u64) -> Result<u64, naoisis::cycle::CyclePanic> {
        let until = Instant::now() + BETWEEN_SIGNALS;
        let mut cycles = 0;
        while cycles < most && !self.is_finished() && !self.is_recording_broken() {
            if let Err(panic) = try_run_cycle(&mut self.world) {
                self.panic = Some(panic.to_string());
                return Err(panic);
            }
            cycles += 1;
            let time_s = self.time_s();
            let events = self.world.resource::<CycleEvents>().iter();
            self.events.extend(events.map(|event| (time_s, event.clone())));
            if cycles.is_multiple_of(CYCLES_PER_LOOK) && Instant::now() >= until {
                break;
            }
        }
        Ok(cycles)
    }

    pub fn robot(&self, py: Python<'_>, id: RobotId) -> PyResult<bevy::ecs::entity::Entity> {
        let roster = self.world.resource::<Roster>();
        roster.get(id).ok_or_else(|| {
            let known: Vec<String> = roster.iter().map(|(id, _)| id.to_string()).collect();
            match_error(py, &format!("there is no robot `{id}`; expected one of {}", known.join(", ")))
        })
    }

    /// The picture of a robot's `camera` (`None`: its first): the newest one if it has these layers, otherwise a new one.
    pub fn picture(
        &mut self,
        py: Python<'_>,
        id: RobotId,
        camera: Option<CameraName>,
        layers: Layers,
    ) -> PyResult<Image> {
        let robot = self.robot(py, id)?;
        let mounts = self.world.get::<CameraSettings>(robot).map(|settings| settings.mounts).unwrap_or_default();
        let Some(side) = camera.or_else(|| mounts.names().next()) else {
            return Err(PyValueError::new_err(format!("{id}: it has no camera")));
        };
        if mounts.get(side).is_none() {
            let names: Vec<String> = mounts.names().map(|name| format!("'{name}'")).collect();
            let message = format!("{id}: there is no camera '{side}'; expected {}", names.join(" or "));
            return Err(PyValueError::new_err(message));
        }
        self.look();
        let newest = self.renderer.through_the_eyes_of(&mut self.world, id, side);
        let is_enough = |image: &Image| {
            (!layers.labels || !image.labels.is_empty()) && (!layers.depth || !image.depth_m.is_empty())
        };
        let image = match newest {
            Some(image) if is_enough(&image) => Some(image),
            _ => self.renderer.draw_view_of_robot(&mut self.world, id, side, layers),
        };
        image.ok_or_else(|| match_error(py, &format!("the robot `{id}` is not on the pitch, and sees nothing")))
    }

    /// Updates the renderer to the current state of the match.
    pub fn look(&mut self) {
        let now = Some(self.cycle());
        if self.seen != now {
            self.renderer.look(&mut self.world);
            self.seen = now;
        }
    }
}
