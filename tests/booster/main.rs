//! The program with the feature `booster`. What needs a client is in the Python files here, which `.ci/booster` runs.
#![expect(clippy::unwrap_used, reason = "a failed test may panic")]

use std::process::Command;

fn output(words: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_naoisis")).args(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {output:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn booster_programs_are_a_team_whose_network_is_chosen() {
    assert!(output(&["list", "teams"]).contains("booster"));
    let help = output(&["run", "--help"]);
    assert!(help.contains("--booster-network") && help.contains("--booster-domain"), "{help}");
}
