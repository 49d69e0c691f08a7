//! Segmentation of an image into blobs: connected pixels of one colour class.

use super::colour::{ColourClass, TABLE, index_of};
use crate::sensing::camera::image::Image;

/// A horizontal run of pixels of one class.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Run {
    pub(super) row: u16,
    pub(super) from: u16,
    /// The column after the last.
    pub(super) to: u16,
    class: ColourClass,
    /// An earlier run of the same blob, or the run itself.
    parent: u32,
}

impl Run {
    pub(super) fn width(&self) -> u16 {
        self.to - self.from
    }

    /// The column of the run's middle, pixels from the left edge.
    pub(super) fn middle(&self) -> f32 {
        f32::from(self.from + self.to) / 2.0
    }
}

/// Connected pixels of one class.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Blob {
    pub(super) class: ColourClass,
    /// Number of pixels.
    pub(super) area: u32,
    pub(super) left: u16,
    /// The column after the last.
    pub(super) right: u16,
    pub(super) top: u16,
    /// The row after the last.
    pub(super) bottom: u16,
    first: u32,
    count: u32,
}

impl Blob {
    pub(super) fn width(&self) -> u16 {
        self.right - self.left
    }

    pub(super) fn height(&self) -> u16 {
        self.bottom - self.top
    }
}

/// An image segmented into classes and blobs.
#[derive(Default)]
pub(super) struct Segmentation {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) classes: Vec<ColourClass>,
    pub(super) blobs: Vec<Blob>,
    runs: Vec<Run>,
    /// The runs, blob by blob, each from top to bottom.
    ordered: Vec<Run>,
    blob_of: Vec<u32>,
}

impl Segmentation {
    pub(super) fn segment(&mut self, image: &Image) {
        (self.width, self.height) = (image.width as usize, image.height as usize);
        let table = &**TABLE;
        self.classes.clear();
        self.classes.extend(image.rgb.as_chunks::<3>().0.iter().map(|&[r, g, b]| table[index_of(r, g, b)]));
        self.find_runs();
        self.collect_blobs();
    }

    /// The runs of a blob, from top to bottom.
    pub(super) fn runs(&self, blob: &Blob) -> &[Run] {
        &self.ordered[blob.first as usize..(blob.first + blob.count) as usize]
    }

    /// Collects the runs of a class that does not form blobs, row by row.
    pub(super) fn runs_of(&self, class: ColourClass, runs: &mut Vec<Run>) {
        runs.clear();
        for (row, classes) in self.classes.chunks_exact(self.width.max(1)).enumerate() {
            let mut column = 0;
            while let Some(start) = classes[column..].iter().position(|&other| other == class) {
                let from = column + start;
                let length = classes[from..].iter().position(|&other| other != class).unwrap_or(self.width - from);
                column = from + length;
                let parent = runs.len() as u32;
                runs.push(Run { row: row as u16, from: from as u16, to: column as u16, class, parent });
            }
        }
    }

    fn find_runs(&mut self) {
        self.runs.clear();
        let mut above = 0..0;
        let all_classes = core::mem::take(&mut self.classes);
        for (row, classes) in all_classes.chunks_exact(self.width).enumerate() {
            let first = self.runs.len();
            let mut column = 0;
            while let Some(start) = classes[column..].iter().position(|class| class.is_cue()) {
                let from = column + start;
                let class = classes[from];
                let length = classes[from..].iter().position(|&other| other != class).unwrap_or(self.width - from);
                column = from + length;
                let parent = self.runs.len() as u32;
                self.runs.push(Run { row: row as u16, from: from as u16, to: column as u16, class, parent });
            }
            let end = self.runs.len();
            self.connect(above, first..end);
            above = first..end;
        }
        self.classes = all_classes;
    }

