//! Builds the stage of a moment, with the looks of its match, and lists the objects on it.

use bevy::math::{Affine3A, Mat3, Quat, Vec2, Vec3};

use super::looks::{MatchLooks, TeamLook, direction};
use super::moments::Moment;
use super::names::Class;
use super::surroundings;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::look::{Rgb, TeamLimbs};
use naoisis_sensing::appearance::Label;
use naoisis_sensing::appearance::colours::{self, Colour};
use naoisis_sensing::appearance::field::{self, GroundMark, GroundShape};
use naoisis_sensing::appearance::posing::{Limb, on_side};
use naoisis_sensing::appearance::robot::{RobotDesign, labels};
use naoisis_sensing::appearance::scene::{Scene, SceneRobot};
use naoisis_sensing::appearance::shapes::{Part, Shape};
use naoisis_sensing::sensing::camera::software::light::Light;
use naoisis_sensing::sensing::camera::software::stage::{Stage, StageBody};

/// An object on a stage.
#[derive(Clone, PartialEq, Debug)]
pub struct Object {
    /// The number that marks the object's pixels.
    pub number: u8,
    /// The label of the object's pixels in a mask.
    pub label: Label,
    /// The class of the object. `None` if it is not labelled.
    pub class: Option<Class>,
    /// Its name in the metadata.
    pub name: String,
    /// Position of the object, m, pitch frame.
    pub place: Vec3,
    /// The key points of a robot, m, pitch frame. Empty for other objects.
    pub keypoints: Vec<Vec3>,
}

/// The things and people beside the pitch of a match.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Surroundings {
    things: Vec<Part<()>>,
    people: Vec<(Vec2, Vec<Part<()>>)>,
}

impl Surroundings {
    /// Draws the surroundings of a pitch.
    pub fn draw(pitch: &Pitch, looks: &MatchLooks, stream: &mut RandomStream) -> Self {
        let things = surroundings::things(pitch, looks, stream);
        Self { things, people: surroundings::people(pitch, looks, stream) }
    }
}

/// A stage that is being built, with the objects on it.
struct Builder {
    stage: Stage,
    objects: Vec<Object>,
}

impl Builder {
    /// The smallest number of an object: lower numbers are labels of the ground.
    const FIRST: u8 = Label::Ball as u8;

    fn add(
        &mut self,
        label: Label,
        class: Option<Class>,
        name: String,
        place: Vec3,
        parts: Vec<Part<()>>,
    ) -> Option<&mut Object> {
        let number = self.objects.last().map_or(Self::FIRST, |object| object.number + 1);
        if number > Stage::MOST_BODIES {
            return None;
        }
        self.stage.bodies.push(StageBody { number, parts, ..StageBody::default() });
        self.objects.push(Object { number, label, class, name, place, keypoints: Vec::new() });
        self.objects.last_mut()
    }
}

/// Returns the stage of a moment with these looks, and the objects on it in the order of its bodies.
pub fn staged(
    moment: &Moment,
    looks: &MatchLooks,
    surroundings: &Surroundings,
    stream: &mut RandomStream,
) -> (Stage, Vec<Object>) {
    let scene = &moment.scene;
    let pitch = Pitch { line_width_m: looks.line_width_m, ..scene.pitch.clone() };
    let stage = Stage {
        light: Light {
            sun: looks.sun,
            from_sun: looks.from_sun,
            ambient: looks.ambient,
            gradient: Light::default().gradient,
            in_shadow: (256.0 * looks.in_shadow) as u32,
        },
        sky: Colour(looks.wall),
        floor: Colour(looks.floor),
        ground: ground(&pitch, looks),
        net: Colour(looks.net),
        nets: End::BOTH.map(|end| field::net_strings(&pitch, end)).to_vec(),
        bodies: Vec::new(),
    };
    let mut builder = Builder { stage, objects: Vec::new() };
    builder.add(Label::Clutter, None, "things".to_owned(), Vec3::ZERO, surroundings.things.clone());
    add_goals(&mut builder, scene, &pitch, looks);
    for (ball, number) in scene.balls().zip(1..) {
        let name = if number == 1 { "ball".to_owned() } else { format!("ball_{number}") };
        let turn = Mat3::from_quat(
            Quat::from_rotation_arc(Vec3::Z, direction(stream)) * Quat::from_rotation_arc(Vec3::X, direction(stream)),
        );
        let shape = Shape::sphere(ball.radius);
        let part = Part {
            frame_from_shape: Affine3A::from_mat3_translation(turn, ball.centre()),
            ..Part::at((), Label::Ball, Colour(looks.ball.ground), shape, ball.centre())
        };
        builder.add(Label::Ball, Some(Class::Ball), name, ball.centre(), vec![part]);
        if let Some(body) = builder.stage.bodies.last_mut() {
            body.patches.clone_from(&looks.ball.patches);
        }
    }
    for robot in &scene.robots {
        add_robot(&mut builder, robot, &looks.teams[robot.id.team], moment, looks);
    }
    for (index, (place, parts)) in surroundings.people.iter().enumerate() {
        let name = format!("person{}", index + 1);
        builder.add(Label::Person, Some(Class::Person), name, place.extend(0.0), parts.clone());
    }
    (builder.stage, builder.objects)
}

