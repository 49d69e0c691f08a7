//! Paths of fields in a scenario, such as `robots[1].pose`.

use core::fmt;

/// A step of a path.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Segment {
    /// A field of an object.
    Field(String),
    /// An element of a list, from 0.
    Index(usize),
}

/// The path of a field in a scenario, as files spell it: `robots[1].pose` or `robots.1.pose`. The empty path is the whole scenario.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct FieldPath(Vec<Segment>);

impl FieldPath {
    /// Parses a path that is not empty. Returns `None` if the text is no path.
    pub(super) fn parse(text: &str) -> Option<FieldPath> {
        let is_index = |index: &str| !index.is_empty() && index.bytes().all(|byte| byte.is_ascii_digit());
        let is_step = |step: &str| {
            let (name, indices) = step.split_once('[').map_or((step, None), |(name, rest)| (name, Some(rest)));
            let indices_are_closed =
                |rest: &str| rest.strip_suffix(']').is_some_and(|all| all.split("][").all(is_index));
            !name.is_empty() && !name.contains(']') && indices.is_none_or(indices_are_closed)
        };
        text.split('.').all(is_step).then(|| FieldPath::from(text))
    }

    /// Returns the path of a field in this one. `name` may itself be a path, such as `goal.width_m`.
    #[must_use]
    pub fn field(&self, name: &str) -> FieldPath {
        let mut path = self.clone();
        path.0.extend(FieldPath::from(name).0);
        path
    }

    /// Returns the path of a field in this one. `name` is not split into steps.
    #[must_use]
    pub fn key(&self, name: &str) -> FieldPath {
        let mut path = self.clone();
        path.0.push(Segment::Field(name.to_owned()));
        path
    }

    /// Returns this path with `outer` in front of it.
    #[must_use]
    pub fn within(self, outer: &FieldPath) -> FieldPath {
        FieldPath(outer.0.iter().cloned().chain(self.0).collect())
    }

    /// Returns the path of a list's element in this one, from 0.
    #[must_use]
    pub fn index(&self, index: usize) -> FieldPath {
        let mut path = self.clone();
        path.0.push(Segment::Index(index));
        path
    }

    /// Returns the steps from the whole scenario to this field.
    pub fn segments(&self) -> &[Segment] {
        &self.0
    }

    /// Returns the name of the last step, if it is a field.
    pub(super) fn last_field(&self) -> Option<&str> {
        match self.0.last()? {
            Segment::Field(name) => Some(name),
            Segment::Index(_) => None,
        }
    }

    /// Returns the name of the last field, without an index.
    pub(super) fn last_name(&self) -> Option<&str> {
        self.0.iter().rev().find_map(|segment| match segment {
            Segment::Field(name) => Some(name.as_str()),
            Segment::Index(_) => None,
        })
    }

    /// Returns the last field with its index, such as `pose[1]`. Returns `None` for the whole scenario.
    pub(super) fn last_part(&self) -> Option<String> {
        let field = self.0.iter().rposition(|segment| matches!(segment, Segment::Field(_)))?;
        Some(self.without_first(field).to_string())
    }

    /// Returns the name for error messages: like the last part, but with its parent if many fields have this name, such as `torso.z_m[1]`.
    pub(super) fn name(&self) -> String {
        /// Measures of boxes. A robot has several boxes.
        const OF_BOXES: [&str; 5] = ["x_m", "y_m", "z_m", "half_width_m", "half_size_m"];
        let Some(field) = self.0.iter().rposition(|segment| matches!(segment, Segment::Field(_))) else {
            return "the value".to_owned();
        };
        let is_of_box = matches!(&self.0[field], Segment::Field(name) if OF_BOXES.contains(&name.as_str()));
        let is_in_field = field > 0 && matches!(self.0[field - 1], Segment::Field(_));
        self.without_first(if is_of_box && is_in_field { field - 1 } else { field }).to_string()
    }

    /// Returns whether the path is `other`, or leads into it.
    pub(super) fn starts_with(&self, other: &FieldPath) -> bool {
        self.0.starts_with(&other.0)
    }

    /// Returns the first `count` steps.
    pub(super) fn first(&self, count: usize) -> FieldPath {
        FieldPath(self.0.iter().take(count).cloned().collect())
    }

    /// Returns the path without its first `count` steps.
    pub(super) fn without_first(&self, count: usize) -> FieldPath {
        FieldPath(self.0.iter().skip(count).cloned().collect())
    }
}

impl From<&str> for FieldPath {
    fn from(text: &str) -> Self {
        let words = text.split(['.', '[']).filter(|word| !word.is_empty());
        FieldPath(
            words
                .map(|word| match word.strip_suffix(']').unwrap_or(word).parse().ok() {
                    Some(index) => Segment::Index(index),
                    None => Segment::Field(word.to_owned()),
                })
                .collect(),
        )
    }
}

impl FromIterator<Segment> for FieldPath {
    fn from_iter<Segments: IntoIterator<Item = Segment>>(segments: Segments) -> Self {
        FieldPath(segments.into_iter().collect())
    }
}

impl fmt::Display for FieldPath {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Index(index) => write!(formatter, "[{index}]")?,
                Segment::Field(name) if position == 0 => write!(formatter, "{}", name.escape_debug())?,
                Segment::Field(name) => write!(formatter, ".{}", name.escape_debug())?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_reads_as_it_prints() {
        let path = FieldPath::default().field("robots").index(1).field("behaviour.script").index(0).field("walk");
        assert_eq!(path.to_string(), "robots[1].behaviour.script[0].walk");
        assert_eq!(FieldPath::from(path.to_string().as_str()), path);
        assert_eq!(FieldPath::from("robots.1.behaviour.script.0.walk"), path);
        assert_eq!(path.without_first(2).to_string(), "behaviour.script[0].walk");
    }

    #[test]
    fn a_name_says_of_what_box_a_measure_is() {
        let name = |path: &str| FieldPath::from(path).name();
        let names =
            ["settings.body.torso.z_m[1]", "cameras.mounts[0].size[1]", "kicks.own.flap.wind_up_s", ""].map(name);
        assert_eq!(names, ["torso.z_m[1]", "size[1]", "wind_up_s", "the value"]);
    }
}
