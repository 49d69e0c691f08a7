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
//! a cycle is none. Messages have a delay of [their own](naoisis_core::communication::MessageSettings::delay_cycles).
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
use naoisis_core::cycle::{ActSystems, Cycle, CycleClock, CycleSystems};
use naoisis_core::events::Refusal;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::robot::head::{HeadAngles, HeadCommand, LateHeadCommand};
use naoisis_core::robot::kick::{KickCommand, KickRequest};
use naoisis_core::robot::motion::WalkCommand;

/// Holds back readings, and commands before they are taken over.
pub struct LatencyPlugin;

impl Plugin for LatencyPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Latency>()
            .register_type::<OnTheirWay>()
            .add_systems(Cycle, set_images_aside.after(SensingSystems::Scene).before(SensingSystems::Images))
            .add_systems(Cycle, hold_back_readings.in_set(SensingSystems::Late))
            .add_systems(Cycle, hold_back_commands.in_set(CycleSystems::Act).before(ActSystems::Say));
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
    fn senses_at_once(&self) -> bool {
        [self.vision_s, self.image_s, self.sonar_s] == [0.0; 3]
    }

    fn acts_at_once(&self) -> bool {
        [self.walk_s, self.kick_s, self.head_s] == [0.0; 3]
    }

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
    fn readings_are_none(&self) -> bool {
        self.percepts.is_empty() && self.images.is_empty() && self.sonars.is_empty()
    }

    fn commands_are_none(&self) -> bool {
        self.walks.is_empty() && self.kicks.is_empty() && self.heads.is_empty()
    }

    /// Whether there never was an image, these included: most matches are played without.
    fn has_no_image(&self, images: &CameraImages) -> bool {
        images.are_unused() && self.aside.are_unused() && self.images.is_empty()
    }

    /// The images among it.
    pub fn images(&self) -> impl Iterator<Item = &CameraImages> {
        self.images.iter().chain([&self.aside])
    }
}

/// Where images are late, new ones are not drawn over those that arrived last.
fn set_images_aside(clock: Res<CycleClock>, mut robots: Query<(&Latency, &mut CameraImages, &mut OnTheirWay)>) {
    for (latency, mut images, mut on_their_way) in &mut robots {
        if latency.image_s != 0.0 && !on_their_way.has_no_image(&images) && clock.cycles_in(latency.image_s) > 0 {
            core::mem::swap(&mut *images, &mut on_their_way.aside);
            images.clear();
            // Whoever has no images now clears this, too.
            images.arrived = Some(clock.cycle);
        }
    }
}

fn hold_back_readings(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Latency,
        &mut Percepts,
        Option<&mut CameraImages>,
        Option<(&SonarSettings, &mut SonarReading)>,
        &mut OnTheirWay,
    )>,
) {
    for (latency, mut percepts, images, sonars, mut on_their_way) in &mut robots {
        percepts.time_s = clock.start_time_s();
        if latency.senses_at_once() && on_their_way.readings_are_none() {
            continue;
        }
        let [vision, image, sonar] =
            [latency.vision_s, latency.image_s, latency.sonar_s].map(|seconds| clock.cycles_in(seconds));
        let queue = &mut on_their_way.percepts;
        if vision > 0 || !queue.is_empty() {
            delay(&mut *percepts, vision, queue);
        }
        if let Some(mut images) = images {
            hold_back_images(image, clock.cycle, &mut images, &mut on_their_way);
        }
        if let Some((settings, mut reading)) = sonars.filter(|(settings, _)| settings.fitted) {
            hold_back_sonars(sonar, clock.start_time_s(), settings, &mut reading, &mut on_their_way.sonars);
        }
    }
}

fn hold_back_commands(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Latency,
        &mut WalkCommand,
        &mut KickCommand,
        &HeadCommand,
        &HeadAngles,
        &mut LateHeadCommand,
        &mut OnTheirWay,
    )>,
) {
    for (latency, mut walk, mut kick, head, angles, mut late_head, mut on_their_way) in &mut robots {
        if latency.acts_at_once() && on_their_way.commands_are_none() && late_head.0.is_none() {
            continue;
        }
        let [walk_cycles, kick_cycles, head_cycles] =
            [latency.walk_s, latency.kick_s, latency.head_s].map(|seconds| clock.cycles_in(seconds));
        if walk_cycles > 0 || !on_their_way.walks.is_empty() {
            delay(&mut *walk, walk_cycles, &mut on_their_way.walks);
        }
        if kick_cycles > 0 || !on_their_way.kicks.is_empty() {
            delay(&mut kick.0, kick_cycles, &mut on_their_way.kicks);
        }
        hold_back_head(head_cycles, (head, angles), &mut late_head, &mut on_their_way.heads);
    }
}

