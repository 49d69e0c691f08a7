//! Values between Rust and Python: dictionaries, lists and numbers in the words of traces and scenario files.

use core::fmt;
use naoisis::record::{shortest_double, shortest_single};
use pyo3::BoundObject;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::ser::{
    self, Serialize, SerializeMap, SerializeSeq, SerializeStruct, SerializeStructVariant, SerializeTuple,
    SerializeTupleStruct, SerializeTupleVariant, Serializer,
};
use serde_json::{Map, Number, Value};

/// Nothing that is read is nested deeper.
const DEEPEST: usize = 100;

/// How many digits the numbers of a Python value have.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Digits {
    /// As many as a line of a trace has.
    Lean,
    /// All that there are.
    All,
}

/// The value as Python has it: as `json.loads` would read it in a trace.
pub fn to_python<'py>(py: Python<'py>, value: &impl Serialize, digits: Digits) -> PyResult<Bound<'py, PyAny>> {
    value.serialize(ToPython { py, digits }).map_err(|Failure(error)| error)
}

/// A value of a scenario or command out of what Python has: dictionaries, sequences, texts, numbers and arrays. `name` is what
/// errors call it.
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

/// What went wrong in Python.
#[derive(Debug)]
struct Failure(PyErr);

impl fmt::Display for Failure {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, formatter)
    }
}

impl core::error::Error for Failure {}

impl ser::Error for Failure {
    fn custom<T: fmt::Display>(message: T) -> Self {
        Failure(PyValueError::new_err(message.to_string()))
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Failure(error)
    }
}

type Made<'py> = Result<Bound<'py, PyAny>, Failure>;

/// Makes a Python value of whatever can be serialised.
#[derive(Clone, Copy)]
struct ToPython<'py> {
    py: Python<'py>,
    digits: Digits,
}

impl<'py> ToPython<'py> {
    fn any<T: IntoPyObject<'py>>(self, value: T) -> Made<'py>
    where
        PyErr: From<T::Error>,
    {
        let value = value.into_pyobject(self.py).map_err(|error| Failure(error.into()))?;
        Ok(value.into_any().into_bound())
    }

    /// The dictionary with one entry that a variant with a value is.
    fn variant(self, name: &str, value: Bound<'py, PyAny>) -> Made<'py> {
        let fields = PyDict::new(self.py);
        fields.set_item(name, value)?;
        Ok(fields.into_any())
    }

    fn elements(self) -> Elements<'py> {
        Elements { to: self, list: PyList::empty(self.py), variant: None }
    }

    fn fields(self) -> Fields<'py> {
        Fields { to: self, dictionary: PyDict::new(self.py), key: None, variant: None }
    }
}

impl<'py> Serializer for ToPython<'py> {
    type Ok = Bound<'py, PyAny>;
    type Error = Failure;
    type SerializeSeq = Elements<'py>;
    type SerializeTuple = Elements<'py>;
    type SerializeTupleStruct = Elements<'py>;
    type SerializeTupleVariant = Elements<'py>;
    type SerializeMap = Fields<'py>;
    type SerializeStruct = Fields<'py>;
    type SerializeStructVariant = Fields<'py>;

