//! The `naoisis` command.

fn main() {}
