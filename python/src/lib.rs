//! The compiled part of the Python package `naoisis`: thin classes and functions over the library. Their documentation and
//! defaults are in Python, where the package wraps them.

use pyo3::prelude::*;
use std::ffi::OsString;
use std::process::ExitCode;

mod batches;
mod environments;
mod errors;
mod matches;
mod played;
mod policies;
mod shapes;
mod simulator;
mod starts;
mod steps;
mod traces;
mod values;

/// Runs a command line and returns its exit status.
#[pyfunction]
fn command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    let status = py.detach(|| naoisis::cli::run_with(words, |_| {}));
    // It does not tell its number otherwise.
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == status).unwrap_or(1)
}

/// The module `naoisis._naoisis`.
#[pymodule]
mod _naoisis {
    use naoisis::internal::appearance::Label;
    use pyo3::prelude::*;
    use pyo3::types::PyDict;

    use crate::values::{Digits, to_python};

    #[pymodule_export]
    use super::batches::Batch;
    #[pymodule_export]
    use super::command;
    #[pymodule_export]
    use super::environments::{Environments, challenges};
    #[pymodule_export]
    use super::matches::Match;
    #[pymodule_export]
    use super::policies::Policy;
    #[pymodule_export]
    use super::traces::{TraceLines, page_of_trace, read_tables, read_trace};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        let labels = PyDict::new(module.py());
        for label in Label::ALL {
            labels.set_item(to_python(module.py(), &label, Digits::All)?, label as u8)?;
        }
        module.add("LABELS", labels)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
