//! The arrays that a step fills, and the step itself.

use naoisis::environment::{Arrays, EnvironmentError, Environments};
use numpy::{PyArrayDyn, PyArrayMethods, PyReadwriteArrayDyn};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// The arrays that a step fills: a dictionary with these keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Filled<'py> {
    pub observations: Bound<'py, PyArrayDyn<f32>>,
    pub images: Bound<'py, PyArrayDyn<u8>>,
    pub rewards: Bound<'py, PyArrayDyn<f32>>,
    pub terminations: Bound<'py, PyArrayDyn<bool>>,
    pub truncations: Bound<'py, PyArrayDyn<bool>>,
    pub successes: Bound<'py, PyArrayDyn<bool>>,
    pub final_observations: Bound<'py, PyArrayDyn<f32>>,
    pub final_images: Bound<'py, PyArrayDyn<u8>>,
    pub final_states: Bound<'py, PyArrayDyn<f32>>,
}

/// Borrows an array for writing. Fails if it is borrowed elsewhere.
pub fn written<'py, T: numpy::Element>(
    array: &Bound<'py, PyArrayDyn<T>>,
    name: &str,
) -> PyResult<PyReadwriteArrayDyn<'py, T>> {
    array.try_readwrite().map_err(|error| PyValueError::new_err(format!("{name}: {error}")))
}

/// The numbers of an array. Fails unless it has `length` of them, in C order.
pub fn slice<'a, T: numpy::Element>(
    array: &'a mut PyReadwriteArrayDyn<'_, T>,
    name: &str,
    length: usize,
) -> PyResult<&'a mut [T]> {
    use numpy::PyUntypedArrayMethods;

    // In the order of Fortran, rows would be written along columns.
    let contiguous = if array.is_c_contiguous() { array.as_slice_mut().ok() } else { None };
    let expected = || PyValueError::new_err(format!("{name}: expected a contiguous array, row by row"));
    let slice = contiguous.ok_or_else(expected)?;
    if slice.len() == length {
        return Ok(slice);
    }
    Err(PyValueError::new_err(format!("{name}: the array has {} numbers; expected {length}", slice.len())))
}

/// Plays a step. An interrupt of Python ends a long step early.
pub fn step(
    py: Python<'_>,
    worlds: &mut Environments,
    actions: &[f32],
    arrays: Arrays,
) -> PyResult<Result<(), EnvironmentError>> {
    /// The number of cycles from which on a step takes a considerable part of a second and is played on another thread.
    const LONG: usize = 10_000;
    /// The time between two checks for an interrupt of Python.
    const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

    if worlds.worlds().saturating_mul(worlds.settings().cycles_per_step as usize) < LONG {
        return Ok(py.detach(|| worlds.step(actions, arrays)));
    }
    let stop = worlds.stop();
    let mut interrupted = Ok(());
    let stepped = py.detach(|| {
        thread::scope(|scope| {
            let (over, is_over) = mpsc::channel();
            let stepping = scope.spawn(move || {
                let stepped = worlds.step(actions, arrays);
                // Nobody else waits for it.
                let _ = over.send(());
                stepped
            });
            while is_over.recv_timeout(BETWEEN_SIGNALS) == Err(RecvTimeoutError::Timeout) {
                if interrupted.is_ok() {
                    interrupted = Python::attach(|py| py.check_signals());
                }
                if interrupted.is_err() {
                    stop.store(true, Ordering::Relaxed);
                }
            }
            stepping.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    });
    interrupted.map(|()| stepped)
}
