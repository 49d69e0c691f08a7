//! The variants of a scenario in a batch.

use naoisis_sim::scenario::{Scenario, ScenarioError};

/// Scenarios by index, each made when it is played, so that any number of them needs no memory.
pub trait Variants: Sync {
    /// The number of variants.
    fn count(&self) -> usize;

    /// Returns the scenario of variant `index`, from 0. Its seed is ignored.
    ///
    /// # Errors
    /// [`ScenarioError`] if its settings are wrong.
    ///
    /// # Panics
    /// May panic if `index` is not below [`count`](Self::count).
    fn scenario(&self, index: usize) -> Result<Scenario, ScenarioError>;

    /// Returns the names of the settings that differ, such as `messages.loss`: columns of a table.
    fn columns(&self) -> Vec<String> {
        Vec::new()
    }

    /// Returns the values of these settings in variant `index`, in the order of the names.
    fn values(&self, _index: usize) -> Vec<String> {
        Vec::new()
    }

    /// Describes how realistic variant `index` is.
    fn realism(&self, index: usize) -> String {
        self.scenario(index).map(|scenario| scenario.realism_in_words()).unwrap_or_default()
    }

    /// Returns a fingerprint of the scenario of variant `index`, independent of its seed.
    fn fingerprint(&self, index: usize) -> String {
        self.scenario(index).map(|scenario| fingerprint(&scenario)).unwrap_or_default()
    }
}

impl Variants for Vec<Scenario> {
    fn count(&self) -> usize {
        self.len()
    }

    fn scenario(&self, index: usize) -> Result<Scenario, ScenarioError> {
        Ok(self[index].clone())
    }
}

/// Returns the FNV-1a hash of a scenario's fields except its seed.
pub(super) fn fingerprint(scenario: &Scenario) -> String {
    let scenario = Scenario { seed: 0, ..scenario.clone() };
    let text = scenario.resolved_json().unwrap_or_default();
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3));
    format!("{hash:016x}")
}
