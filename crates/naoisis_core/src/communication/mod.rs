//! Messages between team-mates (paper, section 3.3).
//!
//! Once a cycle each robot may share one structure, a [`TeamMessage`], with its team-mates by its [`Outbox`]. Each team-mate receives it in
//! its [`Inbox`] in a later cycle, unless the message gets lost, independently for each recipient. Opponents receive nothing.
//!
//! **Delay.** A message arrives `delay_cycles` after it was sent, by default in the next cycle, and up to `jitter_cycles` later, evenly
//! distributed, so that one message may overtake another.
//!
//! **Loss.** Messages are lost with probability `loss`, and always beyond `range_m`, if set. By default no message is lost.
//!
//! **Size.** Texts and datagrams of more than `max_text_bytes`, by default 128 as for whole messages in 2025 (512 in the Humanoid
//! Soccer League of 2026), are refused at the sender; so is a message with a number that is not finite, a position more than a
//! kilometre away, or more than 64 robots. A scenario may give a team a budget of messages and of bytes for the match, beyond
//! which nothing is sent: the size of a message is [`TeamMessage::size_bytes`]. A model, a team or a robot may have smaller limits
//! ([`MessageLimits`]). A league's [budget](crate::game::Rules::message_budget) is different: messages beyond it are sent, and the
//! referee decides. The rules of 2010 have none (500 kbit/s for everything that a team sends), those of 2025 have 1200 messages.
//!
//! **The real NAO** broadcasts UDP packets in the wireless network of the venue, where it is common that most of them are lost for a while.
//!
//! [`MessageStatistics`] counts the messages.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod datagram;
mod limits;
mod message;
mod status_report;
#[cfg(test)]
mod tests;

pub use datagram::Datagram;
pub use limits::MessageLimits;
pub use message::{MOST_ROBOTS, TeamMessage};
pub use status_report::StatusReport;

use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::{CommandKind, CycleEvents, MatchEvent, Refusal};
use crate::geometry::Pose;
use crate::knowledge::Knowledge;
use crate::random::{RandomStream, RandomStreams};
use crate::robot::Roster;
use crate::robot::condition::Condition;
use crate::team::{PerTeam, RobotId};

/// Carries messages: sends them in [`CycleSystems::Act`], delivers them in [`CycleSystems::Communicate`].
pub struct CommunicationPlugin;

impl Plugin for CommunicationPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Outbox>()
            .register_type::<StatusReport>()
            .register_type::<Inbox>()
            .register_type::<MessageLimits>()
            .register_type::<MessageSettings>()
            .register_type::<MessagesInFlight>()
            .register_type::<MessageStatistics>()
            .init_resource::<MessageSettings>()
            .init_resource::<MessagesInFlight>()
            .init_resource::<MessageStatistics>()
            .init_resource::<Roster>()
            .add_systems(
                Cycle,
                (deliver_messages.in_set(CycleSystems::Communicate), send_messages.in_set(ActSystems::Say)),
            );
    }
}

/// The message of the robot in this cycle, if any. Reset to `None` after every cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Outbox(pub Option<TeamMessage>);

/// A message that arrived.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize, JsonSchema)]
pub struct ReceivedMessage {
    /// The sender.
    pub from: RobotId,
    /// The cycle in which it was sent.
    pub sent_cycle: u64,
    /// The content, with the parts of a command's `say`.
    pub say: TeamMessage,
}

/// The messages that arrived in this cycle, ordered by sender, then by the cycle in which they were sent.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
pub struct Inbox(pub Vec<ReceivedMessage>);

