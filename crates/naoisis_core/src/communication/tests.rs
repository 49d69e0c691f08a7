//! Messages that get through, late, or not at all.

use super::*;
use crate::collision::CollisionPlugin;
use crate::cycle::CyclePlugin;
use crate::cycle::run_cycle;
use crate::events::EventsPlugin;
use crate::pitch::PitchPlugin;
use crate::referee::RefereePlugin;
use crate::robot::RobotPlugin;
use crate::team::Team;

const NOTHING: Option<TeamMessage> = None;

/// Three blue robots and a pink one, a metre apart along x, that only talk.
fn talking_app(settings: MessageSettings) -> (App, [Entity; 4]) {
    let mut app = App::new();
    app.add_plugins((
        CyclePlugin::default(),
        EventsPlugin,
        PitchPlugin,
        RobotPlugin,
        CollisionPlugin,
        RefereePlugin,
        CommunicationPlugin,
    ))
    .insert_resource(settings)
    .init_resource::<crate::game::Game>();
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
    app.world().resource::<MessageStatistics>()[Team::Blue]
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
        // The last messages are still in flight.
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
fn what_is_too_long_not_finite_or_out_of_range_is_refused() {
    let (mut app, robots) = talking_app(MessageSettings::default());
    let wrong_ball = TeamMessage { ball_m: Some(Vec2::new(f32::NAN, 0.0)), ..default() };
    for (message, reason) in [
        (word(&"a".repeat(128)), None),
        (word(&"a".repeat(129)), Some(Refusal::TooLarge)),
        (wrong_ball, Some(Refusal::NotFinite)),
        (TeamMessage { ball_m: Some(Vec2::new(0.0, -1000.0)), ..default() }, None),
        (TeamMessage { ball_m: Some(Vec2::new(0.0, -1000.1)), ..default() }, Some(Refusal::TooLarge)),
        (TeamMessage { robots_m: vec![Vec2::ZERO, Vec2::new(1e30, 0.0)], ..default() }, Some(Refusal::TooLarge)),
        (TeamMessage { pose: Some(Pose::new(1e8, 0.0, 0.0)), ..default() }, Some(Refusal::TooLarge)),
    ] {
        say(&mut app, robots[0], message);
        run_cycle(app.world_mut());
        let robot = RobotId::new(Team::Blue, 1);
        let refused = reason.map(|reason| MatchEvent::CommandRefused { robot, command: CommandKind::Say, reason });
        assert_eq!(refusals(&app), Vec::from_iter(refused));
    }
    assert_eq!((statistics(&app).sent, statistics(&app).refused), (2, 5));
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

#[test]
fn each_team_has_its_own_limits() {
    let (mut app, robots) = talking_app(MessageSettings { max_text_bytes: 20, ..default() });
    let blue = MessageLimits { max_text_bytes: Some(4), max_messages: Some(3), ..default() };
    // More than the match allows.
    let pink = MessageLimits { max_text_bytes: Some(99), ..default() };
    for (robot, limits) in robots.into_iter().zip([blue, blue, blue, pink]) {
        app.world_mut().entity_mut(robot).insert(limits);
    }
    for length in [4, 5, 20, 21, 1, 1, 1, 1] {
        for robot in [0, 3] {
            say(&mut app, robots[robot], word(&"a".repeat(length)));
        }
        run_cycle(app.world_mut());
    }
    let statistics = app.world().resource::<MessageStatistics>();
    let counts = |team: Team| {
        let TeamMessageStatistics { sent, refused, over_budget, .. } = statistics[team];
        (sent, refused, over_budget)
    };
    assert_eq!((counts(Team::Blue), counts(Team::Pink)), ((3, 3, 2), (7, 1, 0)));
}
