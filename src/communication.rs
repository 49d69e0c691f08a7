//! Messages between team-mates (paper, section 3.3).
//!
//! Once a cycle each robot may share one structure, a [`TeamMessage`], with its team-mates: it puts it in its
//! [`Outbox`]. Each team-mate finds it in its [`Inbox`] in a later cycle, or never: messages get lost, for each recipient
//! independently. Opponents never hear anything.
//!
//! **Delay.** A message arrives `delay_cycles` after it was sent, by default in the next cycle, and up to `jitter_cycles`
//! later, evenly distributed, so that one message may overtake another.
//!
//! **Loss.** With probability `loss`, and always beyond `range_m` where there is one. None by default.
//!
//! **Size.** Texts of more than `max_text_bytes`, by default 128 as for today's messages as a whole, are refused; so is a
//! message with a number that is not finite. A team may have a budget of messages and of bytes for the match: the rules
//! of 2010 have none (500 Kbit/s for everything that a team sends), today's 1200 messages. What a message counts for is
//! [`TeamMessage::size_bytes`].
//!
//! **The real NAO** broadcasts UDP packets in the wireless network of the venue, where losing most of them for a while is
//! nothing unusual.
//!
//! What became of all messages is counted in [`MessageStatistics`].

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::cycle::{Cycle, CycleClock, CycleSystems};
use crate::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::geometry::{Pose, file_units};
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::robot::head::HeadSystems;
use crate::robot::{RobotId, Roster, Team};

/// Carries messages: sends them in [`CycleSystems::Act`], delivers them in [`CycleSystems::Communicate`].
pub struct CommunicationPlugin;

impl Plugin for CommunicationPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Outbox>()
            .register_type::<Inbox>()
            .register_type::<MessageSettings>()
            .register_type::<MessagesInFlight>()
            .register_type::<MessageStatistics>()
            .init_resource::<MessageSettings>()
            .init_resource::<MessagesInFlight>()
            .init_resource::<MessageStatistics>()
            .init_resource::<Roster>()
            .add_systems(
                Cycle,
                (
                    deliver_messages.in_set(CommunicationSystems::Deliver).in_set(CycleSystems::Communicate),
                    // Refusals are reported in the same list as those of the other commands, in a fixed order.
                    send_messages.in_set(CommunicationSystems::Send).in_set(CycleSystems::Act).before(HeadSystems),
                ),
            );
    }
}

/// The systems of communication.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CommunicationSystems {
    /// Messages arrive.
    Deliver,
    /// Messages leave.
    Send,
}

/// The structure that a robot shares with its team-mates. Every part is optional. Places are in the frame that the
/// team agrees on; the built-in teams use the team frame.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TeamMessage {
    /// Where the sender thinks that it is.
    #[serde(with = "file_units::optional_pose", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Where it thinks that the ball is, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ball_m: Option<Vec2>,
    /// Where it thinks that other robots are, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robots_m: Vec<Vec2>,
    /// What it is about to do, in a word.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub intention: Option<Cow<'static, str>>,
    /// Anything else, short.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub payload: Option<Cow<'static, str>>,
}

impl TeamMessage {
    /// What the message would take on the air, bytes: 4 for every number, the texts, and one byte for each part that is
    /// there.
    pub fn size_bytes(&self) -> usize {
        let TeamMessage { pose, ball_m, robots_m, intention, payload } = self;
        let numbers = 3 * usize::from(pose.is_some()) + 2 * usize::from(ball_m.is_some()) + 2 * robots_m.len();
        let parts = [pose.is_some(), ball_m.is_some(), !robots_m.is_empty(), intention.is_some(), payload.is_some()];
        4 * numbers + self.text_bytes() + parts.into_iter().filter(|&is_there| is_there).count()
    }

    /// The length of its texts, bytes.
    pub fn text_bytes(&self) -> usize {
        [&self.intention, &self.payload].into_iter().flatten().map(|text| text.len()).sum()
    }

    /// Whether every number in it is finite.
    pub fn is_finite(&self) -> bool {
        self.pose.is_none_or(Pose::is_finite)
            && self.ball_m.is_none_or(Vec2::is_finite)
            && self.robots_m.iter().all(|place| place.is_finite())
    }
}

