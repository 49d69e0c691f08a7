//! The variants of a scenario that a batch plays.

use naoisis_sim::scenario::Scenario;

/// Scenarios by their places, each made when it is played: however many there are, they take no memory.
pub trait Variants: Sync {
    /// How many there are.
    fn count(&self) -> usize;

    /// The one at this place, from 0. Its seed does not matter.
    ///
    /// # Errors
    /// Why it cannot be played, in words.
    fn scenario(&self, index: usize) -> Result<Scenario, String>;

    /// The names of the settings that distinguish them, such as `messages.loss`: columns of a table.
    fn columns(&self) -> Vec<String> {
        Vec::new()
    }

    /// The values of these settings, in their order.
    fn values(&self, _index: usize) -> Vec<String> {
        Vec::new()
    }

    /// How much of a real robot it has, in words.
    fn realism(&self, index: usize) -> String {
        self.scenario(index).map(|scenario| scenario.realism_in_words()).unwrap_or_default()
    }

    /// What tells a scenario from others whose values are the same, whatever its seed.
    fn fingerprint(&self, index: usize) -> String {
        self.scenario(index).map(|scenario| fingerprint(&scenario)).unwrap_or_default()
    }
}

impl Variants for Vec<Scenario> {
    fn count(&self) -> usize {
        self.len()
    }

    fn scenario(&self, index: usize) -> Result<Scenario, String> {
        self.get(index).cloned().ok_or_else(|| format!("there is no variant {index}"))
    }
}

/// The FNV-1a hash of a scenario's fields but for its seed.
pub(super) fn fingerprint(scenario: &Scenario) -> String {
    let scenario = Scenario { seed: 0, ..scenario.clone() };
    let text = scenario.resolved_json().unwrap_or_default();
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}
