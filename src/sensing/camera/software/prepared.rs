//! A scene in the form in which it is drawn: once for the pictures of all cameras.

use bevy::math::{Affine3A, Vec3};
use core::ops::Range;

use super::frame::Frame;
use super::light::{self, Paint};
use super::model::Model;
use crate::appearance::field::{self, GroundMark};
use crate::appearance::posing::Limb;
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::Scene;
use crate::appearance::shapes::Part;
use crate::appearance::{Label, colours};
use crate::pitch::{End, Pitch};
use crate::team::RobotId;

/// How finely things are drawn.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Detail {
    /// How robots look.
    pub design: RobotDesign,
    /// Faces around a cylinder, at least 3.
    pub segments: usize,
}

impl Default for Detail {
    /// As is fine enough for the robots' cameras.
    fn default() -> Self {
        Self { design: RobotDesign::Simple, segments: 12 }
    }
}

impl Detail {
    /// As is fine enough for a poster.
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

/// An ellipsoid.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Round {
    pub(super) unit_from_world: Affine3A,
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) paint: Paint,
}

/// Things that are seen or not seen together.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Body {
    pub(super) owner: Option<RobotId>,
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) faces: Range<usize>,
    pub(super) rounds: Range<usize>,
}

/// The net of a goal.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Net {
    pub(super) centre: Vec3,
    pub(super) reach: f32,
    pub(super) strings: Vec<[Vec3; 2]>,
}

/// A robot's limbs reach no further than this from the middle of its body, m.
const ROBOT_REACH: f32 = 0.42;
/// Height of the middle of a robot's body, m.
const ROBOT_MIDDLE: f32 = 0.29;

/// A scene in the form in which it is drawn. It keeps its memory and its models, so keep it from cycle to cycle.
#[derive(Default)]
pub struct PreparedScene {
    pitch: Option<Pitch>,
    detail: Option<Detail>,
    robots: Vec<(RobotId, Model<Limb>)>,
    goals: Vec<(Vec3, f32, Model<()>)>,
    posts: Vec<(Part<()>, Model<()>)>,
    pub(super) ground: Vec<(GroundMark, u32)>,
    pub(super) nets: Vec<Net>,
    pub(super) bodies: Vec<Body>,
    pub(super) faces: Vec<Face>,
    pub(super) corners: Vec<Corner>,
    pub(super) rounds: Vec<Round>,
}

impl PreparedScene {
    /// Takes over what there is to draw.
    pub fn prepare(&mut self, scene: &Scene, detail: Detail) {
        let detail = Detail { segments: detail.segments.max(3), ..detail };
        if self.detail != Some(detail) {
            self.detail = Some(detail);
            self.robots.clear();
            self.posts.clear();
            self.pitch = None;
        }
        if self.pitch.as_ref() != Some(&scene.pitch) {
            self.lay_out(&scene.pitch, detail);
            self.pitch = Some(scene.pitch.clone());
        }
        self.bodies.clear();
        self.faces.clear();
        self.corners.clear();
        self.rounds.clear();

        // The models are taken out for the time being, so that the rest can be written to.
        let robots = core::mem::take(&mut self.robots);
        let mut unknown = Vec::new();
        for robot in &scene.robots {
            let middle = robot.world_from_robot().transform_point3(Vec3::Z * ROBOT_MIDDLE);
            let limbs = robot.world_from_limbs();
            let place = |limb: Limb| limbs[limb as usize];
            match robots.iter().find(|(id, _)| *id == robot.id) {
                Some((_, model)) => self.add(Some(robot.id), middle, ROBOT_REACH, model, place),
                None => {
                    let model = Model::new(&detail.design.parts(robot.id), detail.segments);
                    self.add(Some(robot.id), middle, ROBOT_REACH, &model, place);
                    unknown.push((robot.id, model));
                }
            }
        }
        self.robots = robots;
        self.robots.append(&mut unknown);

        let standing = |()| Affine3A::IDENTITY;
        let goals = core::mem::take(&mut self.goals);
        for (centre, reach, model) in &goals {
            self.add(None, *centre, *reach, model, standing);
        }
        self.goals = goals;
        let parts = scene.posts.iter().map(|post| field::post(&post.post, post.position));
        if !self.posts.iter().map(|(part, _)| *part).eq(parts.clone()) {
            self.posts = parts.map(|part| (part, Model::new(&[part], detail.segments))).collect();
        }
        let posts = core::mem::take(&mut self.posts);
        for (part, model) in &posts {
            self.add(None, part.frame_from_shape.translation.into(), part.shape.reach(), model, standing);
        }
        self.posts = posts;
        if let Some(ball) = scene.ball {
            let (centre, radius) = (ball.centre(), ball.radius);
            let (first_face, first_round) = (self.faces.len(), self.rounds.len());
            self.rounds.push(Round {
                unit_from_world: Affine3A::from_scale_rotation_translation(
                    Vec3::splat(radius),
                    bevy::math::Quat::IDENTITY,
                    centre,
                )
                .inverse(),
                centre,
                reach: radius,
                paint: Paint::new(colours::BALL, Label::Ball),
            });
            self.bodies.push(Body {
                owner: None,
                centre,
                reach: radius,
                faces: first_face..first_face,
                rounds: first_round..first_round + 1,
            });
        }
    }

    /// What stays where it is as long as the pitch is the same.
    fn lay_out(&mut self, pitch: &Pitch, detail: Detail) {
        self.ground =
            field::ground(pitch).into_iter().map(|mark| (mark, Paint::new(mark.colour, mark.label).full())).collect();
        self.goals.clear();
        self.nets.clear();
        for end in End::BOTH {
            let x = end.sign() * (pitch.goal_post_x() + pitch.goal.depth_m / 2.0);
            let centre = Vec3::new(x, 0.0, pitch.goal.height_m / 2.0);
            let size = Vec3::new(pitch.goal.depth_m, pitch.goal.width_m, pitch.goal.height_m);
            let reach = size.length() / 2.0 + 0.1;
            self.goals.push((centre, reach, Model::new(&field::goal_frame(pitch, end), detail.segments)));
            self.nets.push(Net { centre, reach, strings: field::net_strings(pitch, end) });
        }
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
        for face in &model.faces {
            let world_from_frame = place(face.frame);
            let first = self.corners.len() as u32;
            let corners = &model.corners[face.first as usize..(face.first + face.count) as usize];
            self.corners.extend(corners.iter().map(|corner| Corner {
                position: world_from_frame.transform_point3(corner.position),
                light: light::intensity(world_from_frame.transform_vector3(corner.normal)),
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
            }
        }));
        let (faces, rounds) = (first_face..self.faces.len(), first_round..self.rounds.len());
        self.bodies.push(Body { owner, centre, reach, faces, rounds });
    }

    /// The bodies that may be in view, the nearest first, by index and distance.
    #[inline(always)]
    pub(super) fn nearest_first(&self, frame: &Frame, hidden: Option<RobotId>, order: &mut Vec<(f32, usize)>) {
        order.clear();
        for (index, body) in self.bodies.iter().enumerate() {
            let centre = frame.to_camera(body.centre);
            let is_hidden = hidden.is_some() && body.owner == hidden;
            if !is_hidden && frame.may_see(centre, body.reach) {
                order.push((centre.length_squared(), index));
            }
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }
}
