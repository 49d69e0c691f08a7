//! The rules as data. Presets are files in `assets/rules`; the fields' defaults are those of the preset `naoisis`.

mod procedures;

pub use procedures::{
    BallOutRestart, DefenderLimit, KickOffPositions, KickOffProcedure, ReturnPlace, ShootOutProcedure, SideContacts,
    SubstitutionProcedure,
};

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PenaltyReason;
use crate::cycle::CycleClock;
use crate::knowledge::Knowledge;
use crate::named_values::NamedValues;
use crate::pitch::Pitch;
use crate::team::Team;

/// Defines [`Rules`] by the list of its fields with their defaults.
macro_rules! rules {
    ($($(#[$attribute:meta])* $field:ident: $type:ty = $default:expr,)*) => {
        /// The rules as data; presets are files in `assets/rules`. The default is the preset `naoisis`: the paper's match
        /// mode (section 3.4). Durations are in seconds of play unless documented otherwise.
        ///
        /// Groups of fields, in this order: clock and halves; time-outs and substitutes; messages; goals; balls that are out and free kicks;
        /// penalty kicks; kick-offs; penalties; collisions; stalling and ball holding; places; inactivity and stuck games; falls and dives;
        /// shoot-outs; the delay of the robots' information.
        #[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
        #[reflect(Resource, @Knowledge::Public)]
        #[serde(default, deny_unknown_fields)]
        pub struct Rules {
            $($(#[$attribute])* pub $field: $type,)*
        }

        impl Default for Rules {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
}

rules! {
    /// The preset's name, for display.
    name: String = "naoisis".to_owned(),
    /// The [custom rules](crate::referee::CustomRule) in force, by name, with their settings: `{}` for the defaults, `null` to
    /// switch a rule off. Names are checked when a match starts.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    own: NamedValues = NamedValues::default(),

    /// Whether the clock ends halves and the match.
    clock: bool = true,
    /// Duration of a half, s.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    half_s: f32 = 600.0,
    /// Number of halves.
    #[schemars(range(min = 1, max = 10))]
    halves: u32 = 2,
    /// Halves of the extra time that is played after a draw: 0, or usually 2.
    #[schemars(range(min = 0, max = 10))]
    extra_time_halves: u32 = 0,
    /// Duration of a half of the extra time, s.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    extra_half_s: f32 = 300.0,
    /// Whether the clock also runs in `ready` and `set`, except before the first kick-off of a half (2025 rule book, section
    /// 3.1).
    clock_runs_in_stoppages: bool = false,
    /// Whether a half continues after its time while an attacker's ball rolls towards the opponents' goal (2025 rule book,
    /// section 3.18).
    half_ends_when_ball_stops: bool = false,
    /// Lead in goals that ends the match (2025 rule book, section 3.16: 10); if absent, no lead ends it.
    #[schemars(range(min = 1, max = 1000), extend("unit" = "goals"))]
    mercy_goals: Option<u32> = None,
    /// Number of robots of a team that a scenario lines up.
    #[schemars(range(min = 1, max = 11), extend("unit" = "robots"))]
    team_size: u8 = 3,
    /// The team that kicks off the first half, and shoots first in a shoot-out.
    first_kick_off: Team = Team::Blue,

    /// Time-outs that a team may take in a match (2010 and 2025: 1).
    #[schemars(range(min = 0, max = 100))]
    timeouts: u32 = 0,
    /// Longest duration of a team's time-out, s (2010 and 2025: 300).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    timeout_s: f32 = 300.0,
    /// Longest duration of a referee's time-out, s (2025 rule book, section 3.14: 600).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    referee_timeout_s: f32 = 600.0,
    /// Number of substitutes of a team that a scenario lines up beside the pitch.
    #[schemars(range(min = 0, max = 11), extend("unit" = "robots"))]
    substitutes: u8 = 0,
    /// When a substitute may replace a player, besides time-outs and half time.
    substitution: SubstitutionProcedure = SubstitutionProcedure::InTimeouts,

    /// Messages that a team may send in a match, except in shoot-outs; if absent, unlimited. The goals of a team that sends more do not
    /// count (2025 rule book, section 2.4.2: 1200).
    message_budget: Option<u32> = None,

    /// Whether goals count and are followed by a kick-off.
    goals: bool = true,
    /// Whether a goal of the team that kicked off counts only if one of its robots has played the ball outside the
    /// centre circle (2010 rule book, section 4.5).
    no_kick_off_shots: bool = false,
    /// Whether a goal counts only if two robots of the team have played the ball since the last restart (2025 rule
    /// book, section 3.4).
    indirect_goals: bool = false,
    /// Whether the taker of a set play is forbidden to touch the ball again before another robot has; if it does, the other team has an
    /// indirect free kick (HSL 2026, 14.5, 15.5 and 16.4). After the kick-off of a team with fewer than three robots it is allowed outside
    /// the circle (law 8).
    double_touch: bool = false,
    /// Whether [`indirect_goals`](Self::indirect_goals) applies only to the team that restarted play by a kick-off, a kick-in or
    /// an indirect free kick, until an opponent touches the ball (HSL 2026, laws 8 and 13).
    direct_free_kicks: bool = false,
    /// Whether a set play that goes straight into the own goal is a goal, rather than a corner kick (HSL 2026, law 13).
    own_set_play_goals: bool = true,

    /// Whether a ball outside the lines is out.
    ball_out: bool = true,
    /// The restart after the ball has left the pitch.
    ball_out_restart: BallOutRestart = BallOutRestart::KickOff,
    /// Time for which the ball belongs to the attackers in a free kick, s (2025: 30).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    free_kick_s: f32 = 30.0,
    /// Distance that defenders must keep from the ball in a free kick, m (2025: 0.75). If absent, the radius of the centre circle; but
    /// defenders may be nearer on their own goal line between the posts (HSL 2026, 13.3.2).
    #[schemars(range(min = 0.0, max = 100.0))]
    free_kick_distance_m: Option<f32> = Some(0.75),
    /// Whether at a goal kick, and at a free kick in the own penalty area, opponents keep out of the whole area (HSL 2026, 13.3.2 and 15.2).
    goal_kick_clears_area: bool = false,
    /// Whether an indirect free kick for an offence in the offenders' own penalty area is taken from the line of that area that is parallel
    /// to the goal line (HSL 2026, 13.3.1).
    indirect_free_kick_at_area_line: bool = false,
    /// Time for defenders to reach that distance, s (2025: 10 as a guideline).
    #[schemars(range(min = 0.0, max = 1e5))]
    free_kick_leave_s: f32 = 10.0,

    /// Whether pushing near the ball in the own penalty area gives a penalty kick instead of a free kick (2025 rule book,
    /// sections 3.10 and 4.10).
    penalty_kicks: bool = false,
    /// Longest duration of the `ready` before a penalty kick, s (2025: 30).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    penalty_kick_ready_s: f32 = 30.0,
    /// Time for which the ball belongs to the attackers in a penalty kick, s (2025: 30).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    penalty_kick_s: f32 = 30.0,
    /// Whether a half continues after its time until a penalty kick is over (HSL 2026, 7.4).
    penalty_kick_extends_half: bool = false,
    /// Whether a goal is awarded to the attackers if the goalkeeper leaves its goal line, or its feet, before they touch the ball of a
    /// penalty kick (HSL 2026, penalty kick).
    penalty_kick_keeper_goal: bool = false,
    /// Whether at a penalty kick all robots but the goalkeeper and the kicker also stand behind the mark, at the distance of a free kick
    /// from it (HSL 2026, penalty kick). Otherwise they only stay out of the penalty area.
    penalty_kick_behind_mark: bool = false,

    /// Duration of `initial` before the `standby` or the first `ready` of each half, s. Between halves, a GameController tells
    /// `finished` in the first half of this time, then `initial`. Without `ready` and `set` there is no `initial`.
    #[schemars(range(min = 0.0, max = 1e5))]
    initial_s: f32 = 0.0,
    /// Duration of the brief stop with which a free kick, kick-in, goal kick or corner kick begins, s: nobody moves, and all clocks stand
    /// (GameController of the HSL 2026).
    #[schemars(range(min = 0.0, max = 1e5))]
    free_kick_stop_s: f32 = 0.0,
    /// The procedure of a kick-off.
    kick_off: KickOffProcedure = KickOffProcedure::Placed,
    /// Whether robots are placed beside their half of the pitch before each half and after time-outs, and walk in from there during `ready`, as
    /// in the rule book of 2025. Otherwise they are placed at their kick-off positions. Without effect without `ready`.
    walk_in: bool = false,
    /// Least duration of the `standby` before a half's first `ready`, s (2025: 10); 0 for no `standby`.
    #[schemars(range(min = 0.0, max = 1e5))]
    standby_s: f32 = 0.0,
    /// Greatest random extension of `standby`, s (2025: 110).
    #[schemars(range(min = 0.0, max = 1e5))]
    standby_random_s: f32 = 0.0,
    /// Duration of the penalty in place for a robot that begins to walk in `set`, s (2025: 15; HSL 2026: 10). In `standby` the robot's
    /// whole team is penalised, until the robots know of `ready`. If absent, robots cannot walk in these states.
    #[schemars(range(min = 0.0, max = 1e5))]
    motion_in_set_s: Option<f32> = None,
    /// Whether a robot that moves, or gets up, in a brief stop is removed (HSL 2026, 7.2: motion in stop); otherwise robots cannot move
    /// then.
    motion_in_stop: bool = false,
    /// Longest duration of `ready`, s (2010 and 2025: 45).
    #[schemars(range(min = 0.0, max = 1e5))]
    ready_s: f32 = 45.0,
    /// Whether `ready` ends as soon as all robots have stood at legal places for a second.
    end_ready_early: bool = true,
    /// Duration of `set`, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    set_s: f32 = 3.0,
    /// The rule book that defines legal positions at a kick-off.
    kick_off_positions: KickOffPositions = KickOffPositions::Spl2010,
    /// Duration of the penalty for an illegal position in `set`, s (2025: 15); if absent, the robot is placed by hand (2010).
    #[schemars(range(min = 0.0, max = 1e5))]
    illegal_position_s: Option<f32> = None,
    /// Whether that penalty counts as an infraction and grows like others (GameController of the HSL 2026; not in the 2025 rule
    /// book, section 4.4).
    illegal_position_increases: bool = false,
    /// Whether pushing, leaving the field, lying and inactivity are judged in `ready`, too (2025 rule book, section 4;
    /// `GameController`s of 2025 and 2026).
    fouls_in_ready: bool = false,
    /// Time for which only the team that kicks off may approach the ball, s (2025: 10); if absent, both may at once.
    #[schemars(range(min = 0.0, max = 1e5))]
    kick_off_free_s: Option<f32> = None,
    /// Whether a robot that begins a kick-off outside its own half must take it itself (2025 rule book, section 3.7).
    kick_off_player: bool = false,

    /// Duration of a penalty, s (2010 rule book, section 4.3: 30; 2025: 45).
    #[schemars(range(min = 0.0, max = 1e5))]
    penalty_s: f32 = 30.0,
    /// Extension of a penalty for each earlier infraction of the team, s (2025: 10).
    #[schemars(range(min = 0.0, max = 1e5))]
    penalty_increase_s: f32 = 0.0,
    /// Offences that do not make later penalties longer, besides those that never do (HSL 2026, 12.2: illegal positions).
    uncounted: Vec<PenaltyReason> = Vec::new(),
    /// Whether penalties that are not infractions, such as those of fallen robots, are extended, too (GameController of the HSL 2026).
    all_penalties_increase: bool = false,
    /// Whether penalties end when play is stopped for a kick-off (2010 rule book, section 4). At half time they always do.
    penalties_end_at_kick_off: bool = false,
    /// Whether the time of penalties also runs in `ready` (2025 rule book, section 4.2).
    penalties_run_in_ready: bool = false,
    /// Where robots return after a penalty.
    return_place: ReturnPlace = ReturnPlace::HalfwayLine,

    /// Whether the robot that is responsible for a collision is penalised.
    collisions: bool = true,
    /// Greatest speed of walking towards the other robot at which a robot is not responsible, m/s.
    #[schemars(range(min = 0.0, max = 10.0))]
    collision_speed_mps: f32 = 0.05,
    /// Whether collisions of team-mates are judged, too.
    collisions_between_team_mates: bool = false,
    /// Whether the goalkeeper is never responsible in its own penalty area.
    keeper_may_push: bool = false,
    /// Whether both robots are responsible for a collision in which they are equally fast; otherwise neither is (HSL 2026, 12.3.4).
    equal_speeds_penalise_both: bool = true,
    /// Duration of contact with an opponent from which it is pushing at any speed, s (HSL 2026, 12.3.4: 5). If absent, the duration does
    /// not matter.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    push_contact_s: Option<f32> = None,
    /// Whether contacts with a robot's side are legal on its way to the ball.
    side_contacts: SideContacts = SideContacts::default(),
    /// Whether both robots, not only the faster one, are responsible if they collide front to front without the ball between them (2010
    /// rule book, section 4.9.1).
    chest_to_chest_penalises_both: bool = false,
    /// Number of a team's collisions in a half from which the responsible robot is removed for the rest of the half (2010: 4).
    #[schemars(range(min = 1, max = 1000), extend("unit" = "collisions"))]
    pushing_limit: Option<u32> = None,
    /// Whether a collision within half a metre of the ball gives the other team a free kick (2025).
    pushing_free_kick: bool = false,
    /// Distance from the ball within which every offence gives the other team a free kick, m: direct for pushing, else indirect (HSL 2026,
    /// section 5.1: 0.75 in the small division, else 1.5). If absent, only pushing does.
    #[schemars(range(min = 0.0, max = 100.0))]
    offence_free_kick_m: Option<f32> = None,
    /// Whether every offence within [the distance of free kicks](Self::free_kick_distance_m) from the ball gives the other team a free kick
    /// (HSL 2026, 12.1).
    offence_free_kick: bool = false,
    /// Number of cautions for pushing with which a robot is sent off (GameController of the HSL 2026: 2); if absent, there are no cautions.
    #[schemars(range(min = 1, max = 100), extend("unit" = "cautions"))]
    cautions_to_send_off: Option<u32> = None,

    /// Whether a robot that stands near the ball for too long is penalised.
    stalling: bool = true,
    /// Longest legal duration of standing near the ball, s.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    stall_s: f32 = 15.0,
    /// Distance from the robot's origin to the ball's centre that counts as near, m.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 100.0))]
    stall_radius_m: f32 = 0.5,

    /// Whether a robot that covers the ball for too long is penalised (2010 rule book, section 4.6).
    ball_holding: bool = false,
    /// Longest legal duration of covering the ball, s (2010 and 2025: 3).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    ball_holding_s: f32 = 3.0,
    /// Longest legal duration for the goalkeeper with a foot in its own penalty area, s (2010: 5; 2025: 10).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    keeper_ball_holding_s: f32 = 5.0,

    /// Whether a robot that leaves the carpet, or stays in a goal, is penalised (2010 rule book, section 4.12).
    leaving_field: bool = false,
    /// Longest legal stay in a goal, s (2010 and 2025: 5).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    in_goal_s: f32 = 5.0,

    /// Whether illegal defenders are penalised (2010 rule book, section 4.13).
    illegal_defender: bool = false,
    /// Which robots of a team may be in front of their own goal.
    defender_limit: DefenderLimit = DefenderLimit::KeeperOnly,
    /// Reaction time of the referee, s, during which an illegal defender is tolerated.
    #[schemars(range(min = 0.0, max = 1e5))]
    illegal_defender_s: f32 = 1.0,

    /// Whether a robot that keeps an opponent from the ball without going to the ball is penalised (2010 rule book, section
    /// 4.14).
    obstruction: bool = false,
    /// Longest legal duration of obstruction, s.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    obstruction_s: f32 = 2.0,

    /// Whether a robot that does nothing is penalised (2010 rule book, section 4.7).
    inactive: bool = false,
    /// Longest legal duration of inactivity, s (2010 and 2025: 10).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    inactive_s: f32 = 10.0,

    /// Whether stuck games are restarted (2010 rule book, section 3.10).
    game_stuck: bool = false,
    /// Time after which a game counts as stuck, s (2010: 15; 2025: 30).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    game_stuck_s: f32 = 15.0,
    /// Whether robots that approach the ball or explore the pitch count as progress (2025 rule book, section 3.11), as a moving
    /// ball does.
    walking_is_progress: bool = false,
    /// Time after which the robot nearest to a ball that has not moved is penalised, s, if different from
    /// [`game_stuck_s`](Self::game_stuck_s) (HSL 2026, 18.1: 10).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    local_stuck_s: Option<f32> = None,
    /// Distance from the ball, m: play is stopped if no robot has been within it for [`game_stuck_s`](Self::game_stuck_s) (HSL 2026, 18.2:
    /// 1). If absent, play is stopped if the ball has not moved for that time.
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 100.0))]
    global_stuck_m: Option<f32> = None,
    /// Whether the robot nearest to the ball is penalised for a stuck game (2025), rather than moved to the halfway line (2010).
    stuck_robot_is_penalised: bool = false,

    /// Whether robots may fall in collisions.
    falls: bool = false,
    /// Greatest speed of a collision in which no robot falls, m/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    fall_from_mps: f32 = 0.1,
    /// Least speed of a collision in which both robots fall, m/s. In between the probability grows linearly.
    #[schemars(range(min = 0.0, max = 100.0))]
    fall_certain_mps: f32 = 1.0,
    /// Duration of getting up, s, in any state of the game.
    #[schemars(range(min = 0.0, max = 1e5))]
    get_up_s: f32 = 6.0,
    /// Whether a robot that lies on the ground for too long is penalised (2010 rule book, section 4.7).
    fallen: bool = false,
    /// Time within which a fallen robot must begin to get up, s (2010: 5).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    fallen_s: f32 = 5.0,
    /// Time within which a fallen robot must stand, s (2010: 20).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    get_up_limit_s: f32 = 20.0,
    /// Attempts within which a fallen robot must stand, instead of a time; one more if another robot touched it meanwhile (2025 rule book,
    /// section 4.6: 2).
    #[schemars(range(min = 1, max = 100), extend("unit" = "attempts"))]
    get_up_attempts: Option<u32> = None,

    /// Whether robots can dive.
    dives: bool = false,
    /// Duration of a dive, s, in any state of the game. Then the robot lies as after a fall.
    #[schemars(range(min = 0.0, max = 1e5))]
    dive_s: f32 = 1.0,
    /// Time after which a diving robot is down and blocks its strip, s.
    #[schemars(range(min = 0.0, max = 1e5))]
    dive_down_s: f32 = 0.0,
    /// Length of the strip beyond the robot's base, m.
    #[schemars(range(min = 0.0, max = 2.0))]
    dive_reach_m: f32 = 0.5,

    /// Whether a drawn match is decided by a penalty shoot-out (2010 rule book, section 3.8; 2025 rule book, section 3.19).
    shoot_out: bool = false,
    /// The procedure of a shoot-out.
    shoot_out_procedure: ShootOutProcedure = ShootOutProcedure::Spl2010,
    /// Shots of a team before sudden death (2010: 5, in preliminary rounds 3; 2025: 3).
    #[schemars(range(min = 1, max = 100), extend("unit" = "shots"))]
    shoot_out_shots: u32 = 5,
    /// Longest duration of a shot before sudden death, s (2010: 60; 2025: 30).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    shoot_out_s: f32 = 60.0,
    /// Shots of a team in sudden death before a coin decides (2025: 3; 2010: unlimited).
    #[schemars(range(min = 1, max = 100), extend("unit" = "shots"))]
    sudden_death_shots: u32 = 5,
    /// Longest duration of a shot in sudden death, s (2010: 120); by default [`shoot_out_s`](Self::shoot_out_s).
    #[schemars(extend("exclusiveMinimum" = 0.0), range(max = 1e5))]
    sudden_death_s: Option<f32> = None,

    /// Delay with which robots are informed of the start of play, s: the referee whistles (2025: 15; HSL 2026: 10).
    #[schemars(range(min = 0.0, max = 1e5))]
    status_delay_s: f32 = 0.0,
    /// Delay with which robots are informed of the first `ready` of a half, s: the referee raises its arms (2025: 45).
    #[schemars(range(min = 0.0, max = 1e5))]
    ready_delay_s: f32 = 0.0,
    /// Delay with which robots are informed of a goal, s: the referee whistles (2025: 15; GameController of the HSL 2026: 0).
    #[schemars(range(min = 0.0, max = 1e5))]
    goal_delay_s: f32 = 0.0,
    /// Delay with which robots are informed of the team that takes a free kick or penalty kick, s: the referee points (2025: at
    /// least 5).
    #[schemars(range(min = 0.0, max = 1e5))]
    free_kick_signal_s: f32 = 0.0,
}

impl Rules {
    /// The team that kicks off `half`: the [first](Self::first_kick_off) in the first, then alternating.
    pub fn first_kick_off_of_half(&self, half: u32) -> Team {
        if half % 2 == 1 { self.first_kick_off } else { self.first_kick_off.opponent() }
    }

    /// The distance that defenders must keep from the ball in a free kick on `pitch`, m.
    pub fn free_kick_radius_m(&self, pitch: &Pitch) -> f32 {
        self.free_kick_distance_m.unwrap_or(pitch.centre_circle_diameter_m / 2.0)
    }

    /// Whether a penalty for `reason` makes later penalties of the team longer.
    pub fn counts_as_infraction(&self, reason: PenaltyReason) -> bool {
        reason.is_infraction() && !self.uncounted.contains(&reason)
    }

    /// Whether `half` belongs to the extra time.
    pub fn is_extra_time(&self, half: u32) -> bool {
        half > self.halves
    }

    /// Longest duration of the match without stoppages, s, including its extra time.
    pub fn longest_s(&self) -> f32 {
        self.half_s * self.halves as f32 + self.extra_half_s * self.extra_time_halves as f32
    }

    /// Cycles in `half`, at least one.
    pub fn half_cycles(&self, half: u32, clock: &CycleClock) -> u64 {
        u64::from(clock.cycles_in(if self.is_extra_time(half) { self.extra_half_s } else { self.half_s })).max(1)
    }
}
