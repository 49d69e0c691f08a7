//! Latency: what is perceived is older when it is decided on, and what is decided happens later.
//!
//! | what | setting | how old it is says |
//! |---|---|---|
//! | what is recognised in images | `vision_s` | [`Percepts::time_s`] |
//! | images, of those who look at them themselves | `image_s` | [`CameraImages::cycle`], and an image's `time_s` to programs |
//! | sonars | `sonar_s` | [`SonarReading::time_s`] |
//! | walks, kicks, where the head turns | `walk_s`, `kick_s`, `head_s` | |
//!
//! What joints, steps and the body's own state say is as fresh as the cycle: a NAO's board reads them every 10 ms, and less than half
//! a cycle is none. Messages have a delay of [their own](crate::communication::MessageSettings::delay_cycles).
//!
//! **Units.** Seconds; whole cycles of them, the nearest. None by default.
//!
//! **The real NAO**: 30 to 100 ms from exposure to motion, by what teams report.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

use super::camera::CameraImages;
use super::scene::SensingSystems;
use super::sonar::{SonarReading, SonarSettings, SonarSource};
use super::vision::Percepts;
use crate::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use crate::events::Refusal;
use crate::knowledge::Knowledge;
use crate::robot::head::{HeadAngles, HeadCommand, LateHeadCommand};
use crate::robot::kick::{KickCommand, KickRequest};
use crate::robot::motion::WalkCommand;

/// Holds back readings, and commands before they are taken over.
pub struct LatencyPlugin;

impl Plugin for LatencyPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Latency>()
            .register_type::<OnTheirWay>()
            .add_systems(Cycle, set_images_aside.after(SensingSystems::Scene).before(SensingSystems::Images))
            .add_systems(
                Cycle,
                (hold_back_percepts, hold_back_images, hold_back_sonars).chain().in_set(SensingSystems::Late),
            )
            .add_systems(
                Cycle,
                (hold_back_commands, hold_back_heads).chain().in_set(CycleSystems::Act).before(ActSystems::Say),
            );
    }
}

/// How late a robot's readings and commands are.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[require(OnTheirWay, LateHeadCommand)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Latency {
    /// From an image's exposure until what is recognised in it can be decided on, s: the image's own way is part of it.
    pub vision_s: f32,
    /// From an image's exposure until it can be looked at, s.
    #[serde(skip_serializing_if = "is_none")]
    pub image_s: f32,
    /// From a ping until its echo can be decided on, s.
    #[serde(skip_serializing_if = "is_none")]
    pub sonar_s: f32,
    /// From a walk's command until a step can take it over, s.
    pub walk_s: f32,
    /// From a kick's command until the leg begins, s.
    pub kick_s: f32,
    /// From a head's command until its joints begin to turn, s.
    #[serde(skip_serializing_if = "is_none")]
    pub head_s: f32,
}

impl Latency {
    /// All of them, by the names that files have for them.
    pub fn by_name(&self) -> [(&'static str, f32); 6] {
        [
            ("vision_s", self.vision_s),
            ("image_s", self.image_s),
            ("sonar_s", self.sonar_s),
            ("walk_s", self.walk_s),
            ("kick_s", self.kick_s),
            ("head_s", self.head_s),
        ]
    }
}

fn is_none(seconds: &f32) -> bool {
    *seconds == 0.0
}

/// What is on its way, the oldest first.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
#[serde(default)]
pub struct OnTheirWay {
    percepts: VecDeque<Percepts>,
    images: VecDeque<CameraImages>,
    sonars: VecDeque<SonarReading>,
    walks: VecDeque<WalkCommand>,
    kicks: VecDeque<Option<KickRequest>>,
    heads: VecDeque<HeadCommand>,
    /// The images that arrived last, while new ones are taken.
    aside: CameraImages,
}

impl OnTheirWay {
    /// The images among it.
    pub(crate) fn images(&self) -> impl Iterator<Item = &CameraImages> {
        self.images.iter().chain([&self.aside])
    }
}

fn hold_back_percepts(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut Percepts, &mut OnTheirWay)>) {
    for (latency, mut percepts, mut on_their_way) in &mut robots {
        percepts.time_s = clock.start_time_s();
        let cycles = clock.cycles_in(latency.vision_s);
        if cycles > 0 || !on_their_way.percepts.is_empty() {
            *percepts = after(cycles, &mut on_their_way.percepts, core::mem::take(&mut *percepts));
        }
    }
}

/// Where images are late, new ones are not drawn over those that arrived last.
fn set_images_aside(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut CameraImages, &mut OnTheirWay)>) {
    for (latency, mut images, mut on_their_way) in &mut robots {
        if clock.cycles_in(latency.image_s) > 0 {
            core::mem::swap(&mut *images, &mut on_their_way.aside);
            images.clear();
            // Whoever has no images now clears this, too.
            images.arrived = Some(clock.cycle);
        }
    }
}

