//! Reports errors of the commands.

use core::fmt;
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode};
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use super::visible::{visible, visible_in_place};
use naoisis_sim::scenario::ScenarioError;
use naoisis_sim::scenario::wording::shortened;

/// Exit status for errors in arguments or files.
pub const USAGE_ERROR: u8 = 2;

/// Reports a failure of a running command. Returns exit status 1.
pub fn failure(message: &str) -> ExitCode {
    print_error(&format!("error: {message}"));
    ExitCode::FAILURE
}

/// Reports an error in arguments or files. Returns exit status 2.
pub fn usage_error(message: &str) -> ExitCode {
    print_error(&format!("error: {message}"));
    ExitCode::from(USAGE_ERROR)
}

/// Reports an error of a scenario file, with the lines around it on a terminal. Returns exit status 2.
pub fn scenario_error(error: &ScenarioError) -> ExitCode {
    let style = if io::stderr().is_terminal() { Style::of_terminal() } else { Style::Paragraph };
    print_rendered(&rendered(error, style));
    ExitCode::from(USAGE_ERROR)
}

/// Reports all errors of a scenario. Returns exit status 2.
pub fn scenario_errors(errors: &[ScenarioError]) -> ExitCode {
    for error in errors {
        scenario_error(error);
    }
    ExitCode::from(USAGE_ERROR)
}

/// Prints a message that is not an error.
pub fn note(message: &str) {
    print_error(message);
}

fn print_error(text: &str) {
    print_rendered(&visible(&shortened(text)));
}

/// Prints a text that may contain control characters.
fn print_rendered(text: &str) {
    // If standard error is closed, the text is dropped.
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Style in which an error of a scenario file is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Style {
    /// One paragraph, for files and other programs.
    Paragraph,
    /// With the lines around it.
    Snippet,
    /// With the lines around it, in colours.
    ColouredSnippet,
}

impl Style {
    fn of_terminal() -> Style {
        if std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty()) {
            Style::Snippet
        } else {
            Style::ColouredSnippet
        }
    }
}

fn rendered(error: &ScenarioError, style: Style) -> String {
    let mut theme = match style {
        Style::Paragraph => return visible(&shortened(&format!("error: {error}"))).into_owned(),
        Style::Snippet => GraphicalTheme::unicode_nocolor(),
        Style::ColouredSnippet => GraphicalTheme::unicode(),
    };
    "error:".clone_into(&mut theme.characters.error);
    let source = error.place().map(|place| NamedSource::new(visible(error.file()), visible_in_place(place.text())));
    let handler = GraphicalReportHandler::new_themed(theme).with_wrap_lines(false).with_links(false);
    let mut text = String::new();
    match handler.render_report(&mut text, &Report { error, source }) {
        Ok(()) => text.trim().to_owned(),
        Err(fmt::Error) => visible(&format!("error: {error}")).into_owned(),
    }
}

/// An error of a scenario in the form for miette.
#[derive(Debug)]
struct Report<'a> {
    error: &'a ScenarioError,
    source: Option<NamedSource<String>>,
}

impl fmt::Display for Report<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&visible(&shortened(&self.error.headline())))
    }
}

impl std::error::Error for Report<'_> {}

impl Diagnostic for Report<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(visible(&format!("expected {}", self.error.expected())).into_owned()))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let place = self.error.place()?;
        let label = LabeledSpan::new(Some("here".to_owned()), place.span.start, place.span.len());
        Some(Box::new(core::iter::once(label)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::{Format, Scenario};

    fn error() -> ScenarioError {
        Scenario::from_text("(\n  sede: 2,\n)\n", Format::Ron, "typo.ron").expect_err("a misspelled field")
    }

    #[test]
    fn without_a_terminal_an_error_is_one_paragraph() {
        let text = rendered(&error(), Style::Paragraph);
        let start = "error: typo.ron:2:3: there is no field `sede`: did you mean `seed`? expected `name`, ";
        assert!(text.starts_with(start) && !text.contains('\n'), "{text}");
    }

    #[test]
    fn on_a_terminal_it_shows_the_line() {
        let text = rendered(&error(), Style::Snippet);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "error: typo.ron:2:3: there is no field `sede`: did you mean `seed`?", "{text}");
        assert!(lines.iter().any(|line| line.contains("2 │   sede: 2,")), "{text}");
        assert!(text.contains("╰── here") && text.contains("help: expected `name`"), "{text}");
        assert!(!text.contains('\u{1b}'));
        assert!(rendered(&error(), Style::ColouredSnippet).contains('\u{1b}'));
    }

    #[test]
    fn what_a_file_says_to_the_terminal_does_not_reach_it() {
        let text = "(\n  name: \"\u{1b}[2J\", sede: 2,\n)\n";
        let error = Scenario::from_text(text, Format::Ron, "\u{1b}.ron").expect_err("a misspelled field");
        for style in [Style::Paragraph, Style::Snippet] {
            assert!(!rendered(&error, style).contains('\u{1b}'));
        }
        assert!(!rendered(&error, Style::ColouredSnippet).contains("\u{1b}[2J"));
    }

    #[test]
    fn an_error_without_a_place_has_no_snippet() {
        let missing = Scenario::find("nowhere.ron").expect_err("a missing file");
        assert!(rendered(&missing, Style::Snippet).starts_with("error: nowhere.ron: there is no such file"));
    }
}
