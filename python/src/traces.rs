//! Reading traces, as columns or line by line.

use naoisis::behaviour::BehaviourRegistry;
use naoisis::belief::{Belief, point_pitch_from_team};
use naoisis::geometry::{Pose, to_degrees};
use naoisis::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis::interface::fields::Fields;
use naoisis::pitch::End;
use naoisis::record::page;
use naoisis::record::read::{Ending, TraceReader};
use naoisis::record::tables::{Cells, Column, ColumnValues, TABLES, Tables};
use naoisis::team::RobotId;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use crate::errors::trace_error;
use crate::simulator::world;
use crate::values::{Digits, to_python};

/// The number of lines between two checks for an interrupt of Python.
const LINES_PER_SIGNAL: usize = 1000;

/// A quantity of a robot: its name, the parts of a trace that it needs, how many numbers it has, and how they are read. The end
/// is the one that the robot's team defends.
struct Quantity {
    name: &'static str,
    parts: &'static [&'static str],
    numbers: usize,
    of: fn(&RobotRecord, End, &mut Vec<f32>),
}

const fn quantity(
    name: &'static str,
    parts: &'static [&'static str],
    numbers: usize,
    of: fn(&RobotRecord, End, &mut Vec<f32>),
) -> Quantity {
    Quantity { name, parts, numbers, of }
}

/// The columns of a robot. Missing quantities are NaN.
const QUANTITIES: [Quantity; 14] = [
    quantity("pose", &["robots.pose"], 3, |robot, _, row| row.extend(pose(robot.pose))),
    quantity("velocity", &["robots.velocity"], 3, |robot, _, row| {
        let velocity = robot.velocity;
        row.extend([velocity.linear.x, velocity.linear.y, to_degrees(velocity.angular)]);
    }),
    quantity("head_deg", &["robots.head_deg"], 2, |robot, _, row| {
        row.extend([robot.head.yaw, robot.head.pitch].map(to_degrees));
    }),
    quantity("odometry", &["robots.odometry"], 3, |robot, _, row| row.extend(pose(robot.odometry))),
    quantity("sonar_m", &["robots.sonar_m"], 2, |robot, _, row| {
        row.extend([robot.sonar_m.left, robot.sonar_m.right].map(|heard| heard.unwrap_or(f32::NAN)));
    }),
    quantity("penalised", &["robots.penalised"], 1, |robot, _, row| row.push(number(robot.penalised.is_some()))),
    quantity("seen_ball_m", &["robots.percepts"], 2, |robot, _, row| {
        row.extend(place(robot.percepts.ball.map(|ball| ball.position_m)));
    }),
    quantity("belief_pose", &["robots.belief"], 3, |robot, _, row| {
        row.extend(robot.belief.as_ref().map_or([f32::NAN; 3], |belief| pose(belief.pose)));
    }),
    quantity("belief_ball_m", &["robots.belief"], 2, |robot, _, row| {
        row.extend(place(believed_ball(robot.belief.as_ref())));
    }),
    quantity("own_end", &["game.blue_end"], 1, |_, own_end, row| row.push(own_end.sign())),
    quantity("pitch_belief_pose", &["robots.belief", "game.blue_end"], 3, |robot, own_end, row| {
        let belief = robot.belief.as_ref();
        row.extend(belief.map_or([f32::NAN; 3], |belief| pose(belief.pose_in_pitch(own_end))));
    }),
    quantity("pitch_belief_ball_m", &["robots.belief", "game.blue_end"], 2, |robot, own_end, row| {
        let ball = believed_ball(robot.belief.as_ref());
        row.extend(place(ball.map(|ball| point_pitch_from_team(ball, own_end))));
    }),
    quantity("walk", &["robots.command"], 3, |robot, _, row| {
        let walk = robot.command.as_ref().map(|command| command.walk.unwrap_or_default());
        row.extend(walk.map_or([f32::NAN; 3], |walk| [walk.dx, walk.dy, to_degrees(walk.dtheta)]));
    }),
    quantity("kicks", &["robots.command"], 1, |robot, _, row| {
        row.push(robot.command.as_ref().map_or(f32::NAN, |command| number(command.kick.is_some())));
    }),
];

