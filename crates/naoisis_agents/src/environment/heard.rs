//! Messages of team-mates in observations, and the words in them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use super::entry::{AGE, Group, OLDEST_S, PLACE, Sink, UNIT};
use super::extras::MOST_WORDS;
use naoisis_core::communication::{Inbox, ReceivedMessage, TeamMessage};
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;

/// The beginning of a payload with words.
const PREFIX: &str = "say";

/// The names of the words in a message.
const WORDS: [&str; MOST_WORDS as usize] = ["word1", "word2", "word3", "word4", "word5", "word6", "word7", "word8"];

/// The last message of a team-mate.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(crate) struct Heard {
    from: RobotId,
    /// The cycle in which it was sent.
    sent_cycle: u64,
    /// The pose of the sender, as it believes, team frame.
    pose: Option<Pose>,
    /// The position of the ball, as the sender believes, m, team frame.
    ball_m: Option<Vec2>,
    words: Vec<f32>,
}

/// Keeps the newest message of each sender in `heard`.
pub(super) fn keep_newest(heard: &mut Vec<Heard>, world: &World, robot: Entity) {
    for ReceivedMessage { from, sent_cycle, say } in world.get::<Inbox>(robot).into_iter().flat_map(|inbox| &inbox.0) {
        let words = say.payload.as_deref().map(words_of).unwrap_or_default();
        let message = Heard { from: *from, sent_cycle: *sent_cycle, pose: say.pose, ball_m: say.ball_m, words };
        match heard.iter_mut().find(|heard| heard.from == *from) {
            Some(older) if older.sent_cycle <= *sent_cycle => *older = message,
            Some(_) => {}
            None => heard.push(message),
        }
    }
}

/// Adds `words` to a message.
pub(crate) fn with_words(message: Option<TeamMessage>, words: &[f32]) -> TeamMessage {
    let mut payload = PREFIX.to_owned();
    for word in words {
        payload.push_str(&format!(" {:.2}", word + 0.0));
    }
    TeamMessage { payload: Some(Cow::Owned(payload)), ..message.unwrap_or_default() }
}

/// The words of a payload; none if it has another content.
fn words_of(payload: &str) -> Vec<f32> {
    let mut parts = payload.split(' ');
    if parts.next() != Some(PREFIX) {
        return Vec::new();
    }
    let words = parts.map(|part| part.parse::<f32>().ok().filter(|word| word.is_finite()));
    words.take(usize::from(MOST_WORDS)).collect::<Option<_>>().unwrap_or_default()
}

/// Puts the last message of each of `count` team-mates of robot `id`, in the order of their numbers.
pub(super) fn put_messages(sink: &mut impl Sink, heard: &[Heard], world: &World, id: RobotId, count: u8, words: u8) {
    let clock = world.resource::<CycleClock>();
    let roster = world.resource::<Roster>();
    let mut mates = roster.iter().map(|(other, _)| other).filter(|other| other.team == id.team && *other != id);
    for number in 1..=count {
        let mate = mates.next();
        let message = heard.iter().find(|heard| Some(heard.from) == mate);
        let age_s = message.map_or(0.0, |heard| clock.cycle.saturating_sub(heard.sent_cycle) as f32 * clock.period());
        // What is older than the greatest age is forgotten.
        let message = message.filter(|_| age_s <= OLDEST_S);
        let pose = message.and_then(|heard| heard.pose);
        let ball = message.and_then(|heard| heard.ball_m);
        let (at, forward) = pose.map_or((Vec2::ZERO, Vec2::ZERO), |pose| (pose.position, pose.forward()));
        let ball_m = ball.unwrap_or_default();
        let mut group = Group::new(sink, "message", number);
        group
            .flag(
                "heard",
                "1 if this team-mate, by number, was heard in 10 s; else it and the rest of its group are 0",
                message.is_some(),
            )
            .put("age", AGE, "time since it was sent, s", if message.is_some() { age_s } else { 0.0 })
            .flag("pose_known", "1 if the message has the sender's pose; else its numbers are 0", pose.is_some())
            .put("x", PLACE, "position of the sender, team frame, m", at.x)
            .put("y", PLACE, "position of the sender, team frame, m", at.y)
            .put("cos", UNIT, "cosine of the sender's heading, team frame", forward.x)
            .put("sin", UNIT, "sine of the sender's heading, team frame", forward.y)
            .flag("ball_known", "1 if the message has the position of the ball; else its numbers are 0", ball.is_some())
            .put("ball_x", PLACE, "position of the ball, team frame, m", ball_m.x)
            .put("ball_y", PLACE, "position of the ball, team frame, m", ball_m.y);
        for (index, name) in WORDS.iter().enumerate().take(usize::from(words)) {
            let word = message.and_then(|heard| heard.words.get(index)).copied().unwrap_or_default();
            group.put(name, UNIT, "a word of the message", word);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_as_they_were_said() {
        let said = with_words(None, &[1.0, -0.256, 0.0]);
        assert_eq!(said.payload.as_deref(), Some("say 1.00 -0.26 0.00"));
        assert_eq!(words_of("say 1.00 -0.26 0.00"), [1.0, -0.26, 0.0]);
        assert!(with_words(None, &[-1.0; MOST_WORDS as usize]).text_bytes() <= 64, "fits the smallest of messages");
    }

    #[test]
    fn another_content_has_no_words() {
        for payload in ["", "pass 2 1.50 0.20", "say x", "say inf", "saying 1"] {
            assert_eq!(words_of(payload), [0.0_f32; 0], "{payload}");
        }
        assert_eq!(words_of(&format!("say{}", " 1".repeat(20))).len(), 8);
    }
}
