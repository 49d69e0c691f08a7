//! Tells the crate where its assets are, as `NAOISIS_ASSETS`: in its own folder, or at the top of the repository where a
//! checkout has no symbolic links, as on Windows.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let crate_folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let own = crate_folder.join("assets");
    let assets = if own.join("real").is_dir() { own } else { crate_folder.join("../../assets") };
    println!("cargo::rustc-env=NAOISIS_ASSETS={}", assets.display());
}
