//! Conversion between Python values and the JSON of traces and scenario files.

use naoisis::interface::trace_numbers::shortest_json;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;
use serde_json::{Map, Number, Value};

/// The greatest depth of nested values.
const DEEPEST: usize = 100;

/// The digits of numbers in a Python value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Digits {
    /// As in a line of a trace.
    Lean,
    /// All digits.
    All,
}

/// Converts `value` to what `json.loads` would return for it in a trace.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize, digits: Digits) -> PyResult<Bound<'py, PyAny>> {
    let text = match digits {
        Digits::Lean => shortest_json(value),
        Digits::All => serde_json::to_string(value),
    };
    let text = text.map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Converts a Python value (dictionaries, sequences, strings, numbers, arrays) to JSON. Errors call it `name`.
pub fn from_python(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    read(value, name, 0)
}

fn read(value: &Bound<'_, PyAny>, name: &str, depth: usize) -> PyResult<Value> {
    if depth > DEEPEST {
        return Err(PyValueError::new_err(format!(
            "{name}: it is nested too deeply; expected at most {DEEPEST} levels"
        )));
    }
    if value.is_none() {
        return Ok(Value::Null);
    }
    if let Ok(value) = value.cast::<PyBool>() {
        return Ok(Value::Bool(value.is_true()));
    }
    if let Ok(value) = value.cast::<PyInt>() {
        let number = value.extract::<i64>().map(Number::from).or_else(|_| value.extract::<u64>().map(Number::from));
        return number.map(Value::Number).map_err(|_| {
            PyValueError::new_err(format!("{name}: the number is too large; expected one of at most 64 bits"))
        });
    }
    if let Ok(value) = value.cast::<PyFloat>() {
        return finite(value.value(), name).map(Value::Number);
    }
    if let Ok(value) = value.cast::<PyString>() {
        return Ok(Value::String(value.to_str()?.to_owned()));
    }
    if let Ok(fields) = value.cast::<PyDict>() {
        let mut map = Map::new();
        for (key, value) in fields {
            let Ok(key) = key.cast::<PyString>() else {
                return Err(PyTypeError::new_err(format!("{name}: a key is no text; expected names of fields")));
            };
            let key = key.to_str()?;
            map.insert(key.to_owned(), read(&value, &format!("{name}.{key}"), depth + 1)?);
        }
        return Ok(Value::Object(map));
    }
    if value.cast::<PyList>().is_ok() || value.cast::<PyTuple>().is_ok() {
        let elements = value.try_iter()?.enumerate();
        let elements = elements.map(|(index, element)| read(&element?, &format!("{name}[{index}]"), depth + 1));
        return elements.collect::<PyResult<Vec<Value>>>().map(Value::Array);
    }
    // Arrays, and the numbers that are taken from them.
    if let Ok(plain) = value.call_method0("tolist") {
        return read(&plain, name, depth + 1);
    }
    let kind = value.get_type().name()?.to_string();
    let expected = "a dictionary, a list, a text, a number, True, False or None";
    Err(PyTypeError::new_err(format!("{name}: a `{kind}` has no place here; expected {expected}")))
}

fn finite(number: f64, name: &str) -> PyResult<Number> {
    Number::from_f64(number)
        .ok_or_else(|| PyValueError::new_err(format!("{name}: the number is {number}; expected a finite number")))
}
