//! Code that the examples share: with `--view`, a match is shown in a window.

use bevy::prelude::*;
use core::error::Error;

/// With `--view` on the command line, shows the match of a scenario in a window. Returns whether it did; the example
/// then ends.
///
/// `prepare` adds what the scenario needs, such as behaviours; `begun` changes what a scenario cannot express.
pub fn view(json: &str, prepare: impl FnOnce(&mut App), begun: impl FnOnce(&mut App)) -> Result<bool, Box<dyn Error>> {
    if !std::env::args().any(|argument| argument == "--view") {
        return Ok(false);
    }
    show(json, prepare, begun)
}

#[cfg(feature = "viewer")]
fn show(json: &str, prepare: impl FnOnce(&mut App), begun: impl FnOnce(&mut App)) -> Result<bool, Box<dyn Error>> {
    use naoisis::prelude::*;

    if cfg!(target_os = "linux") && std::env::var_os("DISPLAY").is_none_or(|display| display.is_empty()) {
        return Err("--view: there is no display; without --view the example runs headless".into());
    }
    let mut app = App::new();
    app.add_plugins((naoisis::viewer::ViewerPlugins, NaoisisPlugins));
    prepare(&mut app);
    app.start_match(&Scenario::from_json(json)?)?;
    begun(&mut app);
    app.run();
    Ok(true)
}

#[cfg(not(feature = "viewer"))]
fn show(_: &str, _: impl FnOnce(&mut App), _: impl FnOnce(&mut App)) -> Result<bool, Box<dyn Error>> {
    Err("--view: this example was built without the viewer; build it without --no-default-features".into())
}
