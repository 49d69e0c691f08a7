//! Reports errors of the commands.

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use core::fmt::Display;
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

/// The exit status of a command. It is an error if a problem, which has been reported, ended the command.
pub type CommandResult = Result<ExitCode, ExitCode>;

/// Reports errors that end a command. The error of the result is the exit status.
pub trait OrReport<T> {
    /// Reports an error in arguments or files.
    ///
    /// # Errors
    /// Exit status 2.
    fn or_usage_error(self) -> Result<T, ExitCode>;

    /// Reports a failure of a running command.
    ///
    /// # Errors
    /// Exit status 1.
    fn or_failure(self) -> Result<T, ExitCode>;
}

impl<T, E: Display> OrReport<T> for Result<T, E> {
    fn or_usage_error(self) -> Result<T, ExitCode> {
        self.map_err(|error| usage_error(&error.to_string()))
    }

    fn or_failure(self) -> Result<T, ExitCode> {
        self.map_err(|error| failure(&error.to_string()))
    }
}

/// Reports an error of a scenario file, with its line on a terminal. Returns exit status 2.
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

/// A text in which no word has more than 100 letters.
pub fn with_short_words(text: &str) -> String {
    const LONGEST: usize = 100;

    let short = |word: &str| match word.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…{}", &word[..end], &word[word.trim_end().len()..]),
        None => word.to_owned(),
    };
    text.split_inclusive(char::is_whitespace).map(short).collect()
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
    /// With its line.
    Snippet,
    /// With its line, in colours.
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
    let renderer = match style {
        Style::Paragraph => return visible(&shortened(&format!("error: {error}"))).into_owned(),
        Style::Snippet => Renderer::plain(),
        Style::ColouredSnippet => Renderer::styled(),
    };
    let headline = visible(&shortened(&error.headline())).into_owned();
    let expected = visible(&format!("expected {}", error.expected())).into_owned();
    let snippet = error.place().map(|place| {
        let here = AnnotationKind::Primary.span(place.span.clone()).label("here");
        Snippet::source(visible_in_place(place.text())).annotation(here)
    });
    let report = Group::with_title(Level::ERROR.primary_title(headline)).elements(snippet);
    let report = report.element(Level::HELP.message(expected));
    renderer.decor_style(DecorStyle::Unicode).render(&[report])
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
        assert!(text.contains("here") && text.contains("help: expected `name`"), "{text}");
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
