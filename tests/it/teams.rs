//! The built-in players in matches: they find the ball, kick it, score, and cope with what goes wrong.

use bevy::math::Vec2;
use naoisis::pitch::Pitch;
use naoisis::prelude::*;

use crate::support::{blue, collect_events, headless_app, match_of, pink};
use naoisis::behaviour::reasons::{Reasons, ask_for_reasons};
use naoisis::belief::covariance::{ELLIPSE_95, ELLIPSOID_95};
use naoisis::belief::error::{BeliefError, Truth};
use naoisis::belief::{point_team_from_pitch, team_from_pitch};
use naoisis::game::{Penalty, Score};
use naoisis::robot::Roster;

fn goals(events: &[(u64, MatchEvent)]) -> usize {
    events.iter().filter(|(_, event)| matches!(event, MatchEvent::Goal { .. })).count()
}

fn assert_invariants(events: &[(u64, MatchEvent)]) {
    for (cycle, event) in events {
        assert!(!matches!(event, MatchEvent::InvariantBroken { .. }), "cycle {cycle}: {event:?}");
        assert!(!matches!(event, MatchEvent::CommandRefused { .. }), "cycle {cycle}: {event:?}");
    }
}

/// A match between two teams over `seconds`, with what else the scenario says.
fn play(blue: &str, pink: &str, seed: u64, seconds: usize, more: &str) -> (Score, Vec<(u64, MatchEvent)>) {
    let json = format!(r#"{{ "seed": {seed}, "teams": {{ "blue": "{blue}", "pink": "{pink}" }} {more} }}"#);
    let mut app = match_of(&json);
    let events = collect_events(&mut app, 30 * seconds);
    (app.game().score, events)
}

#[test]
fn a_robot_chooses_the_option_that_its_reasons_value_most() {
    for teams in ["chasers", "roles", "passers"] {
        for scenario in ["match3v3", "spl2025", "hsl2026_middle"] {
            let mut scenario = Scenario::named(scenario).unwrap();
            let spec = scenario.teams.as_mut().unwrap();
            (spec.blue, spec.pink) = (teams.to_owned(), teams.to_owned());
            let mut app = headless_app();
            app.start_match(&scenario).unwrap();
            ask_for_reasons(app.world_mut());
            let mut choices = 0;
            for _ in 0..1800 {
                app.run_cycles(1);
                let world = app.world_mut();
                for (id, reasons) in world.query::<(&RobotId, &Reasons)>().iter(world) {
                    let Some(choice) = reasons.choice() else { continue };
                    choices += 1;
                    let is_best = reasons.options.iter().all(|option| option.value <= choice.value + 1e-3);
                    assert!(is_best, "{teams} {}, {id} chose {}: {:?}", scenario.name, choice.name, reasons.options);
                }
            }
            assert!(choices > 1000, "{teams} {}: {choices}", scenario.name);
        }
    }
}

#[test]
fn a_lone_player_scores_into_the_empty_goal_wherever_the_ball_lies() {
    for behaviour in ["chaser", "striker", "supporter"] {
        for [x, y] in [[1.0, 0.5], [2.0, -1.2], [0.0, 0.0], [-1.5, 1.4], [2.7, 1.5]] {
            let mut app = match_of(&format!(
                r#"{{ "ball": {{ "position_m": [{x}, {y}] }},
                     "robots": [{{ "number": 2, "pose": [-0.5, -0.5, 90.0], "behaviour": "{behaviour}" }}] }}"#
            ));
            let scored = app.run_until(30 * 90, |app| app.game().score.blue > 0);
            assert!(scored, "{behaviour}, ball at {x}, {y}: no goal within 90 s; the ball is at {:?}", app.ball());
        }
    }
}

#[test]
fn every_team_plays_on_every_pitch() {
    // `passers` could not do so: on the pitch of 2025 the penalty area was deeper than their furthest place before it.
    for team in ["chasers", "roles", "passers"] {
        for field in ["naoisis", "spl2025"] {
            let rules = format!(r#", "field": "{field}", "rules": "spl2025""#);
            let (_, events) = play(team, "passers", 1, 25, &rules);
            assert_invariants(&events);
        }
    }
}

#[test]
fn pink_attacks_the_other_goal() {
    let mut app = match_of(
        r#"{ "ball": { "position_m": [-1.0, 0.5] },
             "robots": [{ "team": "pink", "number": 2, "pose": [0.5, 0.5, 0.0], "behaviour": "chaser" }] }"#,
    );
    assert!(app.run_until(30 * 90, |app| app.game().score.pink > 0));
    assert_eq!(app.game().score.blue, 0);
}

