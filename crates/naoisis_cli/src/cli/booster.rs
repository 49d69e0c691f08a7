//! Arguments of the command line about programs for Booster's SDK.

use bevy::prelude::*;
use clap::Args;

use super::report;
use naoisis_booster::player::booster_robots;
use naoisis_booster::reach::Reach;

/// Arguments about programs for Booster's SDK.
#[derive(Args, Debug, Clone, Default)]
pub struct BoosterArguments {
    /// Booster programs: speak DDS on all network interfaces, not on the loopback interface alone
    #[arg(long)]
    pub booster_network: bool,
    /// Booster programs: the domain of DDS [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=232))]
    pub booster_domain: Option<u16>,
}

impl BoosterArguments {
    /// Sets whom the match speaks to, and prints whom it waits for, if there are robots for Booster programs.
    pub fn start(&self, world: &mut World) {
        let reach = Reach { domain: self.booster_domain.unwrap_or_default(), network: self.booster_network };
        world.insert_resource(reach);
        let robots = booster_robots(world);
        let names: Vec<String> = match &robots[..] {
            [] => return,
            [robot] => vec![robot.to_string()],
            _ => robots.iter().enumerate().map(|(index, robot)| format!("{robot} as robot{index}")).collect(),
        };
        let place = if reach.network { "on all network interfaces" } else { "on this machine" };
        let names = names.join(", ");
        report::note(&format!("waiting for Booster programs {place}, DDS domain {}: {names}", reach.domain));
    }
}

/// Returns the default speed of a match with such robots as a multiple of real time, in which their programs live.
pub fn pace(world: &mut World) -> Option<f64> {
    (!booster_robots(world).is_empty()).then_some(1.0)
}
