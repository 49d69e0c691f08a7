//! Expectations of a match, each in a line such as `blue.goals >= 1 within 30 s in 25 % of 200`.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;
use strum::{EnumIter, IntoEnumIterator, IntoStaticStr};

use super::quantity::Quantity;
use super::wording::one_of;

/// Number of matches that an expectation can be about, at most.
const MOST_MATCHES: u32 = 1_000_000;

/// A comparison operator.
#[derive(Clone, Copy, PartialEq, Eq, Debug, EnumIter, IntoStaticStr, Reflect)]
pub enum Comparison {
    /// `>=`.
    #[strum(serialize = ">=")]
    AtLeast,
    /// `<=`.
    #[strum(serialize = "<=")]
    AtMost,
    /// `>`.
    #[strum(serialize = ">")]
    More,
    /// `<`.
    #[strum(serialize = "<")]
    Less,
    /// `==`.
    #[strum(serialize = "==")]
    Equal,
    /// `!=`.
    #[strum(serialize = "!=")]
    Unequal,
}

impl Comparison {
    fn sign(self) -> &'static str {
        self.into()
    }

    /// Returns whether the comparison of `value` with `number` holds.
    pub fn holds(self, value: f64, number: f64) -> bool {
        match self {
            Comparison::AtLeast => value >= number,
            Comparison::AtMost => value <= number,
            Comparison::More => value > number,
            Comparison::Less => value < number,
            Comparison::Equal => value == number,
            Comparison::Unequal => value != number,
        }
    }
}

/// The share of matches in which an expectation must hold.
#[derive(Clone, Copy, PartialEq, Debug, Reflect)]
pub struct Frequency {
    /// The least share of matches, %.
    pub percent: f64,
    /// Number of matches to play, each with the next seed.
    pub matches: u32,
}

/// An expectation of a match: `QUANTITY OP NUMBER [within S s] [in P % of N]`.
#[derive(Clone, Copy, PartialEq, Debug, Reflect)]
#[reflect(Serialize, Deserialize)]
pub struct Expectation {
    /// The quantity that is measured.
    pub quantity: Quantity,
    /// The comparison operator.
    pub comparison: Comparison,
    /// The number that the quantity is compared with.
    pub number: f64,
    /// The time over which the quantity is measured, s from the start. `None` for the whole match.
    pub within_s: Option<f64>,
    /// The share of matches in which the expectation must hold. `None` for this single match.
    pub frequency: Option<Frequency>,
}

/// The error for a line that is no expectation.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{text}` is no expectation: {message}; expected {expected}")]
pub struct NotAnExpectation {
    /// The line.
    text: String,
    /// What is wrong with it.
    message: String,
    /// What was expected.
    expected: String,
}

naoisis_core::debug_as_displayed!(NotAnExpectation);

/// The form of an expectation, for error messages.
const FORM: &str = "QUANTITY OP NUMBER [within S s] [in P % of N], such as `blue.goals >= 1 within 30 s`";

impl FromStr for Expectation {
    type Err = NotAnExpectation;

    fn from_str(text: &str) -> Result<Self, NotAnExpectation> {
        let fault =
            |(message, expected): (String, String)| NotAnExpectation { text: text.to_owned(), message, expected };
        let incomplete = |message: &str| fault((message.to_owned(), FORM.to_owned()));
        // Operators need no blanks around them.
        let mut spaced = String::with_capacity(text.len() + 8);
        let mut before = ' ';
        for letter in text.chars() {
            let is_sign = |letter: char| "<>=!".contains(letter);
            if is_sign(before) != is_sign(letter) || letter == '%' || before == '%' {
                spaced.push(' ');
            }
            spaced.push(letter);
            before = letter;
        }
        let mut words = spaced.split_whitespace();
        let quantity =
            Quantity::parse(words.next().ok_or_else(|| incomplete("there is nothing in it"))?).map_err(fault)?;
        let sign = words.next().ok_or_else(|| incomplete("it compares nothing"))?;
        let comparison = Comparison::iter().find(|comparison| comparison.sign() == sign).ok_or_else(|| {
            fault((format!("`{sign}` compares nothing"), one_of(Comparison::iter().map(Comparison::sign))))
        })?;
        let word = words.next().ok_or_else(|| incomplete("a number is missing"))?;
        let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = number.ok_or_else(|| fault((format!("`{word}` is no number"), "a number".to_owned())))?;
        let (mut within_s, mut frequency) = (None, None);
        let mut rest: Vec<&str> = words.collect();
        if let ["within", seconds, ..] = rest[..] {
            let value = seconds.strip_suffix('s').unwrap_or(seconds).parse::<f64>();
            let value = value.ok().filter(|seconds| seconds.is_finite() && *seconds > 0.0);
            within_s = Some(
                value.ok_or_else(|| fault((format!("`{seconds}` is no time"), "seconds, more than 0".to_owned())))?,
            );
            let unit = usize::from(rest.get(2) == Some(&"s"));
            rest.drain(..2 + unit);
        }
        if let ["in", percent, "%", "of", matches] = rest[..] {
            let share = percent.parse::<f64>().ok().filter(|percent| (0.0..=100.0).contains(percent));
            let matches = matches.parse::<u32>().ok().filter(|matches| (1..=MOST_MATCHES).contains(matches));
            let (Some(percent), Some(matches)) = (share, matches) else {
                return Err(incomplete("the share of matches is none"));
            };
            frequency = Some(Frequency { percent, matches });
            rest.clear();
        }
        match rest.first() {
            Some(word) => Err(incomplete(&format!("`{word}` does not belong there"))),
            None => Ok(Expectation { quantity, comparison, number, within_s, frequency }),
        }
    }
}