#[test]
fn three_against_three_is_a_lively_match() {
    let (score, events) = play("chasers", "chasers", 3, 300, "");
    assert_invariants(&events);
    let kicks = |team: Team| {
        events
            .iter()
            .filter(
                |(_, event)| matches!(event, MatchEvent::Kick { robot, direction: Some(_), .. } if robot.team == team),
            )
            .count()
    };
    assert!(kicks(Team::Blue) > 10 && kicks(Team::Pink) > 10, "{} and {} kicks", kicks(Team::Blue), kicks(Team::Pink));
    assert!(score.blue + score.pink > 0);
}

#[test]
fn a_team_that_hears_nothing_still_plays() {
    let scored: u32 = (1..=2)
        .map(|seed| {
            let (score, events) = play("roles", "chasers", seed, 300, r#", "messages": { "loss": 1.0 }"#);
            assert_invariants(&events);
            score.blue + score.pink
        })
        .sum();
    assert!(scored > 0);
}

#[test]
fn players_without_noise_play_too() {
    let exact = r#", "vision": { "noise": "none" }, "sonar": { "noise": "none" }"#;
    let (_, events) = play("roles", "roles", 1, 300, exact);
    assert_invariants(&events);
    assert!(events.iter().filter(|(_, event)| matches!(event, MatchEvent::Kick { .. })).count() > 20);
}

#[test]
fn a_keeper_stops_a_shot_that_it_can_reach() {
    // Over 2 m, the ball at 1.4 m/s takes -ln(1 - 0.5 * 2 / 1.4) / 0.5 = 2.5 s; the keeper walks 0.35 m in 1.75 s.
    let shot = |keeper: &str| {
        let mut app = match_of(&format!(
            r#"{{ "ball": {{ "position_m": [-0.55, 0.2], "velocity_mps": [-1.4, 0.1] }},
                 "robots": [{{ "number": 1, "pose": [-2.75, 0.0, 0.0], "behaviour": "{keeper}" }}] }}"#
        ));
        goals(&collect_events(&mut app, 30 * 8))
    };
    assert_eq!(shot("idle"), 1, "nobody stops it");
    assert_eq!(shot("keeper"), 0);
}

#[test]
fn a_keeper_clears_a_ball_that_lies_in_front_of_its_goal() {
    let mut app = match_of(
        r#"{ "ball": { "position_m": [-2.3, 0.4] },
             "robots": [{ "number": 1, "pose": [-2.8, 0.0, 0.0], "behaviour": "keeper" }] }"#,
    );
    assert!(app.run_until(30 * 30, |app| app.ball().unwrap().position.x > -1.0));
    // And goes back.
    assert!(app.run_until(30 * 30, |app| app.robot_pose(blue(1)).unwrap().position.x < -2.4));
}

#[test]
fn the_kick_off_is_a_pass_and_the_opponents_keep_off_the_circle_until_then() {
    let mut app = match_of(r#"{ "teams": { "blue": "roles", "pink": "roles" } }"#);
    let radius = app.world().resource::<Pitch>().centre_circle_diameter_m / 2.0;
    let mut kicked = None;
    for _ in 0..300 {
        app.run_cycles(1);
        kicked = app.events().iter().find_map(|event| match event {
            MatchEvent::Kick { robot, speed: Some(speed), direction: Some(_), .. } => Some((*robot, *speed)),
            _ => None,
        });
        if kicked.is_some() {
            break;
        }
        for number in 1..=3 {
            assert!(app.robot_pose(pink(number)).unwrap().position.length() > radius);
        }
    }
    let (robot, speed) = kicked.unwrap();
    assert_eq!(robot, blue(2));
    assert!(speed < 0.6, "{speed}");
}

#[test]
fn a_robot_that_lost_the_ball_finds_it_again() {
    // Behind the robot, and out of the sight of the cameras.
    let mut app = match_of(
        r#"{ "rules": "free", "ball": { "position_m": [-1.5, 0.3] },
             "robots": [{ "number": 2, "pose": [0.5, 0.0, 0.0], "behaviour": "chaser" }] }"#,
    );
    let sees = |app: &bevy::prelude::App| app.robot::<Belief>(blue(2)).unwrap().ball.is_some();
    assert!(app.run_until(30 * 8, sees));
}

