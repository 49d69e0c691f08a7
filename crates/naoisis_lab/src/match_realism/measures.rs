//! The measures of a match.

use std::collections::BTreeMap;
use strum::VariantArray;

use naoisis_core::events::FallCause;
use naoisis_core::game::{PenaltyReason, SetPlayKind};
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::game_controller_log::PICK_UP;
use naoisis_record::record::match_counts::MatchCounts;

/// The measures of a match, simulated or real.
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct MatchMeasures {
    /// Goals that count for the team.
    pub goals: PerTeam<u32>,
    /// Goals of both teams in the first half.
    pub goals_in_first_half: u32,
    /// Time in `playing`, s.
    pub play_s: f64,
    /// Time in `ready`, `set` and `playing`, s.
    pub game_s: f64,
    /// Time of all robots in `ready`, `set` and `playing`, s.
    pub robot_s: f64,
    /// The part of `robot_s` without a penalty, s.
    pub active_s: f64,
    /// Penalties of both teams.
    pub penalties: BTreeMap<PenaltyGroup, u32>,
    /// Set plays of both teams.
    pub set_plays: BTreeMap<SetPlayKind, u32>,
    /// Messages that each team sent in `ready`, `set` and `playing`. `None` if they were not counted.
    pub messages: Option<PerTeam<u32>>,
    /// The measures of robots and ball. `None` for the log of a GameController, which does not have them.
    pub field: Option<FieldMeasures>,
}

impl MatchMeasures {
    /// Returns the measures that a GameController also has, from the `counts` of a match.
    pub fn of_counts(counts: &MatchCounts, messages: Option<PerTeam<u32>>) -> Self {
        let both = |of: PerTeam<u32>| of.blue + of.pink;
        let mut penalties = BTreeMap::new();
        let mut set_plays = BTreeMap::new();
        for team in Team::BOTH {
            for (reason, count) in counts.team(team).penalties {
                if let Some(group) = PenaltyGroup::of(reason) {
                    *penalties.entry(group).or_default() += count;
                }
            }
            for (kind, count) in &counts.set_plays[team] {
                *set_plays.entry(*kind).or_default() += count;
            }
        }
        let [blue, pink] = Team::BOTH.map(|team| counts.robot_and_active_s(team));
        Self {
            goals: counts.goals,
            goals_in_first_half: both(counts.goals_in_half(1)),
            play_s: counts.play_s(),
            game_s: counts.game_s(),
            robot_s: blue[0] + pink[0],
            active_s: blue[1] + pink[1],
            penalties,
            set_plays,
            messages,
            field: None,
        }
    }

    /// Returns the goals of both teams.
    pub fn all_goals(&self) -> u32 {
        self.goals.blue + self.goals.pink
    }
}

/// The penalties that a GameController of the leagues distinguishes.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, VariantArray)]
#[non_exhaustive]
pub enum PenaltyGroup {
    /// Pushing.
    Pushing,
    /// Illegal position, illegal defending included.
    IllegalPosition,
    /// Leaving the field.
    LeavingField,
    /// Fallen, inactive or incapable.
    FallenOrInactive,
    /// Ball holding.
    BallHolding,
    /// Local game stuck, stalling included.
    GameStuck,
    /// Motion in `set`.
    MotionInSet,
    /// Motion in `standby`.
    MotionInStandby,
    /// Request for pick-up by the team.
    PickUp,
    /// Sent off.
    SentOff,
    /// Others: stance, arms or hands, obstruction, interventions, rules of one's own.
    Other,
}

impl PenaltyGroup {
    /// All groups, in the order in which they are printed.
    pub const ALL: [Self; Self::VARIANTS.len()] = *Self::VARIANTS.first_chunk().expect("as many as there are");

    /// Returns the group of a reason. Returns `None` for robots that take no part in a shot of a shoot-out, and for substitutes.
    pub fn of(reason: PenaltyReason) -> Option<Self> {
        Some(match reason {
            PenaltyReason::Pushing => Self::Pushing,
            PenaltyReason::IllegalPosition | PenaltyReason::IllegalDefender => Self::IllegalPosition,
            PenaltyReason::LeavingField => Self::LeavingField,
            PenaltyReason::Fallen | PenaltyReason::Inactive => Self::FallenOrInactive,
            PenaltyReason::BallHolding => Self::BallHolding,
            PenaltyReason::GameStuck | PenaltyReason::Stalling => Self::GameStuck,
            PenaltyReason::MotionInSet | PenaltyReason::MotionInStop => Self::MotionInSet,
            PenaltyReason::MotionInStandby => Self::MotionInStandby,
            PenaltyReason::SentOff => Self::SentOff,
            PenaltyReason::PickUp => Self::PickUp,
            PenaltyReason::Custom(name) if name.as_str() == PICK_UP => Self::PickUp,
            PenaltyReason::Obstruction | PenaltyReason::Manual | PenaltyReason::Custom(_) => Self::Other,
            PenaltyReason::ShootOut | PenaltyReason::Substitute => return None,
        })
    }

