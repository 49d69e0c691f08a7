//! Expectations of a match, each in a line such as `blue.goals >= 1 within 30 s in 25 % of 200`.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::borrow::Cow;

use super::wording::{nearest, one_of};
use naoisis_core::events::MistakeKind;
use naoisis_core::team::{RobotId, Team};

/// Number of matches that an expectation can be about, at most.
const MOST_MATCHES: u32 = 1_000_000;

/// A quantity of a match that can be measured.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
pub enum Quantity {
    /// A quantity of a team.
    OfTeam(Team, TeamQuantity),
    /// A quantity of a robot.
    OfRobot(RobotId, RobotQuantity),
    /// A quantity of the ball.
    OfBall(BallQuantity),
}

/// A quantity of the ball: its position at the end.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
pub enum BallQuantity {
    /// Distance from the centre mark, m.
    FromCentreM,
    /// Distance from the left corner at +x, as seen by the team that attacks there, m.
    FromLeftCornerM,
    /// Distance from the right corner at +x, m.
    FromRightCornerM,
}

impl BallQuantity {
    const ALL: [(&str, BallQuantity); 3] = [
        ("from_centre_m", BallQuantity::FromCentreM),
        ("from_left_corner_m", BallQuantity::FromLeftCornerM),
        ("from_right_corner_m", BallQuantity::FromRightCornerM),
    ];
}

/// A quantity of a team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
pub enum TeamQuantity {
    /// Goals that count for the team.
    Goals,
    /// Own goals of the team, which count for the other team.
    OwnGoals,
    /// 1 if the team has won, including in a shoot-out or by a coin toss; otherwise 0.
    Wins,
    /// The team's goals in a shoot-out.
    ShootOutGoals,
    /// Kicks of the team that struck the ball.
    Kicks,
    /// Kicks after which another robot of the team was the next to touch the ball.
    PassesCompleted,
    /// Shots: kicks at the goal, on target or not.
    Shots,
    /// Goals, and shots that would have been goals.
    ShotsOnTarget,
    /// Shots of the other team that the goalkeeper stopped.
    Saves,
    /// Duels that the team won.
    DuelsWon,
    /// Penalties against the team.
    Penalties,
    /// Falls of the team's robots.
    Falls,
    /// Balls that left the pitch and that the team touched last.
    Outs,
    /// Possession: the share of the time in play in which the team had touched the ball last, of the time in which either team had, %.
    PossessionPercent,
    /// Programs of the team that were lost: they crashed, hung, were silent or sent something invalid.
    ProgramsLost,
    /// Mistakes of the team's robots, of one kind or of all kinds.
    Mistakes(Option<MistakeKind>),
}

/// The names of mistakes, of all kinds together and of each kind.
const MISTAKES: [(&str, Option<MistakeKind>); 9] = [
    ("mistakes", None),
    ("ball_misplaced", Some(MistakeKind::BallMisplaced)),
    ("own_pose_lost", Some(MistakeKind::OwnPoseLost)),
    ("ball_not_seen", Some(MistakeKind::BallNotSeen)),
    ("kick_missed", Some(MistakeKind::KickMissed)),
    ("kick_at_own_goal", Some(MistakeKind::KickAtOwnGoal)),
    ("ball_given_away", Some(MistakeKind::BallGivenAway)),
    ("team_mates_collide", Some(MistakeKind::TeamMatesCollide)),
    ("same_ball", Some(MistakeKind::SameBall)),
];