/// What the robot says in this cycle, if anything. None again after every cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Outbox(pub Option<TeamMessage>);

/// A message that arrived.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ReceivedMessage {
    /// Who sent it.
    pub from: RobotId,
    /// In which cycle.
    pub sent_cycle: u64,
    /// What it says.
    pub say: TeamMessage,
}

/// The messages that arrived in this cycle, ordered by sender, then by the cycle in which they were sent.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Inbox(pub Vec<ReceivedMessage>);

/// How messages travel.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MessageSettings {
    /// Probability that a recipient does not get a message, independently for each.
    pub loss: f32,
    /// Cycles from sending to arrival; at least 1, less is taken for 1.
    pub delay_cycles: u32,
    /// Greatest number of cycles that a message may take longer; each up to it is as likely.
    pub jitter_cycles: u32,
    /// Greatest distance between sender and recipient, m; none for the whole pitch.
    pub range_m: Option<f32>,
    /// Greatest length of the texts in a message, bytes.
    pub max_text_bytes: u32,
    /// Messages that a team may send in a match; none for any number.
    pub max_messages: Option<u32>,
    /// Bytes that a team may send in a match; none for any number.
    pub max_bytes: Option<u64>,
}

impl Default for MessageSettings {
    fn default() -> Self {
        Self {
            loss: 0.0,
            delay_cycles: 1,
            jitter_cycles: 0,
            range_m: None,
            max_text_bytes: 128,
            max_messages: None,
            max_bytes: None,
        }
    }
}

impl MessageSettings {
    /// What becomes of a message on its way to a recipient at this distance, m.
    pub fn delivery(&self, distance: f32, stream: &mut RandomStream) -> Delivery {
        if self.range_m.is_some_and(|range| distance > range) {
            return Delivery::OutOfRange;
        }
        if stream.chance(self.loss) {
            return Delivery::Lost;
        }
        let jitter = match self.jitter_cycles {
            0 => 0,
            most => ((stream.uniform() * (most as f32 + 1.0)) as u32).min(most),
        };
        Delivery::AfterCycles(self.delay_cycles.max(1) + jitter)
    }

    /// Why a team that has sent so much may not send this message, if it may not.
    pub fn refusal(&self, message: &TeamMessage, sent: &TeamMessageStatistics) -> Option<Refusal> {
        if !message.is_finite() {
            Some(Refusal::NotFinite)
        } else if message.text_bytes() > self.max_text_bytes as usize {
            Some(Refusal::TooLarge)
        } else if self.max_messages.is_some_and(|most| sent.sent >= most)
            || self.max_bytes.is_some_and(|most| sent.sent_bytes + message.size_bytes() as u64 > most)
        {
            Some(Refusal::BudgetSpent)
        } else {
            None
        }
    }
}

/// What becomes of a message on its way to one recipient.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Delivery {
    /// It arrives so many cycles after it was sent.
    AfterCycles(u32),
    /// It gets lost.
    Lost,
    /// The recipient is too far away.
    OutOfRange,
}

/// A message on its way to one recipient.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct MessageInFlight {
    /// Who will get it.
    pub to: RobotId,
    /// In which cycle.
    pub arrival_cycle: u64,
    /// The message, as it will be received.
    pub message: ReceivedMessage,
}

/// All messages on their way.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct MessagesInFlight(pub Vec<MessageInFlight>);

/// What became of the messages of one team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct TeamMessageStatistics {
    /// Messages sent.
    pub sent: u32,
    /// Bytes sent.
    pub sent_bytes: u64,
    /// Messages refused, because they were too long or not finite.
    pub refused: u32,
    /// Messages refused, because the team had spent its budget.
    pub over_budget: u32,
    /// Recipients that a message reached.
    pub delivered: u32,
    /// Recipients for which a message was lost.
    pub lost: u32,
    /// Recipients that were out of range.
    pub out_of_range: u32,
}

/// What became of all messages of the match.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct MessageStatistics {
    /// Of the blue team.
    pub blue: TeamMessageStatistics,
    /// Of the pink team.
    pub pink: TeamMessageStatistics,
}

