//! The option with which `naoisis run` shows a match while it is played.

use bevy::prelude::*;
use clap::Args;

use super::outputs::Output;
use super::recording::Recording;
use naoisis_record::record::recorder::Recorder;

/// The option of the live view.
#[derive(Args, Debug, Clone, Default)]
pub struct LiveArguments {
    /// Show the match while it is played to Lichtblick or Foxglove, which connect to this address: 127.0.0.1:8765 (port 0 is any free
    /// port); best with --pace 1
    #[arg(long, value_name = "HOST:PORT")]
    live: Option<String>,
}

impl Recording for LiveArguments {
    fn check(&self) -> Result<(), String> {
        let Some(address) = &self.live else { return Ok(()) };
        if !cfg!(feature = "live") {
            return Err(
                "--live: this program was built without the live view; build it with `--features live`".to_owned()
            );
        }
        host_and_port(address).map(drop)
    }

    fn outputs(&self) -> Vec<Output> {
        Vec::new()
    }

    #[cfg(feature = "live")]
    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        use super::report;
        use naoisis_record::record::live::LiveRecorder;

        let Some(address) = &self.live else { return Ok(Vec::new()) };
        let (host, port) = host_and_port(address)?;
        let recorder = LiveRecorder::start(host, port).map_err(|error| format!("--live: {error}"))?;
        report::note(&format!("live view at ws://{host}:{}", recorder.port()));
        let is_local = matches!(host, "localhost" | "::1" | "[::1]") || host.starts_with("127.");
        if !is_local {
            report::note(
                "warning: everybody who reaches this address over the network may watch the match and pause it",
            );
        }
        Ok(vec![Box::new(recorder)])
    }

    #[cfg(not(feature = "live"))]
    fn open(&self, _: &World, _: bool) -> Result<Vec<Box<dyn Recorder>>, String> {
        Ok(Vec::new())
    }
}

/// Splits an address such as `127.0.0.1:8765`.
fn host_and_port(address: &str) -> Result<(&str, u16), String> {
    let parts = address.rsplit_once(':').and_then(|(host, port)| Some((host, port.parse().ok()?)));
    parts
        .filter(|(host, _)| !host.is_empty())
        .ok_or_else(|| format!("--live: `{address}` is no address; expected a host and a port, such as 127.0.0.1:8765"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_is_a_host_and_a_port() {
        assert_eq!(host_and_port("127.0.0.1:8765"), Ok(("127.0.0.1", 8765)));
        assert_eq!(host_and_port("[::1]:0"), Ok(("[::1]", 0)));
        for wrong in ["8765", ":8765", "localhost", "localhost:", "localhost:99999", ""] {
            assert!(host_and_port(wrong).unwrap_err().contains("expected a host and a port"), "{wrong}");
        }
    }
}
