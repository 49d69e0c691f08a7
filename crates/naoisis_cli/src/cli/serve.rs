//! `naoisis serve`: a match that programs connect to.

use clap::Args;
use clap::builder::NonEmptyStringValueParser;

use super::report::CommandResult;
use super::run::run_match;
use super::run_arguments::RunArguments;
use super::{Program, begin};
use naoisis_agents::agents::AgentSettings;
use naoisis_agents::agents::server::Address;

/// Arguments of `naoisis serve`.
#[derive(Args, Debug, Clone)]
pub struct ServeArguments {
    /// Address for programs that play `remote` robots: tcp:127.0.0.1:10000 (port 0 is any free port), or unix:PATH
    #[arg(long, value_name = "tcp:HOST:PORT|unix:PATH")]
    pub listen: Address,
    /// Accept only programs whose hello has this "token"
    #[arg(long, value_name = "WORD", value_parser = NonEmptyStringValueParser::new())]
    pub token: Option<String>,
    #[command(flatten)]
    pub run: RunArguments,
}

/// Runs the command: waits until every remote robot is played, then runs the match.
pub fn serve(program: Program, arguments: &ServeArguments) -> CommandResult {
    run_match(program, &arguments.run, Some(&arguments.listen), |app| {
        begin::begin(app, &arguments.run)?;
        app.world_mut().resource_mut::<AgentSettings>().token.clone_from(&arguments.token);
        Ok(())
    })
}
