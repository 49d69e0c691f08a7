//! Values of the robot panel that can be plotted by a click.

use bevy::prelude::*;
use bevy_egui::egui::Response;
use core::any::TypeId;

use crate::viewer::plots::catalogue::FieldList;
use crate::viewer::plots::field::KnownField;
use crate::viewer::plots::{PlotCommand, Plots, list};
use naoisis_core::robot::Velocity;
use naoisis_core::robot::head::HeadCommand;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::odometry::Odometry;

/// The fields of a robot that can be plotted, and the commands to plot them.
pub(super) struct Pins<'a, 'w> {
    pub robot: RobotId,
    pub plots: &'a Plots,
    pub fields: &'a FieldList,
    pub commands: &'a mut MessageWriter<'w, PlotCommand>,
}

impl Pins<'_, '_> {
    /// Makes a value plottable: the field with this name in this section. `before` is the name before it.
    pub fn offer(&mut self, value: Response, part: &str, name: &str, before: Option<&str>) {
        let (measured, component): (&[&str], Option<(TypeId, &str)>) = match (part, name.trim()) {
            ("senses", "Sonar") => (&["left_sonar", "right_sonar"], None),
            ("senses", "Head") => (&["head_yaw", "head_pitch"], None),
            ("senses", "Odometry") => (&[], Some((TypeId::of::<Odometry>(), ""))),
            ("senses", "True motion") => (&["speed"], Some((TypeId::of::<Velocity>(), ""))),
            ("belief", "error") if before == Some("Itself") => (&["own_place_error", "own_heading_error"], None),
            ("belief", "error") => (&["ball_error"], None),
            ("belief", "Itself") => (&[], Some((TypeId::of::<Belief>(), "pose"))),
            ("belief", "Ball") => (&[], Some((TypeId::of::<Belief>(), "ball"))),
            ("belief", "Opponents") => (&["opponent_error"], Some((TypeId::of::<Belief>(), "opponents"))),
            ("belief", "Team-mates") => (&[], Some((TypeId::of::<Belief>(), "team_mates"))),
            ("commands", "Walk") => (&["wanted_speed", "wanted_ahead", "wanted_left", "wanted_turn"], None),
            ("commands", "Head to") => (&[], Some((TypeId::of::<HeadCommand>(), ""))),
            _ => return,
        };
        let fields = self.fields.all().iter().filter(|known| measured.contains(&known.field.0.as_str()));
        let within = component.into_iter().flat_map(|(component, name)| self.fields.within(component, name));
        let fields: Vec<&KnownField> = fields.chain(within).collect();
        list::pinnable(value, &fields, self.plots, self.robot, self.commands);
    }

    /// Makes a value of a behaviour's component plottable.
    pub fn offer_field(&mut self, value: Response, component: TypeId, name: &str) {
        let fields: Vec<&KnownField> = self.fields.within(component, name).collect();
        list::pinnable(value, &fields, self.plots, self.robot, self.commands);
    }
}
