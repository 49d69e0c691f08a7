//! Places in a scenario, such as `robots[1].pose`.

use core::fmt;

/// A step into a scenario.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Segment {
    /// Into a field of an object.
    Field(String),
    /// Into an element of a list, from 0.
    Index(usize),
}

/// A place in a scenario, as files spell it: `robots[1].pose`, or `robots.1.pose`. The empty path is the whole scenario.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct FieldPath(Vec<Segment>);

impl FieldPath {
    /// The place of this spelling, which is not the whole scenario; none if it is not one.
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

    /// The place of a field within this one. The name may itself be a path, such as `goal.width_m`.
    #[must_use]
    pub fn field(&self, name: &str) -> FieldPath {
        let mut path = self.clone();
        path.0.extend(FieldPath::from(name).0);
        path
    }

    /// The place of a field of this very name within this one.
    #[must_use]
    pub fn key(&self, name: &str) -> FieldPath {
        let mut path = self.clone();
        path.0.push(Segment::Field(name.to_owned()));
        path
    }

    /// This place, when the whole is what is at `outer`.
    #[must_use]
    pub fn within(self, outer: &FieldPath) -> FieldPath {
        FieldPath(outer.0.iter().cloned().chain(self.0).collect())
    }

    /// The place of a list's element within this one, from 0.
    #[must_use]
    pub fn index(&self, index: usize) -> FieldPath {
        let mut path = self.clone();
        path.0.push(Segment::Index(index));
        path
    }

    /// The steps from the whole scenario to this place.
    pub fn segments(&self) -> &[Segment] {
        &self.0
    }

    /// The name of the last step, if it is a field.
    pub(super) fn last_field(&self) -> Option<&str> {
        match self.0.last()? {
            Segment::Field(name) => Some(name),
            Segment::Index(_) => None,
        }
    }

    /// The name of the last field, whatever element of it is meant.
    pub(super) fn last_name(&self) -> Option<&str> {
        self.0.iter().rev().find_map(|segment| match segment {
            Segment::Field(name) => Some(name.as_str()),
            Segment::Index(_) => None,
        })
    }

    /// The last field and what of it is meant, such as `pose[1]`; none for the whole scenario.
    pub(super) fn last_part(&self) -> Option<String> {
        let field = self.0.iter().rposition(|segment| matches!(segment, Segment::Field(_)))?;
        Some(self.without_first(field).to_string())
    }

    /// The same as errors call it: with the field that it is in where many have one of this name, such as `torso.z_m[1]`.
    pub(super) fn name(&self) -> String {
        /// Measures of boxes, of which a robot has several.
        const OF_BOXES: [&str; 5] = ["x_m", "y_m", "z_m", "half_width_m", "half_size_m"];
        let Some(field) = self.0.iter().rposition(|segment| matches!(segment, Segment::Field(_))) else {
            return "the value".to_owned();
        };
        let is_of_box = matches!(&self.0[field], Segment::Field(name) if OF_BOXES.contains(&name.as_str()));
        let is_in_field = field > 0 && matches!(self.0[field - 1], Segment::Field(_));
        self.without_first(if is_of_box && is_in_field { field - 1 } else { field }).to_string()
    }

    /// Whether it is `other`, or a place in it.
    pub(super) fn starts_with(&self, other: &FieldPath) -> bool {
        self.0.starts_with(&other.0)
    }

    /// Its first `count` steps.
    pub(super) fn first(&self, count: usize) -> FieldPath {
        FieldPath(self.0.iter().take(count).cloned().collect())
    }

    /// The path without its first `count` steps.
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
