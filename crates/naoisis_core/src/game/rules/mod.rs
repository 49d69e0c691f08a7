//! The rules as data. Presets are files in `assets/rules`; the fields' defaults are those of the preset `naoisis`.

mod limits;

pub use limits::RulesError;

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::named_values::NamedValues;

/// What follows when the ball has left the pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum BallOutRestart {
    /// A kick-off of the team that did not touch the ball last, as in the paper's match mode (section 3.4).
    #[default]
    KickOff,
    /// Play runs on; the ball is thrown in (2010 rule book, section 3.9).
    ThrowIn,
    /// A kick-in, a goal kick or a corner kick (2025 rule book, section 3.8).
    FreeKick,
}

/// How a kick-off comes about.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickOffProcedure {
    /// Ball and robots are repositioned, and play goes on at once (paper, section 3.4).
    #[default]
    Placed,
    /// Robots walk to their places (`ready`), wait there (`set`), and play begins with the whistle.
    ReadyAndSet,
}

/// Whose rules say where a robot may stand at a kick-off.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum KickOffPositions {
    /// 2010 rule book, section 3.5.
    #[default]
    Spl2010,
    /// 2025 rule book, section 3.7.
    Spl2025,
}

/// Where a robot comes back after a penalty.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ReturnPlace {
    /// On the halfway line, at the side line farther from the ball (2010).
    #[default]
    HalfwayLine,
    /// Where it waited, level with its own penalty mark (2025).
    PenaltyMark,
}

/// Which of a team's robots may be where in front of their own goal.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum DefenderLimit {
    /// Only the keeper, number 1, may have both feet in the penalty area (2010).
    #[default]
    KeeperOnly,
    /// At most this many robots may touch the goal area, or on a pitch without one the penalty area (2025: 3).
    AtMost(u8),
}

/// Whether a robot may touch another with its side, its arm or shoulder, on its way to the ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SideContacts {
    /// It is responsible as for any collision.
    #[default]
    Count,
    /// It may if the other goes to the ball, too (2010 rule book, section 4.9.1).
    FreeIfBothGoToBall,
    /// It may, whatever the other does (2025 rule book, section 4.10).
    FreeOnTheWayToBall,
}

/// How a penalty shoot-out goes.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ShootOutProcedure {
    /// The attacker begins in the centre of the pitch and may play the ball until it is in the penalty area; in sudden death the
    /// faster goal wins, or the ball that came nearer (2010 rule book, sections 3.7 and 3.8).
    #[default]
    Spl2010,
    /// The attacker begins at the edge of the penalty area and may play the ball once; in sudden death the better shot
    /// wins (2025 rule book, section 3.19).
    Spl2025,
}