    /// Returns the key in files and the printed name.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Self::Pushing => ["pushing", "pushing"],
            Self::IllegalPosition => ["illegal_position", "illegal position"],
            Self::LeavingField => ["leaving_field", "leaving the field"],
            Self::FallenOrInactive => ["fallen", "fallen or inactive"],
            Self::BallHolding => ["ball_holding", "ball holding"],
            Self::GameStuck => ["game_stuck", "local game stuck"],
            Self::MotionInSet => ["motion_in_set", "motion in set"],
            Self::MotionInStandby => ["motion_in_standby", "motion in standby"],
            Self::PickUp => ["pick_up", "request for pick-up"],
            Self::SentOff => ["sent_off", "sent off"],
            Self::Other => ["other", "others"],
        }
    }
}

/// What happened to the ball after a kick.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum NextTouch {
    /// A team-mate touched the ball next.
    Mate,
    /// An opponent touched the ball next.
    Opponent,
    /// The kicker touched the ball again, more than half a second later.
    Kicker,
    /// The ball left the pitch.
    Out,
    /// The ball went into a goal.
    Goal,
    /// Play was stopped for another reason.
    Stopped,
}

/// The measures of robots and ball. "In play" is the state `playing`. Robots with a penalty are left out.
#[derive(Clone, PartialEq, Debug, Default)]
#[non_exhaustive]
pub struct FieldMeasures {
    /// Time of all robots in play, s.
    pub robot_play_s: f64,
    /// Time in play of robots that were lying or getting up, s.
    pub lying_s: f64,
    /// Time in play of upright field players, s.
    pub field_player_s: f64,
    /// The part of `field_player_s` in which they were slower than 0.02 m/s, s.
    pub standing_s: f64,
    /// Distance that upright robots walked in play, m. Steps under 0.1 m are left out.
    pub walked_m: f64,
    /// Mean distance that a field player walked in play, m.
    pub field_player_distance_m: Option<f64>,
    /// Falls in play, by cause.
    pub falls: BTreeMap<FallCause, u32>,
    /// Times from a fall until the robot stood again, for robots that lay on the front, s.
    pub get_up_front_s: Vec<f64>,
    /// The same for robots that lay on the back.
    pub get_up_back_s: Vec<f64>,
    /// Contacts of team-mates in play.
    pub contacts_of_mates: u32,
    /// Contacts of opponents in play.
    pub contacts_of_opponents: u32,
    /// The share of the time in play in which a robot recognised the ball.
    pub ball_seen: Option<f64>,
    /// Time of robots within 3 m of the ball, in play, s.
    pub near_3_m_s: f64,
    /// The part of `near_3_m_s` in which the robot recognised the ball, s.
    pub seen_within_3_m_s: f64,
    /// Times in play, longer than 1 s, in which no robot of a team saw the ball until one saw it again, s.
    pub ball_unknown_s: Vec<f64>,
    /// Share of the time in which a robot's pose error is over 0.5 m.
    pub pose_over_half_m: Option<f64>,
    /// The same, over 1 m.
    pub pose_over_1_m: Option<f64>,
    /// Each team's possession.
    pub possession: PerTeam<Option<f64>>,
    /// Length of the ball's path in play, m.
    pub ball_way_m: f64,
    /// Time in play in which the ball was faster than 0.05 m/s, s.
    pub ball_rolls_s: f64,
    /// Time in play with the ball within 0.5 m of a touchline, s.
    pub ball_at_side_s: f64,
    /// Balls that left the pitch.
    pub outs: u32,
    /// Robots that were removed as the game was stuck, with or without a penalty.
    pub stuck_robots: u32,
    /// Stops of play as the game was stuck.
    pub stuck_stops: u32,
    /// Passes of both teams.
    pub passes: u32,
    /// The part of `passes` that a team-mate got.
    pub passes_completed: u32,
    /// Kicks that struck the ball, by name without `left_` and `right_`.
    pub kicks: BTreeMap<String, u32>,
    /// Kicks that missed the ball.
    pub kicks_missed: u32,
    /// Distance between the place of the kick and the ball when the next robot touched it, it left the pitch, or play was stopped, m.
    pub kick_ways_m: Vec<f64>,
    /// What happened after the kicks.
    pub next_touches: BTreeMap<NextTouch, u32>,
    /// Times that the kicker had been within 0.5 m of the ball before a kick, s.
    pub near_before_kick_s: Vec<f64>,
    /// Number of upright robots within 1 m of the ball, summed over the time in play, s.
    pub robots_near_ball_s: f64,
    /// Time in play with four such robots or more, s.
    pub four_near_ball_s: f64,
    /// The part of `four_near_ball_s` in which the ball had rested for 2 s without a touch, s.
    pub left_alone_s: f64,
    /// Time in play with upright robots of both teams within 0.5 m of the ball, s.
    pub contested_s: f64,
    /// Times from the start of `playing` to the first touch, s.
    pub first_touch_s: Vec<f64>,
}

impl FieldMeasures {
    /// Returns the number of falls of upright robots: attempts to get up that failed are left out.
    pub fn all_falls(&self) -> u32 {
        self.falls.iter().filter(|(cause, _)| **cause != FallCause::GettingUp).map(|(_, falls)| falls).sum()
    }

    /// Returns the number of kicks that struck the ball.
    pub fn all_kicks(&self) -> u32 {
        self.kicks.values().sum()
    }
}