/// Returns the markings of the carpet, and those of another carpet beside it if there is one.
fn ground(pitch: &Pitch, looks: &MatchLooks) -> Vec<GroundMark> {
    let own = field::ground(pitch).into_iter().map(|mark| {
        let colour = if mark.label == Label::Line { looks.line } else { looks.turf };
        GroundMark { colour: Colour(colour), ..mark }
    });
    let own: Vec<GroundMark> = own.collect();
    if !looks.has_neighbour {
        return own;
    }
    let away = Vec2::Y * (2.0 * pitch.carpet_half_extents().y + 1.0);
    let moved = |mark: &GroundMark| GroundMark {
        shape: match mark.shape {
            GroundShape::Quadrilateral(corners) => GroundShape::Quadrilateral(corners.map(|corner| corner + away)),
            GroundShape::Ring { centre, inner, outer } => GroundShape::Ring { centre: centre + away, inner, outer },
        },
        ..*mark
    };
    own.iter().map(moved).chain(own.iter().copied()).collect()
}

fn recoloured(parts: Vec<Part<()>>, recolour: impl Fn(&Part<()>) -> Rgb) -> Vec<Part<()>> {
    parts.into_iter().map(|part| Part { colour: Colour(recolour(&part)), ..part }).collect()
}

fn add_goals(builder: &mut Builder, scene: &Scene, pitch: &Pitch, looks: &MatchLooks) {
    for (index, end) in End::BOTH.into_iter().enumerate() {
        let label = field::goal_label(pitch.goal_colour(end));
        let (bar, frame): (Vec<_>, Vec<_>) =
            field::goal_frame(pitch, end).into_iter().partition(|part| part.label == label);
        let place = Vec3::new(end.sign() * pitch.goal_post_x(), 0.0, pitch.goal.height_m);
        let bar = recoloured(bar, |_| looks.goals[index]);
        builder.add(label, None, format!("bar of goal {}", index + 1), place, bar);
        builder.add(
            Label::GoalFrame,
            None,
            format!("frame of goal {}", index + 1),
            place,
            recoloured(frame, |_| looks.net),
        );
    }
    for (index, there) in scene.posts.iter().enumerate() {
        let is_of_goal = there.post.colour.is_some();
        let mut post = there.post;
        let mut place = there.position;
        if is_of_goal {
            // The inner edge stays where it is.
            let radius = looks.post_diameter_m / 2.0;
            place.y += place.y.signum() * (radius - post.radius);
            post.radius = radius;
        }
        let part = field::post(&post, place);
        let end = usize::from(place.x > 0.0);
        let colour = if is_of_goal { looks.goals[end] } else { colours::EXTRA_POST.0 };
        let class = is_of_goal.then_some(Class::GoalPost);
        let name = format!("post{}", index + 1);
        builder.add(part.label, class, name, place.extend(0.0), recoloured(vec![part], |_| colour));
    }
}

