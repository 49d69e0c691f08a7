//! Writes the seeds of each fuzz target into a folder `corpus/TARGET` of the current one.

use std::fs;
use std::io;
use std::path::Path;

fn main() -> io::Result<()> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    for target in naoisis_fuzz::TARGETS {
        let folder = Path::new("corpus").join(target.name);
        fs::create_dir_all(&folder)?;
        for (number, seed) in (target.seeds)(&assets).into_iter().enumerate() {
            fs::write(folder.join(format!("seed_{number}")), seed)?;
        }
    }
    Ok(())
}
