use super::*;
use crate::viewer::commands::{TimelineCommand, ViewerCommand};
use crate::viewer::drive::DrivePlugin;
use crate::viewer::event_log::EventLogPlugin;
use crate::viewer::rebuild::RebuildPlugin;
use bevy::time::TimeUpdateStrategy;
use core::time::Duration;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::sensing::vision::{SceneObject, VisionSettings, WhyMissed};
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// A match of three against three with these vision settings, with ten cycles per frame.
fn app(vision: &str, latency_s: f32) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, RebuildPlugin, UnrecognisedPlugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(333_340)))
        .insert_resource(Simulator(&simulator))
        .init_resource::<DisplaySettings>()
        .insert_resource(Selection(Some(BLUE2)));
    let mut scenario = Scenario::named("match3v3").unwrap();
    scenario.settings.vision = serde_json::from_str(vision).unwrap();
    scenario.settings.latency.vision_s = latency_s;
    app.start_match(&scenario).unwrap();
    app.update();
    app
}

/// What a robot did not recognise, if it is known.
fn missed(app: &App, id: RobotId) -> Option<Vec<MissedObject>> {
    let world = app.world();
    let percepts = world.get::<Percepts>(world.resource::<Roster>().get(id)?)?;
    world.resource::<Unrecognised>().of(id, percepts)
}

#[test]
fn every_object_on_the_pitch_is_recognised_or_has_a_reason() {
    // False detections would be among the percepts, too.
    let noise = r#"{ "noise": { 
        "ball": { "pixel_sd": 1.0, "miss_probability": 0.3, "false_positive_probability": 0.0, "max_distance_m": 3.0 },
        "robots": { "pixel_sd": 3.0, "miss_probability": 0.4, "false_positive_probability": 0.0, "max_distance_m": 4.0,
                    "falloff": { "half_distance_m": 3.0, "exponent": 3.0 } } } }"#;
    let mut app = app(noise, 0.0);
    let ids: Vec<RobotId> = app.world().resource::<Roster>().iter().map(|(id, _)| id).collect();
    let (mut recognised, mut kinds) = (0, std::collections::BTreeMap::<String, u32>::new());
    app.world_mut().init_resource::<Unrecognised>();
    for _ in 0..600 {
        app.run_cycles(1);
        let scene = app.world().resource::<Scene>().clone();
        for &id in &ids {
            let missed = missed(&app, id).expect("noted in every cycle");
            let percepts = app.robot::<Percepts>(id).unwrap();
            let of_kind = |is_kind: fn(&SceneObject) -> bool| missed.iter().filter(|one| is_kind(&one.object)).count();
            let balls = of_kind(|object| matches!(object, SceneObject::Ball(_)));
            let robots = of_kind(|object| matches!(object, SceneObject::Robot(_)));
            let posts = of_kind(|object| matches!(object, SceneObject::GoalPost { .. }));
            let others = scene.robots.iter().filter(|robot| robot.id != id).count();
            assert_eq!(percepts.all_balls().count() + balls, scene.balls().count());
            assert_eq!(percepts.robots.len() + robots, others);
            assert_eq!(percepts.goal_posts.len() + posts, 4);
            recognised += percepts.robots.len() + percepts.goal_posts.len();
            for one in missed {
                let kind = format!("{:?}", one.why);
                *kinds.entry(kind.split([' ', '{']).next().unwrap_or_default().to_owned()).or_default() += 1;
            }
        }
    }
    assert!(recognised > 1000, "{recognised}");
    for kind in ["OutsideImage", "PartlyOutside", "TooFar", "Covered", "Chance"] {
        assert!(kinds.get(kind).is_some_and(|count| *count > 20), "{kinds:?}");
    }
}

#[test]
fn the_present_and_the_past_say_the_same_even_if_the_vision_is_late() {
    for latency_s in [0.0, 0.1] {
        let mut app = app("{}", latency_s);
        let mut earlier = None;
        while app.cycle() < 260 {
            app.update();
            if app.cycle() == 210 {
                earlier = Some(app.world().resource::<ShownUnrecognised>().clone());
            }
        }
        let earlier = earlier.expect("frames of ten cycles");
        assert!(earlier.0.as_ref().is_ok_and(|missed| !missed.is_empty()), "{earlier:?}");
        app.world_mut().write_message(ViewerCommand::TogglePause);
        app.update();
        app.world_mut().write_message(TimelineCommand::GoTo(210));
        app.update();
        assert_eq!(shown(&mut app), earlier);
    }
}

#[test]
fn images_from_before_a_keyframe_have_reasons_too() {
    let mut app = app("{}", 0.1);
    while app.cycle() < 400 {
        app.update();
    }
    let keyframes = app.world().resource::<Keyframes>().cycles(|_| true);
    let kept = keyframes.into_iter().find(|kept| *kept > 0).expect("keyframes within thirteen seconds");
    app.world_mut().write_message(ViewerCommand::TogglePause);
    app.update();
    // The second one is rebuilt after a replay that was only for reasons.
    for cycle in [kept + 1, kept + 2] {
        app.world_mut().write_message(TimelineCommand::GoTo(cycle));
        app.update();
        let said = shown(&mut app).0.unwrap();
        let mut live = simulator();
        live.init_resource::<Unrecognised>();
        live.start_match(app.world().resource::<Scenario>()).unwrap().run_cycles(cycle as usize);
        assert_eq!(Some(said), missed(&live, BLUE2), "cycle {cycle}, keyframe {kept}");
    }
}

#[test]
fn a_robot_that_is_selected_while_the_match_is_paused_has_reasons_too() {
    let mut app = app("{}", 0.0);
    app.world_mut().resource_mut::<Selection>().0 = None;
    while app.cycle() < 60 {
        app.update();
        assert!(app.cycle() < 20 || !app.world().contains_resource::<Unrecognised>(), "nobody looks");
    }
    app.world_mut().write_message(ViewerCommand::TogglePause);
    app.update();
    app.world_mut().resource_mut::<Selection>().0 = Some(BLUE2);
    app.update();
    let said = shown(&mut app).0.unwrap();
    let percepts = app.robot::<Percepts>(BLUE2).unwrap();
    let is_ball = |one: &MissedObject| matches!(one.object, SceneObject::Ball(_));
    assert_eq!(said.iter().any(is_ball), percepts.ball.is_none());
    assert!(said.iter().any(|one| one.why == WhyMissed::OutsideImage), "its own goal is behind it: {said:?}");
}

#[test]
fn what_robots_perceive_is_the_same_with_and_without_reasons() {
    let percepts_of = |is_noted: bool| {
        let mut app = app(r#"{ "points": true }"#, 0.0);
        app.world_mut().remove_resource::<Unrecognised>();
        if is_noted {
            app.world_mut().init_resource::<Unrecognised>();
        }
        app.run_cycles(200);
        assert!(app.robot::<VisionSettings>(BLUE2).unwrap().points);
        (app.robot::<Percepts>(BLUE2).unwrap().clone(), app.ball())
    };
    assert_eq!(percepts_of(true), percepts_of(false));
}

/// Runs frames until the objects at the moment that is shown are known.
fn shown(app: &mut App) -> ShownUnrecognised {
    // The thread may take any time: the test waits for it, but not for ever.
    for _ in 0..20_000 {
        app.update();
        let shown = app.world().resource::<ShownUnrecognised>();
        if shown.0.is_ok() {
            return shown.clone();
        }
        std::thread::yield_now();
    }
    panic!("{:?}", app.world().resource::<ShownUnrecognised>());
}
