//! Many seeded matches, on many threads.

use naoisis::batch::summary::Summary;
use naoisis::batch::sweep::Sweep;
use naoisis::batch::table::{Table, TableError, table_text};
use naoisis::batch::{self, MatchRow, Variants, run_batch};
use naoisis::scenario::Setting;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::errors::scenario_error;
use crate::simulator::{self, Made, setting, simulator};
use crate::values::{Digits, from_python, to_python};

/// A finished batch. The Python class that wraps it has the documentation.
#[pyclass(frozen, module = "naoisis._naoisis")]
pub struct Batch {
    batch: batch::Batch<Sweep>,
    /// The rows of the table, in the order of the matches.
    rows: Vec<MatchRow>,
}

#[pymethods]
impl Batch {
    /// Plays a batch. When Python is interrupted, the running matches are finished, and no more begin.
    #[new]
    fn new(
        py: Python<'_>,
        made: Made<'_>,
        matches: usize,
        sweep: &Bound<'_, PyDict>,
        duration_s: Option<f32>,
        threads: Option<usize>,
        csv: Option<PathBuf>,
    ) -> PyResult<Self> {
        let file = made.file(py)?;
        let settings: PyResult<Vec<Vec<Setting>>> =
            sweep.iter().map(|(path, values)| values_of(&path, &values)).collect();
        let variants = Sweep::new(&file, settings?, None, duration_s).map_err(|error| scenario_error(py, &error))?;
        if variants.combinations().and_then(|combinations| combinations.checked_mul(matches)).is_none() {
            return Err(PyValueError::new_err(
                "sweep: there are more combinations than can be counted; expected fewer",
            ));
        }
        let mut world = simulator::world();
        for sample in variants.samples() {
            let variant = variants.variant(sample).map_err(|error| scenario_error(py, &error))?;
            simulator::start(py, &mut world, &variant)?;
        }
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let threads = threads.unwrap_or(cores);
        let batch = batch::Batch { variants, matches, first_seed: file.scenario.seed, threads };
        let (mut table, mut rows) = match csv {
            Some(path) => Table::open(&path, &batch).map_err(table_error)?,
            None => (Table::unwritten(), Vec::new()),
        };
        let stop = AtomicBool::new(false);
        let mut stopped_by = None;
        py.detach(|| {
            run_batch(&batch, rows.len(), simulator, &stop, |row| {
                let written = table.write(&batch, &row).map_err(table_error);
                rows.push(row);
                if let Err(error) = written.and_then(|()| Python::attach(|py| py.check_signals())) {
                    stop.store(true, Ordering::Relaxed);
                    stopped_by.get_or_insert(error);
                }
            });
        });
        match stopped_by {
            Some(error) => Err(error),
            None => Ok(Self { batch, rows }),
        }
    }

    fn __len__(&self) -> usize {
        self.rows.len()
    }

    /// The table as CSV.
    fn table(&self) -> String {
        table_text(&self.batch, &self.rows)
    }

    /// The names of the settings that distinguish the matches.
    fn settings(&self) -> Vec<String> {
        self.batch.variants.columns()
    }

    /// Each combination of settings with its summary.
    fn summaries<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let list = PyList::empty(py);
        for variant in 0..self.batch.variants.count() {
            let rows = self.rows.iter().filter(|row| row.variant == variant);
            let summary = to_python(py, &Summary::of(rows), Digits::All)?;
            let settings = self.batch.variants.columns().into_iter().zip(self.batch.variants.values(variant));
            let settings: Vec<(String, String)> = settings.collect();
            list.append((settings, self.batch.variants.realism(variant), summary))?;
        }
        Ok(list)
    }
}

/// The values of a setting that is swept.
fn values_of(path: &Bound<'_, PyAny>, values: &Bound<'_, PyAny>) -> PyResult<Vec<Setting>> {
    let path: String = path.extract()?;
    let settings: Vec<Setting> = values
        .try_iter()?
        .map(|value| setting(&path, &from_python(&value?, &path)?.to_string()))
        .collect::<PyResult<_>>()?;
    if settings.is_empty() {
        return Err(PyValueError::new_err(format!("sweep: `{path}` has no values; expected one at least")));
    }
    Ok(settings)
}

fn table_error(error: TableError) -> PyErr {
    match error {
        TableError::Foreign { .. } => PyValueError::new_err(error.to_string()),
        _ => PyOSError::new_err(error.to_string()),
    }
}