#[test]
fn beliefs_stay_near_the_truth_for_a_whole_match() {
    let mut app = headless_app();
    let scenario = Scenario::from_json(r#"{ "seed": 5, "teams": { "blue": "roles", "pink": "roles" } }"#).unwrap();
    app.start_match(&scenario).unwrap();
    let (mut off, mut all) = (0, 0);
    for _ in 0..30 * 300 {
        app.run_cycles(1);
        for id in [blue(1), blue(2), pink(3)] {
            // Who waits beside the pitch has been carried there.
            if app.robot::<Penalty>(id).is_some_and(Penalty::is_active) {
                continue;
            }
            let belief = app.robot::<Belief>(id).unwrap();
            let own_end = app.game().own_end(id.team);
            let error = belief.pose_in_pitch(own_end).position.distance(app.robot_pose(id).unwrap().position);
            all += 1;
            off += usize::from(error > 0.3);
        }
    }
    // Now and then a robot is pushed, or has just been carried to its place.
    assert!(off * 50 < all, "more than 0.3 m off in {off} of {all}");
}

#[test]
fn realistic_beliefs_are_as_sure_as_they_should_be() {
    // How often what was so at the start of a cycle is within the ellipse of 95 % of what is believed in it, and how often
    // something was believed: of poses, of the ball, of opponents.
    let mut within = [[0_u32; 2]; 3];
    for kind in [r#""realism": "realistic""#, r#""league": "hsl2026_middle""#] {
        let mut app =
            match_of(&format!(r#"{{ "seed": 11, {kind}, "teams": {{ "blue": "roles", "pink": "passers" }} }}"#));
        let robots: Vec<RobotId> = app.world().resource::<Roster>().iter().map(|(id, _)| id).collect();
        for cycle in 0..20 * 150 {
            let poses: Vec<Pose> = robots.iter().map(|id| app.robot_pose(*id).unwrap()).collect();
            let ball = app.ball().zip(app.ball_velocity()).map(|(pose, velocity)| [pose.position, velocity]);
            app.run_cycles(1);
            if cycle % 5 != 0 {
                continue;
            }
            let plays = |id: RobotId| !app.robot::<Penalty>(id).is_some_and(Penalty::is_active);
            for (id, pose) in robots.iter().zip(&poses).filter(|(id, _)| plays(**id)) {
                let to_team = |place| point_team_from_pitch(place, app.game().own_end(id.team));
                let opponents = robots.iter().zip(&poses).filter(|(other, _)| other.team != id.team && plays(**other));
                let truth = Truth {
                    pose: team_from_pitch(*pose, app.game().own_end(id.team)),
                    ball: ball.map(|vectors| vectors.map(to_team)),
                    opponents: opponents.map(|(_, pose)| to_team(pose.position)).collect(),
                };
                let error = BeliefError::of(app.robot::<Belief>(*id).unwrap(), &truth, |_| {});
                let pose = error.pose_nees.map(|nees| nees <= ELLIPSOID_95);
                let ball = error.ball.and_then(|ball| ball.nees).map(|nees| nees <= ELLIPSE_95);
                for (within, is_within) in within.iter_mut().zip([pose, ball]) {
                    within[0] += u32::from(is_within == Some(true));
                    within[1] += u32::from(is_within.is_some());
                }
                within[2][0] += error.opponents_within;
                within[2][1] += error.opponents_known;
            }
        }
    }
    // Over a hundred matches 90 to 98 %; what is wrong stays wrong for seconds, so that two matches are a few dozen draws.
    let shares = within.map(|[within, all]| f64::from(within) / f64::from(all));
    assert!(shares.iter().all(|share| (0.86..=0.99).contains(share)), "pose, ball, opponents: {shares:?}");
}

/// The penalties for what a team that knows the rules does not do, and the placements by hand.
fn offences(events: &[(u64, MatchEvent)]) -> Vec<String> {
    use naoisis::game::PenaltyReason::{IllegalDefender, IllegalPosition, Inactive, LeavingField};
    let is_offence = |event: &MatchEvent| match event {
        MatchEvent::Penalty { reason, .. } => {
            matches!(reason, IllegalDefender | IllegalPosition | Inactive | LeavingField)
        }
        MatchEvent::PlacedByHand { .. } => true,
        _ => false,
    };
    let offences = events.iter().filter(|(_, event)| is_offence(event));
    offences.map(|(cycle, event)| format!("{cycle}: {event:?}")).collect()
}

#[test]
fn both_teams_know_the_rule_books() {
    for rules in ["spl2010", "spl2025"] {
        for seed in 1..=2 {
            let rules = format!(r#", "rules": {{ "preset": "{rules}", "half_s": 120, "team_size": 3 }}"#);
            let (_, events) = play("roles", "chasers", seed, 300, &rules);
            assert_invariants(&events);
            let offences = offences(&events);
            assert!(offences.len() <= 1, "{rules}, seed {seed}: {offences:#?}");
        }
    }
}

#[test]
fn who_stands_elsewhere_walks_to_a_legal_place_for_the_kick_off() {
    let mut app = match_of(
        r#"{ "rules": { "preset": "spl2010", "ready_s": 40 }, "fidelity": "ideal",
             "robots": [{ "number": 1, "pose": [-1, 1, 0], "behaviour": "keeper" },
                        { "number": 2, "pose": [1, 1, 0], "behaviour": "striker" },
                        { "team": "pink", "number": 1, "pose": [1.5, -1, 180], "behaviour": "keeper" },
                        { "team": "pink", "number": 2, "pose": [-0.5, -1, 180], "behaviour": "striker" }] }"#,
    );
    let events = collect_events(&mut app, 30 * 44);
    assert_eq!(offences(&events), Vec::<String>::new());
    assert_eq!(app.game().state, GameState::Playing);
}

#[test]
fn a_field_player_leaves_its_own_penalty_area() {
    let mut app = match_of(
        r#"{ "rules": { "preset": "free", "illegal_defender": true, "illegal_defender_s": 4 }, "fidelity": "ideal",
             "ball": { "position_m": [-2.8, 0.9] },
             "robots": [{ "number": 2, "pose": [-2.8, 0.4, 90], "behaviour": "striker" }] }"#,
    );
    let events = collect_events(&mut app, 30 * 20);
    assert_eq!(offences(&events), Vec::<String>::new());
    assert!(app.robot_pose(blue(2)).unwrap().position.x > -2.45);
}

#[test]
fn who_comes_back_from_a_penalty_plays_on() {
    for rules in ["naoisis", "spl2025"] {
        let mut app = match_of(&format!(
            r#"{{ "rules": {{ "preset": "{rules}", "penalty_s": 5, "kick_off": "placed", "game_stuck": false }},
                 "ball": {{ "position_m": [1, -1] }},
                 "robots": [{{ "number": 2, "pose": [0, 0.5, 0], "behaviour": "striker" }},
                            {{ "team": "pink", "number": 1, "pose": [2.7, 0, 180], "behaviour": "idle" }}],
                 "interventions": [{{ "at_s": 1, "do": {{ "penalise": {{ "robot": "blue2", "reason": "pushing" }} }} }}] }}"#
        ));
        let back = app
            .run_until(30 * 10, |app| app.events().iter().any(|event| matches!(event, MatchEvent::PenaltyOver { .. })));
        assert!(back, "{rules}: it does not come back");
        let plays = app.run_until(30 * 60, |app| {
            app.events().iter().any(|event| matches!(event, MatchEvent::Kick { direction: Some(_), .. }))
        });
        assert!(
            plays,
            "{rules}: {:?}, believed {:?}",
            app.robot_pose(blue(2)),
            app.robot::<Belief>(blue(2)).map(|belief| belief.pose)
        );
    }
}