impl fmt::Display for Expectation {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {} {}", self.quantity, self.comparison.sign(), self.number)?;
        if let Some(within_s) = self.within_s {
            write!(formatter, " within {within_s} s")?;
        }
        if let Some(Frequency { percent, matches }) = self.frequency {
            write!(formatter, " in {percent} % of {matches}")?;
        }
        Ok(())
    }
}

impl Serialize for Expectation {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl JsonSchema for Expectation {
    fn schema_name() -> Cow<'static, str> {
        "Expectation".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "description": "What is expected, such as `blue.goals >= 1`." })
    }
}

impl<'de> Deserialize<'de> for Expectation {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(|error: NotAnExpectation| {
            let expected = format!("{} ({})", error.expected, error.message);
            de::Error::invalid_value(de::Unexpected::Str(&text), &expected.as_str())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expectations_are_read_as_they_are_written() {
        for text in [
            "blue.goals >= 1",
            "blue2.kicks >= 1 within 10 s",
            "blue.goals >= 1 within 30 s in 25 % of 200",
            "pink.possession_percent < 62.5 in 100 % of 3",
            "pink3.path_m != 0",
            "blue.mistakes <= 3",
            "pink.ball_misplaced >= 1",
            "blue2.own_pose_lost == 0",
            "ball.from_left_corner_m < 3 within 20 s",
            "pink1.ball_error_m < 0.3 within 20 s",
        ] {
            assert_eq!(text.parse::<Expectation>().unwrap().to_string(), text);
        }
        let compact: Expectation = " blue.goals>=1 within 30s in 25% of 200 ".parse().unwrap();
        assert_eq!(compact.to_string(), "blue.goals >= 1 within 30 s in 25 % of 200");
        let earlier: Expectation = "blue.passes > 2".parse().unwrap();
        assert_eq!(earlier.to_string(), "blue.passes_completed > 2");
    }

    #[test]
    fn what_is_no_expectation_is_told_what_it_should_be() {
        for (text, said) in [
            ("", "there is nothing in it"),
            ("goals >= 1", "`goals` is nobody's"),
            ("blue.gaols >= 1", "did you mean `goals`?"),
            ("ball.goals >= 1", "there is no quantity `goals` of `ball`"),
            ("blue.path_m >= 1", "there is no quantity `path_m` of `blue`"),
            ("green.goals >= 1", "there is nobody called `green`"),
            ("blue0.kicks > 1", "there is nobody called `blue0`"),
            ("blue.goals => 1", "`=>` compares nothing"),
            ("blue.goals >=", "a number is missing"),
            ("blue.goals >= many", "`many` is no number"),
            ("blue.goals >= NaN", "`NaN` is no number"),
            ("blue.goals >= 1 within -3 s", "`-3` is no time"),
            ("blue.goals >= 1 in 120 % of 3", "the share of matches is none"),
            ("blue.goals >= 1 in 20 % of 0", "the share of matches is none"),
            ("blue.goals >= 1 soon", "`soon` does not belong there"),
            ("blue.goals >= 1 within", "`within` does not belong there"),
        ] {
            let error = text.parse::<Expectation>().unwrap_err().to_string();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
