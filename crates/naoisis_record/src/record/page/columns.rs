//! Columns of whole numbers in packed form: zigzag numbers with seven bits in each byte, in most columns the differences in time.

use std::collections::BTreeMap;

use naoisis_core::team::RobotId;

/// The subject of a column, with which its name begins. Columns of one quantity are stored side by side, because similar numbers compress
/// best together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum About {
    Match,
    Ball,
    /// A further ball of a training, from 2.
    MoreBall(u8),
    Robot(RobotId),
}

/// Quantities that are packed without differences, because a robot sees other objects from moment to moment.
const PLAIN: [&str; 20] = [
    "ex", "ey", "l", "lk", "lx", "ly", "ma", "mb", "mc", "mx", "my", "pa", "pb", "pc", "px", "py", "t", "tk", "tx",
    "ty",
];
/// Larger numbers do not fit into the 32 bits of a browser's shift operators.
const LARGEST: f64 = (1 << 29) as f64;

#[derive(Clone, Default)]
struct Column {
    bytes: Vec<u8>,
    last: i32,
}

/// The columns of a part of a match.
#[derive(Clone, Default)]
pub(super) struct Columns(BTreeMap<(&'static str, About), Column>);

impl Columns {
    /// Adds `value` to the column of a quantity, in multiples of `unit`.
    pub(super) fn add(&mut self, about: About, quantity: &'static str, value: f64, unit: f64) {
        // NaN becomes 0.
        let steps = (value / unit).round().clamp(-LARGEST, LARGEST) as i32;
        self.push(about, quantity, steps);
    }

    /// Adds a whole number to the column of a quantity.
    pub(super) fn push(&mut self, about: About, quantity: &'static str, value: i32) {
        let column = self.0.entry((quantity, about)).or_default();
        let number = if is_plain(quantity) { value } else { value - column.last };
        column.last = value;
        let mut rest = ((number << 1) ^ (number >> 31)) as u32;
        while rest > 127 {
            column.bytes.push(rest as u8 | 128);
            rest >>= 7;
        }
        column.bytes.push(rest as u8);
    }

    /// Adds a heading, degrees, in steps of `unit` degrees, without a jump at half a turn.
    pub(super) fn add_heading(&mut self, about: About, quantity: &'static str, degrees: f64, unit: f64) {
        let last = f64::from(self.0.get(&(quantity, about)).map_or(0, |column| column.last)) * unit;
        let turns = ((last - degrees) / 360.0).round();
        self.add(about, quantity, degrees + 360.0 * turns, unit);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the name, the length in bytes and the kind (1: without differences) of each column, and the bytes of all columns in this
    /// order.
    pub(super) fn packed(&self) -> (Vec<(String, usize, u8)>, Vec<u8>) {
        let mut bytes = Vec::new();
        let names = self.0.iter().map(|((quantity, about), column)| {
            bytes.extend_from_slice(&column.bytes);
            let name = match about {
                About::Match => (*quantity).to_owned(),
                About::Ball => format!("ball.{quantity}"),
                About::MoreBall(number) => format!("ball{number}.{quantity}"),
                About::Robot(id) => format!("{id}.{quantity}"),
            };
            (name, column.bytes.len(), u8::from(is_plain(quantity)))
        });
        (names.collect(), bytes)
    }
}

fn is_plain(quantity: &str) -> bool {
    PLAIN.contains(&quantity)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use naoisis_core::team::Team;
    use proptest::prelude::*;

    /// Unpacks a column in the same way as the page.
    pub(in super::super) fn unpacked(bytes: &[u8], is_plain: bool) -> Vec<i32> {
        let (mut values, mut value, mut shift, mut last) = (Vec::new(), 0_u32, 0, 0);
        for byte in bytes {
            value |= u32::from(byte & 127) << shift;
            shift += 7;
            if *byte < 128 {
                let number = (value >> 1) as i32 ^ -((value & 1) as i32);
                last = if is_plain { number } else { last + number };
                values.push(last);
                (value, shift) = (0, 0);
            }
        }
        values
    }

    proptest! {
        #[test]
        fn what_is_packed_is_unpacked(values in prop::collection::vec(-(1 << 29)..=1 << 29, 0..60), plain: bool) {
            let mut columns = Columns::default();
            let quantity = if plain { "tx" } else { "x" };
            for value in &values {
                columns.push(About::Robot(RobotId::new(Team::Pink, 2)), quantity, *value);
            }
            let (names, bytes) = columns.packed();
            prop_assert_eq!(unpacked(&bytes, plain), values.clone());
            let expected: Vec<_> = (!values.is_empty()).then(|| (format!("pink2.{quantity}"), bytes.len(), u8::from(plain))).into_iter().collect();
            prop_assert_eq!(names, expected);
        }
    }

    #[test]
    fn headings_do_not_jump_and_all_numbers_are_some() {
        let mut columns = Columns::default();
        for degrees in [170.0, 179.0, -179.0, -170.0, 175.0] {
            columns.add_heading(About::Match, "h", degrees, 0.5);
        }
        assert_eq!(unpacked(&columns.packed().1, false), [340, 358, 362, 380, 350]);
        let mut columns = Columns::default();
        for value in [f64::NAN, f64::INFINITY, -1e300, 0.26] {
            columns.add(About::Ball, "x", value, 0.05);
        }
        assert_eq!(unpacked(&columns.packed().1, false), [0, 1 << 29, -(1 << 29), 5]);
    }
}