#[test]
fn who_falls_gets_up_and_plays_on() {
    let mut app = match_of(
        r#"{ "rules": { "preset": "extended", "fall_from_mps": 0, "fall_certain_mps": 0.01, "collisions": false },
             "ball": { "position_m": [1.5, 0.8] },
             "robots": [{ "number": 2, "pose": [-0.3, 0, 0], "behaviour": "striker" },
                        { "team": "pink", "number": 2, "pose": [-0.17, 0.05, 180],
                          "behaviour": { "script": [{ "until_s": 1, "walk": [0.006, 0, 0] }] } }] }"#,
    );
    let mut fell = 0;
    let kicked = app.run_until(30 * 90, |app| {
        fell += app.events().iter().filter(|event| matches!(event, MatchEvent::Fall { .. })).count();
        fell > 0 && app.events().iter().any(|event| matches!(event, MatchEvent::Kick { direction: Some(_), .. }))
    });
    assert!(kicked, "{fell} falls");
}

#[test]
fn a_keeper_dives_for_what_it_cannot_walk_to() {
    let goals = |rules: &str| {
        let saved_or_not: usize = (0..6)
            .map(|index| {
                let y = 0.54 - 0.02 * index as f32;
                let mut app = match_of(&format!(
                    r#"{{ "rules": "{rules}", "seed": {index}, "ball": {{ "position_m": [-0.4, {y}], "velocity_mps": [-2.2, 0] }},
                         "robots": [{{ "number": 1, "pose": [-2.75, 0.0, 0.0], "behaviour": "keeper" }}] }}"#
                ));
                goals(&collect_events(&mut app, 30 * 6))
            })
            .sum();
        saved_or_not
    };
    let [without, with] = [goals("naoisis"), goals("extended")];
    assert!(without >= 5 && with <= without - 3, "{without} goals without dives, {with} with them");
}

