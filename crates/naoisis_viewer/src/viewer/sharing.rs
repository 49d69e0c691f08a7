//! Makes something of the match for others: the command that opens a moment, a picture, a web page.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};
use bevy_egui::egui::ColorImage;
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::commands::Share;
use super::interaction::saved_files::{keep, save_page, trace_of};
use super::shared::{KeysSystems, Notice, OpenedTrace, Selection};
use super::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::team::RobotId;

/// Performs [`Share`].
pub struct SharingPlugin;

impl Plugin for SharingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Copied>()
            .add_message::<Share>()
            .add_systems(Update, share.after(KeysSystems))
            .add_systems(EguiPrimaryContextPass, copy);
    }
}

/// What the next frame puts into the clipboard.
#[derive(Resource, Default)]
struct Copied {
    text: Option<String>,
    picture: Option<ColorImage>,
}

fn share(world: &mut World) {
    let wanted: Vec<Share> = world.resource_mut::<Messages<Share>>().drain().collect();
    for share in wanted {
        let told = match share {
            Share::Link => copy_link(world),
            Share::Page => save_page(world).map(|path| format!("Writing {}", path.display())),
            Share::Picture => {
                world.spawn(Screenshot::primary_window()).observe(copy_picture);
                continue;
            }
        };
        let told = told.unwrap_or_else(|message| format!("Not shared: {message}"));
        world.resource_mut::<Notice>().tell(told);
    }
}

/// Copies the command for the moment that is shown. A live match is saved first, because the command opens its trace.
fn copy_link(world: &mut World) -> Result<String, String> {
    let trace = match &world.resource::<OpenedTrace>().0 {
        Some(trace) if world.resource::<Timeline>().is_replay() => trace.clone(),
        _ => trace_of(&keep(world)?),
    };
    let time_s = world.resource::<CycleClock>().end_time_s();
    let path = std::path::absolute(&trace).unwrap_or(trace);
    let link = link(&path.to_string_lossy(), time_s, world.resource::<Selection>().0);
    world.resource_mut::<Copied>().text = Some(link.clone());
    Ok(format!("Copied: {link}"))
}

/// The command that shows a trace at a time, with a robot selected.
fn link(trace: &str, time_s: f64, robot: Option<RobotId>) -> String {
    let trace = shlex::try_quote(trace).unwrap_or(trace.into());
    let robot = robot.map(|robot| format!(" --select {robot}")).unwrap_or_default();
    format!("naoisis replay {trace} --at {time_s:.3}{robot}")
}

fn copy_picture(captured: On<ScreenshotCaptured>, mut copied: ResMut<Copied>, mut notice: ResMut<Notice>) {
    let Ok(picture) = captured.image.clone().try_into_dynamic() else { return };
    let picture = picture.into_rgba8();
    let size = [picture.width() as usize, picture.height() as usize];
    copied.picture = Some(ColorImage::from_rgba_unmultiplied(size, &picture));
    notice.tell("The picture is in the clipboard");
}

fn copy(mut contexts: EguiContexts, mut copied: ResMut<Copied>) -> Result {
    let context = contexts.ctx_mut()?;
    if copied.text.is_some() || copied.picture.is_some() {
        let Copied { text, picture } = core::mem::take(&mut *copied);
        text.into_iter().for_each(|text| context.copy_text(text));
        picture.into_iter().for_each(|picture| context.copy_image(picture));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    #[test]
    fn a_link_is_a_command_for_any_shell_like_bash() {
        let robot = Some(RobotId::new(Team::Blue, 1));
        assert_eq!(link("/a/m.jsonl", 12.0, robot), "naoisis replay /a/m.jsonl --at 12.000 --select blue1");
        // Cycles may be shorter than a hundredth of a second.
        assert_eq!(link("/a b/it's", 0.034, None), "naoisis replay \"/a b/it's\" --at 0.034");
    }
}