/// Returns 1 for true and 0 for false.
fn number(truth: bool) -> f32 {
    f32::from(u8::from(truth))
}

fn pose(pose: Pose) -> [f32; 3] {
    [pose.position.x, pose.position.y, to_degrees(pose.heading)]
}

fn place(place: Option<bevy::math::Vec2>) -> [f32; 2] {
    place.map_or([f32::NAN; 2], |place| place.to_array())
}

fn believed_ball(belief: Option<&Belief>) -> Option<bevy::math::Vec2> {
    belief?.ball.map(|ball| ball.position_m)
}

/// The columns of a robot.
struct RobotColumns {
    id: RobotId,
    columns: [Vec<f32>; QUANTITIES.len()],
}

/// The columns of a trace, with one entry for each line.
#[derive(Default)]
struct Columns {
    cycle: Vec<u64>,
    time_s: Vec<f64>,
    ball: [Vec<f32>; 2],
    score: Vec<u32>,
    state: Vec<&'static str>,
    robots: Vec<RobotColumns>,
}

impl Columns {
    fn push(&mut self, record: &CycleRecord) {
        let lines = self.cycle.len();
        self.cycle.push(record.cycle);
        self.time_s.push(record.time_s);
        let ball = record.ball.map(|ball| [ball.position_m, ball.velocity_mps].map(|vector| vector.to_array()));
        for (column, vector) in self.ball.iter_mut().zip(ball.unwrap_or([[f32::NAN; 3]; 2])) {
            column.extend(vector);
        }
        self.score.extend([record.game.score.blue, record.game.score.pink]);
        self.state.push(record.game.state.name());
        for robot in &record.robots {
            if self.robots.iter().all(|known| known.id != robot.id) {
                let columns = core::array::from_fn(|index| vec![f32::NAN; lines * QUANTITIES[index].numbers]);
                self.robots.push(RobotColumns { id: robot.id, columns });
            }
        }
        for RobotColumns { id, columns } in &mut self.robots {
            let robot = record.robot(*id);
            for (quantity, column) in QUANTITIES.iter().zip(columns) {
                match robot {
                    Some(robot) => (quantity.of)(robot, record.game.own_end(id.team), column),
                    None => column.extend(core::iter::repeat_n(f32::NAN, quantity.numbers)),
                }
            }
        }
    }

    fn into_python<'py>(self, py: Python<'py>, fields: &Fields) -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        dictionary.set_item("cycle", PyArray1::from_vec(py, self.cycle))?;
        dictionary.set_item("time_s", PyArray1::from_vec(py, self.time_s))?;
        for (name, column) in ["ball.position_m", "ball.velocity_mps"].into_iter().zip(self.ball) {
            if fields.has(name) {
                dictionary.set_item(name, table(py, column, 3)?)?;
            }
        }
        if fields.has("game.score") {
            dictionary.set_item("score", table(py, self.score, 2)?)?;
        }
        if fields.has("game.state") {
            dictionary.set_item("state", self.state)?;
        }
        for RobotColumns { id, columns } in self.robots {
            for (quantity, column) in QUANTITIES.iter().zip(columns) {
                if quantity.parts.iter().all(|part| fields.has(part)) {
                    dictionary.set_item(format!("{id}.{}", quantity.name), table(py, column, quantity.numbers)?)?;
                }
            }
        }
        Ok(dictionary)
    }
}

/// A two-dimensional array with `numbers` values in each row.
fn table<'py, T: numpy::Element>(py: Python<'py>, values: Vec<T>, numbers: usize) -> PyResult<Bound<'py, PyAny>> {
    let rows = values.len() / numbers;
    let flat = PyArray1::from_vec(py, values);
    Ok(if numbers == 1 { flat.into_any() } else { flat.reshape([rows, numbers])?.into_any() })
}

