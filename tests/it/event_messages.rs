//! What happens, as messages for systems of a program's own.

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::simulation::Snapshot;

use crate::support::{collect_events, headless_app};

/// What a system has read: events with their cycles.
#[derive(Resource, Default)]
struct Read(Vec<(u64, MatchEvent)>);

fn read(mut events: MessageReader<StampedEvent>, mut read: ResMut<Read>) {
    read.0.extend(events.read().map(|stamped| (stamped.cycle, stamped.event.clone())));
}

/// Plays a match for so many cycles, and returns what happened in it, with the cycles.
fn played(app: &mut App, cycles: usize) -> Vec<(u64, MatchEvent)> {
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    let events = collect_events(app, cycles);
    assert!(events.len() > 3, "{}", events.len());
    events
}

#[test]
fn a_system_of_the_cycle_reads_each_event_in_the_cycle_in_which_it_happened() {
    #[derive(Resource, Default)]
    struct Late(bool);

    fn compare(mut messages: MessageReader<StampedEvent>, events: Res<CycleEvents>, mut late: ResMut<Late>) {
        late.0 |= !messages.read().map(|stamped| &stamped.event).eq(events.iter());
    }
    let mut app = headless_app();
    app.init_resource::<Read>().init_resource::<Late>();
    app.add_systems(Cycle, (read, compare).in_set(CycleSystems::Last));
    let events = played(&mut app, 1800);
    assert_eq!(app.world().resource::<Read>().0, events);
    assert!(!app.world().resource::<Late>().0);
    // Another match begins without those of the last one, and a saved cycle is none of them.
    app.world_mut().resource_mut::<Read>().0.clear();
    assert_eq!(played(&mut app, 1800), app.world().resource::<Read>().0);
}

#[test]
fn a_system_of_frames_reads_the_events_of_all_cycles_since_its_last() {
    let mut app = headless_app();
    app.init_resource::<Read>().add_systems(Update, read);
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    let mut events = Vec::new();
    for frame in 0..60 {
        // Frames of uneven length.
        events.extend(collect_events(&mut app, frame % 7 * 10));
        app.update();
    }
    assert!(events.len() > 3);
    assert_eq!(app.world().resource::<Read>().0, events);
}

#[test]
fn where_nobody_reads_them_few_are_kept() {
    let mut app = headless_app();
    played(&mut app, 3000);
    let kept = app.world().resource::<Messages<StampedEvent>>().len();
    // Twice 256, and those of the last cycle.
    assert!(kept <= 600, "{kept}");
}

#[test]
fn what_happened_before_a_match_was_put_back_is_no_news_in_it() {
    let mut app = headless_app();
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    let saved = Snapshot::take(app.world_mut()).unwrap();
    collect_events(&mut app, 1800);
    assert!(!app.world().resource::<Messages<StampedEvent>>().is_empty());
    saved.restore(app.world_mut()).unwrap();
    assert!(app.world().resource::<Messages<StampedEvent>>().is_empty());
}

#[test]
fn a_behaviour_may_not_read_them() {
    #[derive(Component, Default)]
    struct Insider;

    // A `MessageReader` does not even compile here.
    fn listen(events: Res<Messages<StampedEvent>>, robots: Query<&Odometry, With<Insider>>) {
        assert!(events.is_empty() && robots.is_empty());
    }
    let error = headless_app().try_add_behaviour::<Insider, _>("insider", listen).err().unwrap().to_string();
    assert!(error.contains("StampedEvent"), "{error}");
}
