//! Quantities of a match that can be measured, and their names, such as `blue.goals`.

use bevy::prelude::*;
use core::fmt;
use strum::{EnumIter, IntoEnumIterator, IntoStaticStr};

use super::wording::{nearest, one_of};
use naoisis_core::events::MistakeKind;
use naoisis_core::team::{RobotId, Team};

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
#[derive(Clone, Copy, PartialEq, Eq, Debug, EnumIter, IntoStaticStr, Reflect)]
#[strum(serialize_all = "snake_case")]
pub enum BallQuantity {
    /// Distance from the centre mark, m.
    FromCentreM,
    /// Distance from the left corner at +x, as seen by the team that attacks there, m.
    FromLeftCornerM,
    /// Distance from the right corner at +x, m.
    FromRightCornerM,
}

/// A quantity of a team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, EnumIter, IntoStaticStr, Reflect)]
#[strum(serialize_all = "snake_case")]
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

/// A quantity of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug, EnumIter, IntoStaticStr, Reflect)]
#[strum(serialize_all = "snake_case")]
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

/// Quantities with names in files: the variant in snake case, and for mistakes of one kind the name of the kind.
trait Named: IntoEnumIterator + Into<&'static str> + Copy {
    /// Creates the quantity of the mistakes of a kind; `None` if there is no such quantity.
    fn of_mistakes(_kind: MistakeKind) -> Option<Self> {
        None
    }

    /// Returns the kind of mistakes that the quantity counts, if it is only one.
    fn kind_of_mistakes(self) -> Option<MistakeKind> {
        None
    }

    fn all() -> impl Iterator<Item = Self> {
        Self::iter().chain(MistakeKind::ALL.into_iter().filter_map(Self::of_mistakes))
    }

    fn name(self) -> &'static str {
        self.kind_of_mistakes().map_or_else(|| self.into(), MistakeKind::key)
    }

    /// Returns the quantity `what` of `whose`.
    ///
    /// # Errors
    /// What is wrong, and what was expected.
    fn find(whose: &str, what: &str) -> Result<Self, (String, String)> {
        Self::all().find(|quantity| quantity.name() == what).ok_or_else(|| {
            let names = || Self::all().map(Self::name);
            let meant = nearest(what, names()).map(|name| format!(": did you mean `{name}`?"));
            let message = format!("there is no quantity `{what}` of `{whose}`{}", meant.unwrap_or_default());
            (message, one_of(names()))
        })
    }
}

impl Named for BallQuantity {}

impl Named for TeamQuantity {
    fn of_mistakes(kind: MistakeKind) -> Option<Self> {
        Some(TeamQuantity::Mistakes(Some(kind)))
    }

    fn kind_of_mistakes(self) -> Option<MistakeKind> {
        if let TeamQuantity::Mistakes(kind) = self { kind } else { None }
    }
}

impl Named for RobotQuantity {
    fn of_mistakes(kind: MistakeKind) -> Option<Self> {
        Some(RobotQuantity::Mistakes(Some(kind)))
    }

    fn kind_of_mistakes(self) -> Option<MistakeKind> {
        if let RobotQuantity::Mistakes(kind) = self { kind } else { None }
    }
}

impl Quantity {
    /// Reads the name of a quantity.
    ///
    /// # Errors
    /// What is wrong, and what was expected.
    pub(super) fn parse(word: &str) -> Result<Self, (String, String)> {
        let Some((whose, what)) = word.split_once('.') else {
            let expected = "a team's or a robot's, such as `blue.goals` or `blue2.kicks`".to_owned();
            return Err((format!("`{word}` is nobody's"), expected));
        };
        if let Some(team) = Team::BOTH.into_iter().find(|team| team.name() == whose) {
            // The name that it had at first.
            let what = if what == "passes" { TeamQuantity::PassesCompleted.name() } else { what };
            return TeamQuantity::find(whose, what).map(|quantity| Quantity::OfTeam(team, quantity));
        }
        if whose == "ball" {
            return BallQuantity::find(whose, what).map(Quantity::OfBall);
        }
        let robot: RobotId = whose.parse().map_err(|_| {
            (format!("there is nobody called `{whose}`"), "a team or a robot, such as `blue` or `pink3`".to_owned())
        })?;
        RobotQuantity::find(whose, what).map(|quantity| Quantity::OfRobot(robot, quantity))
    }

    /// Returns whether the quantity needs a search for mistakes.
    pub fn is_of_mistakes(self) -> bool {
        matches!(
            self,
            Quantity::OfTeam(_, TeamQuantity::Mistakes(_)) | Quantity::OfRobot(_, RobotQuantity::Mistakes(_))
        )
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Quantity::OfTeam(team, quantity) => write!(formatter, "{team}.{}", quantity.name()),
            Quantity::OfRobot(robot, quantity) => write!(formatter, "{robot}.{}", quantity.name()),
            Quantity::OfBall(quantity) => write!(formatter, "ball.{}", quantity.name()),
        }
    }
}
