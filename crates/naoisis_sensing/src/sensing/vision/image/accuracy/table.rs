//! The table of an [`Accuracy`].

use core::fmt;

use super::class::LEAST_PIXELS;
use super::{Accuracy, ClassAccuracy};

/// All distances, m.
pub const EVERYWHERE_M: [f32; 2] = [0.0, f32::INFINITY];

/// The limits of the distances of the rows, m.
const BANDS_M: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, f32::INFINITY];

impl Accuracy {
    /// All classes, by their names.
    pub fn classes(&self) -> [(&'static str, &ClassAccuracy); 8] {
        [
            ("ball", &self.ball),
            ("goal posts", &self.goal_posts),
            ("robots", &self.robots),
            ("lines", &self.lines),
            ("junctions", &self.junctions),
            ("penalty crosses", &self.penalty_crosses),
            ("centre circle", &self.centre_circle),
            ("corner arcs", &self.corner_arcs),
        ]
    }
}

impl fmt::Display for Accuracy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            formatter,
            "{} looks; {} images, {:.0} a second on one core; visible: at least {LEAST_PIXELS} pixels in an image (of a robot: of its \
             waistband; of a cross: all of it; of lines and where they meet: in view)",
            self.looks,
            self.images,
            self.images as f64 / self.looking.as_secs_f64().max(1e-9)
        )?;
        writeln!(
            formatter,
            "{:<16}{:>8}{:>9}{:>14}{:>14}{:>9}{:>12}{:>10}",
            "", "visible", "found", "false in 100", "range median", "90 %", "bearing", "90 %"
        )?;
        for (name, class) in self.classes() {
            // A pitch may have no corner arcs.
            if class.sightings.is_empty() && class.false_detections == 0 {
                continue;
            }
            let false_in_100 = 100.0 * class.false_detections as f32 / self.looks.max(1) as f32;
            row(formatter, name, class, EVERYWHERE_M, &format!("{false_in_100:.2}"))?;
            for band in BANDS_M.windows(2).map(|ends| [ends[0], ends[1]]) {
                if class.visible(band).next().is_none() {
                    continue;
                }
                let name = match band {
                    [from, to] if to.is_finite() => format!("  {from} to {to} m"),
                    [from, _] => format!("  from {from} m"),
                };
                row(formatter, &name, class, band, "")?;
            }
        }
        Ok(())
    }
}

/// Writes a row: a class at distances in `band`.
fn row(
    formatter: &mut fmt::Formatter<'_>,
    name: &str,
    class: &ClassAccuracy,
    band: [f32; 2],
    false_in_100: &str,
) -> fmt::Result {
    let visible = class.visible(band).count();
    let is_any_found = class.visible(band).any(|sighting| sighting.seen.is_some());
    // Without objects there is no share, and without detections no error.
    let known = |is_known: bool, words: String| if is_known { words } else { "-".to_owned() };
    let range = |share| known(is_any_found, format!("{:.1} %", 100.0 * class.range_error(band, share)));
    let bearing = |share| known(is_any_found, format!("{:.2} deg", class.bearing_error(band, share).to_degrees()));
    writeln!(
        formatter,
        "{name:<16}{visible:>8}{:>9}{false_in_100:>14}{:>14}{:>9}{:>12}{:>10}",
        known(visible > 0, format!("{:.1} %", 100.0 * class.found_share(band))),
        range(0.5),
        range(0.9),
        bearing(0.5),
        bearing(0.9),
    )
}
