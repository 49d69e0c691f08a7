//! Makes the entities and resources of a scenario.

use bevy::prelude::*;

use super::names;
use super::sensors::{SensorRecord, SensorRegistry};
use crate::scenario::wording::one_of;
use crate::scenario::{BallSpec, BehaviourSpec, FieldPath, RobotSpec, Scenario, ScenarioFault, TeamsSpec};
use naoisis_core::ball::{Ball, BallPath, BallVelocity, ExtraBall};
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::script::Script;
use naoisis_core::behaviour::{BehaviourRegistry, Policy, PolicyReader, Program, REMOTE};
use naoisis_core::communication::{Inbox, MessageStatistics, MessagesInFlight, Outbox};
use naoisis_core::cycle::{CycleClock, PendingHalf};
use naoisis_core::events::Contacts;
use naoisis_core::events::{CycleEvents, StampedEvent};
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::{Pose, wrap_angle};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{Pitch, Post};
use naoisis_core::random::{BehaviourRandom, RandomStreams};
use naoisis_core::referee;
use naoisis_core::referee::placing::{LineUp, Occupied};
use naoisis_core::referee::removal::waiting_pose;
use naoisis_core::robot::head::{HeadAngles, HeadCommand};
use naoisis_core::robot::kick::{KickCommand, KickPhase};
use naoisis_core::robot::motion::{ExecutedStep, WalkCommand};
use naoisis_core::robot::posture::Posture;
use naoisis_core::robot::{PreviousPose, Roster, Velocity};
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::localisation_method::LocalisationMethod;
use naoisis_sensing::belief::{Belief, SimpleBelief, team_from_pitch};
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::sonar::SonarReading;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;

/// Marks the entities of a match: robots, ball and posts.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[reflect(Component, @Knowledge::Truth)]
pub struct MatchEntity;

/// Despawns the entities of the match.
pub(super) fn despawn_match(world: &mut World) {
    let mut entities = world.query_filtered::<Entity, With<MatchEntity>>();
    let entities: Vec<Entity> = entities.iter(world).collect();
    for entity in entities {
        world.despawn(entity);
    }
}

/// Returns a component of the ball.
pub(super) fn ball_component<C: Component + Clone>(world: &World) -> Option<C> {
    let mut balls = world.try_query_filtered::<&C, With<Ball>>()?;
    balls.iter(world).next().cloned()
}

/// Replaces the match in the world by a new match of the scenario.
///
/// # Errors
/// [`ScenarioFault`] if the scenario contradicts itself, names a behaviour or team that is not registered, or needs camera images that
/// cannot be rendered here. The world is unchanged then.
pub fn start(world: &mut World, scenario: &Scenario) -> Result<(), ScenarioFault> {
    scenario.validate()?;
    let robots = robots_of(world, scenario)?;
    scenario.settings.cameras.render.make_ready(world)?;
    despawn_match(world);
    world.insert_resource(scenario.field.clone());
    world.insert_resource(scenario.rules.clone());
    world.insert_resource(scenario.messages.clone());
    world.insert_resource(MessagesInFlight::default());
    world.insert_resource(MessageStatistics::default());
    world.insert_resource(clock_of(scenario));
    world.insert_resource(PendingHalf::default());
    referee::start(world, &clock_of(scenario), &scenario.rules, scenario.seed, &scenario.interventions);
    world.insert_resource(CycleEvents::default());
    world.resource_mut::<Messages<StampedEvent>>().clear();
    world.insert_resource(Contacts::default());
    spawn_posts(world, scenario);
    spawn_balls(world, scenario);
    world.resource_scope(|world, sensors: Mut<SensorRegistry>| {
        for robot in &robots {
            let mut entity = spawn_robot(world, scenario, robot);
            sensors.equip(&mut entity, scenario, robot);
        }
    });
    world.insert_resource(scenario.clone());
    Ok(())
}

/// Returns the scenario with a list of all robots, including those of teams.
pub fn resolved(world: &World, scenario: &Scenario) -> Scenario {
    match robots_of(world, scenario) {
        Ok(robots) => Scenario { robots, teams: None, ..scenario.clone() },
        Err(_) => scenario.clone(),
    }
}