/// The rules as data; presets are files in `assets/rules`. The default is the preset `naoisis`: the paper's match
/// mode (section 3.4). Durations are in seconds of play unless they say otherwise.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Rules {
    /// The preset's name, for display.
    pub name: String,
    /// The [rules that the program has registered](naoisis_sim::simulation::rules) which are in force, by name, with their settings;
    /// `{}` for their defaults, `null` for none. Whether there are such is found when a match starts.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    pub own: NamedValues,

    /// Whether the halves end, sides are changed and the match is finished by the clock.
    pub clock: bool,
    /// Duration of a half, s.
    pub half_s: f32,
    /// Number of halves.
    pub halves: u32,
    /// Whether the clock runs on in `ready` and `set`; never before the first kick-off of a half (2025 rule book, section
    /// 3.1).
    pub clock_runs_in_stoppages: bool,
    /// Whether a half goes on after its time as long as an attacker's ball rolls towards the opponents' goal (2025 rule book,
    /// section 3.18).
    pub half_ends_when_ball_stops: bool,
    /// The match is over when a team leads by so many goals (2025 rule book, section 3.16: 10).
    pub mercy_goals: Option<u32>,
    /// Robots of a team when a scenario lines up whole teams.
    pub team_size: u8,

    /// How many messages a team may send in a match, shoot-outs apart; none for any number. The goals of one that sends more
    /// do not count (2025 rule book, section 2.4.2: 1200).
    pub message_budget: Option<u32>,

    /// Whether goals count and are followed by a kick-off.
    pub goals: bool,
    /// Whether a goal of the team that kicked off counts only if one of its robots has played the ball outside the
    /// centre circle (2010 rule book, section 4.5).
    pub no_kick_off_shots: bool,
    /// Whether a goal counts only if two robots of the team have played the ball since the last restart (2025 rule
    /// book, section 3.4).
    pub indirect_goals: bool,
    /// Whether that goes only for the team that restarted play, and only after a kick-off, a kick-in and an indirect free kick:
    /// anything else is direct, and an opponent's touch ends it (HSL 2026, laws 8 and 13).
    pub direct_free_kicks: bool,

    /// Whether a ball outside the lines is out.
    pub ball_out: bool,
    /// What follows then.
    pub ball_out_restart: BallOutRestart,
    /// How long a free kick is the attackers' own, s (2025: 30).
    pub free_kick_s: f32,
    /// How far from the ball defenders must stay meanwhile, m (2025: 0.75).
    pub free_kick_distance_m: f32,
    /// How long they have to get there, s (2025: 10 as a guideline).
    pub free_kick_leave_s: f32,

    /// Whether a push at the ball by which a robot is pushed in the pusher's own penalty area gives a penalty kick instead
    /// (2025 rule book, sections 3.10 and 4.10).
    pub penalty_kicks: bool,
    /// Longest duration of the `ready` before a penalty kick, s (2025: 30).
    pub penalty_kick_ready_s: f32,
    /// How long a penalty kick is the attackers' own, s (2025: 30).
    pub penalty_kick_s: f32,

    /// How a kick-off comes about.
    pub kick_off: KickOffProcedure,
    /// Least duration of the `standby` before a half's first `ready`, s (2025: 10); 0: there is none.
    pub standby_s: f32,
    /// How much longer it lasts at most, by chance, s (2025: 110).
    pub standby_random_s: f32,
    /// For how long a robot is penalised that begins to walk in `set`, s (2025: 15; HSL 2026: 10). It stays where it is. In
    /// `standby` it is its whole team, until they are told `ready`. None: nobody can walk then.
    pub motion_in_set_s: Option<f32>,
    /// Longest duration of `ready`, s (2010 and 2025: 45).
    pub ready_s: f32,
    /// Whether `ready` ends as soon as all robots have stood at legal places for a second.
    pub end_ready_early: bool,
    /// Duration of `set`, s.
    pub set_s: f32,
    /// Where robots may stand.
    pub kick_off_positions: KickOffPositions,
    /// For how long a robot at an illegal place in `set` is removed, s (2025: 15); none: it is placed by hand (2010).
    pub illegal_position_s: Option<f32>,
    /// Whether that counts and grows as other penalties do (GameController of the HSL 2026; 2025 rule book, section 4.4: not).
    pub illegal_position_increases: bool,
    /// Whether pushing, leaving the field, lying and inactivity are judged in `ready`, too (2025 rule book, section 4; the
    /// `GameController`s of 2025 and 2026 have these calls in it).
    pub fouls_in_ready: bool,
    /// For how long only the team that kicks off may approach the ball, s (2025: 10); none: everybody may at once.
    pub kick_off_free_s: Option<f32>,
    /// Whether a robot that begins a kick-off outside its own half must take it itself (2025 rule book, section 3.7).
    pub kick_off_player: bool,

    /// How long a penalised robot is off the pitch, s (2010 rule book, section 4.3: 30; 2025: 45).
    pub penalty_s: f32,
    /// How much longer for each earlier penalty of its team that counts, s (2025: 10).
    pub penalty_increase_s: f32,
    /// Whether that goes for penalties that do not count themselves, too, such as those of fallen robots (GameController of the
    /// HSL 2026).
    pub all_penalties_increase: bool,
    /// Whether penalties are over when play is stopped for a kick-off (2010 rule book, section 4). They always are
    /// at half time.
    pub penalties_end_at_kick_off: bool,
    /// Whether penalties run on in `ready`, and stand still in `set` alone (2025 rule book, section 4.2).
    pub penalties_run_in_ready: bool,
    /// Where robots come back.
    pub return_place: ReturnPlace,

    /// Whether the robot that is responsible for a collision is penalised.
    pub collisions: bool,
    /// A robot that walks towards the other no faster than this is not responsible, m/s.
    pub collision_speed_mps: f32,
    /// Whether that goes for collisions of team-mates, too.
    pub collisions_between_team_mates: bool,
    /// Whether the keeper, number 1, is never responsible in its own penalty area.
    pub keeper_may_push: bool,
    /// Whether it may touch another with its side on its way to the ball.
    pub side_contacts: SideContacts,
    /// Whether both are responsible that walk into each other front to front without the ball between them (2010 rule book,
    /// section 4.9.1), and not the faster one alone.
    pub chest_to_chest_penalises_both: bool,
    /// From this collision of a team on in a half, the responsible robot is removed for the rest of the half (2010: 4).
    pub pushing_limit: Option<u32>,
    /// Whether a collision within half a metre of the ball gives the other team a free kick (2025).
    pub pushing_free_kick: bool,
    /// Any offence of a robot so near to the ball, m, gives the other team a free kick, an indirect one but for pushing; none:
    /// pushing alone does (HSL 2026, section 5.1: 0.75 in the small division, else 1.5).
    pub offence_free_kick_m: Option<f32>,
    /// A robot that pushes is cautioned, and with so many cautions sent off for the rest of the match; none: no cautions
    /// (GameController of the HSL 2026: 2).
    pub cautions_to_send_off: Option<u32>,

    /// Whether a robot that stands near the ball for too long is penalised.
    pub stalling: bool,
    /// For how long it may, s.
    pub stall_s: f32,
    /// How near is near, m, from the robot's origin to the ball's centre.
    pub stall_radius_m: f32,

    /// Whether a robot that covers the ball for too long is penalised (2010 rule book, section 4.6).
    pub ball_holding: bool,
    /// For how long it may, s (2010 and 2025: 3).
    pub ball_holding_s: f32,
    /// For how long the keeper may with a foot in its own penalty area, s (2010: 5; 2025: 10).
    pub keeper_ball_holding_s: f32,

    /// Whether a robot that leaves the carpet, or stays in a goal, is penalised (2010 rule book, section 4.12).
    pub leaving_field: bool,
    /// For how long it may be in a goal, s (2010 and 2025: 5).
    pub in_goal_s: f32,

    /// Whether robots that defend where they may not are penalised (2010 rule book, section 4.13).
    pub illegal_defender: bool,
    /// Who may be where.
    pub defender_limit: DefenderLimit,
    /// For how long a robot may be there too many, s: a referee's reaction.
    pub illegal_defender_s: f32,

    /// Whether a robot that keeps an opponent from the ball and does not go to it is penalised (2010 rule book, section 4.14).
    pub obstruction: bool,
    /// For how long it may step into an opponent's way, s.
    pub obstruction_s: f32,

    /// Whether a robot that does nothing is penalised (2010 rule book, section 4.7).
    pub inactive: bool,
    /// For how long it may, s (2010 and 2025: 10).
    pub inactive_s: f32,

    /// Whether play that is stuck is freed (2010 rule book, section 3.10).
    pub game_stuck: bool,
    /// After how long, s (2010: 15; 2025: 30).
    pub game_stuck_s: f32,
    /// Whether robots that come nearer to the ball, or explore the pitch, keep play from being stuck (2025 rule book, section
    /// 3.11), as does a ball that moves.
    pub walking_is_progress: bool,
    /// Whether the robot nearest to the ball is then penalised (2025), rather than moved to the halfway line (2010).
    pub stuck_robot_is_penalised: bool,

    /// Whether robots may fall when they collide.
    pub falls: bool,
    /// Up to this speed, at which two meet, neither falls, m/s.
    pub fall_from_mps: f32,
    /// From this speed on both fall, m/s; between the two the probability grows in proportion.
    pub fall_certain_mps: f32,
    /// How long a robot takes to get up, s of any state of the game.
    pub get_up_s: f32,
    /// Whether a robot that lies for too long is penalised (2010 rule book, section 4.7).
    pub fallen: bool,
    /// Within this time it must begin to get up, s (2010: 5).
    pub fallen_s: f32,
    /// Within this time it must stand, s (2010: 20).
    pub get_up_limit_s: f32,
    /// In so many attempts instead, and in one more if somebody touched it meanwhile (2025 rule book, section 4.6: 2).
    pub get_up_attempts: Option<u32>,

    /// Whether robots can dive.
    pub dives: bool,
    /// How long a dive blocks its strip, s of any state of the game.
    pub dive_s: f32,
    /// How far the strip reaches beyond the robot's base, m.
    pub dive_reach_m: f32,

    /// Whether a drawn match is decided by a penalty shoot-out (2010 rule book, section 3.8; 2025 rule book, section 3.19).
    pub shoot_out: bool,
    /// How it goes.
    pub shoot_out_procedure: ShootOutProcedure,
    /// Shots of a team before sudden death (2010: 5, in preliminary rounds 3; 2025: 3).
    pub shoot_out_shots: u32,
    /// Longest duration of such a shot, s (2010: 60; 2025: 30).
    pub shoot_out_s: f32,
    /// Shots of a team in sudden death before a coin decides (2025: 3; in 2010 there is no number).
    pub sudden_death_shots: u32,
    /// Longest duration of such a shot, s (2010: 120); none: that of the others.
    pub sudden_death_s: Option<f32>,

    /// For how long robots are not told that play begins, s: the referee whistles (2025: 15; HSL 2026: 10).
    pub status_delay_s: f32,
    /// For how long they are not told of a half's first `ready`, s: the referee raises its arms (2025: 45).
    pub ready_delay_s: f32,
    /// For how long they are not told of a goal, s: the referee whistles that, too (2025: 15; the GameController of the HSL 2026
    /// tells it at once).
    pub goal_delay_s: f32,
    /// For how long robots are told only which free kick or penalty kick there is, and not whose, s: the referee points, and they
    /// have to look (2025: 5, for as long as it points at least).
    pub free_kick_signal_s: f32,
}