fn hold_back_images(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut CameraImages, &mut OnTheirWay)>) {
    for (latency, mut images, mut on_their_way) in &mut robots {
        let OnTheirWay { images: queue, aside, .. } = &mut *on_their_way;
        let cycles = clock.cycles_in(latency.image_s);
        if cycles == 0 {
            if !queue.is_empty() {
                queue.clear();
            }
            continue;
        }
        if images.cycle == Some(clock.cycle) {
            queue.push_back(core::mem::take(&mut *images));
        } else if images.arrived.is_none() {
            queue.clear();
            aside.clear();
        }
        core::mem::swap(&mut *images, aside);
        let has_arrived =
            |image: &CameraImages| image.cycle.is_some_and(|taken| taken + u64::from(cycles) <= clock.cycle);
        while queue.front().is_some_and(has_arrived) {
            *aside = core::mem::replace(&mut *images, queue.pop_front().unwrap_or_default());
            images.arrived = Some(clock.cycle);
        }
    }
}

fn hold_back_sonars(
    clock: Res<CycleClock>,
    mut robots: Query<(&Latency, &SonarSettings, &mut SonarReading, &mut OnTheirWay)>,
) {
    let now = clock.start_time_s();
    for (latency, settings, mut reading, mut on_their_way) in &mut robots {
        let cycles = clock.cycles_in(latency.sonar_s);
        if settings.fitted && (cycles > 0 || !on_their_way.sonars.is_empty()) {
            // Who has no rate pings in every cycle. Between two pings, what is on its way last is still the newest.
            let pings_always = settings.rate_hz.is_none() || settings.source == SonarSource::Truth;
            let time_s = reading.time_s.or(pings_always.then_some(now));
            let under_way = on_their_way.sonars.back().filter(|_| time_s != Some(now)).copied();
            let newest = under_way.unwrap_or(SonarReading { time_s, ..*reading });
            *reading = after(cycles, &mut on_their_way.sonars, newest);
        }
    }
}

fn hold_back_commands(
    clock: Res<CycleClock>,
    mut robots: Query<(&Latency, &mut WalkCommand, &mut KickCommand, &mut OnTheirWay)>,
) {
    for (latency, mut walk, mut kick, mut on_their_way) in &mut robots {
        let [walk_cycles, kick_cycles] = [latency.walk_s, latency.kick_s].map(|seconds| clock.cycles_in(seconds));
        if walk_cycles > 0 || !on_their_way.walks.is_empty() {
            *walk = after(walk_cycles, &mut on_their_way.walks, *walk);
        }
        if kick_cycles > 0 || !on_their_way.kicks.is_empty() {
            kick.0 = after(kick_cycles, &mut on_their_way.kicks, kick.0);
        }
    }
}

/// A head's command stays until it is changed: the joints go by what it was, and before the first by where they are.
fn hold_back_heads(
    clock: Res<CycleClock>,
    mut robots: Query<(&Latency, &HeadCommand, &HeadAngles, &mut LateHeadCommand, &mut OnTheirWay)>,
) {
    for (latency, command, angles, mut late, mut on_their_way) in &mut robots {
        let cycles = clock.cycles_in(latency.head_s);
        if cycles == 0 {
            if late.0.is_some() {
                late.0 = None;
                on_their_way.heads.clear();
            }
            continue;
        }
        let stays = HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
        // One that is not a number is refused, and the head stays where it is.
        let is_refused = Refusal::of_numbers([command.yaw, command.pitch]).is_some();
        let heads = &mut on_their_way.heads;
        heads.push_back(if is_refused { stays } else { *command });
        while heads.len() > cycles as usize {
            late.0 = heads.pop_front();
        }
        late.0 = Some(late.0.unwrap_or(stays));
    }
}

/// Sends a value on its way, and takes the one that arrives after so many cycles; nothing while there is none.
fn after<T: Default>(cycles: u32, on_their_way: &mut VecDeque<T>, value: T) -> T {
    on_their_way.push_back(value);
    let mut arrived = T::default();
    while on_their_way.len() > cycles as usize {
        arrived = on_their_way.pop_front().unwrap_or_default();
    }
    arrived
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_arrives_after_its_cycles_and_what_is_too_old_is_dropped_when_it_gets_faster() {
        let mut queue = VecDeque::new();
        let arrived: Vec<u32> = (1..=6).map(|value| after(2, &mut queue, value)).collect();
        assert_eq!(arrived, [0, 0, 1, 2, 3, 4]);
        assert_eq!((after(1, &mut queue, 7), after(0, &mut queue, 8)), (6, 8));
        assert!(queue.is_empty());
    }
}
