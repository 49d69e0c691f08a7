//! What reaches the terminal: nothing there can be told from what a file says to it, and what cannot be printed fails.

use core::fmt;
use std::borrow::Cow;
use std::io::{self, Write};
use std::process::ExitCode;

use super::report;

/// Standard output, or standard error in its place, as the commands print to it. Whoever closes it has seen enough: the
/// rest goes nowhere, quietly. Any other failure is said at the end.
#[derive(Debug, Default)]
pub struct Printer {
    is_stderr: bool,
    error: Option<io::Error>,
}

impl Printer {
    /// Prints to standard error, where standard output is taken by something else.
    pub fn to_stderr() -> Self {
        Self { is_stderr: true, error: None }
    }

    /// Prints a text, with its control characters made visible.
    pub fn print(&mut self, text: impl fmt::Display) {
        if self.error.is_some() {
            return;
        }
        let text = text.to_string();
        let text = visible(&text);
        let printed =
            if self.is_stderr { write(io::stderr().lock(), &text) } else { write(io::stdout().lock(), &text) };
        self.error = printed.err();
    }

    /// Whether nothing more can be printed.
    pub fn is_closed(&self) -> bool {
        self.error.is_some()
    }

    /// The exit status of a command that would end with `status`: a failure, which is said, if something that was wanted
    /// could not be printed.
    pub fn finish(self, status: ExitCode) -> ExitCode {
        match self.error {
            Some(error) if error.kind() != io::ErrorKind::BrokenPipe => {
                let name = if self.is_stderr { "standard error" } else { "standard output" };
                report::failure(&format!("cannot write to {name}: {error}"))
            }
            _ => status,
        }
    }
}

fn write(mut stream: impl Write, text: &str) -> io::Result<()> {
    stream.write_all(text.as_bytes())?;
    stream.flush()
}

/// A text with its control characters, and those that turn the direction of reading, as escapes such as `\u{1b}`.
/// Lines stay lines.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if is_hidden(character) {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

/// A text with every control character replaced by a visible one of as many bytes, so that places in it stay the same.
pub fn visible_in_place(text: &str) -> String {
    let replacement = |character: char| match character.len_utf8() {
        1 => '?',
        2 => '¿',
        _ => char::REPLACEMENT_CHARACTER,
    };
    text.chars().map(|character| if is_hidden(character) { replacement(character) } else { character }).collect()
}

/// Whether a terminal would act on a character rather than show it.
fn is_hidden(character: char) -> bool {
    let turns_reading = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    turns_reading || (character.is_control() && !matches!(character, '\n' | '\t'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_would_act_on_is_shown_instead() {
        assert_eq!(visible("über\tall\n\u{1b}[31mred\r\u{9b}2J\u{7f}"), "über\tall\n\\u{1b}[31mred\\r\\u{9b}2J\\u{7f}");
        assert_eq!(visible("a\u{202e}b"), "a\\u{202e}b");
        assert!(matches!(visible("plain\n"), Cow::Borrowed(_)));
        let text = "ä\u{1b}[1m\u{9b}\u{202e}\n";
        let replaced = visible_in_place(text);
        assert_eq!((replaced.len(), replaced.as_str()), (text.len(), "ä?[1m¿\u{fffd}\n"));
    }
}
