//! One match: playing it, reading its state, saving it.

use naoisis::agents::{self, AgentError, CommandError, RobotCommand};
use naoisis::camera_model::{CameraName, NotACameraName};
use naoisis::cycle::CycleClock;
use naoisis::game::{Game, GameState, Rules};
use naoisis::interface::gather::gather_on_demand;
use naoisis::record::beliefs::BeliefRecorder;
use naoisis::record::match_renderer::view_of_field;
use naoisis::record::mcap::McapRecorder;
use naoisis::record::page::{PageRecorder, PageSoFar};
use naoisis::record::picture_recorder::PictureRecorder;
use naoisis::record::recorder::{self, EndReason, Recorder, Recorders};
use naoisis::record::trace::TraceRecorder;
use naoisis::record::video::VideoRecorder;
use naoisis::robot::Roster;
use naoisis::scenario::Scenario;
use naoisis::sensing::camera::image::Layers;
use naoisis::simulation::{Snapshot, resolved};
use naoisis::team::RobotId;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};
use std::path::PathBuf;
use std::sync::{Mutex, TryLockError};

use crate::errors::{match_error, of_panic, of_snapshot, snapshot_error};
use crate::played::Played;
use crate::simulator::{self, Made, controlled, robot_id};
use crate::values::{Digits, from_python, to_python};

/// A match. The Python class that wraps it has the documentation.
#[pyclass(frozen, module = "naoisis._naoisis")]
pub struct Match(Mutex<Played>);

/// The number of cycles between two checks for an interrupt of Python.
const CYCLES_PER_SIGNAL: u64 = 64;

/// The command of each robot in a dictionary.
fn commands_of(commands: &Bound<'_, PyDict>) -> PyResult<Vec<(RobotId, RobotCommand)>> {
    let command_of = |(robot, command): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let robot: String = robot.extract()?;
        let value = from_python(&command, &robot)?;
        let command = RobotCommand::from_value(&value).map_err(|error| {
            let field = match &error {
                CommandError::Malformed { field, .. } if !field.is_empty() => format!(".{field}"),
                _ => String::new(),
            };
            PyValueError::new_err(format!("{robot}{field}: {error}"))
        })?;
        Ok((robot_id(&robot)?, command))
    };
    commands.iter().map(command_of).collect()
}

fn agent_error(py: Python<'_>, error: AgentError) -> PyErr {
    match_error(py, &error.to_string())
}

/// The camera with the name `word`; `None` for a robot's first camera.
fn camera_named(word: Option<&str>) -> PyResult<Option<CameraName>> {
    let named = word.map(|word| word.parse().map_err(|error: NotACameraName| PyValueError::new_err(error.to_string())));
    named.transpose()
}

/// An array of rows, columns and, if there are several, channels.
fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    values: Vec<T>,
    image: [u32; 2],
    channels: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let [width, height] = image.map(|pixels| pixels as usize);
    let flat = PyArray1::from_vec(py, values);
    Ok(match channels {
        1 => flat.reshape([height, width])?.into_any(),
        _ => flat.reshape([height, width, channels])?.into_any(),
    })
}

impl Match {
    /// Calls `act` with the match. Fails if another thread is playing it.
    fn with<T>(&self, py: Python<'_>, act: impl FnOnce(&mut Played) -> PyResult<T>) -> PyResult<T> {
        match self.0.try_lock() {
            Ok(mut played) => {
                if let Some(panic) = &played.panic {
                    return Err(match_error(py, &format!("the match was broken off: {panic}")));
                }
                act(&mut played)
            }
            Err(TryLockError::WouldBlock) => {
                Err(match_error(py, "another thread is playing this match; expected one at a time"))
            }
            Err(TryLockError::Poisoned(_)) => Err(match_error(py, "the match was broken off by an error")),
        }
    }
}

#[pymethods]
impl Match {
    #[new]
    fn new(py: Python<'_>, made: Made<'_>, control: Vec<String>) -> PyResult<Self> {
        let mut file = made.file(py)?;
        let mut world = simulator::world();
        // What is wrong with the scenario is said first.
        simulator::start(py, &mut world, &file)?;
        let (scenario, control) = controlled(&world, &file.scenario, &control)?;
        if !control.is_empty() {
            file.scenario = scenario;
            simulator::start(py, &mut world, &file)?;
        }
        for id in control {
            agents::believe(&mut world, id).map_err(|error| agent_error(py, error))?;
        }
        gather_on_demand(&mut world);
        Ok(Self(Mutex::new(Played::new(world))))
    }

