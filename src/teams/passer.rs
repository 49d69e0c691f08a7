//! The passer: whoever is soonest at the ball shoots or passes, the others wait where a pass can reach them, or stand
//! between the ball and the own goal when the opponents have it.
//!
//! All of that is by messages: everybody tells where it is and which opponents it sees, so that each knows more of them
//! than it sees itself; and who is about to pass says to whom and where to, so that the other goes there. The keeper
//! stands further out than that of other teams, as whoever falls back covers what it leaves, and nobody of them walks
//! into an opponent. With an opponent at the ball they kick it at once past that one, if there is any way, and not into its feet.

use bevy::prelude::*;

use super::at_hand::best_at_hand;
use super::attack::{choose_aim, go_for, kick_towards, search};
use super::giving_way::give_way;
use super::obeying::is_for_the_keeper_only;
use super::options::{Company, KickOption, best, options, pass_worth, reach_m, walking_s};
use super::passing::{Pass, meet, rolled};
use super::player::{Decision, Player, PlayerMemory};
use super::roles::{SUPPORT_DISTANCE_M, support, time_around_ball_s};
use crate::behaviour::reasons::Reasons;
use crate::belief::{BallBelief, Belief, RobotBelief};
use crate::geometry::unit;

/// The jersey number of the keeper, who has other things to do.
const KEEPER: u8 = 1;
/// What was heard or seen of a team-mate longer ago does not count, s.
const FRESH_TEAM_MATE_S: f32 = 2.0;
/// What team-mates told of opponents longer ago does not count, s.
const FRESH_REPORT_S: f32 = 1.0;
/// An opponent that is told of and one that is seen nearer to each other than this are one, m.
const SAME_OPPONENT_M: f32 = 0.5;
/// A player keeps its turn at the ball until a team-mate is nearer by this, s.
const TURN_PREFERENCE_S: f32 = 0.8;
/// An announced pass is waited for so long, s.
const PASS_PATIENCE_S: f32 = 4.0;
/// A kick that ends nearer to who gets it than this share of the reach is a pass, which is announced; of others each makes what
/// it can.
const NEAR_RECEIVER: f32 = 0.2;
/// A kick that can be made at once must be better than the one that is prepared by this, in goals.
const AT_HAND_GAIN: f32 = 0.02;
/// In a hurry it may be worse by this, in goals.
const PRESSED_LOSS: f32 = 0.1;
/// How much better a new place to wait at must be than the one chosen before.
const PLACE_PREFERENCE: f32 = 1.25;
/// Opponents must be nearer to the ball by this for the team to fall back, s.
const FALL_BACK_S: f32 = 1.0;
/// Whoever guards stands between the ball and a place beside the middle of the goal by this share of its width: what the keeper
/// does not cover.
const BESIDE_KEEPER: f32 = 0.29;
/// And so far from the goal at most, as a share of the pitch's length, or just outside the penalty area.
const MOST_GUARD: f32 = 0.3;
/// A ball further back than this share of the own half is defended by all.
const OWN_THIRD: f32 = 0.33;
/// Places to wait at for a pass, from the ball: angles to the way to the goal, radians, and shares of the kick's reach.
const WAITING_ANGLES: [f32; 6] = [0.2, -0.2, 0.6, -0.6, 1.1, -1.1];
const WAITING_SHARES: [f32; 3] = [0.35, 0.55, 0.75];
/// Who waits keeps so far from team-mates, as a share of the kick's reach.
const APART_SHARE: f32 = 0.25;
/// Distance of the keeper's place from the middle of the goal, m: further out it covers more of the goal, as the others
/// cover what it leaves.
const KEEPER_GUARD_M: f32 = 0.9;
/// The keeper clears a ball nearer to the goal than this, m.
const KEEPER_CLEAR_M: f32 = 1.5;