impl Default for Rules {
    fn default() -> Self {
        Self {
            name: "naoisis".to_owned(),
            own: NamedValues::default(),
            clock: true,
            half_s: 600.0,
            halves: 2,
            clock_runs_in_stoppages: false,
            half_ends_when_ball_stops: false,
            mercy_goals: None,
            team_size: 3,
            message_budget: None,
            goals: true,
            no_kick_off_shots: false,
            indirect_goals: false,
            direct_free_kicks: false,
            ball_out: true,
            ball_out_restart: BallOutRestart::KickOff,
            free_kick_s: 30.0,
            free_kick_distance_m: 0.75,
            free_kick_leave_s: 10.0,
            penalty_kicks: false,
            penalty_kick_ready_s: 30.0,
            penalty_kick_s: 30.0,
            kick_off: KickOffProcedure::Placed,
            standby_s: 0.0,
            standby_random_s: 0.0,
            motion_in_set_s: None,
            ready_s: 45.0,
            end_ready_early: true,
            set_s: 3.0,
            kick_off_positions: KickOffPositions::Spl2010,
            illegal_position_s: None,
            illegal_position_increases: false,
            fouls_in_ready: false,
            kick_off_free_s: None,
            kick_off_player: false,
            penalty_s: 30.0,
            penalty_increase_s: 0.0,
            all_penalties_increase: false,
            penalties_end_at_kick_off: false,
            penalties_run_in_ready: false,
            return_place: ReturnPlace::HalfwayLine,
            collisions: true,
            collision_speed_mps: 0.05,
            collisions_between_team_mates: false,
            keeper_may_push: false,
            side_contacts: SideContacts::default(),
            chest_to_chest_penalises_both: false,
            pushing_limit: None,
            pushing_free_kick: false,
            offence_free_kick_m: None,
            cautions_to_send_off: None,
            stalling: true,
            stall_s: 15.0,
            stall_radius_m: 0.5,
            ball_holding: false,
            ball_holding_s: 3.0,
            keeper_ball_holding_s: 5.0,
            leaving_field: false,
            in_goal_s: 5.0,
            illegal_defender: false,
            defender_limit: DefenderLimit::KeeperOnly,
            illegal_defender_s: 1.0,
            obstruction: false,
            obstruction_s: 2.0,
            inactive: false,
            inactive_s: 10.0,
            game_stuck: false,
            game_stuck_s: 15.0,
            walking_is_progress: false,
            stuck_robot_is_penalised: false,
            falls: false,
            fall_from_mps: 0.1,
            fall_certain_mps: 1.0,
            get_up_s: 6.0,
            fallen: false,
            fallen_s: 5.0,
            get_up_limit_s: 20.0,
            get_up_attempts: None,
            dives: false,
            dive_s: 1.0,
            dive_reach_m: 0.5,
            shoot_out: false,
            shoot_out_procedure: ShootOutProcedure::Spl2010,
            shoot_out_shots: 5,
            shoot_out_s: 60.0,
            sudden_death_shots: 5,
            sudden_death_s: None,
            status_delay_s: 0.0,
            ready_delay_s: 0.0,
            goal_delay_s: 0.0,
            free_kick_signal_s: 0.0,
        }
    }
}

impl Rules {
    /// Cycles in a half, at least one.
    pub fn half_cycles(&self, clock: &CycleClock) -> u64 {
        u64::from(clock.cycles_in(self.half_s)).max(1)
    }
}
