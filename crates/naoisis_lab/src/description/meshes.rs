//! Computes the bounds of meshes: STL (binary and text) and OBJ.

use bevy::math::DVec3;
use std::path::Path;

use super::DescriptionError;
use super::tree::bounds;
use naoisis_core::read_file::read_file;

/// Length of a binary STL header: 80 arbitrary bytes, and the number of triangles.
const HEADER_BYTES: usize = 84;
/// Length of a triangle in binary STL: a normal and three corners with four bytes per number, and two more bytes.
const TRIANGLE_BYTES: usize = 50;

/// Returns the least and the greatest corner of a mesh, m, with each axis multiplied by `scale`.
///
/// # Errors
/// [`DescriptionError::Mesh`] if the mesh cannot be read.
pub(super) fn bounds_of(path: &Path, scale: DVec3) -> Result<[DVec3; 2], DescriptionError> {
    let name = path.display();
    let wrong = |problem: String| DescriptionError::Mesh(format!("the mesh {name} {problem}"));
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let bytes = match ending.as_str() {
        "stl" | "obj" => read_file(path),
        _ => return Err(wrong("is neither STL nor OBJ".to_owned())),
    };
    let bytes = bytes.map_err(|problem| wrong(format!("cannot be read: {problem}")))?;
    let found = match ending.as_str() {
        "stl" => stl(&bytes),
        _ => bounds(text_points(&bytes, "v")),
    };
    let [one, other] = found.ok_or_else(|| wrong("has no triangles".to_owned()))?.map(|corner| corner * scale);
    Ok([one.min(other), one.max(other)])
}

fn stl(bytes: &[u8]) -> Option<[DVec3; 2]> {
    let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES).and_then(|count| count.try_into().ok());
    let triangles = count.map_or(0, u32::from_le_bytes) as usize;
    // Binary files may begin with `solid` like text files, but have exactly this length.
    if triangles > 0 && bytes.len() - HEADER_BYTES == triangles.saturating_mul(TRIANGLE_BYTES) {
        let corners = bytes[HEADER_BYTES..].chunks_exact(TRIANGLE_BYTES).flat_map(|triangle| {
            triangle[12..48].chunks_exact(12).map(|corner| {
                let number = |at: usize| {
                    f64::from(f32::from_le_bytes([corner[at], corner[at + 1], corner[at + 2], corner[at + 3]]))
                };
                DVec3::new(number(0), number(4), number(8))
            })
        });
        return bounds(corners.filter(|corner| corner.is_finite()));
    }
    bounds(text_points(bytes, "vertex"))
}

/// Returns the points in the lines that begin with `word`.
fn text_points<'a>(bytes: &'a [u8], word: &'a str) -> impl Iterator<Item = DVec3> {
    bytes.split(|byte| *byte == b'\n').filter_map(move |line| {
        let mut words = core::str::from_utf8(line).ok()?.split_whitespace();
        (words.next()? == word).then_some(())?;
        let mut number = || words.next()?.parse::<f64>().ok().filter(|number| number.is_finite());
        Some(DVec3::new(number()?, number()?, number()?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn bounds_of_text_and_binary_files_agree() {
        let corners = [[0.0, -1.0, 2.0], [3.0, 0.5, 2.5], [1.0, 4.0, -2.0_f32]];
        let mut text = "solid robot\n facet normal 0 0 1\n  outer loop\n".to_owned();
        let mut objects = "# comment\nvn 9 9 9\n".to_owned();
        // A binary file that begins like a text file.
        let mut binary = b"solid ".to_vec();
        binary.resize(80, b' ');
        binary.extend(1_u32.to_le_bytes());
        binary.extend([0; 12]);
        for [x, y, z] in corners {
            text.push_str(&format!("   vertex {x} {y} {z:e}\r\n"));
            objects.push_str(&format!("v {x} {y} {z}\n"));
            [x, y, z].iter().for_each(|number| binary.extend(number.to_le_bytes()));
        }
        binary.extend([0; 2]);
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in [("a.STL", text.as_bytes()), ("b.stl", &binary), ("c.obj", objects.as_bytes())] {
            let path = folder.path().join(name);
            fs::write(&path, bytes).unwrap();
            let found = bounds_of(&path, DVec3::new(-1.0, 1.0, 0.5)).unwrap();
            assert_eq!(found, [DVec3::new(-3.0, -1.0, -1.0), DVec3::new(0.0, 4.0, 1.25)], "{name}");
        }
        let reason = |name: &str| bounds_of(&folder.path().join(name), DVec3::ONE).unwrap_err().to_string();
        assert!(reason("no.stl").contains("no.stl cannot be read"), "{}", reason("no.stl"));
        assert!(reason("no.dae").contains("neither STL nor OBJ"));
        fs::write(folder.path().join("cut.stl"), &binary[..90]).unwrap();
        assert!(reason("cut.stl").contains("no triangles"));
    }
}