/// Decides for a passer.
pub fn decide(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let belief = with_what_mates_tell(player, memory);
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
        wait_for_the_ball(player, memory, ball)
    };
    decision.walk = give_way(player, decision.walk, &player.belief.opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Decides for the keeper.
pub fn keep(player: &Player, memory: &mut PlayerMemory) -> Decision {
    listen(player, memory);
    let belief = with_what_mates_tell(player, memory);
    let player = &Player { belief: &belief, ..*player };
    let clear = |player: &Player, memory: &mut PlayerMemory| match player.ball() {
        Some(ball) => attack(player, memory, ball),
        None => search(player, memory),
    };
    let mut decision = super::keeper::keep(player, memory, KEEPER_GUARD_M, KEEPER_CLEAR_M, clear);
    decision.walk = give_way(player, decision.walk, &player.belief.opponents);
    Decision { reports_opponents: true, ..decision }
}

/// Takes note of announced passes, and of opponents that team-mates see.
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

/// What the player believes, with the opponents that its team-mates tell of.
fn with_what_mates_tell(player: &Player, memory: &PlayerMemory) -> Belief {
    let mut belief = player.belief.clone();
    for (_, place, when) in &memory.told_opponents {
        if belief.opponents.iter().all(|other| other.position_m.distance(*place) > SAME_OPPONENT_M) {
            let age_s = player.status.time_s - when;
            belief.opponents.push(RobotBelief { id: None, position_m: *place, covariance: [0.04, 0.0, 0.04], age_s });
        }
    }
    belief
}

/// When somebody at `place` is behind the ball, or where it will be, s.
fn time_to_ball_s(player: &Player, ball: &BallBelief, place: Vec2) -> f32 {
    let (meeting_place, time_s) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, place, player.limits.max_linear_mps);
    time_s + time_around_ball_s(player, place, meeting_place)
}

/// Whether it is this player's turn: no field player of its team is at the ball sooner.
fn has_turn(player: &Player, memory: &PlayerMemory, ball: &BallBelief) -> bool {
    let preference = if memory.attacks { TURN_PREFERENCE_S } else { 0.0 };
    let own_s = time_to_ball_s(player, ball, player.position()) - preference;
    let mates = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    mates.filter(|mate| mate.id.is_none_or(|id| id.number != KEEPER)).all(|mate| {
        let time_s = time_to_ball_s(player, ball, mate.position_m);
        own_s < time_s || (own_s == time_s && mate.id.is_none_or(|id| player.id < id))
    })
}

/// The field players of the own team that the player knows of: numbers and places, m, team frame.
fn mates(player: &Player) -> Vec<(u8, Vec2)> {
    let fresh = player.belief.team_mates.iter().filter(|mate| mate.age_s < FRESH_TEAM_MATE_S);
    fresh.filter_map(|mate| Some((mate.id?.number, mate.position_m))).filter(|(number, _)| *number != KEEPER).collect()
}

/// Whether the own team has a kick-off that is not over yet.
fn is_own_kick_off(player: &Player, memory: &PlayerMemory) -> bool {
    memory.kick_off_since_s.is_some() && player.status.kick_off_team == player.id.team
}

/// Whether the own team has a free kick: opponents keep off.
fn is_own_set_play(player: &Player) -> bool {
    player.status.set_play.is_some_and(|set_play| set_play.team == Some(player.id.team))
}

/// What the player can do with the ball, and where it meets it.
fn possible(
    player: &Player,
    memory: &mut PlayerMemory,
    company: Company,
    ball: &BallBelief,
) -> (Vec<KickOption>, Vec2) {
    let (meeting_place, _) =
        meet(ball.position_m, ball.velocity_mps, player.rolling, player.position(), player.limits.max_linear_mps);
    let previous = memory.aim;
    let aim = choose_aim(player, memory, meeting_place);
    let options = if is_own_kick_off(player, memory) {
        // It is played to a team-mate; who knows of none plays it to the side.
        let passes = options(player, company, meeting_place, None, previous, true);
        let to_the_side =
            KickOption { aim, place: meeting_place + aim.direction * aim.distance_m, receiver: None, value: 0.0 };
        if passes.is_empty() { vec![to_the_side] } else { passes }
    } else {
        options(player, company, meeting_place, Some(aim), previous, is_own_set_play(player))
    };
    (options, meeting_place)
}