/// Reads a trace: its columns, its scenario, its events with their times, and its end.
#[pyfunction]
pub fn read_trace<'py>(
    py: Python<'py>,
    path: PathBuf,
) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyAny>, Bound<'py, PyList>, Option<String>)> {
    let failed = |error| trace_error(py, &error);
    let mut reader = TraceReader::open(&path).map_err(failed)?;
    let (mut columns, mut events) = (Columns::default(), Vec::new());
    while let Some(record) = reader.next_cycle().map_err(failed)? {
        columns.push(&record);
        events.extend(record.events.iter().cloned().map(|event| (record.time_s, event)));
        if columns.cycle.len().is_multiple_of(LINES_PER_SIGNAL) {
            py.check_signals()?;
        }
    }
    let happened = PyList::empty(py);
    for (time_s, event) in &events {
        let event = to_python(py, event, Digits::Lean)?;
        event.cast::<PyDict>().map_err(PyErr::from)?.set_item("time_s", *time_s)?;
        happened.append(event)?;
    }
    let ending = match reader.ending() {
        Ending::Proper(reason) => Some(to_python(py, &reason, Digits::All)?.extract()?),
        _ => None,
    };
    let scenario = to_python(py, reader.scenario(), Digits::All)?;
    Ok((columns.into_python(py, reader.fields())?, scenario, happened, ending))
}

/// Reads a trace as tables, each a dictionary of its columns. Missing numbers are NaN, missing texts `None`. A column of integers
/// with missing values becomes one of floats.
#[pyfunction]
pub fn read_tables(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let failed = |error| trace_error(py, &error);
    let mut reader = TraceReader::open(&path).map_err(failed)?;
    let mut tables = Tables::new(reader.fields().clone());
    let mut lines = 0_usize;
    while let Some(record) = reader.next_cycle().map_err(failed)? {
        tables.push(&record);
        lines += 1;
        if lines.is_multiple_of(LINES_PER_SIGNAL) {
            py.check_signals()?;
        }
    }
    let dictionary = PyDict::new(py);
    for table in TABLES.iter().filter_map(|definition| tables.of(definition.name)) {
        let columns = PyDict::new(py);
        for (column, values) in table.definition().columns.iter().zip(table.columns()) {
            columns.set_item(column.name, array(py, column, values)?)?;
        }
        dictionary.set_item(table.definition().name, columns)?;
    }
    Ok(dictionary)
}

/// The values of a column as an array of numbers or a list of texts.
fn array<'py>(py: Python<'py>, column: &Column, values: &ColumnValues) -> PyResult<Bound<'py, PyAny>> {
    /// All rows, with `missing` where there is no value.
    fn rows<T: Clone>(presence: &[i16], cells: &[T], missing: &T) -> Vec<T> {
        let mut cells = cells.iter();
        presence
            .iter()
            .map(|&is_there| if is_there == 1 { cells.next() } else { None }.unwrap_or(missing).clone())
            .collect()
    }
    let presence = &values.presence;
    Ok(match &values.cells {
        Cells::Whole(cells) if !column.is_optional => PyArray1::from_slice(py, cells).into_any(),
        Cells::Whole(cells) => {
            let cells: Vec<f64> = cells.iter().map(|&cell| cell as f64).collect();
            PyArray1::from_vec(py, rows(presence, &cells, &f64::NAN)).into_any()
        }
        Cells::Single(cells) => PyArray1::from_vec(py, rows(presence, cells, &f32::NAN)).into_any(),
        Cells::Double(cells) => PyArray1::from_vec(py, rows(presence, cells, &f64::NAN)).into_any(),
        Cells::Text(cells) => {
            let cells: Vec<Option<&str>> = cells.iter().map(|cell| Some(cell.as_str())).collect();
            PyList::new(py, rows(presence, &cells, &None))?.into_any()
        }
        _ => PyList::empty(py).into_any(),
    })
}

/// The cycles of a trace as dictionaries, one after the other.
#[pyclass(frozen, module = "naoisis._naoisis")]
pub struct TraceLines(Mutex<TraceReader>);

#[pymethods]
impl TraceLines {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        TraceReader::open(&path).map(|reader| Self(Mutex::new(reader))).map_err(|error| trace_error(py, &error))
    }

    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let mut reader = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let record = reader.next_cycle().map_err(|error| trace_error(py, &error))?;
        record.map(|record| to_python(py, &record, Digits::Lean)).transpose()
    }
}

/// The page of a trace, for a browser.
#[pyfunction]
pub fn page_of_trace(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let page = py.detach(|| {
        let mut reader = TraceReader::open(&path)?;
        page::page_of_trace(&mut reader, world().resource::<BehaviourRegistry>())
    });
    page.map_err(|error| trace_error(py, &error))
}