/// How a robot went in a second of play: the way that it walked and how far that took it, m, and how often it turned back.
fn seconds_of(robot: RobotId, app: &mut bevy::prelude::App, seconds: usize) -> Vec<(f32, f32, usize)> {
    /// What is slower is standing, m a cycle.
    const MOVES_M: f32 = 0.000_2;
    let mut result = Vec::new();
    for _ in 0..seconds {
        let mut places = vec![app.robot_pose(robot).unwrap().position];
        let mut plays = true;
        for _ in 0..30 {
            app.run_cycles(1);
            plays &= app.game().state == GameState::Playing && !app.robot::<Penalty>(robot).unwrap().is_active();
            places.push(app.robot_pose(robot).unwrap().position);
        }
        if plays {
            let steps: Vec<Vec2> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let moves: Vec<&Vec2> = steps.iter().filter(|step| step.length() > MOVES_M).collect();
            let reversals = moves.windows(2).filter(|pair| pair[0].dot(*pair[1]) < 0.0).count();
            let path_m = steps.iter().map(|step| step.length()).sum();
            result.push((path_m, places[0].distance(places[30]), reversals));
        }
    }
    result
}

#[test]
fn a_keeper_goes_where_it_goes_without_turning_back_all_the_time() {
    for seed in 1..=2 {
        let json = format!(
            r#"{{ "seed": {seed}, "realism": "realistic", "teams": {{ "blue": "roles", "pink": "passers" }} }}"#
        );
        let mut app = match_of(&json);
        let seconds = seconds_of(blue(1), &mut app, 120);
        let walked: Vec<_> = seconds.iter().filter(|(path_m, ..)| *path_m > 0.02).collect();
        assert!(walked.len() > 5, "it hardly moves: {} of {} s", walked.len(), seconds.len());
        let mut ratios: Vec<f32> = walked.iter().map(|(path_m, net_m, _)| path_m / net_m.max(0.001)).collect();
        ratios.sort_by(f32::total_cmp);
        assert!(ratios[ratios.len() / 2] < 1.6, "seed {seed}: {ratios:?}");
        let reversals: usize = seconds.iter().map(|(.., reversals)| reversals).sum();
        assert!(reversals < seconds.len(), "seed {seed}: {reversals} reversals in {} s", seconds.len());
    }
}
