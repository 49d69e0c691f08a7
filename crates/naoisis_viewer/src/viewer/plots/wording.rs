//! Names of fields and units for the window, without names of types.

use heck::AsSnakeCase;

/// The unit of a number.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Unit {
    /// No unit, or unknown.
    Plain,
    /// A unit, such as `m`.
    In(&'static str),
    /// 0 is no, 1 is yes.
    YesNo,
    /// The index of one of these words, from 0.
    OneOf(Vec<String>),
}

impl Unit {
    /// Returns the symbol of the unit; empty if there is none.
    pub fn symbol(&self) -> &'static str {
        match self {
            Unit::In(symbol) => symbol,
            _ => "",
        }
    }

    /// Returns the word for a whole number, if numbers stand for words.
    pub fn word(&self, value: f64) -> Option<&str> {
        match self {
            Unit::YesNo => ["no", "yes"].get(value as usize).copied(),
            Unit::OneOf(words) => words.get(value as usize).map(String::as_str),
            _ => None,
        }
    }

    /// Returns whether numbers stand for words.
    pub fn is_words(&self) -> bool {
        matches!(self, Unit::YesNo | Unit::OneOf(_))
    }
}

/// Suffixes of names that state a unit, the longest first.
const ENDINGS: [(&str, Unit); 13] = [
    ("_radps", Unit::In("°/s")),
    ("_mps2", Unit::In("m/s²")),
    ("_mps", Unit::In("m/s")),
    ("_rad", Unit::In("°")),
    ("_deg", Unit::In("°")),
    ("_m2", Unit::In("m²")),
    ("_px", Unit::In("px")),
    ("_hz", Unit::In("Hz")),
    ("_ms", Unit::In("ms")),
    ("_kg", Unit::In("kg")),
    ("_cycles", Unit::In("cycles")),
    ("_m", Unit::In("m")),
    ("_s", Unit::In("s")),
];

/// Names of angles in radians, and of angular velocities.
const ANGLES: [&str; 9] = ["heading", "yaw", "pitch", "roll", "angle", "bearing", "theta", "dtheta", "direction"];
const TURNS: [&str; 2] = ["angular", "turn_rate"];
/// Names of positions in metres.
const PLACES: [&str; 2] = ["position", "place"];

/// Returns the unit of a number, from the type name of its component and the names along its path, and the factor from the
/// program's unit: angles are shown in degrees.
pub fn unit(component: &str, names: &[String]) -> (Unit, f32) {
    for name in names.iter().rev() {
        for (ending, unit) in ENDINGS {
            if name.ends_with(ending) {
                let factor = if ending.starts_with("_rad") { 1_f32.to_degrees() } else { 1.0 };
                return (unit, factor);
            }
        }
        let last = name.rsplit('.').next().unwrap_or(name);
        if ANGLES.contains(&last) {
            return (Unit::In("°"), 1_f32.to_degrees());
        }
        if TURNS.contains(&last) {
            return (Unit::In("°/s"), 1_f32.to_degrees());
        }
        if PLACES.contains(&last) {
            return (Unit::In("m"), 1.0);
        }
    }
    match component {
        "Velocity" | "BallVelocity" => (Unit::In("m/s"), 1.0),
        _ => (Unit::Plain, 1.0),
    }
}

/// Returns the name of a component, from the name of its type.
pub fn component(type_name: &str) -> String {
    variant(type_name.split('<').next().unwrap_or(type_name))
}

/// Returns the name of a variant, from its identifier.
pub fn variant(name: &str) -> String {
    AsSnakeCase(name).to_string().replace('_', " ")
}

/// Returns the name of a path: without units, with numbers and coordinates directly after the name that they belong to.
pub fn path(names: &[String]) -> String {
    let mut words = String::new();
    for name in names.iter().flat_map(|name| name.split('.')) {
        let ending = ENDINGS.iter().find(|(ending, _)| name.ends_with(ending)).map_or("", |(ending, _)| ending);
        let bare = name.strip_suffix(ending).unwrap_or(name).replace('_', " ");
        let is_part = bare.len() == 1 && (bare.parse::<u8>().is_ok() || ["x", "y", "z", "w"].contains(&bare.as_str()));
        if !words.is_empty() {
            words.push_str(if is_part { " " } else { ", " });
        }
        words.push_str(&bare);
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(path: &str) -> Vec<String> {
        path.split('/').map(str::to_owned).collect()
    }

    #[test]
    fn units_come_from_names() {
        let of = |component: &str, path: &str| unit(component, &names(path)).0.symbol();
        assert_eq!(of("Belief", "ball/position_m/x"), "m");
        assert_eq!(of("Belief", "pose/heading"), "°");
        assert_eq!(of("Velocity", "linear/x"), "m/s");
        assert_eq!(of("Velocity", "angular"), "°/s");
        assert_eq!(of("PlayerMemory", "attacks"), "");
        // Radians are shown in degrees. Values in degrees stay as they are.
        assert!((unit("Pose", &names("heading")).1 - 57.295_78).abs() < 1e-4);
        assert_eq!(unit("Pose", &names("heading_deg")).1, 1.0);
    }

    #[test]
    fn names_of_the_program_become_words() {
        assert_eq!(component("PlayerMemory"), "player memory");
        assert_eq!(component("ROSLink"), "ros link");
        assert_eq!(path(&names("ball/position_m/x")), "ball, position x");
        assert_eq!(path(&names("joints/3")), "joints 3");
        assert_eq!(variant("GetUp"), "get up");
    }

    #[test]
    fn numbers_that_stand_for_words_are_told_as_words() {
        assert_eq!(Unit::YesNo.word(1.0), Some("yes"));
        assert_eq!(Unit::OneOf(vec!["wait".to_owned()]).word(0.0), Some("wait"));
        assert_eq!(Unit::OneOf(vec!["wait".to_owned()]).word(1.0), None);
        assert_eq!(Unit::In("m").word(1.0), None);
    }
}
