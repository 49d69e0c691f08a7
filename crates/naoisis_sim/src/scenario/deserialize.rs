//! Reads types from a tree of values, strictly: it refuses a list for a struct and numbers that overflow to infinity, which `serde_json`
//! accepts. Its errors are data, not sentences.

use core::fmt;
use core::iter::Enumerate;
use core::slice;
use serde::de::value::StrDeserializer;
use serde::de::{
    self, DeserializeSeed, EnumAccess, Expected, IntoDeserializer, MapAccess, SeqAccess, Unexpected, VariantAccess,
    Visitor,
};
use serde::forward_to_deserialize_any;
use serde::{Deserialize, Deserializer};
use serde_json::{Map, Value, map};

use super::field_path::{FieldPath, Segment};
use super::wording::{did_you_mean, one_of, quoted};

/// Reads a type from a value.
///
/// # Errors
/// The fault of the value, and where it is.
pub fn read<'de, T: Deserialize<'de>>(value: &'de Value) -> Result<T, ShapeFault> {
    T::deserialize(StrictDeserializer(value))
}

/// A fault of a value, and its place. It is boxed, as every step of reading passes it on.
#[derive(Clone, PartialEq, Debug)]
pub struct ShapeFault(Box<Fault>);

#[derive(Clone, PartialEq, Debug)]
struct Fault {
    error: ShapeError,
    /// The steps from the faulty value outwards.
    steps: Vec<Segment>,
}

impl ShapeFault {
    /// Returns what is wrong.
    pub fn error(&self) -> &ShapeError {
        &self.0.error
    }

    /// Returns the path of the faulty value in the value that was read.
    pub fn path(&self) -> FieldPath {
        self.0.steps.iter().rev().cloned().collect()
    }

    fn inside(mut self, step: Segment) -> Self {
        self.0.steps.push(step);
        self
    }

    fn in_field(self, name: &str) -> Self {
        self.inside(Segment::Field(name.to_owned()))
    }
}

impl From<ShapeError> for ShapeFault {
    fn from(error: ShapeError) -> Self {
        ShapeFault(Box::new(Fault { error, steps: Vec::new() }))
    }
}

/// What is wrong with a value.
#[derive(Clone, PartialEq, Debug)]
pub enum ShapeError {
    /// An object has an unknown field.
    UnknownField {
        /// The name of the field, as in files.
        name: String,
        /// The names of the possible fields.
        expected: &'static [&'static str],
    },
    /// An object lacks a field that has no default.
    MissingField(&'static str),
    /// A value has the wrong type or form.
    Mismatch {
        /// The value found.
        found: String,
        /// What was expected.
        expected: String,
    },
    /// Another error, in its own words.
    Other(String),
}

impl ShapeError {
    fn variant(found: &str, variants: &'static [&'static str]) -> Self {
        let meant = did_you_mean(found, variants.iter().copied());
        ShapeError::Mismatch { found: format!("{}{meant}", quoted(found)), expected: one_of(variants.iter().copied()) }
    }

    /// Returns whether the name of a field is wrong, not its value.
    pub fn is_about_key(&self) -> bool {
        matches!(self, ShapeError::UnknownField { .. })
    }

    /// Describes what is wrong with a field of this name, and what was expected.
    pub fn words(&self, field: Option<&str>) -> (String, String) {
        match self {
            ShapeError::UnknownField { name, expected } => {
                let meant = did_you_mean(name, expected.iter().copied());
                (format!("there is no field {}{meant}", quoted(name)), one_of(expected.iter().copied()))
            }
            ShapeError::MissingField(name) => {
                (format!("the field {} is missing", quoted(name)), format!("a field {}", quoted(name)))
            }
            ShapeError::Mismatch { found, expected } => {
                let subject = field.map_or("it".to_owned(), quoted);
                let expected = field.and_then(list_form).map_or(expected.clone(), str::to_owned);
                (format!("{subject} is {found}"), expected)
            }
            // Errors of types with their own deserialisation also say what they expected.
            ShapeError::Other(message) => {
                ["; expected ", ": expected "].into_iter().find_map(|words| message.split_once(words)).map_or_else(
                    || (message.clone(), "a value that the field can have".to_owned()),
                    |(message, expected)| (message.to_owned(), expected.to_owned()),
                )
            }
        }
    }
}

