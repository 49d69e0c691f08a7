//! The last kick of a robot: when its behaviour decided it, its result, and the belief at that time.

use bevy::prelude::*;

use crate::viewer::keyframes::Keyframes;
use naoisis_core::events::{KickMiss, KickResult, MatchEvent};
use naoisis_core::game::Game;
use naoisis_core::robot::kick::KickRequest;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sensing::belief::point_pitch_from_team;
use naoisis_sim::interface::cycle_record::CycleRecord;

/// The longest time between the decision and the kick, cycles.
const LONGEST_CYCLES: u64 = 90;

/// The last kick of a robot before a moment.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct LastKick {
    /// The cycle of the kick.
    pub cycle: u64,
    /// The cycle in which the behaviour decided it, if that is known.
    pub decided: Option<u64>,
    /// The kick and its result, as text.
    pub words: String,
}

/// The last result, so that records are not read again in every frame.
#[derive(Default)]
pub(super) struct Found {
    of: Option<(RobotId, u64, Keyframes)>,
    kick: Option<LastKick>,
}

impl Found {
    /// Returns the last kick of a robot until the end of a cycle.
    pub fn last_kick(
        &mut self,
        (robot, cycle): (RobotId, u64),
        history: &mut History,
        keyframes: &Keyframes,
        game: &Game,
    ) -> Option<&LastKick> {
        let Some(mark) = history.last_kick(robot, cycle) else {
            *self = Self::default();
            return None;
        };
        let is_found = self
            .of
            .as_ref()
            .is_some_and(|(other, cycle, of)| (*other, *cycle) == (robot, mark.cycle) && of.is_same(keyframes));
        if !is_found {
            self.of = Some((robot, mark.cycle, keyframes.clone()));
            self.kick = read(history, robot, mark.cycle, game);
        }
        self.kick.as_ref()
    }
}

fn read(history: &mut History, robot: RobotId, cycle: u64, game: &Game) -> Option<LastKick> {
    let record = history.record(cycle).ok()??;
    let words = words(&record, robot, game)?;
    let mut decided = None;
    for earlier in (cycle.saturating_sub(LONGEST_CYCLES)..=cycle).rev() {
        let Ok(Some(record)) = history.record(earlier) else { break };
        // A kick under way is not requested again.
        match (wanted(&record, robot), decided) {
            (Some(_), _) => decided = Some(record.cycle),
            (None, Some(_)) => break,
            (None, None) => {}
        }
    }
    Some(LastKick { cycle, decided, words })
}

/// The kick that a robot's behaviour requested in a cycle.
fn wanted(record: &CycleRecord, robot: RobotId) -> Option<KickRequest> {
    record.robot(robot)?.command.as_ref()?.kick
}

/// The kick of a robot in a cycle and its result, as text.
fn words(record: &CycleRecord, robot: RobotId, game: &Game) -> Option<String> {
    let (kick_type, result, reason) = record.events.iter().find_map(|event| match event {
        MatchEvent::Kick { robot: kicker, kick_type, result, reason, .. } if *kicker == robot => {
            Some((*kick_type, *result, *reason))
        }
        _ => None,
    })?;
    let came_of_it = match (result, reason) {
        (KickResult::Missed, Some(reason)) => format!("missed, {}", miss_words(reason)),
        (KickResult::Missed, None) => "missed".to_owned(),
        (KickResult::Reduced, _) => "struck from the wrong side".to_owned(),
        _ => "struck the ball".to_owned(),
    };
    let believed = record.robot(robot).and_then(|robot| robot.belief.as_ref()?.ball);
    let off = believed.zip(record.ball.as_ref()).map(|(believed, ball)| {
        point_pitch_from_team(believed.position_m, game.own_end(robot.team)).distance(ball.position_m.truncate())
    });
    let off = off.filter(|_| result == KickResult::Missed);
    let off = off.map_or_else(String::new, |off| format!("; it believed the ball {off:.2} m from where it was"));
    Some(format!("{}: {came_of_it}{off}", kick_type.words()))
}

/// Why a kick missed, as the rest of a sentence.
pub(super) fn miss_words(reason: KickMiss) -> &'static str {
    match reason {
        KickMiss::Down => "because it was not on its feet",
        KickMiss::OutOfReach => "because the ball was out of its reach",
        KickMiss::Busy => "because it was still kicking",
        KickMiss::Penalised => "because it is penalised",
        KickMiss::PlayStopped => "because play is stopped",
        KickMiss::NotANumber => "because its speed is not a number",
        KickMiss::NoBall => "because there is no ball",
        KickMiss::NoSuchKick => "because it has no such kick",
    }
}

/// Why the kick that a robot requests in this cycle does not start, if so.
pub(super) fn refused_now(record: &CycleRecord, robot: RobotId) -> Option<String> {
    record.events.iter().find_map(|event| match event {
        MatchEvent::Kick { robot: kicker, kick_type, result: KickResult::Missed, reason: Some(reason), .. }
            if *kicker == robot && *reason != KickMiss::OutOfReach =>
        {
            Some(format!("Requests a kick ({}), which is refused {}", kick_type.words(), miss_words(*reason)))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::kick_geometry::KickType;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::RobotRecord;
    use naoisis_sim::interface::vocabulary::RobotCommand;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    #[test]
    fn a_kick_is_traced_to_when_it_was_wanted_and_says_why_it_missed() {
        let mut history = History::default();
        for cycle in 0..=40 {
            let kick = (10..13).contains(&cycle).then(|| KickRequest::new(KickType::LeftStraight, 1.0));
            let command = Some(RobotCommand { kick, ..default() });
            let mut record =
                CycleRecord { cycle, robots: vec![RobotRecord { command, ..RobotRecord::new(BLUE) }], ..default() };
            if cycle == 20 {
                record.events.push(MatchEvent::Kick {
                    robot: BLUE,
                    kick_type: KickType::LeftStraight,
                    speed: Some(1.0),
                    result: KickResult::Missed,
                    reason: Some(KickMiss::OutOfReach),
                    direction: None,
                    launch_speed_mps: None,
                });
            }
            history.push(&record).unwrap();
        }
        let (mut found, keyframes, game) = (Found::default(), Keyframes::default(), Game::default());
        assert_eq!(found.last_kick((BLUE, 19), &mut history, &keyframes, &game), None);
        let kick = found.last_kick((BLUE, 40), &mut history, &keyframes, &game).unwrap();
        assert_eq!((kick.cycle, kick.decided), (20, Some(10)));
        assert!(kick.words.ends_with("missed, because the ball was out of its reach"), "{}", kick.words);
    }
}
