//! Formats the numbers of traces with their significant digits.
//!
//! A number has at most five decimal places: a hundredth of a millimetre, a hundred-thousandth of a degree or second. Numbers of single
//! precision have at most six digits. Small numbers have at least three, because variances are small. No sensor of a robot is more
//! accurate. The header of a trace keeps all digits, because the match can be played again from it.

use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter};
use std::io::{self, Write};

/// Decimal places of a number, at most.
const PLACES: usize = 5;
/// Digits of a number of single precision, at most.
const DIGITS: usize = 6;
/// Digits of a small number, at least.
const LEAST_DIGITS: usize = 3;
/// Size from which on numbers are formatted with `serde_json`'s default.
const LARGEST: f64 = 1e10;
/// Decimal places of a small number at most. Smaller numbers are written as 0.
const MOST_PLACES: usize = 12;
/// Bytes of the longest number, with its decimal places, point and sign.
const LONGEST: usize = 32;

/// Returns `number` as it is read back from a trace.
pub fn shortest_single(number: f32) -> f64 {
    parsed(number.into(), |text| ShortestFloats.write_f32(text, number))
}

/// Returns the number that a reader gets from the shortest decimal text of `number`, as traces have it.
pub fn shortest_double(number: f64) -> f64 {
    parsed(number, |text| ShortestFloats.write_f64(text, number))
}

/// Returns the JSON of `value`, with numbers formatted as in a trace.
///
/// # Errors
/// If `value` cannot be written as JSON, such as a map whose keys are not texts.
pub fn shortest_json(value: &impl Serialize) -> serde_json::Result<String> {
    let mut text = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut text, ShortestFloats))?;
    String::from_utf8(text).map_err(serde::ser::Error::custom)
}

/// Returns the number that is read back after `write`, or `number` if that fails.
fn parsed(number: f64, write: impl FnOnce(&mut &mut [u8]) -> io::Result<()>) -> f64 {
    let mut text = [0; LONGEST];
    let mut rest = &mut text[..];
    let written = write(&mut rest);
    let left = rest.len();
    let text = core::str::from_utf8(&text[..LONGEST - left]).ok().filter(|_| written.is_ok());
    text.and_then(|text| text.parse().ok()).unwrap_or(number)
}

const POWERS: [u64; MOST_PLACES + 1] = {
    let mut powers = [1; MOST_PLACES + 1];
    let mut index = 1;
    while index < powers.len() {
        powers[index] = 10 * powers[index - 1];
        index += 1;
    }
    powers
};

/// Writes JSON without blanks, and with rounded numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShortestFloats;

impl Formatter for ShortestFloats {
    fn write_f32<W: ?Sized + Write>(&mut self, writer: &mut W, number: f32) -> io::Result<()> {
        let size = f64::from(number.abs());
        if size >= LARGEST {
            return CompactFormatter.write_f32(writer, number);
        }
        // Large numbers have fewer decimal places.
        let places = (0..PLACES).find(|places| size >= POWERS[DIGITS - 1 - places] as f64).unwrap_or(PLACES);
        write_number(writer, f64::from(number), places)
    }

    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, number: f64) -> io::Result<()> {
        write_number(writer, number, PLACES)
    }
}

/// Writes `number` with at most `places` decimal places, or more if it is small.
fn write_number<W: ?Sized + Write>(writer: &mut W, number: f64, places: usize) -> io::Result<()> {
    let size = number.abs();
    if size >= LARGEST {
        return CompactFormatter.write_f64(writer, number);
    }
    let least = POWERS[LEAST_DIGITS - 1] as f64;
    let mut places = places;
    while (PLACES..MOST_PLACES).contains(&places) && size * (POWERS[places] as f64) < least {
        places += 1;
    }
    let scaled = (size * POWERS[places] as f64).round() as u64;
    if scaled == 0 {
        return writer.write_all(b"0.0");
    }
    let (whole, mut fraction) = (scaled / POWERS[places], scaled % POWERS[places]);
    while places > 1 && fraction % 10 == 0 {
        fraction /= 10;
        places -= 1;
    }
    let mut text = [0; LONGEST];
    let mut start = LONGEST;
    let mut put = |character: u8| {
        start -= 1;
        text[start] = character;
    };
    for _ in 0..places.max(1) {
        put(b'0' + (fraction % 10) as u8);
        fraction /= 10;
    }
    put(b'.');
    let mut rest = whole;
    loop {
        put(b'0' + (rest % 10) as u8);
        rest /= 10;
        if rest == 0 {
            break;
        }
    }
    if number < 0.0 {
        put(b'-');
    }
    writer.write_all(&text[start..])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn written(value: impl Serialize) -> String {
        shortest_json(&value).unwrap()
    }

    #[test]
    fn numbers_have_the_digits_that_mean_something() {
        let single = [0.0_f32, -0.0, 1.0, -0.1, 2.718_301_8, 12.345_678, -160.234_56, 123_456.78, 9_876_543.0, 1e20];
        assert_eq!(
            single.map(written),
            ["0.0", "0.0", "1.0", "-0.1", "2.7183", "12.3457", "-160.235", "123457.0", "9876543.0", "1e+20"]
        );
        assert_eq!(
            [0.009_876_54_f32, 1.234_5e-5, -1.234_5e-9, 1e-15].map(written),
            ["0.00988", "0.0000123", "-0.00000000123", "0.0"]
        );
        assert_eq!([1_199.966_666_666, 179.999_994, 1.0 / 3.0].map(written), ["1199.96667", "179.99999", "0.33333"]);
        assert_eq!(written(f32::NAN), "null");
        assert_eq!(written((7_u64, "1.2345678")), r#"[7,"1.2345678"]"#);
    }

    proptest! {
        #[test]
        fn a_shortest_number_is_near_and_stays_as_it_is(number in -2000.0_f32..2000.0, scale in proptest::sample::select(vec![1e-8_f32, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0])) {
            let number = number * scale;
            let text = written(number);
            let read: f32 = text.parse().unwrap();
            prop_assert!((read - number).abs() <= 0.6e-5_f32.max(0.6e-5 * number.abs()).min(0.6e-2 * number.abs() + 1e-12));
            prop_assert_eq!(written(read), text.clone());
            prop_assert_eq!(written(f64::from(number)).parse::<f64>().map(written).unwrap(), written(f64::from(number)));
            prop_assert!(text.len() <= 15);
            prop_assert_eq!((shortest_single(number), shortest_double(number.into())), (text.parse().unwrap(), written(f64::from(number)).parse().unwrap()));
        }
    }
}
