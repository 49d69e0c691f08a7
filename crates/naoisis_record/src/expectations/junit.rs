//! Writes verdicts as JUnit XML, which other tools display.

use core::fmt::{Display, Write};

use super::verdict::Verdict;

/// Returns a file of JUnit XML with the verdicts on each scenario, or the error why it could not be played.
pub fn junit<E: Display>(scenarios: &[(String, Result<Vec<Verdict>, E>)]) -> String {
    let mut suites = String::new();
    let (mut tests, mut failures, mut errors) = (0, 0, 0);
    for (scenario, outcome) in scenarios {
        let verdicts = outcome.as_deref().unwrap_or_default();
        let failed = verdicts.iter().filter(|verdict| !verdict.holds).count();
        let of_suite = [verdicts.len() + usize::from(outcome.is_err()), failed, usize::from(outcome.is_err())];
        [tests, failures, errors] = [tests + of_suite[0], failures + of_suite[1], errors + of_suite[2]];
        let scenario = escaped(scenario);
        // Writing to a string cannot fail.
        let _ = writeln!(suites, "  <testsuite name=\"{scenario}\" {}>", counts(of_suite));
        if let Err(error) = outcome {
            let message = escaped(&error.to_string());
            let _ = writeln!(
                suites,
                "    <testcase classname=\"{scenario}\" name=\"it can be played\"><error message=\"{message}\"/></testcase>"
            );
        }
        for verdict in verdicts {
            let name = escaped(&verdict.expectation.to_string());
            let _ = write!(suites, "    <testcase classname=\"{scenario}\" name=\"{name}\"");
            let _ = if verdict.holds {
                writeln!(suites, "/>")
            } else {
                writeln!(suites, "><failure message=\"{}\"/></testcase>", escaped(&verdict.found))
            };
        }
        suites.push_str("  </testsuite>\n");
    }
    let counts = counts([tests, failures, errors]);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"naoisis\" {counts}>\n{suites}</testsuites>\n"
    )
}

fn counts([tests, failures, errors]: [usize; 3]) -> String {
    format!("tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\"")
}

/// Escapes a text for an XML attribute, without control characters, which XML forbids.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            letter if letter.is_control() => escaped.push(' '),
            letter => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_are_test_cases() {
        let verdict =
            |text: &str, holds| Verdict { expectation: text.parse().unwrap(), holds, found: "it was 0".to_owned() };
        let verdicts = vec![verdict("blue.goals >= 1", false), verdict("pink.kicks < 3", true)];
        assert_eq!(
            junit(&[
                ("my \"test\"".to_owned(), Ok(verdicts)),
                ("wrong".to_owned(), Err("no <field>\nhere".to_owned()))
            ]),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <testsuites name=\"naoisis\" tests=\"3\" failures=\"1\" errors=\"1\">\n\
             \x20 <testsuite name=\"my &quot;test&quot;\" tests=\"2\" failures=\"1\" errors=\"0\">\n\
             \x20   <testcase classname=\"my &quot;test&quot;\" name=\"blue.goals &gt;= 1\"><failure message=\"it was 0\"/></testcase>\n\
             \x20   <testcase classname=\"my &quot;test&quot;\" name=\"pink.kicks &lt; 3\"/>\n\
             \x20 </testsuite>\n\
             \x20 <testsuite name=\"wrong\" tests=\"1\" failures=\"0\" errors=\"1\">\n\
             \x20   <testcase classname=\"wrong\" name=\"it can be played\"><error message=\"no &lt;field&gt; here\"/></testcase>\n\
             \x20 </testsuite>\n</testsuites>\n"
        );
    }
}
