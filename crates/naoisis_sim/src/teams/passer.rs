//! The passer: the player that is soonest at the ball shoots or passes. The others wait where a pass can reach them, or stand between
//! the ball and the own goal when the opponents have it.
//!
//! Passers coordinate by messages. Each reports its place and the opponents that it sees, so that all know of more opponents than they
//! see themselves; and a player that is about to pass announces the receiver and the place, so that the receiver goes there. The keeper
//! stands further out than in other teams, as the players that fall back cover what it leaves. No passer walks into an opponent. With an
//! opponent at the ball, a passer kicks the ball past it at once if it can; on small pitches it does not kick the ball into the
//! opponent's feet, but walks to where it can kick it past.

use bevy::prelude::*;

use super::at_hand::best_at_hand;
use super::attack::{choose_aim, go_for, kick_towards};
use super::giving_way::give_way;
use super::kicking::BallAtFeet;
use super::options::{KickOption, best, options};
use super::passing::{Pass, meet};
use super::player::{Decision, Player, PlayerMemory};
use super::positioning::{time_to_ball_s, wait_for_the_ball};
use super::roles::{goes_for_the_ball, is_soonest, reasons_of_turn, soonest_mate_s};
use super::rule_limits::is_for_the_keeper_only;
use super::searching::search;
use super::worth::{Company, is_futile, reach_m};
use naoisis_core::behaviour::reasons::Reasons;
use naoisis_core::robot::kick::KickRequest;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::{BallBelief, Belief, RobotBelief};

/// The greatest age of information about a team-mate, s. It is long, because limited messages are rare.
const FRESH_TEAM_MATE_S: f32 = 6.0;
/// The greatest age of opponents that team-mates reported, s.
const FRESH_REPORT_S: f32 = 1.0;
/// A reported opponent and a seen one within this distance are the same, m.
const SAME_OPPONENT_M: f32 = 0.5;
/// The time for which a player waits for an announced pass, s.
const PASS_PATIENCE_S: f32 = 4.0;
/// A kick is announced as a pass if it ends within this distance of the receiver, as a share of the reach.
const NEAR_RECEIVER: f32 = 0.2;
/// A kick that can be made at once may be worse than the prepared one by this, in goals: opponents come nearer during the preparation.
const AT_HAND_LOSS: f32 = 0.03;
/// The same for a player in a hurry.
const PRESSED_LOSS: f32 = 0.1;
/// After this time at the ball, it is kicked even into an opponent's feet, s.
const STAND_OFF_S: f32 = 15.0;
/// The distance of the keeper's place from the middle of the goal, m: further out it covers more of the goal, and the others cover what
/// it leaves.
const KEEPER_GUARD_M: f32 = 0.9;
/// The keeper clears a ball nearer to the goal than this, m.
const KEEPER_CLEAR_M: f32 = 1.5;