impl MessageStatistics {
    /// Those of this team.
    pub fn of(&self, team: Team) -> &TeamMessageStatistics {
        match team {
            Team::Blue => &self.blue,
            Team::Pink => &self.pink,
        }
    }

    fn of_mut(&mut self, team: Team) -> &mut TeamMessageStatistics {
        match team {
            Team::Blue => &mut self.blue,
            Team::Pink => &mut self.pink,
        }
    }
}

fn deliver_messages(
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    mut in_flight: ResMut<MessagesInFlight>,
    mut statistics: ResMut<MessageStatistics>,
    mut inboxes: Query<&mut Inbox>,
) {
    for mut inbox in &mut inboxes {
        if !inbox.0.is_empty() {
            inbox.0.clear();
        }
    }
    if in_flight.0.is_empty() {
        return;
    }
    for arrived in in_flight.0.extract_if(.., |message| message.arrival_cycle <= clock.cycle) {
        let team = statistics.of_mut(arrived.message.from.team);
        match roster.get(arrived.to).and_then(|recipient| inboxes.get_mut(recipient).ok()) {
            Some(mut inbox) => {
                team.delivered += 1;
                let place = inbox.0.partition_point(|message| {
                    (message.from, message.sent_cycle) <= (arrived.message.from, arrived.message.sent_cycle)
                });
                inbox.0.insert(place, arrived.message);
            }
            None => team.lost += 1,
        }
    }
}