    fn serialize_bool(self, value: bool) -> Made<'py> {
        Ok(PyBool::new(self.py, value).to_owned().into_any())
    }

    fn serialize_i8(self, value: i8) -> Made<'py> {
        self.serialize_i64(value.into())
    }

    fn serialize_i16(self, value: i16) -> Made<'py> {
        self.serialize_i64(value.into())
    }

    fn serialize_i32(self, value: i32) -> Made<'py> {
        self.serialize_i64(value.into())
    }

    fn serialize_i64(self, value: i64) -> Made<'py> {
        self.any(value)
    }

    fn serialize_u8(self, value: u8) -> Made<'py> {
        self.serialize_u64(value.into())
    }

    fn serialize_u16(self, value: u16) -> Made<'py> {
        self.serialize_u64(value.into())
    }

    fn serialize_u32(self, value: u32) -> Made<'py> {
        self.serialize_u64(value.into())
    }

    fn serialize_u64(self, value: u64) -> Made<'py> {
        self.any(value)
    }

    fn serialize_f32(self, value: f32) -> Made<'py> {
        if !value.is_finite() {
            return self.serialize_none();
        }
        let number = match self.digits {
            Digits::Lean => shortest_single(value),
            // The shortest number in decimal digits that is this one in single precision.
            Digits::All => value.to_string().parse().unwrap_or_else(|_| value.into()),
        };
        self.any(number)
    }

    fn serialize_f64(self, value: f64) -> Made<'py> {
        if !value.is_finite() {
            return self.serialize_none();
        }
        self.any(if self.digits == Digits::Lean { shortest_double(value) } else { value })
    }

    fn serialize_char(self, value: char) -> Made<'py> {
        self.any(value)
    }

    fn serialize_str(self, value: &str) -> Made<'py> {
        self.any(value)
    }

    fn serialize_bytes(self, value: &[u8]) -> Made<'py> {
        self.any(value)
    }

    fn serialize_none(self) -> Made<'py> {
        Ok(self.py.None().into_bound(self.py))
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Made<'py> {
        self.serialize_none()
    }

    fn serialize_unit_struct(self, _: &'static str) -> Made<'py> {
        self.serialize_none()
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Made<'py> {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Made<'py> {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Made<'py> {
        self.variant(variant, value.serialize(self)?)
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Elements<'py>, Failure> {
        Ok(self.elements())
    }

    fn serialize_tuple(self, _: usize) -> Result<Elements<'py>, Failure> {
        Ok(self.elements())
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Elements<'py>, Failure> {
        Ok(self.elements())
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Elements<'py>, Failure> {
        Ok(Elements { variant: Some(variant), ..self.elements() })
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Fields<'py>, Failure> {
        Ok(self.fields())
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Fields<'py>, Failure> {
        Ok(self.fields())
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Fields<'py>, Failure> {
        Ok(Fields { variant: Some(variant), ..self.fields() })
    }
}

/// A list that is being made.
struct Elements<'py> {
    to: ToPython<'py>,
    list: Bound<'py, PyList>,
    variant: Option<&'static str>,
}

impl<'py> Elements<'py> {
    fn push<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failure> {
        Ok(self.list.append(value.serialize(self.to)?)?)
    }

    fn made(self) -> Made<'py> {
        let list = self.list.into_any();
        self.variant.map_or(Ok(list.clone()), |variant| self.to.variant(variant, list))
    }
}

/// The traits of lists differ by their names alone.
macro_rules! elements {
    ($($kind:ident $push:ident;)*) => {
        $(impl<'py> $kind for Elements<'py> {
            type Ok = Bound<'py, PyAny>;
            type Error = Failure;

            fn $push<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failure> {
                self.push(value)
            }

            fn end(self) -> Made<'py> {
                self.made()
            }
        })*
    };
}

elements! {
    SerializeSeq serialize_element;
    SerializeTuple serialize_element;
    SerializeTupleStruct serialize_field;
    SerializeTupleVariant serialize_field;
}

/// A dictionary that is being made.
struct Fields<'py> {
    to: ToPython<'py>,
    dictionary: Bound<'py, PyDict>,
    key: Option<Bound<'py, PyAny>>,
    variant: Option<&'static str>,
}

impl<'py> Fields<'py> {
    fn made(self) -> Made<'py> {
        let dictionary = self.dictionary.into_any();
        self.variant.map_or(Ok(dictionary.clone()), |variant| self.to.variant(variant, dictionary))
    }
}

impl<'py> SerializeMap for Fields<'py> {
    type Ok = Bound<'py, PyAny>;
    type Error = Failure;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Result<(), Failure> {
        self.key = Some(key.serialize(self.to)?);
        Ok(())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Result<(), Failure> {
        let value = value.serialize(self.to)?;
        match self.key.take() {
            Some(key) => Ok(self.dictionary.set_item(key, value)?),
            None => Err(ser::Error::custom("a value without a key")),
        }
    }

    fn end(self) -> Made<'py> {
        self.made()
    }
}

/// The traits of structures differ by their names alone.
macro_rules! fields {
    ($($kind:ident)*) => {
        $(impl<'py> $kind for Fields<'py> {
            type Ok = Bound<'py, PyAny>;
            type Error = Failure;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Result<(), Failure> {
                Ok(self.dictionary.set_item(key, value.serialize(self.to)?)?)
            }

            fn end(self) -> Made<'py> {
                self.made()
            }
        })*
    };
}

fields! { SerializeStruct SerializeStructVariant }
