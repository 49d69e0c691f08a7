//! The rules as data. Presets are files in `assets/rules`; the fields' defaults are those of the preset `naoisis`.

mod limits;
mod procedures;

pub use limits::RulesError;
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
    /// The preset's name, for display.
    pub name: String,
    /// The [custom rules](crate::referee::CustomRule) in force, by name, with their settings: `{}` for the defaults, `null` to
    /// switch a rule off. Names are checked when a match starts.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    #[schemars(with = "serde_json::Map<String, serde_json::Value>")]
    pub own: NamedValues,

    /// Whether the clock ends halves and the match.
    pub clock: bool,
    /// Duration of a half, s.
    pub half_s: f32,
    /// Number of halves.
    pub halves: u32,
    /// Halves of the extra time that is played after a draw: 0, or usually 2.
    pub extra_time_halves: u32,
    /// Duration of a half of the extra time, s.
    pub extra_half_s: f32,
    /// Whether the clock also runs in `ready` and `set`, except before the first kick-off of a half (2025 rule book, section
    /// 3.1).
    pub clock_runs_in_stoppages: bool,
    /// Whether a half continues after its time while an attacker's ball rolls towards the opponents' goal (2025 rule book,
    /// section 3.18).
    pub half_ends_when_ball_stops: bool,
    /// Lead in goals that ends the match (2025 rule book, section 3.16: 10); if absent, no lead ends it.
    pub mercy_goals: Option<u32>,
    /// Number of robots of a team that a scenario lines up.
    pub team_size: u8,
    /// The team that kicks off the first half, and shoots first in a shoot-out.
    pub first_kick_off: Team,

    /// Time-outs that a team may take in a match (2010 and 2025: 1).
    pub timeouts: u32,
    /// Longest duration of a team's time-out, s (2010 and 2025: 300).
    pub timeout_s: f32,
    /// Longest duration of a referee's time-out, s (2025 rule book, section 3.14: 600).
    pub referee_timeout_s: f32,
    /// Number of substitutes of a team that a scenario lines up beside the pitch.
    pub substitutes: u8,
    /// When a substitute may replace a player, besides time-outs and half time.
    pub substitution: SubstitutionProcedure,

    /// Messages that a team may send in a match, except in shoot-outs; if absent, unlimited. The goals of a team that sends more do not
    /// count (2025 rule book, section 2.4.2: 1200).
    pub message_budget: Option<u32>,

    /// Whether goals count and are followed by a kick-off.
    pub goals: bool,
    /// Whether a goal of the team that kicked off counts only if one of its robots has played the ball outside the
    /// centre circle (2010 rule book, section 4.5).
    pub no_kick_off_shots: bool,
    /// Whether a goal counts only if two robots of the team have played the ball since the last restart (2025 rule
    /// book, section 3.4).
    pub indirect_goals: bool,
    /// Whether the taker of a set play is forbidden to touch the ball again before another robot has; if it does, the other team has an
    /// indirect free kick (HSL 2026, 14.5, 15.5 and 16.4). After the kick-off of a team with fewer than three robots it is allowed outside
    /// the circle (law 8).
    pub double_touch: bool,
    /// Whether [`indirect_goals`](Self::indirect_goals) applies only to the team that restarted play by a kick-off, a kick-in or
    /// an indirect free kick, until an opponent touches the ball (HSL 2026, laws 8 and 13).
    pub direct_free_kicks: bool,
    /// Whether a set play that goes straight into the own goal is a goal, rather than a corner kick (HSL 2026, law 13).
    pub own_set_play_goals: bool,

    /// Whether a ball outside the lines is out.
    pub ball_out: bool,
    /// The restart after the ball has left the pitch.
    pub ball_out_restart: BallOutRestart,
    /// Time for which the ball belongs to the attackers in a free kick, s (2025: 30).
    pub free_kick_s: f32,
    /// Distance that defenders must keep from the ball in a free kick, m (2025: 0.75). If absent, the radius of the centre circle; but
    /// defenders may be nearer on their own goal line between the posts (HSL 2026, 13.3.2).
    pub free_kick_distance_m: Option<f32>,
    /// Whether at a goal kick, and at a free kick in the own penalty area, opponents keep out of the whole area (HSL 2026, 13.3.2 and 15.2).
    pub goal_kick_clears_area: bool,
    /// Whether an indirect free kick for an offence in the offenders' own penalty area is taken from the line of that area that is parallel
    /// to the goal line (HSL 2026, 13.3.1).
    pub indirect_free_kick_at_area_line: bool,
    /// Time for defenders to reach that distance, s (2025: 10 as a guideline).
    pub free_kick_leave_s: f32,

    /// Whether pushing near the ball in the own penalty area gives a penalty kick instead of a free kick (2025 rule book,
    /// sections 3.10 and 4.10).
    pub penalty_kicks: bool,
    /// Longest duration of the `ready` before a penalty kick, s (2025: 30).
    pub penalty_kick_ready_s: f32,
    /// Time for which the ball belongs to the attackers in a penalty kick, s (2025: 30).
    pub penalty_kick_s: f32,
    /// Whether a half continues after its time until a penalty kick is over (HSL 2026, 7.4).
    pub penalty_kick_extends_half: bool,
    /// Whether a goal is awarded to the attackers if the goalkeeper leaves its goal line, or its feet, before they touch the ball of a
    /// penalty kick (HSL 2026, penalty kick).
    pub penalty_kick_keeper_goal: bool,
    /// Whether at a penalty kick all robots but the goalkeeper and the kicker also stand behind the mark, at the distance of a free kick
    /// from it (HSL 2026, penalty kick). Otherwise they only stay out of the penalty area.
    pub penalty_kick_behind_mark: bool,

    /// Duration of `initial` before the `standby` or the first `ready` of each half, s. Between halves, a GameController tells
    /// `finished` in the first half of this time, then `initial`. Without `ready` and `set` there is no `initial`.
    pub initial_s: f32,
    /// Duration of the brief stop with which a free kick, kick-in, goal kick or corner kick begins, s: nobody moves, and all clocks stand
    /// (GameController of the HSL 2026).
    pub free_kick_stop_s: f32,
    /// The procedure of a kick-off.
    pub kick_off: KickOffProcedure,
    /// Whether robots are placed beside their half of the pitch before each half and after time-outs, and walk in from there during `ready`, as
    /// in the rule book of 2025. Otherwise they are placed at their kick-off positions. Without effect without `ready`.
    pub walk_in: bool,
    /// Least duration of the `standby` before a half's first `ready`, s (2025: 10); 0 for no `standby`.
    pub standby_s: f32,
    /// Greatest random extension of `standby`, s (2025: 110).
    pub standby_random_s: f32,
    /// Duration of the penalty in place for a robot that begins to walk in `set`, s (2025: 15; HSL 2026: 10). In `standby` the robot's
    /// whole team is penalised, until the robots know of `ready`. If absent, robots cannot walk in these states.
    pub motion_in_set_s: Option<f32>,
    /// Whether a robot that moves, or gets up, in a brief stop is removed (HSL 2026, 7.2: motion in stop); otherwise robots cannot move
    /// then.
    pub motion_in_stop: bool,
    /// Longest duration of `ready`, s (2010 and 2025: 45).
    pub ready_s: f32,
    /// Whether `ready` ends as soon as all robots have stood at legal places for a second.
    pub end_ready_early: bool,
    /// Duration of `set`, s.
    pub set_s: f32,
    /// The rule book that defines legal positions at a kick-off.
    pub kick_off_positions: KickOffPositions,
    /// Duration of the penalty for an illegal position in `set`, s (2025: 15); if absent, the robot is placed by hand (2010).
    pub illegal_position_s: Option<f32>,
    /// Whether that penalty counts as an infraction and grows like others (GameController of the HSL 2026; not in the 2025 rule
    /// book, section 4.4).
    pub illegal_position_increases: bool,
    /// Whether pushing, leaving the field, lying and inactivity are judged in `ready`, too (2025 rule book, section 4;
    /// `GameController`s of 2025 and 2026).
    pub fouls_in_ready: bool,
    /// Time for which only the team that kicks off may approach the ball, s (2025: 10); if absent, both may at once.
    pub kick_off_free_s: Option<f32>,
    /// Whether a robot that begins a kick-off outside its own half must take it itself (2025 rule book, section 3.7).
    pub kick_off_player: bool,

    /// Duration of a penalty, s (2010 rule book, section 4.3: 30; 2025: 45).
    pub penalty_s: f32,
    /// Extension of a penalty for each earlier infraction of the team, s (2025: 10).
    pub penalty_increase_s: f32,
    /// Offences that do not make later penalties longer, besides those that never do (HSL 2026, 12.2: illegal positions).
    pub uncounted: Vec<PenaltyReason>,
    /// Whether penalties that are not infractions, such as those of fallen robots, are extended, too (GameController of the HSL 2026).
    pub all_penalties_increase: bool,
    /// Whether penalties end when play is stopped for a kick-off (2010 rule book, section 4). At half time they always do.
    pub penalties_end_at_kick_off: bool,
    /// Whether the time of penalties also runs in `ready` (2025 rule book, section 4.2).
    pub penalties_run_in_ready: bool,
    /// Where robots return after a penalty.
    pub return_place: ReturnPlace,

    /// Whether the robot that is responsible for a collision is penalised.
    pub collisions: bool,
    /// Greatest speed of walking towards the other robot at which a robot is not responsible, m/s.
    pub collision_speed_mps: f32,
    /// Whether collisions of team-mates are judged, too.
    pub collisions_between_team_mates: bool,
    /// Whether the goalkeeper is never responsible in its own penalty area.
    pub keeper_may_push: bool,
    /// Whether both robots are responsible for a collision in which they are equally fast; otherwise neither is (HSL 2026, 12.3.4).
    pub equal_speeds_penalise_both: bool,
    /// Duration of contact with an opponent from which it is pushing at any speed, s (HSL 2026, 12.3.4: 5). If absent, the duration does
    /// not matter.
    pub push_contact_s: Option<f32>,
    /// Whether contacts with a robot's side are legal on its way to the ball.
    pub side_contacts: SideContacts,
    /// Whether both robots, not only the faster one, are responsible if they collide front to front without the ball between them (2010
    /// rule book, section 4.9.1).
    pub chest_to_chest_penalises_both: bool,
    /// Number of a team's collisions in a half from which the responsible robot is removed for the rest of the half (2010: 4).
    pub pushing_limit: Option<u32>,
    /// Whether a collision within half a metre of the ball gives the other team a free kick (2025).
    pub pushing_free_kick: bool,
    /// Distance from the ball within which every offence gives the other team a free kick, m: direct for pushing, else indirect (HSL 2026,
    /// section 5.1: 0.75 in the small division, else 1.5). If absent, only pushing does.
    pub offence_free_kick_m: Option<f32>,
    /// Whether every offence within [the distance of free kicks](Self::free_kick_distance_m) from the ball gives the other team a free kick
    /// (HSL 2026, 12.1).
    pub offence_free_kick: bool,
    /// Number of cautions for pushing with which a robot is sent off (GameController of the HSL 2026: 2); if absent, there are no cautions.
    pub cautions_to_send_off: Option<u32>,

    /// Whether a robot that stands near the ball for too long is penalised.
    pub stalling: bool,
    /// Longest legal duration of standing near the ball, s.
    pub stall_s: f32,
    /// Distance from the robot's origin to the ball's centre that counts as near, m.
    pub stall_radius_m: f32,

    /// Whether a robot that covers the ball for too long is penalised (2010 rule book, section 4.6).
    pub ball_holding: bool,
    /// Longest legal duration of covering the ball, s (2010 and 2025: 3).
    pub ball_holding_s: f32,
    /// Longest legal duration for the goalkeeper with a foot in its own penalty area, s (2010: 5; 2025: 10).
    pub keeper_ball_holding_s: f32,

    /// Whether a robot that leaves the carpet, or stays in a goal, is penalised (2010 rule book, section 4.12).
    pub leaving_field: bool,
    /// Longest legal stay in a goal, s (2010 and 2025: 5).
    pub in_goal_s: f32,

    /// Whether illegal defenders are penalised (2010 rule book, section 4.13).
    pub illegal_defender: bool,
    /// Which robots of a team may be in front of their own goal.
    pub defender_limit: DefenderLimit,
    /// Reaction time of the referee, s, during which an illegal defender is tolerated.
    pub illegal_defender_s: f32,

    /// Whether a robot that keeps an opponent from the ball without going to the ball is penalised (2010 rule book, section
    /// 4.14).
    pub obstruction: bool,
    /// Longest legal duration of obstruction, s.
    pub obstruction_s: f32,

    /// Whether a robot that does nothing is penalised (2010 rule book, section 4.7).
    pub inactive: bool,
    /// Longest legal duration of inactivity, s (2010 and 2025: 10).
    pub inactive_s: f32,

    /// Whether stuck games are restarted (2010 rule book, section 3.10).
    pub game_stuck: bool,
    /// Time after which a game counts as stuck, s (2010: 15; 2025: 30).
    pub game_stuck_s: f32,
    /// Whether robots that approach the ball or explore the pitch count as progress (2025 rule book, section 3.11), as a moving
    /// ball does.
    pub walking_is_progress: bool,
    /// Time after which the robot nearest to a ball that has not moved is penalised, s, if different from
    /// [`game_stuck_s`](Self::game_stuck_s) (HSL 2026, 18.1: 10).
    pub local_stuck_s: Option<f32>,
    /// Distance from the ball, m: play is stopped if no robot has been within it for [`game_stuck_s`](Self::game_stuck_s) (HSL 2026, 18.2:
    /// 1). If absent, play is stopped if the ball has not moved for that time.
    pub global_stuck_m: Option<f32>,
    /// Whether the robot nearest to the ball is penalised for a stuck game (2025), rather than moved to the halfway line (2010).
    pub stuck_robot_is_penalised: bool,

    /// Whether robots may fall in collisions.
    pub falls: bool,
    /// Greatest speed of a collision in which no robot falls, m/s.
    pub fall_from_mps: f32,
    /// Least speed of a collision in which both robots fall, m/s. In between the probability grows linearly.
    pub fall_certain_mps: f32,
    /// Duration of getting up, s, in any state of the game.
    pub get_up_s: f32,
    /// Whether a robot that lies on the ground for too long is penalised (2010 rule book, section 4.7).
    pub fallen: bool,
    /// Time within which a fallen robot must begin to get up, s (2010: 5).
    pub fallen_s: f32,
    /// Time within which a fallen robot must stand, s (2010: 20).
    pub get_up_limit_s: f32,
    /// Attempts within which a fallen robot must stand, instead of a time; one more if another robot touched it meanwhile (2025 rule book,
    /// section 4.6: 2).
    pub get_up_attempts: Option<u32>,

    /// Whether robots can dive.
    pub dives: bool,
    /// Duration of a dive, s, in any state of the game. Then the robot lies as after a fall.
    pub dive_s: f32,
    /// Time after which a diving robot is down and blocks its strip, s.
    pub dive_down_s: f32,
    /// Length of the strip beyond the robot's base, m.
    pub dive_reach_m: f32,

    /// Whether a drawn match is decided by a penalty shoot-out (2010 rule book, section 3.8; 2025 rule book, section 3.19).
    pub shoot_out: bool,
    /// The procedure of a shoot-out.
    pub shoot_out_procedure: ShootOutProcedure,
    /// Shots of a team before sudden death (2010: 5, in preliminary rounds 3; 2025: 3).
    pub shoot_out_shots: u32,
    /// Longest duration of a shot before sudden death, s (2010: 60; 2025: 30).
    pub shoot_out_s: f32,
    /// Shots of a team in sudden death before a coin decides (2025: 3; 2010: unlimited).
    pub sudden_death_shots: u32,
    /// Longest duration of a shot in sudden death, s (2010: 120); by default [`shoot_out_s`](Self::shoot_out_s).
    pub sudden_death_s: Option<f32>,

    /// Delay with which robots are informed of the start of play, s: the referee whistles (2025: 15; HSL 2026: 10).
    pub status_delay_s: f32,
    /// Delay with which robots are informed of the first `ready` of a half, s: the referee raises its arms (2025: 45).
    pub ready_delay_s: f32,
    /// Delay with which robots are informed of a goal, s: the referee whistles (2025: 15; GameController of the HSL 2026: 0).
    pub goal_delay_s: f32,
    /// Delay with which robots are informed of the team that takes a free kick or penalty kick, s: the referee points (2025: at
    /// least 5).
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
            extra_time_halves: 0,
            extra_half_s: 300.0,
            clock_runs_in_stoppages: false,
            half_ends_when_ball_stops: false,
            mercy_goals: None,
            team_size: 3,
            first_kick_off: Team::Blue,
            timeouts: 0,
            timeout_s: 300.0,
            referee_timeout_s: 600.0,
            substitutes: 0,
            substitution: SubstitutionProcedure::InTimeouts,
            message_budget: None,
            goals: true,
            no_kick_off_shots: false,
            indirect_goals: false,
            double_touch: false,
            direct_free_kicks: false,
            own_set_play_goals: true,
            ball_out: true,
            ball_out_restart: BallOutRestart::KickOff,
            free_kick_s: 30.0,
            free_kick_distance_m: Some(0.75),
            goal_kick_clears_area: false,
            indirect_free_kick_at_area_line: false,
            free_kick_leave_s: 10.0,
            penalty_kicks: false,
            penalty_kick_ready_s: 30.0,
            penalty_kick_s: 30.0,
            penalty_kick_extends_half: false,
            penalty_kick_keeper_goal: false,
            penalty_kick_behind_mark: false,
            initial_s: 0.0,
            free_kick_stop_s: 0.0,
            kick_off: KickOffProcedure::Placed,
            walk_in: false,
            standby_s: 0.0,
            standby_random_s: 0.0,
            motion_in_set_s: None,
            motion_in_stop: false,
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
            uncounted: Vec::new(),
            all_penalties_increase: false,
            penalties_end_at_kick_off: false,
            penalties_run_in_ready: false,
            return_place: ReturnPlace::HalfwayLine,
            collisions: true,
            collision_speed_mps: 0.05,
            collisions_between_team_mates: false,
            keeper_may_push: false,
            equal_speeds_penalise_both: true,
            push_contact_s: None,
            side_contacts: SideContacts::default(),
            chest_to_chest_penalises_both: false,
            pushing_limit: None,
            pushing_free_kick: false,
            offence_free_kick_m: None,
            offence_free_kick: false,
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
            local_stuck_s: None,
            global_stuck_m: None,
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
            dive_down_s: 0.0,
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