fn send_messages(
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    settings: Res<MessageSettings>,
    mut in_flight: ResMut<MessagesInFlight>,
    mut statistics: ResMut<MessageStatistics>,
    mut events: ResMut<CycleEvents>,
    mut outboxes: Query<&mut Outbox>,
    mut recipients: Query<(&Pose, &mut RandomStreams), With<Inbox>>,
    poses: Query<&Pose>,
) {
    for (from, sender) in roster.iter() {
        let Ok(mut outbox) = outboxes.get_mut(sender) else { continue };
        // Not touching what is empty keeps change detection useful.
        if outbox.0.is_none() {
            continue;
        }
        let Some(say) = outbox.0.take() else { continue };
        let team = statistics.of_mut(from.team);
        if let Some(reason) = settings.refusal(&say, team) {
            let count = if reason == Refusal::BudgetSpent { &mut team.over_budget } else { &mut team.refused };
            *count += 1;
            // A team that is over its budget would fill the record with one and the same refusal.
            if reason != Refusal::BudgetSpent || *count == 1 {
                events.push(MatchEvent::CommandRefused { robot: from, command: CommandKind::Say, reason });
            }
            continue;
        }
        team.sent += 1;
        team.sent_bytes += say.size_bytes() as u64;
        let place = poses.get(sender).map_or(Vec2::ZERO, |pose| pose.position);
        for (to, recipient) in roster.iter().filter(|(to, _)| to.team == from.team && *to != from) {
            let Ok((pose, mut streams)) = recipients.get_mut(recipient) else { continue };
            match settings.delivery(pose.position.distance(place), &mut streams.messages) {
                Delivery::AfterCycles(cycles) => in_flight.0.push(MessageInFlight {
                    to,
                    arrival_cycle: clock.cycle + u64::from(cycles),
                    message: ReceivedMessage { from, sent_cycle: clock.cycle, say: say.clone() },
                }),
                Delivery::Lost => team.lost += 1,
                Delivery::OutOfRange => team.out_of_range += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cycle::run_cycle;
    use crate::simulation::NaoisisPlugins;

    const NOTHING: Option<TeamMessage> = None;

    /// Three blue robots and a pink one, a metre apart along x, that only talk.
    fn talking_app(settings: MessageSettings) -> (App, [Entity; 4]) {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins).insert_resource(settings).init_resource::<crate::referee::Game>();
        let ids = [(Team::Blue, 1), (Team::Blue, 2), (Team::Blue, 3), (Team::Pink, 1)];
        let mut x = -1.0;
        let robots = ids.map(|(team, number)| {
            x += 1.0;
            let id = RobotId::new(team, number);
            let parts = (Outbox::default(), Inbox::default(), RandomStreams::new(1, id));
            app.world_mut().spawn((id, Pose::new(x, 0.0, 0.0), parts)).id()
        });
        (app, robots)
    }

    fn say(app: &mut App, robot: Entity, message: impl Into<Option<TeamMessage>>) {
        app.world_mut().get_mut::<Outbox>(robot).unwrap().0 = message.into();
    }

    fn word(text: &str) -> TeamMessage {
        TeamMessage { payload: Some(text.to_owned().into()), ..default() }
    }

    fn inbox(app: &App, robot: Entity) -> &[ReceivedMessage] {
        &app.world().get::<Inbox>(robot).unwrap().0
    }

    fn refusals(app: &App) -> Vec<MatchEvent> {
        let is_refusal = |event: &&MatchEvent| matches!(event, MatchEvent::CommandRefused { .. });
        app.world().resource::<CycleEvents>().iter().filter(is_refusal).cloned().collect()
    }

    fn statistics(app: &App) -> TeamMessageStatistics {
        *app.world().resource::<MessageStatistics>().of(Team::Blue)
    }

    #[test]
    fn a_message_reaches_the_team_mates_in_the_next_cycle_and_nobody_else() {
        let (mut app, robots) = talking_app(MessageSettings::default());
        say(&mut app, robots[1], word("mine"));
        run_cycle(app.world_mut());
        assert!(robots.iter().all(|&robot| inbox(&app, robot).is_empty()));
        assert_eq!(app.world().get::<Outbox>(robots[1]).unwrap().0, NOTHING);
        run_cycle(app.world_mut());
        let expected = ReceivedMessage { from: RobotId::new(Team::Blue, 2), sent_cycle: 1, say: word("mine") };
        assert_eq!(inbox(&app, robots[0]), core::slice::from_ref(&expected));
        assert_eq!(inbox(&app, robots[2]), [expected]);
        assert!(inbox(&app, robots[1]).is_empty() && inbox(&app, robots[3]).is_empty());
        run_cycle(app.world_mut());
        assert!(robots.iter().all(|&robot| inbox(&app, robot).is_empty()));
        let expected = TeamMessageStatistics { sent: 1, sent_bytes: 5, delivered: 2, ..default() };
        assert_eq!(statistics(&app), expected);
    }

    #[test]
    fn messages_are_sorted_by_sender_and_time_and_arrive_after_their_delay() {
        let (mut app, robots) = talking_app(MessageSettings { delay_cycles: 3, ..default() });
        for robot in [2, 1] {
            say(&mut app, robots[robot], word("first"));
        }
        for cycle in 1..=3 {
            run_cycle(app.world_mut());
            assert!(inbox(&app, robots[0]).is_empty(), "cycle {cycle}");
        }
        run_cycle(app.world_mut());
        let senders: Vec<u8> = inbox(&app, robots[0]).iter().map(|message| message.from.number).collect();
        assert_eq!(senders, [2, 3]);
    }

    #[test]
    fn messages_are_lost_as_often_as_asked_for_and_independently() {
        let cycles = 4000;
        for (loss, least, most) in [(0.0, 0, 0), (0.3, 1084, 1316), (1.0, cycles, cycles)] {
            let (mut app, robots) = talking_app(MessageSettings { loss, ..default() });
            let (mut lost, mut both) = ([0; 2], 0);
            for _ in 0..=cycles {
                say(&mut app, robots[0], word("hello"));
                run_cycle(app.world_mut());
                let missing = [1, 2].map(|index| inbox(&app, robots[index]).is_empty());
                lost[0] += i32::from(missing[0]);
                lost[1] += i32::from(missing[1]);
                both += i32::from(missing == [true; 2]);
            }
            // Nothing can have arrived in the first cycle.
            let [first, second] = lost.map(|count| count - 1);
            // Binomial: 1200 ± sqrt(4000 * 0.3 * 0.7) = 29; four of them: 99.99 %.
            assert!((least..=most).contains(&first) && (least..=most).contains(&second), "{lost:?}");
            if loss == 0.3 {
                // Independent: 360 ± sqrt(4000 * 0.09 * 0.91) = 18.1; four of them: 99.99 %.
                assert!((both - 1 - 360).abs() < 73, "{both}");
            }
            let TeamMessageStatistics { sent, delivered, lost, .. } = statistics(&app);
            // What was sent last is still on its way.
            assert_eq!(2 * sent, delivered + lost + app.world().resource::<MessagesInFlight>().0.len() as u32);
        }
    }

    #[test]
    fn jitter_delays_evenly_between_its_bounds() {
        let settings = MessageSettings { delay_cycles: 2, jitter_cycles: 3, ..default() };
        let mut stream = RandomStream::for_match(9, "jitter test");
        let mut counts = [0; 7];
        let draws = 4000;
        for _ in 0..draws {
            let Delivery::AfterCycles(cycles) = settings.delivery(1.0, &mut stream) else { panic!("lost") };
            counts[cycles as usize] += 1;
        }
        // Binomial: 1000 ± sqrt(4000 * 0.25 * 0.75) = 27.4; four of them: 99.99 %.
        assert_eq!([counts[0], counts[1], counts[6]], [0; 3]);
        assert!(counts[2..=5].iter().all(|count: &i32| (count - 1000).abs() < 110), "{counts:?}");
    }

    #[test]
    fn a_message_that_overtakes_another_is_sorted_where_both_arrive() {
        let (mut app, robots) = talking_app(MessageSettings { jitter_cycles: 5, ..default() });
        let mut received = 0;
        for _ in 0..200 {
            say(&mut app, robots[0], word("again"));
            run_cycle(app.world_mut());
            let cycles: Vec<u64> = inbox(&app, robots[1]).iter().map(|message| message.sent_cycle).collect();
            assert!(cycles.is_sorted());
            received += cycles.len();
        }
        assert!(received > 190);
    }

    #[test]
    fn who_is_out_of_range_hears_nothing() {
        let (mut app, robots) = talking_app(MessageSettings { range_m: Some(1.5), ..default() });
        say(&mut app, robots[0], word("near"));
        run_cycle(app.world_mut());
        run_cycle(app.world_mut());
        assert_eq!((inbox(&app, robots[1]).len(), inbox(&app, robots[2]).len()), (1, 0));
        assert_eq!((statistics(&app).delivered, statistics(&app).out_of_range), (1, 1));
    }

    #[test]
    fn what_is_too_long_or_not_finite_is_refused() {
        let (mut app, robots) = talking_app(MessageSettings::default());
        let wrong_ball = TeamMessage { ball_m: Some(Vec2::new(f32::NAN, 0.0)), ..default() };
        for (message, reason) in [
            (word(&"a".repeat(128)), None),
            (word(&"a".repeat(129)), Some(Refusal::TooLarge)),
            (wrong_ball, Some(Refusal::NotFinite)),
        ] {
            say(&mut app, robots[0], message);
            run_cycle(app.world_mut());
            let robot = RobotId::new(Team::Blue, 1);
            let refused = reason.map(|reason| MatchEvent::CommandRefused { robot, command: CommandKind::Say, reason });
            assert_eq!(refusals(&app), Vec::from_iter(refused));
        }
        assert_eq!((statistics(&app).sent, statistics(&app).refused), (1, 2));
    }

    #[test]
    fn a_team_that_has_spent_its_budget_falls_silent() {
        let ball = TeamMessage { ball_m: Some(Vec2::ONE), ..default() };
        assert_eq!(ball.size_bytes(), 9);
        let by_count = MessageSettings { max_messages: Some(2), ..default() };
        // Two messages of 9 bytes; a third would make 27.
        let by_bytes = MessageSettings { max_bytes: Some(26), ..default() };
        for settings in [by_count, by_bytes] {
            let (mut app, robots) = talking_app(settings);
            let mut events = 0;
            for _ in 0..5 {
                say(&mut app, robots[0], ball.clone());
                say(&mut app, robots[3], ball.clone());
                run_cycle(app.world_mut());
                events += refusals(&app).len();
            }
            let TeamMessageStatistics { sent, over_budget, sent_bytes, .. } = statistics(&app);
            assert_eq!((sent, over_budget, sent_bytes), (2, 3, 18));
            // Once for each team.
            assert_eq!(events, 2);
        }
    }
}