    #[staticmethod]
    fn restore(py: Python<'_>, snapshot: &[u8]) -> PyResult<Self> {
        let mut world = simulator::world();
        let snapshot = Snapshot::from_bytes(snapshot, &world)
            .map_err(|message| snapshot_error(py, &format!("{message}; expected the bytes of a snapshot")))?;
        snapshot.restore(&mut world).map_err(|error| of_snapshot(py, &error))?;
        gather_on_demand(&mut world);
        Ok(Self(Mutex::new(Played::new(world))))
    }

    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.with(py, |played| {
            let snapshot = Snapshot::take(&mut played.world).map_err(|error| of_snapshot(py, &error))?;
            let bytes = snapshot.to_bytes(&played.world).map_err(|error| of_snapshot(py, &error))?;
            Ok(PyBytes::new(py, &bytes))
        })
    }

    /// The robots that Python commands.
    #[getter]
    fn control(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |played| Ok(played.control().iter().map(ToString::to_string).collect()))
    }

    /// Plays `cycles` cycles with these commands: robots walk in all of them; everything else is commanded in the first.
    fn step(&self, py: Python<'_>, commands: &Bound<'_, PyDict>, cycles: u64) -> PyResult<()> {
        let commands = commands_of(commands)?;
        self.with(py, |played| {
            let control = played.control();
            if let Some((id, _)) = commands.iter().find(|(id, _)| !control.contains(id)) {
                let control: Vec<String> = control.iter().map(ToString::to_string).collect();
                let expected = if control.is_empty() { "none".to_owned() } else { control.join(", ") };
                return Err(PyValueError::new_err(format!(
                    "`{id}` is not controlled; expected commands for {expected}"
                )));
            }
            played.events.clear();
            for cycle in 0..cycles {
                for (id, command) in &commands {
                    let command = match cycle {
                        0 => command.clone(),
                        _ => RobotCommand { walk: command.walk, ..RobotCommand::default() },
                    };
                    agents::command(&mut played.world, *id, command.rounded())
                        .map_err(|error| agent_error(py, error))?;
                }
                if py.detach(|| played.play(1)).map_err(|panic| of_panic(py, &panic))? == 0 {
                    break;
                }
                if cycle % CYCLES_PER_SIGNAL == CYCLES_PER_SIGNAL - 1 {
                    py.check_signals()?;
                }
            }
            py.check_signals()
        })
    }

    /// Plays up to `most` cycles, until the match ends or Python is interrupted. Returns the number of cycles played.
    fn play(&self, py: Python<'_>, most: u64) -> PyResult<u64> {
        self.with(py, |played| {
            played.events.clear();
            let mut cycles = 0;
            loop {
                let some = py.detach(|| played.play(most - cycles)).map_err(|panic| of_panic(py, &panic))?;
                cycles += some;
                if some == 0 || cycles == most {
                    return Ok(cycles);
                }
                py.check_signals()?;
            }
        })
    }

    #[getter]
    fn cycle(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |played| Ok(played.cycle()))
    }

    #[getter]
    fn time_s(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |played| Ok(played.time_s()))
    }

    #[getter]
    fn cycle_s(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |played| Ok(played.world.resource::<CycleClock>().period_s))
    }

    #[getter]
    fn finished(&self, py: Python<'_>) -> PyResult<bool> {
        self.with(py, |played| Ok(played.is_finished()))
    }

    #[getter]
    fn score<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |played| to_python(py, &played.world.resource::<Game>().score, Digits::Lean))
    }

    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |played| {
            let result = played.world.resource::<Game>().result(played.world.resource::<Rules>());
            to_python(py, &result, Digits::Lean)
        })
    }

    #[getter]
    fn robots(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |played| Ok(played.world.resource::<Roster>().iter().map(|(id, _)| id.to_string()).collect()))
    }

    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        self.with(py, |played| {
            let list = PyList::empty(py);
            for (time_s, event) in &played.events {
                let event = to_python(py, event, Digits::Lean)?;
                event.cast::<PyDict>().map_err(PyErr::from)?.set_item("time_s", *time_s)?;
                list.append(event)?;
            }
            Ok(list)
        })
    }

    #[getter]
    fn scenario<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |played| {
            let scenario = resolved(&played.world, played.world.resource::<Scenario>());
            to_python(py, &scenario, Digits::All)
        })
    }

    #[getter]
    fn realism(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |played| Ok(played.world.resource::<Scenario>().realism_in_words()))
    }

    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.with(py, |played| to_python(py, played.record(), Digits::Lean))
    }

    fn perception<'py>(&self, py: Python<'py>, robot: &str) -> PyResult<Bound<'py, PyAny>> {
        let id = robot_id(robot)?;
        self.with(py, |played| {
            played.robot(py, id)?;
            played.perceive();
            let perception = agents::perception(&mut played.world, id).map_err(|error| agent_error(py, error))?;
            to_python(py, &perception, Digits::Lean)
        })
    }

    fn belief<'py>(&self, py: Python<'py>, robot: &str) -> PyResult<Bound<'py, PyAny>> {
        let id = robot_id(robot)?;
        self.with(py, |played| {
            played.robot(py, id)?;
            played.perceive();
            let belief = agents::belief(&played.world, id).map_err(|error| agent_error(py, error))?;
            to_python(py, &belief, Digits::Lean)
        })
    }

    fn image<'py>(&self, py: Python<'py>, robot: &str, camera: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        let (id, camera) = (robot_id(robot)?, camera_named(camera)?);
        let image = self.with(py, |played| played.picture(py, id, camera, Layers::default()))?;
        array(py, image.rgb, [image.width, image.height], 3)
    }

    fn labels<'py>(&self, py: Python<'py>, robot: &str, camera: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        let (id, camera) = (robot_id(robot)?, camera_named(camera)?);
        let layers = Layers { labels: true, depth: false };
        let image = self.with(py, |played| played.picture(py, id, camera, layers))?;
        array(py, image.labels, [image.width, image.height], 1)
    }

    fn depth<'py>(&self, py: Python<'py>, robot: &str, camera: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        let (id, camera) = (robot_id(robot)?, camera_named(camera)?);
        let layers = Layers { labels: false, depth: true };
        let image = self.with(py, |played| played.picture(py, id, camera, layers))?;
        array(py, image.depth_m, [image.width, image.height], 1)
    }

    fn field_image<'py>(&self, py: Python<'py>, width: u32, height: u32) -> PyResult<Bound<'py, PyAny>> {
        /// The greatest width and height of a picture, pixels.
        const LARGEST: u32 = 8192;

        if !(1..=LARGEST).contains(&width) || !(1..=LARGEST).contains(&height) {
            let message = format!("a picture of {width} x {height} pixels cannot be drawn; expected 1 to {LARGEST}");
            return Err(PyValueError::new_err(message));
        }
        let image = self.with(py, |played| {
            played.look();
            let view = view_of_field(&played.renderer.scene().pitch, [width, height]);
            Ok(played.renderer.draw(&mut played.world, &view))
        })?;
        array(py, image.rgb, [image.width, image.height], 3)
    }

    /// Records the match from now on.
    fn record(
        &self,
        py: Python<'_>,
        trace: Option<PathBuf>,
        beliefs: Option<PathBuf>,
        video: Option<PathBuf>,
        html: Option<PathBuf>,
        mcap: Option<PathBuf>,
    ) -> PyResult<()> {
        self.with(py, |played| {
            if played.world.contains_resource::<Recorders>() {
                return Err(match_error(py, "the match is being recorded already; expected `close()` before"));
            }
            let mut recorders: Vec<Box<dyn Recorder>> = Vec::new();
            let failed = |error: recorder::RecordError| PyOSError::new_err(error.to_string());
            if let Some(path) = video {
                let cycle_s = played.world.resource::<CycleClock>().period_s;
                let video = Some(VideoRecorder::create(&path, 1, Vec::new(), cycle_s).map_err(failed)?);
                recorders.push(Box::new(PictureRecorder { video, ..PictureRecorder::default() }));
            }
            if let Some(path) = trace {
                recorders.push(Box::new(TraceRecorder::create(&path).map_err(failed)?));
            }
            if let Some(path) = beliefs {
                recorders.push(Box::new(BeliefRecorder::create(&path).map_err(failed)?));
            }
            if let Some(path) = html {
                let recorder = PageRecorder::create(&path).map_err(failed)?;
                played.page = Some(recorder.so_far());
                recorders.push(Box::new(recorder));
            }
            if let Some(path) = mcap {
                recorders.push(Box::new(McapRecorder::create(&path).map_err(failed)?));
            }
            recorder::start(&mut played.world, recorders);
            Ok(())
        })
    }

    /// The page of the match so far, if one is or was recorded.
    fn page(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.with(py, |played| Ok(played.page.as_ref().map(PageSoFar::html)))
    }

    /// Ends all recordings and returns their notes.
    fn close(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |played| {
            let reason = match played.world.resource::<Game>().state {
                GameState::Finished => EndReason::FinalWhistle,
                _ if played.is_finished() => EndReason::Duration,
                _ => EndReason::Interrupted,
            };
            let said = recorder::finish(&mut played.world, reason);
            gather_on_demand(&mut played.world);
            let said: Result<Vec<_>, _> = said.into_iter().collect();
            let said = said.map_err(|error| PyOSError::new_err(error.to_string()))?;
            Ok(said.into_iter().flatten().collect())
        })
    }
}