/// Shoots, passes, or takes the ball forward: whatever is worth most.
fn attack(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief) -> Decision {
    memory.lost_since_s = None;
    let mates = mates(player);
    let company = Company { mates: &mates, opponents: &player.belief.opponents };
    let (options, meeting_place) = possible(player, memory, company, ball);
    let Some(chosen) = best(&options) else { return search(player, memory) };
    memory.aim = Some(chosen.aim.direction);
    let kick_off = is_own_kick_off(player, memory);
    let mut made = *chosen;
    let decision = go_for(player, memory, ball, &chosen.aim, meeting_place, |at_feet, hurried| {
        let is_ours = kick_off || is_own_set_play(player);
        let at_hand = best_at_hand(player, company, at_feet, !kick_off, is_ours);
        let mut if_better_by = |least: f32| {
            let (kick, option) = at_hand.filter(|(_, option)| option.value > chosen.value + least)?;
            made = option;
            Some(kick)
        };
        let towards = |hurried: bool| kick_towards(player, at_feet, &chosen.aim, hurried);
        if_better_by(AT_HAND_GAIN)
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

/// What speaks for the decision of a passer: with the ball, what each kick is worth, in goals.
pub fn reasons(player: &Player, mut memory: PlayerMemory, decision: &Decision) -> Reasons {
    listen(player, &mut memory);
    let belief = with_what_mates_tell(player, &memory);
    let player = &Player { belief: &belief, ..*player };
    let Some(ball) = player.ball() else { return Reasons::default() };
    if !matches!(decision.intention, "attack" | "kick") {
        return super::roles::reasons(player, decision);
    }
    let mates = mates(player);
    let company = Company { mates: &mates, opponents: &player.belief.opponents };
    let (options, _) = possible(player, &mut memory, company, ball);
    let chosen = best(&options).and_then(|best| options.iter().position(|option| option == best));
    Reasons { chosen, options: options.iter().map(KickOption::choice).collect() }
}

/// Goes where a pass was announced to, or could come to; back, if the opponents are sooner at the ball.
fn wait_for_the_ball(player: &Player, memory: &mut PlayerMemory, ball: &BallBelief) -> Decision {
    let facing = (ball.position_m - player.position()).normalize_or(Vec2::X);
    let mut obstacles = player.obstacles();
    obstacles.add(ball.position_m, 0.7 * SUPPORT_DISTANCE_M);
    if let Some((pass, _)) = memory.expected_pass {
        let behind = (player.opponent_goal() - pass.place).normalize_or(Vec2::X) * -0.25;
        let place = pass.place + behind;
        let walk = player.go_and_stay(place, facing, &obstacles);
        return Decision { walk, target: Some(place), intention: "receive", ..default() };
    }
    let mates = mates(player);
    let company = Company { mates: &mates, opponents: &player.belief.opponents };
    let place = match job(player, company, ball) {
        Job::Cover => None,
        Job::Guard => Some(guard_place(player, ball)),
        Job::Offer => Some(free_place(player, memory, company, ball.position_m)),
    };
    if let Some(place) = place {
        let walk = player.go_and_stay(place, facing, &obstacles);
        return Decision { walk, target: Some(place), intention: "support", ..default() };
    }
    memory.free_place = None;
    support(player, ball.position_m)
}

/// What a player does that does not go for the ball.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Job {
    /// Stands behind whoever goes for the ball, for what comes back.
    Cover,
    /// Stands between the ball and the own goal.
    Guard,
    /// Waits where a pass could reach it.
    Offer,
}

/// The jobs of those who wait, from the one furthest back to the one furthest ahead.
fn jobs(waiting: usize) -> &'static [Job] {
    use Job::{Cover, Guard, Offer};
    match waiting {
        0 | 1 => &[Offer],
        2 => &[Cover, Offer],
        3 => &[Guard, Cover, Offer],
        4 => &[Guard, Cover, Offer, Offer],
        5 => &[Guard, Cover, Cover, Offer, Offer],
        _ => &[Guard, Guard, Cover, Cover, Offer, Offer],
    }
}

/// The player's job among those who wait.
fn job(player: &Player, company: Company, ball: &BallBelief) -> Job {
    let to_ball_s = |place: Vec2| time_to_ball_s(player, ball, place);
    let sooner = |best: f32, next: f32| best.min(next);
    let theirs_s = company.opponents.iter().map(|other| to_ball_s(other.position_m)).fold(f32::MAX, sooner);
    let ours_s = company.mates.iter().map(|(_, mate)| to_ball_s(*mate)).fold(to_ball_s(player.position()), sooner);
    // Whoever is soonest at the ball goes for it.
    let waits = |place: Vec2| to_ball_s(place) > ours_s;
    let own = (player.position().x, player.id.number);
    let waiting = company.mates.iter().filter(|(_, mate)| waits(*mate));
    let (behind, others) = waiting
        .fold((0, 0), |(behind, others), (number, mate)| (behind + usize::from((mate.x, *number) < own), others + 1));
    let job = *jobs(others + 1).get(behind).unwrap_or(&Job::Cover);
    let falls_back = theirs_s + FALL_BACK_S < ours_s || ball.position_m.x < -OWN_THIRD * player.pitch.half_length();
    match (job, falls_back) {
        (Job::Offer, true) if others == 0 => Job::Guard,
        (Job::Offer, true) => Job::Cover,
        _ => job,
    }
}

/// Between the ball and that side of the own goal on which the player is, outside the penalty area.
fn guard_place(player: &Player, ball: &BallBelief) -> Vec2 {
    let ball = rolled(ball.position_m, ball.velocity_mps, player.rolling, 1.0);
    let to_goal = player.own_goal() - ball;
    let side = if to_goal.perp_dot(player.position() - ball) * to_goal.x > 0.0 { 1.0 } else { -1.0 };
    let goal = player.own_goal() + Vec2::new(0.0, side * BESIDE_KEEPER * player.pitch.goal.width_m);
    // On a large pitch, the penalty area alone is deeper than that.
    let least = player.pitch.penalty_area.depth_m + 0.35;
    let away = (0.5 * ball.distance(goal)).min(MOST_GUARD * player.pitch.length_m).max(least);
    goal + (ball - goal).normalize_or(Vec2::X) * away
}

/// The place at which a pass would be worth most, not too far away.
fn free_place(player: &Player, memory: &mut PlayerMemory, company: Company, ball: Vec2) -> Vec2 {
    let reach = reach_m(player);
    let half = Vec2::new(player.pitch.half_length() - 0.8, player.pitch.half_width() - 0.5);
    let value = |place: Vec2| {
        let way_s = walking_s(player, [player.position()], place);
        let mate_m = company.mates.iter().map(|(_, mate)| mate.distance(place)).fold(f32::MAX, f32::min);
        let apart = (mate_m / (APART_SHARE * reach)).min(1.0);
        let distance = ball.distance(place);
        let in_range = distance > 0.2 * reach && distance < 0.9 * reach;
        if in_range { apart * pass_worth(player, company, ball, place).max(0.01) / (1.0 + 0.1 * way_s) } else { 0.0 }
    };
    let towards_goal = (player.opponent_goal() - ball).normalize_or(Vec2::X);
    let mut best = memory.free_place.map_or((0.0, player.position()), |place| (PLACE_PREFERENCE * value(place), place));
    for angle in WAITING_ANGLES {
        let direction = unit(angle).rotate(towards_goal);
        for share in WAITING_SHARES {
            let place = (ball + direction * share * reach).clamp(-half, half);
            let worth = value(place);
            if worth > best.0 {
                best = (worth, place);
            }
        }
    }
    memory.free_place = Some(best.1);
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::communication::{ReceivedMessage, TeamMessage};
    use crate::geometry::Pose;
    use crate::team::{RobotId, Team};
    use crate::teams::player::tests::PlayerFixture;

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
    fn who_stands_free_gets_the_ball_unless_a_team_mate_tells_of_an_opponent_there() {
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
    fn of_those_who_wait_the_last_guards_and_the_foremost_offers_itself() {
        let mut situation = PlayerFixture::new(Pose::new(-1.0, 0.0, 0.0), Vec2::ZERO);
        let jobs = |situation: &PlayerFixture| {
            let player = situation.player();
            let mates = mates(&player);
            job(&player, Company { mates: &mates, opponents: &[] }, player.ball().unwrap())
        };
        // Number 3 is at the ball; of 2, 4 and 5, 2 is the last, then the one in the middle, then the foremost.
        situation.belief.team_mates = vec![mate(3, -0.2, 0.0), mate(4, 0.5, 0.8), mate(5, 1.2, -0.8)];
        assert_eq!(jobs(&situation), Job::Guard);
        situation.belief.pose.position = Vec2::new(0.8, 1.5);
        assert_eq!(jobs(&situation), Job::Cover);
        situation.belief.pose.position = Vec2::new(1.8, 1.5);
        assert_eq!(jobs(&situation), Job::Offer);
    }

    #[test]
    fn whoever_is_told_of_a_pass_goes_where_it_will_come() {
        let mut situation = PlayerFixture::new(Pose::new(0.5, 1.2, 0.0), Vec2::new(-1.0, -0.5));
        situation.belief.team_mates = vec![mate(3, -1.2, -0.5)];
        let announced = TeamMessage { payload: Some("pass 2 1.50 0.20".into()), ..default() };
        situation.heard = vec![said(3, announced)];
        let mut memory = PlayerMemory::default();
        let decision = decide(&situation.player(), &mut memory);
        assert_eq!(decision.intention, "receive");
        let step = situation.player().forward.rotate(decision.walk.translation());
        assert!(step.dot(Vec2::new(1.0, -1.0)) > 0.0, "{step}");
        // A pass for somebody else is not its business.
        situation.heard = vec![said(3, TeamMessage { payload: Some("pass 4 1.50 0.20".into()), ..default() })];
        assert_ne!(decide(&situation.player(), &mut PlayerMemory::default()).intention, "receive");
    }

    #[test]
    fn who_falls_back_covers_the_side_of_the_goal_on_which_it_is() {
        let ball = BallBelief { position_m: Vec2::new(-1.0, 0.0), ..default() };
        for side in [1.0, -1.0] {
            let situation = PlayerFixture::new(Pose::new(-1.5, 0.3 * side, 0.0), ball.position_m);
            let place = guard_place(&situation.player(), &ball);
            // On the line from (-1, 0) to (-3, 0.4), half-way.
            assert!(place.distance(Vec2::new(-2.0, 0.2 * side)) < 0.05, "{place}");
        }
    }

    #[test]
    fn on_a_large_pitch_it_stands_just_outside_the_penalty_area() {
        let ball = BallBelief { position_m: Vec2::new(-1.0, 0.0), ..default() };
        let mut situation = PlayerFixture::new(Pose::new(-1.5, 0.3, 0.0), ball.position_m);
        // That of the pitch of 2025: 1.65 m deep.
        situation.pitch.penalty_area.depth_m = 1.65;
        let place = guard_place(&situation.player(), &ball);
        assert!((place.distance(Vec2::new(-3.0, BESIDE_KEEPER * 1.4)) - 2.0).abs() < 1e-4, "{place}");
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