/// Describes the contents of a scenario's lists of numbers, by the name of their field.
fn list_form(field: &str) -> Option<&'static str> {
    Some(match field {
        "pose" => "a list of three numbers, [x m, y m, heading deg]",
        "walk" => "a list of three numbers, [dx m, dy m, dtheta deg]",
        "head_deg" => "a list of two numbers, [yaw deg, pitch deg]",
        "yaw_deg" | "pitch_deg" => "a list of two numbers, [least deg, greatest deg]",
        "position_m" | "ball_m" => "a list of two numbers, [x m, y m]",
        "velocity_mps" => "a list of two numbers, [x m/s, y m/s]",
        _ => return None,
    })
}

fn describe_value(value: &Value) -> String {
    match value {
        Value::Null => "nothing (null)".to_owned(),
        Value::Bool(value) => format!("`{value}`"),
        Value::Number(number) => format!("the number {number}"),
        Value::String(text) => format!("the text {}", quoted(text)),
        Value::Array(values) => format!("a list of {}", values.len()),
        Value::Object(_) => "an object".to_owned(),
    }
}

fn mismatch(value: &Value, expected: impl Into<String>) -> ShapeFault {
    ShapeError::Mismatch { found: describe_value(value), expected: expected.into() }.into()
}

fn too_long(list: &Value, expected: usize) -> ShapeFault {
    mismatch(list, format!("a list of {expected}"))
}

fn describe_unexpected(unexpected: Unexpected) -> String {
    match unexpected {
        Unexpected::Bool(value) => format!("`{value}`"),
        Unexpected::Unsigned(number) => format!("the number {number}"),
        Unexpected::Signed(number) => format!("the number {number}"),
        Unexpected::Float(number) => format!("the number {number:?}"),
        Unexpected::Str(text) => format!("the text {}", quoted(text)),
        Unexpected::Unit | Unexpected::Option => "nothing (null)".to_owned(),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "an object".to_owned(),
        other => other.to_string(),
    }
}

/// Translates serde's descriptions of types for users.
fn describe_expected(expected: &dyn Expected) -> String {
    let words = expected.to_string();
    match words.as_str() {
        "f32" | "f64" => "a number".to_owned(),
        "u8" => "a whole number from 0 to 255".to_owned(),
        "u16" | "u32" | "u64" | "usize" => "a whole number, not negative".to_owned(),
        "i8" | "i16" | "i32" | "i64" => "a whole number".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a string" | "string" => "a text in quotes".to_owned(),
        "a sequence" => "a list".to_owned(),
        // glam's vectors.
        "a sequence of 2 f32 values" => "a list of two numbers".to_owned(),
        "a sequence of 3 f32 values" => "a list of three numbers".to_owned(),
        words if words.starts_with("struct ") => "an object with named fields".to_owned(),
        words => words.replace("an array of length", "a list of"),
    }
}

impl fmt::Display for ShapeFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (message, expected) = self.error().words(None);
        write!(formatter, "{message}; expected {expected}")
    }
}

impl std::error::Error for ShapeFault {}

impl de::Error for ShapeFault {
    fn custom<T: fmt::Display>(message: T) -> Self {
        ShapeError::Other(message.to_string()).into()
    }

    fn invalid_type(unexpected: Unexpected, expected: &dyn Expected) -> Self {
        ShapeError::Mismatch { found: describe_unexpected(unexpected), expected: describe_expected(expected) }.into()
    }

    fn invalid_value(unexpected: Unexpected, expected: &dyn Expected) -> Self {
        de::Error::invalid_type(unexpected, expected)
    }

