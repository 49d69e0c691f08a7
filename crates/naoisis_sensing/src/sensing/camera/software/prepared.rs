//! A scene prepared for drawing, once for the pictures of all cameras.

use bevy::math::{Affine3A, Mat3, Vec3};
use core::ops::Range;

use super::frame::Frame;
use super::light::{Light, Paint};
use super::model::Model;
use super::stage::{PatchArea, Stage};
use crate::appearance::ball;
use crate::appearance::colours::Colour;
use crate::appearance::field::{self, GroundMark};
use crate::appearance::people;
use crate::appearance::posing::Limb;
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::{Scene, ScenePost};
use crate::appearance::view::View;
use crate::appearance::{Label, colours};
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::robot::body::Body as RobotBody;
use naoisis_core::team::RobotId;

/// The level of detail.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Detail {
    /// The design of robots.
    pub design: RobotDesign,
    /// Faces around a cylinder, at least 3.
    pub segments: usize,
}

impl Default for Detail {
    /// Sufficient for the robots' cameras.
    fn default() -> Self {
        Self { design: RobotDesign::Simple, segments: 12 }
    }
}

impl Detail {
    /// Sufficient for a poster.
    pub const FINE: Detail = Detail { design: RobotDesign::Nao, segments: 40 };
}

/// A corner of a face, pitch frame, and the light on the surface there.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Corner {
    pub(super) position: Vec3,
    pub(super) light: f32,
}

/// A flat convex face, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Face {
    pub(super) normal: Vec3,
    /// The distance of its plane from the origin, along the normal.
    pub(super) offset: f32,
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) paint: Paint,
    pub(super) is_flat: bool,
    /// The pixel of a flat face.
    pub(super) colour: u32,
}

/// An area of an ellipsoid with another paint, between two planes that are perpendicular to an axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Patch {
    pub(super) area: PatchArea,
    pub(super) paint: Paint,
}

impl Patch {
    #[inline(always)]
    pub(super) fn covers(&self, point: Vec3) -> bool {
        self.area.covers(point)
    }
}

/// An ellipsoid.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Round {
    pub(super) unit_from_world: Affine3A,
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) paint: Paint,
    /// Its patches, as a range of those of the scene.
    pub(super) patches: Range<usize>,
}

/// Faces and ellipsoids that are culled together.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Body {
    pub(super) owner: Option<RobotId>,
    /// Whether it may move.
    pub(super) moves: bool,
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) faces: Range<usize>,
    pub(super) rounds: Range<usize>,
}

impl Body {
    /// Whether it belongs to the robot whose camera takes the view.
    #[inline(always)]
    pub(super) fn is_hidden_from(&self, view: &View) -> bool {
        self.owner.is_some() && self.owner == view.hidden
    }
}

/// The net of a goal.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Net {
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) strings: Vec<[Vec3; 2]>,
}

/// The greatest distance of a point of a robot's limbs from the middle of its body, with an arm and a leg stretched out, as a multiple of
/// its height.
const ROBOT_REACH_IN_HEIGHTS: f32 = 0.733;

/// The static objects of a match, and their level of detail.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Still {
    detail: Detail,
    pitch: Pitch,
    posts: Vec<ScenePost>,
}

/// A scene prepared for drawing. It reuses its memory and models from cycle to cycle, so keep it.
pub struct PreparedScene {
    pub(super) still: Option<Still>,
    /// The numbers of static bodies, faces, corners and ellipsoids, which come first.
    still_counts: [usize; 4],
    robots: Vec<((RobotId, RobotBody), Model<Limb>)>,
    pub(super) ground: Vec<(GroundMark, u32)>,
    /// The unevenness of the carpet.
    pub(super) unevenness: f32,
    pub(super) nets: Vec<Net>,
    pub(super) bodies: Vec<Body>,
    pub(super) faces: Vec<Face>,
    pub(super) corners: Vec<Corner>,
    pub(super) rounds: Vec<Round>,
    pub(super) patches: Vec<Patch>,
    pub(super) light: Light,
    /// The pixels of the sky and of the floor.
    pub(super) backdrop: [u32; 2],
    pub(super) net_colour: Colour,
}

impl Default for PreparedScene {
    fn default() -> Self {
        Self {
            still: None,
            still_counts: [0; 4],
            robots: Vec::new(),
            ground: Vec::new(),
            unevenness: 0.0,
            nets: Vec::new(),
            bodies: Vec::new(),
            faces: Vec::new(),
            corners: Vec::new(),
            rounds: Vec::new(),
            patches: Vec::new(),
            light: Light::default(),
            backdrop: backdrop([colours::SKY, colours::FLOOR]),
            net_colour: colours::NET,
        }
    }
}

/// The pixels of the sky and of the floor.
fn backdrop([sky, floor]: [Colour; 2]) -> [u32; 2] {
    [Paint::new(sky, Label::Sky).full(), Paint::new(floor, Label::Floor).full()]
}

