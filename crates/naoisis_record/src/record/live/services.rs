//! The services by which viewers pause the match, step through it and change its speed.

use foxglove::websocket::service::{Request, Service, ServiceSchema};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::record::live_control::LiveControl;
use crate::record::mcap::viewer_schema::viewer_schema;

/// The request of `/naoisis/pause`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Pause {
    /// Whether the match is paused, or goes on.
    #[serde(default = "yes")]
    paused: bool,
}

/// The request of `/naoisis/step`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Step {
    /// The number of cycles to play; then the match is paused.
    #[serde(default = "one")]
    cycles: u64,
}

/// The request of `/naoisis/speed`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Speed {
    /// The speed as a multiple of real time, 0.001 to 1,000,000.
    times_real_time: f64,
}

fn yes() -> bool {
    true
}

fn one() -> u64 {
    1
}

/// Returns all services.
pub(super) fn all(control: &LiveControl) -> Vec<Service> {
    vec![
        service(control, "pause", |control, Pause { paused }| {
            control.pause(paused);
            Ok(())
        }),
        service(control, "step", |control, Step { cycles }| {
            control.step(cycles);
            Ok(())
        }),
        service(control, "speed", |control, Speed { times_real_time }| {
            if !(1e-3..=1e6).contains(&times_real_time) {
                return Err(format!("`times_real_time` is {times_real_time}; expected 0.001 to 1000000"));
            }
            control.set_speed(times_real_time);
            Ok(())
        }),
    ]
}

fn service<T: DeserializeOwned + JsonSchema + 'static>(
    control: &LiveControl,
    name: &str,
    act: impl Fn(&LiveControl, T) -> Result<(), String> + Send + Sync + 'static,
) -> Service {
    let schema = ServiceSchema::new(format!("naoisis.{name}")).with_request("json", viewer_schema::<T>());
    let control = control.clone();
    Service::builder(format!("/naoisis/{name}"), schema).handler_fn(move |request: Request| {
        // An empty request has all defaults.
        let payload = if request.payload().is_empty() { b"{}" } else { request.payload() };
        let wish: T = serde_json::from_slice(payload).map_err(|error| error.to_string())?;
        act(&control, wish)?;
        Ok::<_, String>("{}")
    })
}