/// Returns the robots of the scenario, including those of its teams, at their places at the start and ordered by id. All of their behaviours are
/// registered.
pub(super) fn robots_of(world: &World, scenario: &Scenario) -> Result<Vec<RobotSpec>, ScenarioFault> {
    let registry = world.resource::<BehaviourRegistry>();
    if let Some(fault) = names::unknown(world, scenario).into_iter().next() {
        return Err(fault);
    }
    let mut robots = scenario.robots.clone();
    if let Some(teams) = &scenario.teams {
        let game = Game::at_start(&scenario.rules, &clock_of(scenario));
        let mut line_up = scenario.line_up(&game, game.kick_off(), scenario.ball.map(|ball| ball.place_m()));
        robots.extend(team_of(scenario, registry, Team::Blue, teams, &mut line_up)?);
        robots.extend(team_of(scenario, registry, Team::Pink, teams, &mut line_up)?);
    }
    robots.sort_by_key(RobotSpec::id);
    seat_substitutes(scenario, &mut robots);
    for robot in &mut robots {
        // Headings have the range of files.
        robot.pose.heading = wrap_angle(robot.pose.heading);
    }
    Ok(robots)
}

/// Places the substitutes beside the pitch.
fn seat_substitutes(scenario: &Scenario, robots: &mut [RobotSpec]) {
    let Scenario { field, rules, .. } = scenario;
    let game = Game::at_start(rules, &clock_of(scenario));
    let mut seated = Occupied::by_posts(field, &[], None);
    for robot in robots.iter().filter(|robot| !robot.substitute) {
        seated.add_robot(robot.pose, &scenario.body_of(robot));
    }
    for robot in robots.iter_mut().filter(|robot| robot.substitute) {
        let (body, own_end) = (scenario.body_of(robot), game.own_end(robot.team));
        robot.pose = waiting_pose(field, rules.return_place, own_end, Vec2::ZERO, &body, &seated);
        seated.add_robot(robot.pose, &body);
    }
}

/// Returns the robots of a team at their places at the start.
fn team_of(
    scenario: &Scenario,
    registry: &BehaviourRegistry,
    team: Team,
    teams: &TeamsSpec,
    line_up: &mut LineUp,
) -> Result<Vec<RobotSpec>, ScenarioFault> {
    let (size, name) = (scenario.rules.team_size, teams.name(team));
    let numbers = 1..=size + scenario.rules.substitutes;
    let mut spec_of = |number, behaviour| {
        let robot = teams.robot(team, number);
        let substitute = number > size;
        let pose = if substitute { Pose::default() } else { line_up.put_down(robot.id(), &scenario.body_of(&robot)) };
        RobotSpec { pose, behaviour, substitute, ..robot }
    };
    if let Some(Some(words)) = TeamsSpec::command_line(name) {
        return Ok(numbers.map(|number| spec_of(number, BehaviourSpec::Program(words.clone()))).collect());
    }
    if let Some(file) = TeamsSpec::policy(name) {
        return Ok(numbers.map(|number| spec_of(number, BehaviourSpec::Policy(file.to_owned()))).collect());
    }
    if name == REMOTE {
        return Ok(numbers.map(|number| spec_of(number, BehaviourSpec::Named(REMOTE.to_owned()))).collect());
    }
    let Some(recipe) = registry.team(name) else {
        return Err(names::no_team(registry, &FieldPath::default().field("teams").field(team.name()), name));
    };
    for number in 1..=size {
        let behaviour = recipe.behaviour_of(number, size);
        if registry.marker_of(&behaviour).is_none() {
            return Err(ScenarioFault::new(
                FieldPath::default().field("teams").field(team.name()),
                format!("player {number} of the team `{name}` has the behaviour `{behaviour}`, which there is not"),
                format!("a team whose players have some of {}", one_of(registry.behaviour_names())),
            ));
        }
    }
    // Substitutes have the behaviour of the last player.
    let named = |number: u8| BehaviourSpec::Named(recipe.behaviour_of(number.min(size), size).into_owned());
    Ok(numbers.map(|number| spec_of(number, named(number))).collect())
}

fn clock_of(scenario: &Scenario) -> CycleClock {
    CycleClock { cycle: 0, period_s: scenario.cycle_s }
}

fn spawn_posts(world: &mut World, scenario: &Scenario) {
    for post in Pitch::goal_posts(&scenario.field) {
        world.spawn((MatchEntity, Pose { position: post.position, heading: 0.0 }, Post::from(post)));
    }
    for post in &scenario.posts {
        world.spawn((
            MatchEntity,
            Pose { position: post.position_m, heading: 0.0 },
            Post { radius: post.radius_m, height: post.height_m, colour: None },
        ));
    }
}

fn spawn_balls(world: &mut World, scenario: &Scenario) {
    for (number, ball) in (0..).zip(scenario.balls()) {
        let pose = Pose { position: ball.place_m(), heading: 0.0 };
        let parts = (
            MatchEntity,
            pose,
            PreviousPose(pose),
            BallVelocity(ball.velocity_mps.truncate()),
            ball.start_flight(),
            ball.physics(),
            BallPath::default(),
        );
        if number == 0 {
            world.spawn((Ball, parts))
        } else {
            world.spawn((ExtraBall(number), parts))
        };
    }
}

