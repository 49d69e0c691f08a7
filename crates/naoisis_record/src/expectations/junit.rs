//! Writes verdicts as JUnit XML, which other tools display.

use core::fmt::Write;

use super::verdict::Verdict;

/// Returns the verdicts on each scenario as a JUnit XML file.
pub fn junit(scenarios: &[(String, Vec<Verdict>)]) -> String {
    let all = || scenarios.iter().flat_map(|(_, verdicts)| verdicts);
    let failures = |verdicts: &[Verdict]| verdicts.iter().filter(|verdict| !verdict.holds).count();
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let failed = all().filter(|verdict| !verdict.holds).count();
    // Writing to a string cannot fail.
    let _ = writeln!(text, "<testsuites name=\"naoisis\" tests=\"{}\" failures=\"{failed}\">", all().count());
    for (scenario, verdicts) in scenarios {
        let (scenario, tests, failed) = (escaped(scenario), verdicts.len(), failures(verdicts));
        let _ = writeln!(text, "  <testsuite name=\"{scenario}\" tests=\"{tests}\" failures=\"{failed}\">");
        for verdict in verdicts {
            let name = escaped(&verdict.expectation.to_string());
            let _ = write!(text, "    <testcase classname=\"{scenario}\" name=\"{name}\"");
            let _ = if verdict.holds {
                writeln!(text, "/>")
            } else {
                writeln!(text, "><failure message=\"{}\"/></testcase>", escaped(&verdict.found))
            };
        }
        text.push_str("  </testsuite>\n");
    }
    text.push_str("</testsuites>\n");
    text
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
            junit(&[("my \"test\"".to_owned(), verdicts)]),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <testsuites name=\"naoisis\" tests=\"2\" failures=\"1\">\n\
             \x20 <testsuite name=\"my &quot;test&quot;\" tests=\"2\" failures=\"1\">\n\
             \x20   <testcase classname=\"my &quot;test&quot;\" name=\"blue.goals &gt;= 1\"><failure message=\"it was 0\"/></testcase>\n\
             \x20   <testcase classname=\"my &quot;test&quot;\" name=\"pink.kicks &lt; 3\"/>\n\
             \x20 </testsuite>\n</testsuites>\n"
        );
    }
}