    fn invalid_length(length: usize, expected: &dyn Expected) -> Self {
        ShapeError::Mismatch { found: format!("a list of {length}"), expected: describe_expected(expected) }.into()
    }

    fn unknown_variant(variant: &str, expected: &'static [&'static str]) -> Self {
        ShapeError::variant(variant, expected).into()
    }

    fn unknown_field(name: &str, expected: &'static [&'static str]) -> Self {
        ShapeError::UnknownField { name: name.to_owned(), expected }.into()
    }

    fn missing_field(name: &'static str) -> Self {
        ShapeError::MissingField(name).into()
    }
}

/// Deserialises types strictly from a value.
#[derive(Clone, Copy)]
struct StrictDeserializer<'a>(pub &'a Value);

impl<'de> Deserializer<'de> for StrictDeserializer<'de> {
    type Error = ShapeFault;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ShapeFault> {
        match self.0 {
            Value::Null => visitor.visit_unit(),
            Value::Bool(value) => visitor.visit_bool(*value),
            Value::Number(number) => match (number.as_u64(), number.as_i64(), number.as_f64()) {
                (Some(number), _, _) => visitor.visit_u64(number),
                (_, Some(number), _) => visitor.visit_i64(number),
                (_, _, Some(number)) => visitor.visit_f64(number),
                _ => Err(mismatch(self.0, "a finite number")),
            },
            Value::String(text) => visitor.visit_borrowed_str(text),
            Value::Array(values) => {
                let mut elements = Elements { values: values.iter().enumerate() };
                let result = visitor.visit_seq(&mut elements)?;
                match elements.values.len() {
                    0 => Ok(result),
                    superfluous => Err(too_long(self.0, values.len() - superfluous)),
                }
            }
            Value::Object(fields) => visitor.visit_map(Fields::of(fields)),
        }
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ShapeFault> {
        if self.0.as_f64().is_some_and(|number| !(number as f32).is_finite()) {
            return Err(mismatch(self.0, "a finite number, of single precision (at most 3.4e38)"));
        }
        self.deserialize_any(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, ShapeFault> {
        match self.0 {
            Value::Null => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, ShapeFault> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ShapeFault> {
        match self.0 {
            Value::Object(fields) => visitor.visit_map(Fields::of(fields)),
            _ => Err(mismatch(self.0, "an object with named fields")),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ShapeFault> {
        visitor.visit_enum(Variant::of(self.0, variants)?)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

impl<'de> IntoDeserializer<'de, ShapeFault> for StrictDeserializer<'de> {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

struct Elements<'a> {
    values: Enumerate<slice::Iter<'a, Value>>,
}

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = ShapeFault;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, ShapeFault> {
        let Some((index, value)) = self.values.next() else { return Ok(None) };
        seed.deserialize(StrictDeserializer(value)).map(Some).map_err(|fault| fault.inside(Segment::Index(index)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.values.len())
    }
}

struct Fields<'a> {
    fields: map::Iter<'a>,
    /// The field whose name was read last.
    entry: Option<(&'a String, &'a Value)>,
}

impl<'a> Fields<'a> {
    fn of(fields: &'a Map<String, Value>) -> Self {
        Fields { fields: fields.iter(), entry: None }
    }
}

impl<'de> MapAccess<'de> for Fields<'de> {
    type Error = ShapeFault;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, ShapeFault> {
        self.entry = self.fields.next();
        let Some((name, _)) = self.entry else { return Ok(None) };
        let key: StrDeserializer<'_, ShapeFault> = name.as_str().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|fault| fault.in_field(name))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, ShapeFault> {
        match self.entry.take() {
            Some((name, value)) => seed.deserialize(StrictDeserializer(value)).map_err(|fault| fault.in_field(name)),
            None => seed.deserialize(StrictDeserializer(&Value::Null)),
        }
    }
}

struct Variant<'a> {
    variant: &'a str,
    value: Option<&'a Value>,
}

impl<'a> Variant<'a> {
    /// Reads a word, or an object with one field.
    fn of(value: &'a Value, variants: &[&str]) -> Result<Self, ShapeFault> {
        match value {
            Value::String(variant) => return Ok(Variant { variant, value: None }),
            Value::Object(fields) if fields.len() == 1 => {
                if let Some((variant, value)) = fields.iter().next() {
                    return Ok(Variant { variant, value: Some(value) });
                }
            }
            _ => {}
        }
        Err(mismatch(value, one_of(variants.iter().copied())))
    }
}

impl<'de> EnumAccess<'de> for Variant<'de> {
    type Error = ShapeFault;
    type Variant = VariantContent<'de>;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, VariantContent<'de>), ShapeFault> {
        let variant: StrDeserializer<'_, ShapeFault> = self.variant.into_deserializer();
        let content = VariantContent { variant: self.variant, value: self.value.unwrap_or(&Value::Null) };
        Ok((seed.deserialize(variant)?, content))
    }
}

struct VariantContent<'a> {
    variant: &'a str,
    value: &'a Value,
}

impl<'de> VariantAccess<'de> for VariantContent<'de> {
    type Error = ShapeFault;

    fn unit_variant(self) -> Result<(), ShapeFault> {
        match self.value {
            Value::Null => Ok(()),
            other => Err(mismatch(other, "no value: the word alone").in_field(self.variant)),
        }
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, ShapeFault> {
        seed.deserialize(StrictDeserializer(self.value)).map_err(|fault| fault.in_field(self.variant))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _length: usize, visitor: V) -> Result<V::Value, ShapeFault> {
        let content = match self.value {
            Value::Array(_) => StrictDeserializer(self.value).deserialize_any(visitor),
            other => Err(mismatch(other, "a list")),
        };
        content.map_err(|fault| fault.in_field(self.variant))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, ShapeFault> {
        let content = StrictDeserializer(self.value).deserialize_struct("", fields, visitor);
        content.map_err(|fault| fault.in_field(self.variant))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::ball::Rolling;
    use naoisis_core::robot::kick::KickSettings;
    use naoisis_core::robot::motion::MotionSettings;
    use naoisis_sensing::sensing::sonar::SonarNoise;
    use serde_json::json;

    #[test]
    fn lists_are_no_structs_and_numbers_stay_finite() {
        assert!(read::<MotionSettings>(&json!([0.1])).is_err());
        assert!(read::<MotionSettings>(&json!({ "max_linear_mps": 1e300 })).is_err());
        assert!(read::<[f32; 2]>(&json!([1, 2, 3])).is_err());
        assert_eq!(read::<MotionSettings>(&json!({})), Ok(MotionSettings::default()));
    }

    #[test]
    fn types_that_read_themselves_say_what_they_expected() {
        let words = |kicks: Value| read::<KickSettings>(&kicks).unwrap_err().to_string();
        let no_name = words(json!({ "own": { "Banana Kick": {} } }));
        assert!(
            no_name.ends_with("is no name of a kick; expected a word of 1 to 15 small letters, digits and `_`"),
            "{no_name}"
        );
        let paper = words(json!({ "own": { "left_side": {} } }));
        assert_eq!(paper, "`left_side` is not a kick of its own; expected it beside `own`");
    }

    #[test]
    fn enums_are_words_or_objects_with_one_field() {
        assert_eq!(read::<Rolling>(&json!({ "constant_mps2": 0.3 })), Ok(Rolling::ConstantMps2(0.3)));
        assert_eq!(read::<SonarNoise>(&json!("none")), Ok(SonarNoise::None));
        assert!(read::<SonarNoise>(&json!({ "gaussian": [0.1] })).is_err());
        assert!(read::<SonarNoise>(&json!("gausian")).unwrap_err().to_string().contains("did you mean"));
        assert!(read::<SonarNoise>(&json!({})).is_err());
    }
}
