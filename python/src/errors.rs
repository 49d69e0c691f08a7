//! Converts errors of the Rust library to the package's exceptions, with file, line and column.

use naoisis::cycle::CyclePanic;
use naoisis::record::read::TraceError;
use naoisis::scenario::ScenarioError;
use naoisis::scenario::wording::shortened;
use naoisis::simulation::SnapshotError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// The module in which the exceptions are defined.
const MODULE: &str = "naoisis.errors";

/// The exception for an invalid scenario, with file, line, column, field and what was expected.
pub fn scenario_error(py: Python<'_>, error: &ScenarioError) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let field = error.path().map(ToString::to_string).filter(|field| !field.is_empty());
    let (place, expected) = ((error.line(), error.column()), error.expected());
    made(CLASS.import(py, MODULE, "ScenarioError").and_then(|class| {
        class.call1((shortened(&error.to_string()), error.file(), place.0, place.1, field, expected))
    }))
}

/// The exception for a trace that cannot be read, with file, line and column.
pub fn trace_error(py: Python<'_>, error: &TraceError) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let (path, place) = match error {
        TraceError::Line { path, line, column, .. } => (Some(path.clone()), Some((*line, *column))),
        TraceError::Io { path, .. } => (Some(path.clone()), None),
        _ => (None, None),
    };
    let (line, column) = (place.map(|place| place.0), place.map(|place| place.1));
    let file = path.map(|path| path.display().to_string());
    made(
        CLASS
            .import(py, MODULE, "TraceError")
            .and_then(|class| class.call1((shortened(&error.to_string()), file, line, column))),
    )
}

/// The exception for a snapshot that cannot be read or taken.
pub fn snapshot_error(py: Python<'_>, message: &str) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    made(CLASS.import(py, MODULE, "SnapshotError").and_then(|class| class.call1((shortened(message),))))
}

/// The exception for a request that a match cannot carry out.
pub fn match_error(py: Python<'_>, message: &str) -> PyErr {
    static CLASS: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    made(CLASS.import(py, MODULE, "MatchError").and_then(|class| class.call1((shortened(message),))))
}

/// A snapshot's error as an exception.
pub fn of_snapshot(py: Python<'_>, error: &SnapshotError) -> PyErr {
    snapshot_error(py, &error.to_string())
}

/// A panic in a match as an exception.
pub fn of_panic(py: Python<'_>, panic: &CyclePanic) -> PyErr {
    match_error(py, &panic.to_string())
}

/// The exception, or the error from constructing it.
fn made(exception: PyResult<Bound<'_, PyAny>>) -> PyErr {
    match exception {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}