impl PreparedScene {
    /// Prepares a scene.
    pub fn prepare(&mut self, scene: &Scene, detail: Detail) {
        let detail = Detail { segments: detail.segments.max(3), ..detail };
        let is_same =
            |still: &Still| still.detail == detail && still.pitch == scene.pitch && still.posts == scene.posts;
        if !self.still.as_ref().is_some_and(is_same) {
            if self.still.as_ref().is_none_or(|still| still.detail != detail) {
                self.robots.clear();
            }
            self.lay_out(scene, detail);
        }
        let [bodies, faces, corners, rounds] = self.still_counts;
        self.bodies.truncate(bodies);
        self.faces.truncate(faces);
        self.corners.truncate(corners);
        self.rounds.truncate(rounds);
        self.patches.clear();

        // The models are moved out temporarily, so that the other fields can be written.
        let robots = core::mem::take(&mut self.robots);
        let mut unknown = Vec::new();
        for robot in &scene.robots {
            let middle = robot.world_from_robot().transform_point3(Vec3::Z * (robot.body.height_m / 2.0));
            let limbs = robot.world_from_limbs();
            let place = |limb: Limb| limbs[limb as usize];
            let reach = ROBOT_REACH_IN_HEIGHTS * robot.body.height_m;
            match robots.iter().find(|((id, body), _)| *id == robot.id && *body == robot.body) {
                Some((_, model)) => self.add(Some(robot.id), middle, reach, model, place),
                None => {
                    let model = Model::new(&detail.design.parts(robot.id, &robot.body), detail.segments);
                    self.add(Some(robot.id), middle, reach, &model, place);
                    unknown.push(((robot.id, robot.body), model));
                }
            }
        }
        self.robots = robots;
        self.robots.append(&mut unknown);

        for ball in scene.balls() {
            let (centre, reach) = (ball.centre(), ball.radius);
            let (face, round) = (self.faces.len(), self.rounds.len());
            let first = self.patches.len();
            let areas = ball::patches(ball.look).into_iter();
            self.patches.extend(areas.map(|area| Patch { area, paint: Paint::new(area.colour, Label::Ball) }));
            let patches = first..self.patches.len();
            // A plain ball is not turned, to avoid rounding.
            let turn = if patches.is_empty() { Mat3::IDENTITY } else { ball.turn() };
            self.rounds.push(Round {
                unit_from_world: Affine3A::from_mat3_translation(
                    turn * Mat3::from_diagonal(Vec3::splat(reach)),
                    centre,
                )
                .inverse(),
                centre,
                reach,
                paint: Paint::new(ball::ground(ball.look), Label::Ball),
                patches,
            });
            let (faces, rounds) = (face..face, round..round + 1);
            self.bodies.push(Body { owner: None, moves: true, centre, reach, faces, rounds });
        }
        for body in &mut self.bodies[bodies..] {
            body.moves = true;
        }
    }

    /// Prepares a stage, with `segments` faces around a cylinder. The number of each body is its label in the picture.
    pub fn prepare_stage(&mut self, stage: &Stage, segments: usize) {
        // A stage replaces the scene of a match, which is prepared from the beginning when it is drawn next.
        *self = Self::default();
        self.light = stage.light;
        self.backdrop = backdrop([stage.sky, stage.floor]);
        self.net_colour = stage.net;
        self.ground = stage.ground.iter().map(|mark| (*mark, Paint::new(mark.colour, mark.label).full())).collect();
        self.nets.extend(stage.nets.iter().map(|strings| {
            let [least, most] = bounds_of(strings.iter().flatten().copied());
            let (centre, reach) = ((least + most) / 2.0, (most - least).length() / 2.0);
            Net { centre, reach, strings: strings.clone() }
        }));
        for body in &stage.bodies {
            let mut model = Model::new(&body.parts, segments.max(3));
            let label = u32::from(body.number & Stage::MOST_BODIES) << 24;
            model.faces.iter_mut().for_each(|face| face.paint.label = label);
            model.rounds.iter_mut().for_each(|round| round.paint.label = label);
            let first = self.patches.len();
            self.patches.extend(body.patches.iter().map(|&area| {
                let paint = Paint { label, ..Paint::new(area.colour, Label::Ball) };
                Patch { area, paint }
            }));
            let round = self.rounds.len();
            self.add(None, Vec3::ZERO, 0.0, &model, |()| Affine3A::IDENTITY);
            for round in &mut self.rounds[round..] {
                round.patches = first..self.patches.len();
            }
            if let Some(mut body) = self.bodies.pop() {
                let [least, most] = self.bounds(&body);
                (body.centre, body.reach) = ((least + most) / 2.0, (most - least).length() / 2.0);
                self.bodies.push(body);
            }
        }
    }

