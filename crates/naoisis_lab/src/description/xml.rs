//! Reads XML files as trees of elements with their places in the file.

use core::fmt;
use roxmltree::{Document, Node};
use std::path::Path;
use std::sync::Arc;

use super::DescriptionError;
use naoisis_core::read_file::read_file;

/// Depth of nested elements at most.
const DEEPEST: usize = 256;

/// A place in a file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Place {
    /// The name of the file without its folder.
    pub file: Arc<str>,
    line: u32,
    column: u32,
}

impl Place {
    /// Returns the start of a file.
    pub fn start_of(path: &Path) -> Place {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        Place { file: name.as_ref().into(), line: 1, column: 1 }
    }

    /// Returns an error at this place.
    pub fn wrong(&self, problem: impl Into<String>) -> DescriptionError {
        let Place { file, line, column } = self;
        DescriptionError::Wrong { file: file.to_string(), line: *line, column: *column, problem: problem.into() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}", self.file, self.line)
    }
}

/// An element with its attributes, without namespaces.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Element {
    pub name: String,
    pub attributes: Vec<(String, String)>,
    pub children: Vec<Element>,
    /// The text, without blanks at both ends.
    pub text: String,
    pub place: Place,
}

impl Element {
    /// Reads a file.
    ///
    /// # Errors
    /// If the file cannot be read, is no XML, or is a xacro file.
    pub fn read(path: &Path) -> Result<Element, DescriptionError> {
        let unreadable = |reason: String| DescriptionError::Unreadable { file: path.display().to_string(), reason };
        let bytes = read_file(path).map_err(|problem| unreadable(problem.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|_| unreadable("it is not UTF-8 text".to_owned()))?;
        Self::parse(&text, path)
    }

    fn parse(text: &str, path: &Path) -> Result<Element, DescriptionError> {
        let start = Place::start_of(path);
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let document = match Document::parse(text) {
            Ok(document) => document,
            Err(roxmltree::Error::UnknownNamespace(prefix, at)) if prefix == "xacro" => {
                return Err(xacro(&Place { line: at.row, column: at.col, ..start }, path));
            }
            Err(error) => {
                let at = error.pos();
                return Err(Place { line: at.row, column: at.col, ..start }.wrong(format!("this is no XML: {error}")));
            }
        };
        let place = |node: Node| {
            let at = document.text_pos_at(node.range().start);
            Place { line: at.row, column: at.col, ..start.clone() }
        };
        let has_macros = |value: &str| value.contains("${") || value.contains("$(");
        let is_xacro = |node: &Node| {
            node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
                || node.attributes().any(|attribute| has_macros(attribute.value()))
        };
        if let Some(node) = document.descendants().find(|node| node.is_element() && is_xacro(node)) {
            return Err(xacro(&place(node), path));
        }
        Self::of(document.root_element(), &place, 0)
    }

    fn of(node: Node, place: &impl Fn(Node) -> Place, depth: usize) -> Result<Element, DescriptionError> {
        let at = place(node);
        if depth > DEEPEST {
            return Err(at.wrong(format!("elements are nested more than {DEEPEST} deep")));
        }
        let attribute = |attribute: roxmltree::Attribute| (attribute.name().to_owned(), attribute.value().to_owned());
        Ok(Element {
            name: node.tag_name().name().to_owned(),
            attributes: node.attributes().map(attribute).collect(),
            children: node
                .children()
                .filter(Node::is_element)
                .map(|child| Self::of(child, place, depth + 1))
                .collect::<Result<_, _>>()?,
            text: node.text().unwrap_or_default().trim().to_owned(),
            place: at,
        })
    }

    /// Returns the children with this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// Returns the first child with this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// Returns an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(own, _)| own == name).map(|(_, value)| value.as_str())
    }

    /// Returns a required attribute.
    ///
    /// # Errors
    /// If the attribute is missing.
    pub fn needs(&self, name: &str) -> Result<&str, DescriptionError> {
        self.attribute(name).ok_or_else(|| self.place.wrong(format!("<{}> has no `{name}`", self.name)))
    }

