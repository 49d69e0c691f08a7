//! Sets `NAOISIS_ASSETS` to the path of the crate's assets, relative to the folder of the crate: in this folder, or at the top of the
//! repository if a checkout has no symbolic links, as on Windows. An absolute path would be wrong in another checkout that shares the build
//! folder.

use std::path::PathBuf;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let crate_folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default());
    let own = crate_folder.join("assets");
    let assets = if own.join("real").is_dir() { "assets" } else { "../../assets" };
    println!("cargo::rustc-env=NAOISIS_ASSETS={assets}");
}