/// Decides for a passer.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let belief = with_reported_opponents(player, memory);
    let player = &Player { belief: &belief, ..*player };
    let Some(ball) = player.ball() else { return Decision { reports_opponents: true, ..search(player, memory) } };
    memory.attacks = has_turn(player, memory, ball);
    let mut decision = if memory.attacks && !is_for_the_keeper_only(player, ball.position_m) {
        memory.free_place = None;
        attack(player, memory, ball)
    } else {
        memory.lost_since_s = None;
        memory.kick = None;
        memory.at_ball_since_s = None;
        let mates = mates(player);
        let company = Company { mates: &mates, opponents: &player.belief.opponents };
        wait_for_the_ball(player, memory, company, ball)
    };
    decision.walk = give_way(player, decision.walk, &player.belief.opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Decides for the keeper of a team of passers.
pub fn keep(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let belief = with_reported_opponents(player, memory);
    let player = &Player { belief: &belief, ..*player };
    let clear = |player: &Player, memory: &mut PlayerMemory| match player.ball() {
        Some(ball) => attack(player, memory, ball),
        None => search(player, memory),
    };
    let mut decision = super::keeper::keep(player, memory, KEEPER_GUARD_M, KEEPER_CLEAR_M, clear);
    decision.walk = give_way(player, decision.walk, &player.belief.opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Records announced passes, and the opponents that team-mates report, in `memory`.
fn listen(player: &Player, memory: &mut PlayerMemory) {
    let now = player.status.time_s;
    for message in player.heard {
        memory.told_opponents.retain(|(from, ..)| *from != message.from);
        memory.told_opponents.extend(message.say.robots_m.iter().map(|place| (message.from, *place, now)));
        let pass = message.say.payload.as_ref().and_then(|text| text.parse::<Pass>().ok());
        if let Some(pass) = pass.filter(|pass| pass.to == player.id.number) {
            memory.expected_pass = Some((pass, now));
        }
    }
    memory.told_opponents.retain(|(.., when)| now - when < FRESH_REPORT_S);
    if memory.expected_pass.is_some_and(|(_, when)| now - when > PASS_PATIENCE_S) {
        memory.expected_pass = None;
    }
}

/// The player's belief with the opponents that its team-mates reported.
fn with_reported_opponents(player: &Player, memory: &PlayerMemory) -> Belief {
    let mut belief = player.belief.clone();
    for (_, place, when) in &memory.told_opponents {
        if belief.opponents.iter().all(|other| other.position_m.distance(*place) > SAME_OPPONENT_M) {
            let age_s = player.status.time_s - when;
            belief.opponents.push(RobotBelief { id: None, position_m: *place, covariance: [0.04, 0.0, 0.04], age_s });
        }
    }
    belief
}

/// Whether the player goes for the ball: no field player of its team is there sooner.
fn has_turn(player: &Player, memory: &PlayerMemory, ball: &BallBelief) -> bool {
    let counts = |id| is_field_player(player, id);
    is_soonest(player, memory, FRESH_TEAM_MATE_S, counts, |place| time_to_ball_s(player, ball, place))
}

/// Whether a team-mate is a field player, or may be one.
fn is_field_player(player: &Player, id: Option<RobotId>) -> bool {
    !id.is_some_and(|id| player.is_goalkeeper(id))
}

/// The known field players of the own team: jersey numbers and places, m, team frame.
fn mates(player: &Player) -> Vec<(u8, Vec2)> {
    let fresh = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    fresh.filter_map(|mate| Some((mate.id.filter(|id| !player.is_goalkeeper(*id))?.number, mate.position_m))).collect()
}

/// Whether the own team has a kick-off that is not over yet.
fn is_own_kick_off(player: &Player, memory: &PlayerMemory) -> bool {
    player.kick_off_team(memory) == Some(player.id.team)
}

/// Whether the own team has a free kick, from which opponents must keep away.
fn is_own_set_play(player: &Player) -> bool {
    player.status.set_play.is_some_and(|set_play| set_play.team == Some(player.id.team))
}

/// The kicks that the player could prepare, and the place where it meets the ball.
fn options_at_ball(
    player: &Player,
    memory: &mut PlayerMemory,
    company: Company,
    ball: &BallBelief,
) -> (Vec<KickOption>, Vec2) {
    let (meeting_place, _) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, player.position(), player.motion.max_linear_mps);
    let previous = memory.aim;
    let aim = choose_aim(player, memory, meeting_place);
    let options = if is_own_kick_off(player, memory) {
        // The ball is passed to a team-mate, or played to the side if the player knows of none.
        let passes = options(player, company, meeting_place, None, previous, true);
        let to_the_side =
            KickOption { aim, place: meeting_place + aim.direction * aim.distance_m, receiver: None, value: 0.0 };
        if passes.is_empty() { vec![to_the_side] } else { passes }
    } else {
        options(player, company, meeting_place, Some(aim), previous, is_own_set_play(player))
    };
    (options, meeting_place)
}

/// Shoots, passes, kicks the ball ahead or dribbles, whichever has the greatest value.
fn attack(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief) -> Decision {
    memory.lost_since_s = None;
    let mates = mates(player);
    let company = Company { mates: &mates, opponents: &player.belief.opponents };
    let (options, meeting_place) = options_at_ball(player, memory, company, ball);
    let Some(chosen) = best(&options) else { return search(player, memory) };
    memory.aim = Some(chosen.aim.direction);
    let kick_off = is_own_kick_off(player, memory);
    let stood_long = memory.at_ball_since_s.is_some_and(|since| player.status.time_s - since > STAND_OFF_S);
    let mut made = *chosen;
    let decision = go_for(player, memory, ball, &chosen.aim, meeting_place, |at_feet, hurried| {
        let is_ours = kick_off || is_own_set_play(player);
        let may_kick = |kick: &KickRequest| stood_long || !is_kick_futile(player, company, at_feet, kick);
        let at_hand = best_at_hand(player, company, at_feet, !kick_off, is_ours).filter(|(kick, _)| may_kick(kick));
        let mut if_better_by = |least: f32| {
            let (kick, option) = at_hand.filter(|(_, option)| option.value > chosen.value + least)?;
            made = option;
            Some(kick)
        };
        if chosen.aim.dribbles {
            // Only a better kick interrupts it; of a player in a hurry, also one that is a little worse.
            return if_better_by(if hurried { -PRESSED_LOSS } else { 0.0 });
        }
        let towards = |hurried: bool| kick_towards(player, at_feet, &chosen.aim, hurried).filter(may_kick);
        if_better_by(-AT_HAND_LOSS)
            .or_else(|| towards(false))
            .or_else(|| if hurried { if_better_by(-PRESSED_LOSS) } else { None })
            .or_else(|| towards(hurried))
    });
    let is_near = |to: u8| {
        let mut places = mates.iter().filter(|(number, _)| *number == to);
        places.any(|(_, mate)| mate.distance(made.place) < NEAR_RECEIVER * reach_m(player))
    };
    let pass = made.receiver.filter(|to| is_near(*to)).map(|to| Pass { to, place: made.place });
    Decision { pass, ..decision }
}

/// Whether a kick would only hit the feet of the opponents at the ball.
fn is_kick_futile(player: &Player, company: Company, at_feet: BallAtFeet, kick: &KickRequest) -> bool {
    let strike = player.kicks.strike(kick.kick_type, at_feet.in_robot, kick.direction);
    strike.is_some_and(|strike| is_futile(player, company, at_feet.place, at_feet.forward.rotate(strike.direction)))
}

/// Returns the reasons for a passer's decision: with the ball, the values of its kicks, in goals.
pub fn reasons(player: &Player, mut memory: PlayerMemory, decision: &Decision) -> Reasons {
    listen(player, &mut memory);
    let belief = with_reported_opponents(player, &memory);
    let player = &Player { belief: &belief, ..*player };
    let Some(ball) = player.ball() else { return Reasons::default() };
    if !goes_for_the_ball(decision.intention) {
        let time_s = |place| time_to_ball_s(player, ball, place);
        let mate_s = soonest_mate_s(player, &memory, FRESH_TEAM_MATE_S, |id| is_field_player(player, id), time_s);
        return reasons_of_turn(player, &memory, decision, [time_s(player.position()), mate_s]);
    }
    let mates = mates(player);
    let company = Company { mates: &mates, opponents: &player.belief.opponents };
    let (options, _) = options_at_ball(player, &mut memory, company, ball);
    let chosen = best(&options).and_then(|best| options.iter().position(|option| option == best));
    Reasons { chosen, options: options.iter().map(KickOption::choice).collect() }
}

/// Returns the reasons for the decision of a keeper of passers.
pub fn reasons_of_keeper(player: &Player, memory: PlayerMemory, decision: &Decision) -> Reasons {
    let belief = with_reported_opponents(player, &memory);
    super::keeper::reasons_at(&Player { belief: &belief, ..*player }, &memory, decision, KEEPER_CLEAR_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::teams::player::tests::PlayerFixture;
    use naoisis_core::communication::{ReceivedMessage, TeamMessage};
    use naoisis_core::geometry::Pose;
    use naoisis_core::robot::kick::KickModel;
    use naoisis_core::team::{RobotId, Team};

    fn mate(number: u8, x: f32, y: f32) -> RobotBelief {
        let id = Some(RobotId::new(Team::Blue, number));
        RobotBelief { id, position_m: Vec2::new(x, y), covariance: [0.01, 0.0, 0.01], age_s: 0.0 }
    }

    fn opponent(x: f32, y: f32) -> RobotBelief {
        RobotBelief { id: None, ..mate(1, x, y) }
    }

    fn said(number: u8, say: TeamMessage) -> ReceivedMessage {
        ReceivedMessage { from: RobotId::new(Team::Blue, number), sent_cycle: 0, say }
    }

    #[test]
    fn a_free_team_mate_gets_the_ball_unless_an_opponent_is_reported_there() {
        // 4.5 m from the goal there is no shot.
        let mut situation = PlayerFixture::new(Pose::new(-1.7, 0.0, 0.0), Vec2::new(-1.5, 0.0));
        situation.belief.team_mates = vec![mate(3, 0.3, 0.9)];
        situation.belief.opponents = vec![opponent(-0.7, 0.0), opponent(-0.7, -0.6)];
        let worth = |situation: &PlayerFixture| {
            let decision = decide(&situation.player(), &mut PlayerMemory::default());
            let reasons = reasons(&situation.player(), PlayerMemory::default(), &decision);
            reasons.choice().filter(|choice| choice.name == "pass to 3").map(|choice| choice.value)
        };
        let free = worth(&situation).expect("a pass");
        let robots_m = vec![Vec2::new(0.4, 0.9)];
        situation.heard = vec![said(3, TeamMessage { robots_m, ..default() })];
        assert!(worth(&situation).is_none_or(|guarded| guarded < free), "{free}");
    }

    #[test]
    fn a_player_kicks_into_feet_right_ahead_only_after_a_long_time() {
        // The left foot's straight kick sends the ball ahead, and the right foot's side kick sends it to the left.
        let mut situation = PlayerFixture::new(Pose::new(1.0, 0.0, 0.0), Vec2::new(1.175, 0.05));
        situation.kicks.left_straight = KickModel::of(6.0);
        let kicks = |situation: &PlayerFixture, at_ball_since_s: f32| {
            let mut memory = PlayerMemory { at_ball_since_s: Some(at_ball_since_s), ..default() };
            decide(&situation.player(), &mut memory).kick.is_some()
        };
        let now = situation.status.time_s;
        assert!(kicks(&situation, now - 1.0));
        situation.belief.opponents = vec![opponent(1.4, 0.05), opponent(1.3, 0.25)];
        assert!(!kicks(&situation, now - 1.0));
        assert!(kicks(&situation, now - STAND_OFF_S - 1.0));
    }

    #[test]
    fn its_reasons_are_the_kicks_that_it_could_make_and_the_best_is_what_it_prepares() {
        let mut situation = PlayerFixture::new(Pose::new(-0.6, 0.0, 0.0), Vec2::ZERO);
        situation.belief.team_mates = vec![mate(3, 1.6, 0.8)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        let reasons = reasons(&situation.player(), PlayerMemory::default(), &decision);
        let choice = reasons.choice().unwrap();
        assert!(reasons.options.len() > 5 && reasons.options.iter().all(|option| option.value <= choice.value));
        assert!(choice.name == "pass to 3" || decision.pass.is_none(), "{choice:?} {decision:?}");
    }

    #[test]
    fn the_own_kick_off_is_played_to_a_team_mate_and_is_no_shot() {
        let mut situation = PlayerFixture::new(Pose::new(-0.3, 0.0, 0.0), Vec2::ZERO);
        situation.belief.team_mates = vec![mate(3, -0.6, 1.2)];
        situation.belief.opponents = vec![opponent(1.0, 0.0), opponent(1.0, 0.8), opponent(1.0, -0.8)];
        let memory = PlayerMemory { kick_off_since_s: Some(0.0), ..default() };
        let decision = decide(&situation.player(), &mut memory.clone());
        let reasons = reasons(&situation.player(), memory, &decision);
        assert!(reasons.options.iter().all(|option| option.name != "shoot"), "{reasons:?}");
        assert_eq!(reasons.choice().unwrap().name, "pass to 3", "{reasons:?}");
    }

    #[test]
    fn the_receiver_of_an_announced_pass_goes_to_its_place() {
        let mut situation = PlayerFixture::new(Pose::new(0.5, 1.2, 0.0), Vec2::new(-1.0, -0.5));
        situation.belief.team_mates = vec![mate(3, -1.2, -0.5)];
        let announced = TeamMessage { payload: Some("pass 2 1.50 0.20".into()), ..default() };
        situation.heard = vec![said(3, announced)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        assert_eq!(decision.intention, "receive");
        let step = situation.player().forward.rotate(decision.walk.translation());
        assert!(step.dot(Vec2::new(1.0, -1.0)) > 0.0, "{step}");
        // A pass to another player.
        situation.heard = vec![said(3, TeamMessage { payload: Some("pass 4 1.50 0.20".into()), ..default() })];
        assert_ne!(decide(&situation.player(), &mut PlayerMemory::default()).intention, "receive");
    }

    #[test]
    fn when_the_opponents_have_the_ball_it_stands_before_the_own_goal() {
        let mut situation = PlayerFixture::new(Pose::new(0.5, 1.2, 0.0), Vec2::new(0.0, -1.0));
        situation.belief.team_mates = vec![mate(3, 0.6, -0.8)];
        situation.belief.opponents = vec![opponent(0.3, -1.0)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        let step = situation.player().forward.rotate(decision.walk.translation());
        assert!(decision.intention == "support" && step.x < 0.0, "{decision:?}");
    }
}