fn spawn_robot<'w>(world: &'w mut World, scenario: &Scenario, robot: &RobotSpec) -> EntityWorldMut<'w> {
    let id = robot.id();
    let [yaw, pitch] = robot.head_angles;
    let mut entity = world.spawn((
        MatchEntity,
        id,
        scenario.settings_of(robot).components(),
        (robot.pose, PreviousPose(robot.pose), Velocity::default()),
        (WalkCommand::default(), ExecutedStep::default()),
        (HeadAngles { yaw, pitch }, HeadCommand { yaw, pitch }),
        (KickCommand::default(), KickPhase::default()),
        (SonarReading::default(), Percepts::default(), Odometry::default(), BodyStatus::default()),
        (Outbox::default(), Inbox::default(), Drawings::default(), SensorRecord::default()),
        RandomStreams::new(scenario.seed, id),
        if robot.substitute { Penalty::SUBSTITUTE } else { Penalty::default() },
    ));
    if let Some(on) = robot.lies_on {
        entity.insert(Posture::fallen(on));
    }
    give_behaviour(&mut entity, scenario, robot);
    entity
}

/// Gives a robot its behaviour and, if it has the built-in belief, a belief that begins at the robot's pose.
pub(super) fn give_behaviour(entity: &mut EntityWorldMut, scenario: &Scenario, robot: &RobotSpec) {
    match &robot.behaviour {
        BehaviourSpec::Script(entries) => {
            entity.insert(Script(entries.clone()));
        }
        BehaviourSpec::Program(words) => {
            entity.insert(Program(words.clone()));
        }
        BehaviourSpec::Policy(file) => {
            entity.insert((Policy(file.clone()), BehaviourRandom::new(scenario.seed, robot.id())));
            if PolicyReader::read(entity.world(), robot.team, file).is_ok_and(|needs| needs.belief) {
                entity.insert(SimpleBelief::default());
                let localisation = robot.own.localisation.unwrap_or(scenario.settings.localisation);
                begin_belief(entity, robot.pose, localisation, ball_in(scenario));
            }
        }
        BehaviourSpec::Named(name) => {
            let marker = entity.world().resource::<BehaviourRegistry>().marker_of(name);
            if let Some(insert) = marker {
                insert(entity);
            }
            if entity.contains::<BehaviourRandom>() {
                entity.insert(BehaviourRandom::new(scenario.seed, robot.id()));
            }
            let localisation = robot.own.localisation.unwrap_or(scenario.settings.localisation);
            begin_belief(entity, robot.pose, localisation, ball_in(scenario));
        }
    }
}

/// Initialises the belief of a robot, if it has one, and its localisation. The robot knows its initial pose, because its team places it
/// there.
fn begin_belief(robot: &mut EntityWorldMut, pose: Pose, localisation: LocalisationMethod, ball: BallSpec) {
    let Some(id) = robot.get::<RobotId>().copied() else { return };
    if robot.contains::<Belief>() {
        let own_end = robot.world().resource::<Game>().own_end(id.team);
        robot.insert(Belief::at(team_from_pitch(pose, own_end)));
    }
    if let Some(mut belief) = robot.get_mut::<SimpleBelief>() {
        belief.localisation = localisation;
        (belief.ball.radius_m, belief.ball.rolling) = (ball.radius_m, ball.rolling);
    }
}

/// Returns the ball of a scenario, whose size and rolling are known to all robots.
fn ball_in(scenario: &Scenario) -> BallSpec {
    scenario.ball.unwrap_or_default()
}

/// Gives a robot the built-in belief, if it has none. The belief begins at the robot's pose. Returns whether there is such a robot.
pub fn give_belief(world: &mut World, id: RobotId) -> bool {
    let Some(entity) = world.resource::<Roster>().get(id) else { return false };
    let scenario = world.resource::<Scenario>();
    let own = scenario.robots.iter().find(|robot| robot.id() == id).and_then(|robot| robot.own.localisation);
    let localisation = own.unwrap_or(scenario.settings.localisation);
    let ball = ball_in(scenario);
    let mut robot = world.entity_mut(entity);
    if !robot.contains::<SimpleBelief>() {
        let pose = robot.get::<Pose>().copied().unwrap_or_default();
        robot.insert(SimpleBelief::default());
        begin_belief(&mut robot, pose, localisation, ball);
    }
    true
}