/// In this cycle, with images that are late by so many.
fn hold_back_images(cycles: u32, now: u64, images: &mut CameraImages, on_their_way: &mut OnTheirWay) {
    if on_their_way.has_no_image(images) {
        return;
    }
    let OnTheirWay { images: queue, aside, .. } = on_their_way;
    if cycles == 0 {
        if !queue.is_empty() {
            queue.clear();
        }
        return;
    }
    if images.cycle == Some(now) {
        queue.push_back(core::mem::take(images));
    } else if images.arrived.is_none() {
        queue.clear();
        aside.clear();
    }
    core::mem::swap(images, aside);
    let has_arrived = |image: &CameraImages| image.cycle.is_some_and(|taken| taken + u64::from(cycles) <= now);
    while queue.front().is_some_and(has_arrived) {
        *aside = core::mem::replace(images, queue.pop_front().unwrap_or_default());
        images.arrived = Some(now);
    }
}

/// At this time, s, with sonars that are late by so many cycles.
fn hold_back_sonars(
    cycles: u32,
    now: f64,
    settings: &SonarSettings,
    reading: &mut SonarReading,
    queue: &mut VecDeque<SonarReading>,
) {
    if cycles > 0 || !queue.is_empty() {
        // Who has no rate pings in every cycle. Between two pings, what is on its way last is still the newest.
        let pings_always = settings.rate_hz.is_none() || settings.source == SonarSource::Truth;
        let time_s = reading.time_s.or(pings_always.then_some(now));
        let under_way = queue.back().filter(|_| time_s != Some(now)).copied();
        let newest = under_way.unwrap_or(SonarReading { time_s, ..*reading });
        *reading = newest;
        delay(reading, cycles, queue);
    }
}

/// A head's command stays until it is changed: the joints go by what it was, and before the first by where they are.
fn hold_back_head(
    cycles: u32,
    (command, angles): (&HeadCommand, &HeadAngles),
    late: &mut LateHeadCommand,
    queue: &mut VecDeque<HeadCommand>,
) {
    if cycles == 0 {
        late.0 = None;
        queue.clear();
        return;
    }
    let stays = HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
    // One that is not a number is refused, and the head stays where it is.
    let is_refused = Refusal::of_numbers([command.yaw, command.pitch]).is_some();
    queue.push_back(if is_refused { stays } else { *command });
    while queue.len() > cycles as usize {
        late.0 = queue.pop_front();
    }
    late.0 = Some(late.0.unwrap_or(stays));
}

/// Sends a value on its way, and puts the one in its place that arrives after so many cycles; nothing while there is none.
fn delay<T: Default>(value: &mut T, cycles: u32, on_their_way: &mut VecDeque<T>) {
    let cycles = cycles as usize;
    // Mostly as many are on their way as should be: who arrives makes room for who is sent.
    if on_their_way.len() == cycles
        && let Some(oldest) = on_their_way.pop_front()
    {
        on_their_way.push_back(core::mem::replace(value, oldest));
        return;
    }
    on_their_way.push_back(core::mem::take(value));
    while on_their_way.len() > cycles {
        *value = on_their_way.pop_front().unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_sent_arrives_after_its_cycles_and_what_is_too_old_is_dropped_when_it_gets_faster() {
        let mut queue = VecDeque::new();
        let mut after = |mut value: u32, cycles: u32| {
            delay(&mut value, cycles, &mut queue);
            value
        };
        let arrived: Vec<u32> = (1..=6).map(|value| after(value, 2)).collect();
        assert_eq!(arrived, [0, 0, 1, 2, 3, 4]);
        assert_eq!((after(7, 1), after(8, 0), after(9, 0)), (6, 8, 9));
        assert!(queue.is_empty());
    }
}
