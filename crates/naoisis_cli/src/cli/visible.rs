//! Escapes characters that a terminal would interpret.

use std::borrow::Cow;

/// Returns the text with control characters, and those that change the direction of text, as escapes such as `\u{1b}`. Line ends are kept.
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

/// Returns the text with every control character replaced by a visible one of the same number of bytes, so that positions stay valid.
pub fn visible_in_place(text: &str) -> String {
    let replacement = |character: char| match character.len_utf8() {
        1 => '?',
        2 => '¿',
        _ => char::REPLACEMENT_CHARACTER,
    };
    text.chars().map(|character| if is_hidden(character) { replacement(character) } else { character }).collect()
}

/// Returns whether a terminal would interpret the character instead of showing it.
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