    /// Returns the numbers of an attribute, between `least` and `most` of them. Returns `None` if the attribute is missing.
    ///
    /// # Errors
    /// If there is another number of values, or a value is no number.
    pub fn numbers(&self, name: &str, least: usize, most: usize) -> Result<Option<Vec<f64>>, DescriptionError> {
        let Some(text) = self.attribute(name) else { return Ok(None) };
        let number = |word: &str| word.parse::<f64>().ok().filter(|number| number.is_finite());
        let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
        match numbers {
            Some(numbers) if (least..=most).contains(&numbers.len()) => Ok(Some(numbers)),
            _ => {
                let count = if least == most { least.to_string() } else { format!("{least} to {most}") };
                let what = if most == 1 { "a number".to_owned() } else { format!("{count} numbers") };
                Err(self.place.wrong(format!("`{name}` of <{}> is \"{text}\"; expected {what}", self.name)))
            }
        }
    }

    /// Returns the `N` numbers of an attribute. Returns `None` if the attribute is missing.
    ///
    /// # Errors
    /// If there is another number of values, or a value is no number.
    pub fn vector<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>, DescriptionError> {
        Ok(self.numbers(name, N, N)?.and_then(|numbers| numbers.try_into().ok()))
    }

    /// Returns the number of an attribute. Returns `None` if the attribute is missing.
    ///
    /// # Errors
    /// If the value is no number.
    pub fn number(&self, name: &str) -> Result<Option<f64>, DescriptionError> {
        Ok(self.vector::<1>(name)?.map(|[number]| number))
    }
}

fn xacro(place: &Place, path: &Path) -> DescriptionError {
    let from = path.display().to_string();
    let stem = from.strip_suffix(".xacro").unwrap_or(&from);
    let stem = stem.strip_suffix(".urdf").unwrap_or(stem);
    let to = if from.ends_with(".xacro") { format!("{stem}.urdf") } else { format!("{stem}_expanded.urdf") };
    place.wrong(format!("this is a xacro file, which has macros; expand it first: xacro {from} > {to}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Element, String> {
        Element::parse(text, Path::new("some/robot.urdf")).map_err(|error| error.to_string())
    }

    #[test]
    fn errors_have_file_line_and_column() {
        let text = "\u{feff}<robot name='r'>\r\n  <limit lower='1' upper='one'/>\r\n</robot>";
        let robot = parse(text).unwrap();
        let limit = robot.child("limit").unwrap();
        assert_eq!((limit.number("lower"), limit.number("effort")), (Ok(Some(1.0)), Ok(None)));
        let error = limit.number("upper").unwrap_err().to_string();
        assert_eq!(error, "robot.urdf:2:3: `upper` of <limit> is \"one\"; expected a number");
        let error = limit.needs("name").unwrap_err().to_string();
        assert_eq!(error, "robot.urdf:2:3: <limit> has no `name`");
        assert!(limit.number("NaN").is_ok() && limit.vector::<3>("lower").is_err());
        let broken = parse("<robot>\n<a></b></robot>").unwrap_err();
        assert!(broken.starts_with("robot.urdf:2:4: this is no XML"), "{broken}");
        let deep = format!("{}{}", "<a>".repeat(2000), "</a>".repeat(2000));
        assert!(parse(&deep).unwrap_err().contains("nested more than"));
    }

    #[test]
    fn xacro_is_refused_with_its_command() {
        let uri = "xmlns:xacro='http://www.ros.org/wiki/xacro'";
        let text = format!("<robot {uri}>\n  <xacro:property name='a' value='1'/>\n</robot>");
        let error = Element::parse(&text, Path::new("d/k.urdf.xacro")).unwrap_err().to_string();
        assert!(
            error.starts_with("k.urdf.xacro:2:3: ") && error.ends_with("xacro d/k.urdf.xacro > d/k.urdf"),
            "{error}"
        );
        assert!(parse("<robot><xacro:a/></robot>").unwrap_err().contains("xacro some/robot.urdf >"));
        // Expanded xacro files still have its namespace.
        parse(&format!("<robot {uri}><link name='a'/></robot>")).unwrap();
    }
}