    /// Connects the runs of a row with those of the row above that they touch, including diagonally.
    fn connect(&mut self, above: core::ops::Range<usize>, row: core::ops::Range<usize>) {
        let mut upper = above.start;
        for index in row {
            let run = self.runs[index];
            while upper < above.end && self.runs[upper].to < run.from {
                upper += 1;
            }
            let mut other = upper;
            while other < above.end && self.runs[other].from <= run.to {
                if self.runs[other].class == run.class {
                    let (one, two) = (self.root(index as u32), self.root(other as u32));
                    // The root with the lower index stays the root.
                    let (root, leaf) = if one < two { (one, two) } else { (two, one) };
                    self.runs[leaf as usize].parent = root;
                }
                other += 1;
            }
        }
    }

    fn root(&mut self, mut index: u32) -> u32 {
        loop {
            let parent = self.runs[index as usize].parent;
            if parent == index {
                return index;
            }
            let grandparent = self.runs[parent as usize].parent;
            self.runs[index as usize].parent = grandparent;
            index = grandparent;
        }
    }

    fn collect_blobs(&mut self) {
        self.blobs.clear();
        self.blob_of.clear();
        for index in 0..self.runs.len() {
            let root = self.root(index as u32) as usize;
            let run = self.runs[index];
            if root == index {
                self.blob_of.push(self.blobs.len() as u32);
                self.blobs.push(Blob {
                    class: run.class,
                    area: 0,
                    left: run.from,
                    right: run.to,
                    top: run.row,
                    bottom: run.row + 1,
                    first: 0,
                    count: 0,
                });
            } else {
                self.blob_of.push(self.blob_of[root]);
            }
            let blob = &mut self.blobs[self.blob_of[index] as usize];
            blob.area += u32::from(run.width());
            blob.left = blob.left.min(run.from);
            blob.right = blob.right.max(run.to);
            blob.bottom = run.row + 1;
            blob.count += 1;
        }
        let mut first = 0;
        for blob in &mut self.blobs {
            blob.first = first;
            first += blob.count;
            blob.count = 0;
        }
        self.ordered.clear();
        self.ordered.extend_from_slice(&self.runs);
        for (run, &blob) in self.runs.iter().zip(&self.blob_of) {
            let blob = &mut self.blobs[blob as usize];
            self.ordered[(blob.first + blob.count) as usize] = *run;
            blob.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::colours::{self, Colour};
    use naoisis_core::team::Team;

    /// An image from words: `o` orange, `p` pink, anything else green.
    fn image(rows: &[&str]) -> Image {
        let colour = |letter: char| match letter {
            'o' => colours::BALL,
            'p' => colours::team(Team::Pink),
            _ => colours::CARPET,
        };
        let rgb = rows.iter().flat_map(|row| row.chars()).flat_map(|letter| {
            let Colour(rgb) = colour(letter);
            rgb
        });
        Image { width: rows[0].len() as u32, height: rows.len() as u32, rgb: rgb.collect(), ..Image::default() }
    }

    #[test]
    fn pixels_that_touch_are_a_blob() {
        let mut segmentation = Segmentation::default();
        segmentation.segment(&image(&["o...oo", "o.o..o", "o.o.oo", "oooo..", ".....p"]));
        let areas: Vec<_> = segmentation.blobs.iter().map(|blob| (blob.class, blob.area)).collect();
        // The right part touches the left one diagonally.
        assert_eq!(areas, [(ColourClass::Orange, 9 + 5), (ColourClass::Pink, 1)]);
        let blob = segmentation.blobs[0];
        assert_eq!((blob.left, blob.right, blob.top, blob.bottom), (0, 6, 0, 4));
        assert_eq!(segmentation.runs(&blob).len(), 2 + 3 + 3 + 1);
        assert!(segmentation.runs(&blob).is_sorted_by_key(|run| run.row));
    }

    #[test]
    fn what_does_not_touch_is_apart() {
        let mut segmentation = Segmentation::default();
        segmentation.segment(&image(&["oo..oo", "......", "pp.oo.", "oo...."]));
        assert_eq!(segmentation.blobs.len(), 5);
    }
}
