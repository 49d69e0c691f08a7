//! The widgets of the panels by role and name, from the tree that egui makes for screen readers.
//!
//! The tree is only made when the state of the window is reported.

use bevy::prelude::*;
use bevy_egui::egui::accesskit::{Action, Node, NodeId, Role, Toggled, TreeUpdate};
use bevy_egui::{EguiContext, EguiOutput};
use core::cmp::Ordering;
use serde::Serialize;
use std::collections::BTreeMap;

/// Keeps a list of the widgets of the panels.
pub struct WidgetsPlugin;

impl Plugin for WidgetsPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Widgets>()
            .add_systems(Update, make_tree.in_set(WidgetsSystems))
            .add_systems(Last, list_widgets.in_set(WidgetsSystems));
    }
}

/// The systems that list widgets. They only run while the state is reported.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct WidgetsSystems;

/// The widgets of the visible panels, from top to bottom.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct Widgets(pub Vec<Widget>);

/// A widget.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Widget {
    /// Its role: `Button`, `CheckBox`, `ComboBox`, `Slider`, `SpinButton`, `TextInput`.
    pub role: String,
    /// Its text, or the label beside it.
    pub name: String,
    /// Its value, if any: `true` or `false` of boxes and entries of lists, the text, a number.
    pub value: Option<String>,
    /// Its left, upper, right and lower edge in the window, logical pixels.
    pub edges: [f64; 4],
}

fn make_tree(mut contexts: Query<&mut EguiContext, Added<EguiContext>>) {
    for mut context in &mut contexts {
        context.get_mut().enable_accesskit();
    }
}

fn list_widgets(outputs: Query<&EguiOutput>, windows: Query<&Window>, mut widgets: ResMut<Widgets>) {
    let scale = windows.iter().next().map_or(1.0, Window::scale_factor);
    let of_output = |output: &EguiOutput| {
        let tree = output.platform_output.accesskit_update.as_ref();
        tree.map(|tree| widgets_of(tree, f64::from(output.pixels_per_point / scale)))
    };
    widgets.0 = outputs.iter().filter_map(of_output).flatten().collect();
}

/// The widgets of a tree; `scale` converts pixels of the panels to those of the window.
fn widgets_of(tree: &TreeUpdate, scale: f64) -> Vec<Widget> {
    let nodes: BTreeMap<NodeId, &Node> = tree.nodes.iter().map(|(id, node)| (*id, node)).collect();
    let name_of = |node: &Node| {
        let beside = || node.labelled_by().iter().find_map(|id| nodes.get(id)?.value());
        node.label().filter(|words| !words.is_empty()).or_else(beside).map(str::to_owned)
    };
    // Texts can be clicked, too, to copy them, but they are not operable.
    let is_operable = |node: &Node| {
        let is_reached = [Action::Click, Action::SetValue].into_iter().any(|action| node.supports_action(action));
        is_reached && !node.is_disabled() && node.role() != Role::Label
    };
    let widget_of = |node: &Node| {
        let bounds = node.bounds()?;
        let toggled = node.toggled().map(|toggled| (toggled == Toggled::True).to_string());
        Some(Widget {
            role: format!("{:?}", node.role()),
            name: name_of(node)?,
            value: toggled
                .or_else(|| node.value().map(str::to_owned))
                .or_else(|| node.numeric_value().map(|value| value.to_string())),
            edges: [bounds.x0, bounds.y0, bounds.x1, bounds.y1].map(|edge| edge * scale),
        })
    };
    let mut found: Vec<Widget> =
        nodes.values().copied().filter(|node| is_operable(node)).filter_map(widget_of).collect();
    let place = |widget: &Widget| (widget.edges[1], widget.edges[0]);
    found.sort_by(|one, other| place(one).partial_cmp(&place(other)).unwrap_or(Ordering::Equal));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::{self, Button, ComboBox, RawInput, Slider};

    fn shown(show: impl FnMut(&mut egui::Ui)) -> Vec<Widget> {
        let context = egui::Context::default();
        context.enable_accesskit();
        let mut output = context.run_ui(RawInput::default(), show);
        output.textures_delta.clear();
        widgets_of(&output.platform_output.accesskit_update.expect("a tree"), 2.0)
    }

    fn names_and_values(widgets: &[Widget]) -> Vec<(&str, Option<&str>)> {
        widgets.iter().map(|widget| (widget.name.as_str(), widget.value.as_deref())).collect()
    }

    #[test]
    fn what_can_be_operated_is_found_by_its_words() {
        let (mut on, mut share) = (true, 0.25);
        let widgets = shown(|ui| {
            ui.label("not a thing to press");
            let _pressed = ui.button("Open");
            ui.checkbox(&mut on, "Areas");
            ui.add_enabled(false, Button::new("Close"));
            ui.add(Slider::new(&mut share, 0.0..=1.0).text("Lost"));
        });
        let expected = [("Open", None), ("Areas", Some("true")), ("Lost", Some("0.25"))];
        // The number of a slider can be typed, so it is a widget of its own.
        let widgets: Vec<Widget> = widgets.into_iter().filter(|widget| widget.role != "SpinButton").collect();
        assert_eq!(names_and_values(&widgets), expected);
    }

    #[test]
    fn a_list_is_found_by_the_words_beside_it() {
        let widgets = shown(|ui| {
            let label = ui.label("Blue").id;
            ComboBox::from_id_salt("blue").selected_text("roles").show_ui(ui, |_| ()).response.labelled_by(label);
        });
        assert_eq!(names_and_values(&widgets), [("Blue", Some("roles"))]);
    }

    #[test]
    fn edges_are_pixels_of_the_window() {
        let mut edges = egui::Rect::NOTHING;
        let widgets = shown(|ui| edges = ui.button("Open").rect);
        let [left, _, right, _] = widgets[0].edges;
        assert!((right - left - 2.0 * f64::from(edges.width())).abs() < 1e-3, "{widgets:?}");
    }
}