    /// Prepares the static objects.
    fn lay_out(&mut self, scene: &Scene, detail: Detail) {
        (self.light, self.net_colour) = (Light::default(), colours::NET);
        self.backdrop = backdrop([colours::SKY, colours::FLOOR]);
        self.patches.clear();
        let pitch = &scene.pitch;
        self.unevenness = pitch.unevenness;
        self.ground =
            field::ground(pitch).into_iter().map(|mark| (mark, Paint::new(mark.colour, mark.label).full())).collect();
        self.nets.clear();
        self.bodies.clear();
        self.faces.clear();
        self.corners.clear();
        self.rounds.clear();
        let standing = |()| Affine3A::IDENTITY;
        for end in End::BOTH {
            let x = end.sign() * (pitch.goal_post_x() + pitch.goal.depth_m / 2.0);
            let centre = Vec3::new(x, 0.0, pitch.goal.height_m / 2.0);
            let size = Vec3::new(pitch.goal.depth_m, pitch.goal.width_m, pitch.goal.height_m);
            let reach = size.length() / 2.0 + 0.1;
            self.add(None, centre, reach, &Model::new(&field::goal_frame(pitch, end), detail.segments), standing);
            self.nets.push(Net { centre, reach, strings: field::net_strings(pitch, end) });
        }
        for ScenePost { post, position } in &scene.posts {
            let part = field::post(post, *position);
            let centre = part.frame_from_shape.translation.into();
            self.add(None, centre, part.shape.reach(), &Model::new(&[part], detail.segments), standing);
        }
        for person in people::people(pitch) {
            let reach = person.height / 2.0 + 0.2;
            let centre = person.place.extend(person.height / 2.0);
            self.add(None, centre, reach, &Model::new(&person.parts(), detail.segments), standing);
        }
        self.still_counts = [self.bodies.len(), self.faces.len(), self.corners.len(), self.rounds.len()];
        self.still = Some(Still { detail, pitch: pitch.clone(), posts: scene.posts.clone() });
    }

    fn add<F: Copy>(
        &mut self,
        owner: Option<RobotId>,
        centre: Vec3,
        reach: f32,
        model: &Model<F>,
        place: impl Fn(F) -> Affine3A,
    ) {
        let (first_face, first_round) = (self.faces.len(), self.rounds.len());
        let light = self.light;
        for face in &model.faces {
            let world_from_frame = place(face.frame);
            let first = self.corners.len() as u32;
            let corners = &model.corners[face.first as usize..(face.first + face.count) as usize];
            self.corners.extend(corners.iter().map(|corner| Corner {
                position: world_from_frame.transform_point3(corner.position),
                light: light.intensity(world_from_frame.transform_vector3(corner.normal)),
            }));
            let normal = world_from_frame.transform_vector3(face.normal);
            let corner = self.corners[first as usize];
            self.faces.push(Face {
                normal,
                offset: normal.dot(corner.position),
                first,
                count: face.count,
                paint: face.paint,
                is_flat: face.is_flat,
                colour: face.paint.lit(corner.light as u32),
            });
        }
        self.rounds.extend(model.rounds.iter().map(|round| {
            let world_from_unit = place(round.frame) * round.frame_from_unit;
            Round {
                unit_from_world: world_from_unit.inverse(),
                centre: world_from_unit.translation.into(),
                reach: round.reach,
                paint: round.paint,
                patches: 0..0,
            }
        }));
        let (faces, rounds) = (first_face..self.faces.len(), first_round..self.rounds.len());
        self.bodies.push(Body { owner, moves: false, centre, reach, faces, rounds });
    }

    /// The bounding box of a body, by its least and greatest corner, pitch frame.
    pub(super) fn bounds(&self, body: &Body) -> [Vec3; 2] {
        let faces = self.faces[body.faces.clone()].iter();
        let corners = faces.flat_map(|face| &self.corners[face.first as usize..(face.first + face.count) as usize]);
        let points = corners.map(|corner| [corner.position; 2]);
        let rounds = self.rounds[body.rounds.clone()].iter();
        let rounds = rounds.map(|round| [round.centre - round.reach, round.centre + round.reach]);
        points
            .chain(rounds)
            .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, most], [low, high]| [least.min(low), most.max(high)])
    }

    /// Collects the indices of the bodies to draw that may be in view, sorted by distance, nearest first, then by index.
    #[inline(always)]
    pub(super) fn nearest_first(&self, frame: &Frame, is_drawn: impl Fn(usize) -> bool, order: &mut Vec<(f32, usize)>) {
        order.clear();
        for (index, body) in self.bodies.iter().enumerate() {
            let centre = frame.to_camera(body.centre);
            if is_drawn(index) && frame.may_see(centre, body.reach) {
                order.push((centre.length_squared(), index));
            }
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}

/// The least and greatest corner of the bounding box of points.
fn bounds_of(points: impl Iterator<Item = Vec3>) -> [Vec3; 2] {
    points.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[least, most], point| [least.min(point), most.max(point)])
}
