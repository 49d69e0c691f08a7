//! Learned policies, evaluated as in a match.

use naoisis::environment::ActionKind;
use naoisis::policy::{Choice, LoadedPolicy};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

use crate::values::{Digits, to_python};

/// A policy and its layout. The Python class that wraps it has the documentation.
#[pyclass(frozen, module = "naoisis._naoisis")]
pub struct Policy(LoadedPolicy);

#[pymethods]
impl Policy {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let read = py.detach(|| LoadedPolicy::read(&path));
        read.map(Self).map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// The layout, as in its JSON file.
    fn layout<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, self.0.layout(), Digits::All)
    }

    /// The number of choices in each list; empty for a continuous action.
    fn choices(&self) -> Vec<usize> {
        let space = self.0.layout().actions();
        match space.kind() {
            ActionKind::Continuous => Vec::new(),
            _ => space.names().iter().map(Vec::len).collect(),
        }
    }

    /// The length of an action.
    fn numbers(&self) -> usize {
        self.0.layout().actions().len()
    }

    /// Whether choices are drawn at random by their probabilities.
    fn draws(&self) -> bool {
        self.0.layout().choice == Choice::Drawn
    }

    /// The outputs for an observation, and the recurrent state after it.
    fn outputs<'py>(
        &self,
        py: Python<'py>,
        observation: PyReadonlyArray1<'py, f32>,
        mut state: Vec<Vec<f32>>,
    ) -> PyResult<(Bound<'py, PyArray1<f32>>, Vec<Vec<f32>>)> {
        let observation = observation.as_array().to_vec();
        let outputs = self.0.outputs(observation, &mut state);
        let outputs = outputs.map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok((PyArray1::from_vec(py, outputs), state))
    }
}