/// Settings of the delivery and the limits of messages.
#[derive(Resource, Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct MessageSettings {
    /// Probability that a recipient does not get a message, independently for each.
    pub loss: f32,
    /// Cycles from sending to arrival; at least 1.
    pub delay_cycles: u32,
    /// Greatest additional delay, cycles; uniformly distributed.
    pub jitter_cycles: u32,
    /// Greatest distance between sender and recipient, m; unlimited by default.
    pub range_m: Option<f32>,
    /// Greatest length of the texts and the datagram in a message together, bytes.
    pub max_text_bytes: u32,
    /// Messages that a team can send in a match, beyond which they are refused; unlimited by default. The budget of a league is in its
    /// [rules](crate::game::Rules::message_budget).
    pub max_messages: Option<u32>,
    /// Bytes that a team can send in a match; unlimited by default.
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
    /// The delivery of a message to a recipient at `distance`, m.
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
}

/// The delivery of a message to one recipient.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Delivery {
    /// The message arrives this number of cycles after it was sent.
    AfterCycles(u32),
    /// The message gets lost.
    Lost,
    /// The recipient is too far away.
    OutOfRange,
}

/// A message on its way to one recipient.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct MessageInFlight {
    /// The recipient.
    pub to: RobotId,
    /// The cycle in which it arrives.
    pub arrival_cycle: u64,
    /// The message.
    pub message: ReceivedMessage,
}

/// All messages in flight.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct MessagesInFlight(pub Vec<MessageInFlight>);

/// Statistics of the messages of one team.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct TeamMessageStatistics {
    /// Messages that behaviours sent.
    pub sent: u32,
    /// Total length of the sent messages, bytes.
    pub sent_bytes: u64,
    /// Messages refused, because they were too long, not finite or out of range.
    pub refused: u32,
    /// Messages refused, because the team had spent its budget.
    pub over_budget: u32,
    /// Deliveries.
    pub delivered: u32,
    /// Losses, counted for each recipient.
    pub lost: u32,
    /// Recipients out of range.
    pub out_of_range: u32,
}

/// Statistics of all messages of the match.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, Deref, DerefMut)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct MessageStatistics(pub PerTeam<TeamMessageStatistics>);

/// Delivers the messages that arrive in this cycle.
pub fn deliver_messages(
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
        let team = &mut statistics[arrived.message.from.team];
        match roster.get(arrived.to).and_then(|recipient| inboxes.get_mut(recipient).ok()) {
            Some(mut inbox) => {
                team.delivered = team.delivered.saturating_add(1);
                let place = inbox.0.partition_point(|message| {
                    (message.from, message.sent_cycle) <= (arrived.message.from, arrived.message.sent_cycle)
                });
                inbox.0.insert(place, arrived.message);
            }
            None => team.lost = team.lost.saturating_add(1),
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
    mut outboxes: Query<(&mut Outbox, Option<&MessageLimits>, Option<&Condition>)>,
    mut recipients: Query<(&Pose, &mut RandomStreams), With<Inbox>>,
    poses: Query<&Pose>,
) {
    for (from, sender) in roster.iter() {
        let Ok((mut outbox, own_limits, condition)) = outboxes.get_mut(sender) else { continue };
        // Does not trigger change detection of empty outboxes.
        if outbox.0.is_none() {
            continue;
        }
        let Some(say) = outbox.0.take() else { continue };
        // Nobody hears a program that is still starting.
        if condition.is_some_and(|condition| !condition.is_running()) {
            continue;
        }
        let team = &mut statistics[from.team];
        let limits = settings.limits_with(&own_limits.copied().unwrap_or_default());
        if let Some(reason) = limits.refusal(&say, team) {
            let count = if reason == Refusal::BudgetSpent { &mut team.over_budget } else { &mut team.refused };
            *count = count.saturating_add(1);
            // Once is enough: otherwise a team over its budget would fill the record with the same refusal.
            if reason != Refusal::BudgetSpent || *count == 1 {
                events.push(MatchEvent::CommandRefused { robot: from, command: CommandKind::Say, reason });
            }
            continue;
        }
        team.sent = team.sent.saturating_add(1);
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
                Delivery::Lost => team.lost = team.lost.saturating_add(1),
                Delivery::OutOfRange => team.out_of_range = team.out_of_range.saturating_add(1),
            }
        }
    }
}