fn add_robot(builder: &mut Builder, robot: &SceneRobot, team: &TeamLook, moment: &Moment, looks: &MatchLooks) {
    let is_own = robot.id == moment.robot;
    if is_own && !looks.sees_itself {
        return;
    }
    let mut body = robot.body;
    if let Some(shell) = team.shell {
        body.look.shell = shell;
    }
    if team.limbs {
        body.look.team_limbs = TeamLimbs { head: false, arms: true, legs: true };
    }
    let limbs = robot.world_from_limbs();
    let [label, band] = labels(robot.id.team);
    let drawn = RobotDesign::Nao.parts(robot.id, &body);
    // The camera is inside its robot's head, so the head is left out.
    let parts = drawn.into_iter().filter(|part| !is_own || part.frame != Limb::Head).map(|part| {
        let is_team = part.label == band || part.colour == colours::worn(robot.id.team, robot.body.jersey);
        let is_shirt = team.shirts && part.frame == Limb::Trunk && part.colour == Colour(body.look.shell);
        let colour = if is_team || is_shirt { Colour(team.colour) } else { part.colour };
        let frame_from_shape = limbs[part.frame as usize] * part.frame_from_shape;
        Part { frame: (), label: part.label, colour, shape: part.shape, frame_from_shape }
    });
    let parts = parts.collect();
    let (class, name) =
        if is_own { (None, format!("{} itself", robot.id)) } else { (Some(Class::Robot), robot.id.to_string()) };
    let place = robot.pose.position.extend(0.0);
    if let Some(object) = builder.add(label, class, name, place, parts)
        && !is_own
    {
        object.keypoints = keypoints(robot, &limbs);
    }
}

/// Returns the key points of a robot with arms and legs. Empty for other robots.
fn keypoints(robot: &SceneRobot, limbs: &[Affine3A; Limb::COUNT]) -> Vec<Vec3> {
    let (Some(arms), Some(_)) = (robot.body.arms, robot.body.legs) else { return Vec::new() };
    let at = |limb: Limb, point: Vec3| limbs[limb as usize].transform_point3(point);
    let half_head = (robot.body.height_m - robot.body.neck_m.z) / 2.0;
    let mut points = vec![at(Limb::Head, Vec3::Z * half_head)];
    let hand = Vec3::new(0.2, 0.04, -0.86) * arms.length_m;
    let [left, right] = Limb::ARMS;
    points.extend([at(left, Vec3::ZERO), at(right, Vec3::ZERO)]);
    points.extend([at(left, on_side(hand, 0)), at(right, on_side(hand, 1))]);
    for [left, right] in [Limb::THIGHS, Limb::SHANKS, Limb::FEET] {
        points.extend([at(left, Vec3::ZERO), at(right, Vec3::ZERO)]);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::moments::{Cast, drawn};
    use crate::dataset::names::KEYPOINTS;
    use crate::dataset::ranges::Ranges;
    use bevy::prelude::*;
    use naoisis_core::pitch::GoalColour;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn each_object_has_a_number_of_its_own_and_teams_their_colours() {
        let scenario = Scenario::named("match3v3").unwrap();
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&scenario).unwrap();
        let cast = Cast::of(app.world(), &scenario);
        let mut stream = RandomStream::for_match(7, "test");
        let ranges = Ranges::read(None).unwrap();
        let looks = MatchLooks::draw(&ranges, [GoalColour::White; 2], &mut stream);
        let looks = MatchLooks { sees_itself: true, people: 60, ..looks };
        let empty = Scene::empty(Pitch::default());
        let surroundings = Surroundings::draw(&empty.pitch, &looks, &mut stream);
        for _ in 0..10 {
            let moment = drawn(&empty, &cast, &ranges, &mut stream).unwrap();
            let (stage, objects) = staged(&moment, &looks, &surroundings, &mut stream);
            assert_eq!(stage.bodies.len(), objects.len());
            for (index, (body, object)) in stage.bodies.iter().zip(&objects).enumerate() {
                assert_eq!((body.number, object.number), (4 + index as u8, 4 + index as u8));
                assert!(object.keypoints.is_empty() || object.keypoints.len() == KEYPOINTS.len());
            }
            let count = |class| objects.iter().filter(|object| object.class == Some(class)).count();
            assert_eq!((count(Class::GoalPost), count(Class::Person)), (4, 60));
            assert_eq!(count(Class::Robot), moment.scene.robots.len() - 1);
            let has = |colour: Rgb| {
                stage.bodies.iter().flat_map(|body| &body.parts).any(|part| part.colour == Colour(colour))
            };
            let teams: Vec<_> = moment.scene.robots.iter().map(|robot| robot.id.team).collect();
            assert!(teams.iter().all(|team| has(looks.teams[*team].colour)));
        }
    }
}
