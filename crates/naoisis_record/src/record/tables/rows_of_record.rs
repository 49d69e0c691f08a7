//! Makes the rows of the tables from a cycle's record.

use bevy::math::Vec2;
use serde::Serialize;
use serde_json::Value;

use super::rows::{BeliefRow, CycleRow, EventRow, MessageRow, PerceptRow, RobotRow};
use naoisis_core::communication::ReceivedMessage;
use naoisis_core::events::MatchEvent;
use naoisis_core::geometry::{Pose, to_degrees};
use naoisis_sensing::belief::{RobotBelief, point_pitch_from_team};
use naoisis_sensing::sensing::vision::LandmarkKind;
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::interface::fields::Fields;

/// Returns the word for a value, as in traces.
fn word(value: &impl Serialize) -> Option<String> {
    match serde_json::to_value(value).ok()? {
        Value::String(word) => Some(word),
        // A variant with fields is an object with a single key, its name.
        Value::Object(object) => object.into_iter().next().map(|(name, _)| name),
        _ => None,
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

impl CycleRow {
    pub(super) fn new(record: &CycleRecord, fields: &Fields) -> Self {
        let CycleRecord { cycle, time_s, ball, game, .. } = record;
        let position = ball.filter(|_| fields.has("ball.position_m")).map(|ball| ball.position_m);
        let velocity = ball.filter(|_| fields.has("ball.velocity_mps")).map(|ball| ball.velocity_mps);
        let has_score = fields.has("game.score");
        let has = |name: &str| fields.has(name).then_some(game);
        Self {
            cycle: *cycle as i64,
            time_s: *time_s,
            ball_x_m: position.map(|at| at.x),
            ball_y_m: position.map(|at| at.y),
            ball_z_m: position.map(|at| at.z),
            ball_vx_mps: velocity.map(|velocity| velocity.x),
            ball_vy_mps: velocity.map(|velocity| velocity.y),
            ball_vz_mps: velocity.map(|velocity| velocity.z),
            state: has("game.state").map(|game| game.state.name().to_owned()),
            score_blue: has_score.then_some(i64::from(game.score.blue)),
            score_pink: has_score.then_some(i64::from(game.score.pink)),
            half: has("game.half").map(|game| i64::from(game.half)),
            time_left_s: game.time_left_s,
            blue_end: has("game.blue_end").and_then(|game| word(&game.blue_end)),
            kicking_team: game.kicking_team.map(|team| team.name().to_owned()),
            set_play: game.set_play.and_then(|set_play| word(&set_play.kind)),
        }
    }
}

impl RobotRow {
    pub(super) fn new(record: &CycleRecord, robot: &RobotRecord, fields: &Fields) -> Self {
        let has = |name: &str| fields.has(name).then_some(robot);
        let pose = has("robots.pose").map(|robot| robot.pose);
        let velocity = has("robots.velocity").map(|robot| robot.velocity);
        let head = has("robots.head_deg").map(|robot| robot.head);
        let odometry = has("robots.odometry").map(|robot| robot.odometry);
        let command = robot.command.as_ref();
        let walk = command.and_then(|command| command.walk);
        let kick = command.and_then(|command| command.kick.as_ref());
        Self {
            cycle: record.cycle as i64,
            time_s: record.time_s,
            robot: robot.id.to_string(),
            team: robot.id.team.name().to_owned(),
            number: i64::from(robot.id.number),
            x_m: pose.map(|pose| pose.position.x),
            y_m: pose.map(|pose| pose.position.y),
            heading_deg: pose.map(|pose| to_degrees(pose.heading)),
            vx_mps: velocity.map(|velocity| velocity.linear.x),
            vy_mps: velocity.map(|velocity| velocity.linear.y),
            turn_degps: velocity.map(|velocity| to_degrees(velocity.angular)),
            head_yaw_deg: head.map(|head| to_degrees(head.yaw)),
            head_pitch_deg: head.map(|head| to_degrees(head.pitch)),
            posture: has("robots.posture").map(|robot| robot.posture.name().to_owned()),
            penalty: robot.penalised.map(|penalty| penalty.reason.name().to_owned()),
            penalty_left_s: robot.penalised.map(|penalty| penalty.time_left_s),
            odometry_x_m: odometry.map(|pose| pose.position.x),
            odometry_y_m: odometry.map(|pose| pose.position.y),
            odometry_heading_deg: odometry.map(|pose| to_degrees(pose.heading)),
            sonar_left_m: robot.sonar_m.left,
            sonar_right_m: robot.sonar_m.right,
            body: robot.body.and_then(|body| word(&body)),
            walk_x_m: walk.map(|walk| walk.dx),
            walk_y_m: walk.map(|walk| walk.dy),
            walk_turn_deg: walk.map(|walk| to_degrees(walk.dtheta)),
            kick: kick.map(|kick| kick.kick_type.name().to_owned()),
            kick_speed: kick.map(|kick| kick.speed),
            kick_direction_deg: kick.map(|kick| to_degrees(kick.direction)),
        }
    }
}

impl PerceptRow {
    pub(super) fn all(record: &CycleRecord, robot: &RobotRecord) -> impl Iterator<Item = Self> {
        let percepts = &robot.percepts;
        let row = |kind: &str, camera: String, pixel: Vec2, place: Vec2, detail: Option<String>| Self {
            cycle: record.cycle as i64,
            time_s: record.time_s,
            robot: robot.id.to_string(),
            exposed_s: percepts.time_s,
            kind: kind.to_owned(),
            camera,
            u_px: pixel.x,
            v_px: pixel.y,
            x_m: place.x,
            y_m: place.y,
            end_u_px: None,
            end_v_px: None,
            end_x_m: None,
            end_y_m: None,
            detail,
        };
        let balls = percepts
            .all_balls()
            .map(move |seen| row("ball", seen.camera.to_string(), seen.pixel, seen.position_m, None));
        let posts = percepts.goal_posts.iter().map(move |seen| {
            row("goal_post", seen.camera.to_string(), seen.pixel, seen.position_m, word(&seen.colour))
        });
        let robots = percepts
            .robots
            .iter()
            .map(move |seen| row("robot", seen.camera.to_string(), seen.pixel, seen.position_m, word(&seen.team)));
        let landmarks = percepts.landmarks.iter().map(move |seen| {
            let of = |kind, detail| row(kind, seen.camera.to_string(), seen.pixel, seen.position_m, detail);
            match seen.kind {
                LandmarkKind::Line { end_pixel, end_position_m } => Self {
                    end_u_px: Some(end_pixel.x),
                    end_v_px: Some(end_pixel.y),
                    end_x_m: Some(end_position_m.x),
                    end_y_m: Some(end_position_m.y),
                    ..of("line", None)
                },
                LandmarkKind::Junction { shape } => of("junction", word(&shape)),
                LandmarkKind::PenaltyCross => of("penalty_cross", None),
                LandmarkKind::CentreCircle => of("centre_circle", None),
                LandmarkKind::CornerArc => of("corner_arc", None),
            }
        });
        balls.chain(posts).chain(robots).chain(landmarks)
    }
}

impl BeliefRow {
    pub(super) fn all(record: &CycleRecord, robot: &RobotRecord, fields: &Fields) -> Vec<Self> {
        let Some(belief) = &robot.belief else { return Vec::new() };
        let own_end = fields.has("game.blue_end").then(|| record.game.own_end(robot.id.team));
        let row = |about: &str, at: Vec2, covariance: [f32; 3], age_s: f32| {
            let in_pitch = own_end.map(|own_end| point_pitch_from_team(at, own_end));
            Self {
                cycle: record.cycle as i64,
                time_s: record.time_s,
                robot: robot.id.to_string(),
                about: about.to_owned(),
                id: None,
                x_m: at.x,
                y_m: at.y,
                heading_deg: None,
                pitch_x_m: in_pitch.map(|at| at.x),
                pitch_y_m: in_pitch.map(|at| at.y),
                pitch_heading_deg: None,
                vx_mps: None,
                vy_mps: None,
                variance_xx: covariance[0],
                covariance_xy: covariance[1],
                variance_yy: covariance[2],
                heading_sd_deg: None,
                age_s,
                heard_from: None,
            }
        };
        let Pose { position, heading } = belief.pose;
        let [xx, xy, yy, .., variance] = belief.pose_covariance;
        let mut rows = vec![Self {
            heading_deg: Some(to_degrees(heading)),
            pitch_heading_deg: own_end.map(|own_end| to_degrees(belief.pose_in_pitch(own_end).heading)),
            heading_sd_deg: Some(to_degrees(variance.max(0.0).sqrt())),
            ..row("self", position, [xx, xy, yy], belief.pose_age_s)
        }];
        rows.extend(belief.ball.map(|ball| Self {
            vx_mps: Some(ball.velocity_mps.x),
            vy_mps: Some(ball.velocity_mps.y),
            heard_from: ball.heard_from.map(|id| id.to_string()),
            ..row("ball", ball.position_m, ball.position_covariance, ball.age_s)
        }));
        let robot = |about, robot: &RobotBelief| Self {
            id: robot.id.map(|id| id.to_string()),
            ..row(about, robot.position_m, robot.covariance, robot.age_s)
        };
        rows.extend(belief.team_mates.iter().map(|mate| robot("team_mate", mate)));
        rows.extend(belief.opponents.iter().map(|opponent| robot("opponent", opponent)));
        rows
    }
}

impl EventRow {
    pub(super) fn new(record: &CycleRecord, event: &MatchEvent) -> Self {
        let value = serde_json::to_value(event).unwrap_or_default();
        let text = |name: &str| value.get(name).and_then(Value::as_str).map(str::to_owned);
        Self {
            cycle: record.cycle as i64,
            time_s: record.time_s,
            kind: text("kind").unwrap_or_default(),
            robot: text("robot"),
            team: text("team"),
            json: value.to_string(),
        }
    }
}

impl MessageRow {
    pub(super) fn all(record: &CycleRecord, robot: &RobotRecord) -> impl Iterator<Item = Self> {
        robot.inbox.iter().map(|ReceivedMessage { from, sent_cycle, say }| Self {
            cycle: record.cycle as i64,
            time_s: record.time_s,
            robot: robot.id.to_string(),
            from: from.to_string(),
            sent_cycle: *sent_cycle as i64,
            x_m: say.pose.map(|pose| pose.position.x),
            y_m: say.pose.map(|pose| pose.position.y),
            heading_deg: say.pose.map(|pose| to_degrees(pose.heading)),
            ball_x_m: say.ball_m.map(|ball| ball.x),
            ball_y_m: say.ball_m.map(|ball| ball.y),
            intention: say.intention.as_ref().map(|intention| intention.clone().into_owned()),
            json: json(say),
        })
    }
}
