//! The entries of an observation: name and range of each number, and the sinks that collect them. The same code fills
//! arrays and lists the names of their entries.

use core::fmt;

/// The greatest distance in an observation, m. Larger ones are clamped.
const FARTHEST_M: f32 = 20.0;
/// The greatest speed in an observation, m/s.
const FASTEST_MPS: f32 = 10.0;
/// The greatest age in an observation, s.
pub(super) const OLDEST_S: f32 = 10.0;

/// The range of positions, m.
pub(super) const PLACE: [f32; 2] = [-FARTHEST_M, FARTHEST_M];
/// The range of velocities, m/s or rad/s.
pub(super) const SPEED: [f32; 2] = [-FASTEST_MPS, FASTEST_MPS];
/// The range of cosines, sines, and other numbers without a unit.
pub(super) const UNIT: [f32; 2] = [-1.0, 1.0];
/// The range of ages, s, and of standard deviations of positions, m.
pub(super) const AGE: [f32; 2] = [0.0, OLDEST_S];

/// One number of an observation.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ObservationEntry {
    /// The group, such as `ball`; empty for values of the robot itself.
    pub group: &'static str,
    /// The number among several groups with the same name, from 1; 0 if there is only one.
    pub number: u8,
    /// Its name in the group, such as `x`.
    pub name: &'static str,
    /// The least value.
    pub low: f32,
    /// The greatest value.
    pub high: f32,
    /// The meaning, with its unit.
    pub says: &'static str,
}

impl ObservationEntry {
    /// `value` within the range of the entry; NaN becomes 0.
    fn within(&self, value: f32) -> f32 {
        if value.is_nan() { 0.0 } else { value.clamp(self.low, self.high) }
    }
}

impl fmt::Display for ObservationEntry {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.group, self.number) {
            ("", _) => formatter.write_str(self.name),
            (group, 0) => write!(formatter, "{group}.{}", self.name),
            (group, number) => write!(formatter, "{group}{number}.{}", self.name),
        }
    }
}

/// Receives the numbers of an observation one after the other.
pub(super) trait Sink {
    /// Takes the next number.
    fn put(&mut self, entry: ObservationEntry, value: f32);
}

/// Collects the entries.
#[derive(Default)]
pub(super) struct Entries(pub Vec<ObservationEntry>);

impl Sink for Entries {
    fn put(&mut self, entry: ObservationEntry, _: f32) {
        self.0.push(entry);
    }
}

/// Fills an array; clamps each number to its range.
pub(super) struct Values<'a> {
    pub array: &'a mut [f32],
    pub filled: usize,
}

impl Sink for Values<'_> {
    fn put(&mut self, entry: ObservationEntry, value: f32) {
        if let Some(place) = self.array.get_mut(self.filled) {
            *place = entry.within(value);
            self.filled += 1;
        }
    }
}

impl Sink for Vec<(ObservationEntry, f32)> {
    fn put(&mut self, entry: ObservationEntry, value: f32) {
        self.push((entry, entry.within(value)));
    }
}

/// Puts the numbers of one group into a sink.
pub(super) struct Group<'a, S> {
    pub sink: &'a mut S,
    pub group: &'static str,
    pub number: u8,
}

impl<'a, S: Sink> Group<'a, S> {
    pub fn new(sink: &'a mut S, group: &'static str, number: u8) -> Self {
        Self { sink, group, number }
    }

    /// Puts a number with its range.
    pub fn put(&mut self, name: &'static str, [low, high]: [f32; 2], says: &'static str, value: f32) -> &mut Self {
        self.sink.put(ObservationEntry { group: self.group, number: self.number, name, low, high, says }, value);
        self
    }

    /// Puts 1 if `holds`, else 0.
    pub fn flag(&mut self, name: &'static str, says: &'static str, holds: bool) -> &mut Self {
        self.put(name, [0.0, 1.0], says, f32::from(u8::from(holds)))
    }
}