/// Returns the names of quantities, with those of mistakes.
fn with_mistakes<Q>(
    own: impl IntoIterator<Item = (&'static str, Q)>,
    mistakes: fn(Option<MistakeKind>) -> Q,
) -> impl Iterator<Item = (&'static str, Q)> {
    own.into_iter().chain(MISTAKES.into_iter().map(move |(name, kind)| (name, mistakes(kind))))
}

impl TeamQuantity {
    const OWN: [(&str, TeamQuantity); 16] = [
        ("goals", TeamQuantity::Goals),
        ("own_goals", TeamQuantity::OwnGoals),
        ("wins", TeamQuantity::Wins),
        ("shoot_out_goals", TeamQuantity::ShootOutGoals),
        ("kicks", TeamQuantity::Kicks),
        ("passes_completed", TeamQuantity::PassesCompleted),
        // The name that it had at first.
        ("passes", TeamQuantity::PassesCompleted),
        ("shots", TeamQuantity::Shots),
        ("shots_on_target", TeamQuantity::ShotsOnTarget),
        ("saves", TeamQuantity::Saves),
        ("duels_won", TeamQuantity::DuelsWon),
        ("penalties", TeamQuantity::Penalties),
        ("programs_lost", TeamQuantity::ProgramsLost),
        ("falls", TeamQuantity::Falls),
        ("outs", TeamQuantity::Outs),
        ("possession_percent", TeamQuantity::PossessionPercent),
    ];

    fn all() -> impl Iterator<Item = (&'static str, TeamQuantity)> {
        with_mistakes(Self::OWN, TeamQuantity::Mistakes)
    }
}

/// A quantity of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
pub enum RobotQuantity {
    /// Kicks of the robot that struck the ball.
    Kicks,
    /// Penalties against the robot.
    Penalties,
    /// Number of falls.
    Falls,
    /// Distance that the robot walked, m.
    PathM,
    /// Share of the cycles in which the robot saw the ball, except during its penalties, %.
    BallSeenPercent,
    /// Distance between the robot's believed and true position, mean over all cycles, m.
    PoseErrorM,
    /// Distance between the ball's believed and true position, mean over all cycles in which the robot has a belief about the ball, m.
    BallErrorM,
    /// Mistakes of the robot, of one kind or of all kinds.
    Mistakes(Option<MistakeKind>),
}

impl RobotQuantity {
    const OWN: [(&str, RobotQuantity); 7] = [
        ("kicks", RobotQuantity::Kicks),
        ("penalties", RobotQuantity::Penalties),
        ("falls", RobotQuantity::Falls),
        ("path_m", RobotQuantity::PathM),
        ("ball_seen_percent", RobotQuantity::BallSeenPercent),
        ("pose_error_m", RobotQuantity::PoseErrorM),
        ("ball_error_m", RobotQuantity::BallErrorM),
    ];

    fn all() -> impl Iterator<Item = (&'static str, RobotQuantity)> {
        with_mistakes(Self::OWN, RobotQuantity::Mistakes)
    }
}

/// A comparison operator.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect)]
pub enum Comparison {
    /// `>=`.
    AtLeast,
    /// `<=`.
    AtMost,
    /// `>`.
    More,
    /// `<`.
    Less,
    /// `==`.
    Equal,
    /// `!=`.
    Unequal,
}

impl Comparison {
    const ALL: [(&str, Comparison); 6] = [
        (">=", Comparison::AtLeast),
        ("<=", Comparison::AtMost),
        (">", Comparison::More),
        ("<", Comparison::Less),
        ("==", Comparison::Equal),
        ("!=", Comparison::Unequal),
    ];

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

impl Quantity {
    fn parse(word: &str) -> Result<Self, (String, String)> {
        let Some((whose, what)) = word.split_once('.') else {
            let expected = "a team's or a robot's, such as `blue.goals` or `blue2.kicks`".to_owned();
            return Err((format!("`{word}` is nobody's"), expected));
        };
        let names = |all: Vec<&'static str>| {
            let meant = nearest(what, all.iter().copied()).map(|name| format!(": did you mean `{name}`?"));
            (
                format!("there is no quantity `{what}` of `{whose}`{}", meant.unwrap_or_default()),
                one_of(all.iter().copied()),
            )
        };
        if let Some(team) = Team::BOTH.into_iter().find(|team| team.name() == whose) {
            let found = TeamQuantity::all().find(|(name, _)| *name == what);
            let found = found.map(|(_, quantity)| Quantity::OfTeam(team, quantity));
            return found.ok_or_else(|| names(TeamQuantity::all().map(|(name, _)| name).collect()));
        }
        if whose == "ball" {
            let found = BallQuantity::ALL.into_iter().find(|(name, _)| *name == what);
            let found = found.map(|(_, quantity)| Quantity::OfBall(quantity));
            return found.ok_or_else(|| names(BallQuantity::ALL.map(|(name, _)| name).to_vec()));
        }
        let robot: RobotId = whose.parse().map_err(|_| {
            (format!("there is nobody called `{whose}`"), "a team or a robot, such as `blue` or `pink3`".to_owned())
        })?;
        let found = RobotQuantity::all().find(|(name, _)| *name == what);
        let found = found.map(|(_, quantity)| Quantity::OfRobot(robot, quantity));
        found.ok_or_else(|| names(RobotQuantity::all().map(|(name, _)| name).collect()))
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::OfTeam(team, quantity) => {
                let name = TeamQuantity::all().find(|(_, other)| other == quantity).map_or("", |(name, _)| name);
                write!(formatter, "{team}.{name}")
            }
            Quantity::OfRobot(robot, quantity) => {
                let name = RobotQuantity::all().find(|(_, other)| other == quantity).map_or("", |(name, _)| name);
                write!(formatter, "{robot}.{name}")
            }
            Quantity::OfBall(quantity) => {
                let name = BallQuantity::ALL.iter().find(|(_, other)| other == quantity).map_or("", |(name, _)| name);
                write!(formatter, "ball.{name}")
            }
        }
    }
}

impl Quantity {
    /// Returns whether the quantity needs a search for mistakes.
    pub fn is_of_mistakes(self) -> bool {
        matches!(
            self,
            Quantity::OfTeam(_, TeamQuantity::Mistakes(_)) | Quantity::OfRobot(_, RobotQuantity::Mistakes(_))
        )
    }
}

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
        let comparison = Comparison::ALL.into_iter().find(|(name, _)| *name == sign).map(|(_, comparison)| comparison);
        let comparison = comparison.ok_or_else(|| {
            fault((format!("`{sign}` compares nothing"), one_of(Comparison::ALL.map(|(name, _)| name).iter().copied())))
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
        let sign =
            Comparison::ALL.into_iter().find(|(_, other)| *other == self.comparison).map_or("", |(name, _)| name);
        write!(formatter, "{} {sign} {}", self.quantity, self.number)?;
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
            "blue2.own_pose_lost == 0",
            "ball.from_left_corner_m < 3 within 20 s",
            "pink1.ball_error_m < 0.3 within 20 s",
        ] {
            assert_eq!(text.parse::<Expectation>().unwrap().to_string(), text);
        }
        let compact: Expectation = " blue.goals>=1 within 30s in 25% of 200 ".parse().unwrap();
        assert_eq!(compact.to_string(), "blue.goals >= 1 within 30 s in 25 % of 200");
    }

    #[test]
    fn every_kind_of_mistake_has_its_name_from_tables() {
        let kinds: Vec<MistakeKind> = MISTAKES.into_iter().filter_map(|(_, kind)| kind).collect();
        assert_eq!(kinds, MistakeKind::ALL);
        for (name, kind) in MISTAKES {
            assert_eq!(kind.map_or("mistakes".to_owned(), MistakeKind::key), name);
        }
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
