//! Numbers for people, and pieces of the page.

use crate::markup::escape;

/// A number with about four digits.
pub(crate) fn number(value: f64) -> String {
    let digits = if value == 0.0 { 0 } else { libm::floor(libm::log10(value.abs())) as i32 };
    let decimals = usize::try_from((3 - digits).clamp(0, 4)).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    // No minus sign before a zero.
    let is_zero = text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.'));
    if is_zero { "0".to_owned() } else { text.replace('-', "−") }
}

/// A value with its unit, which stays on its line.
pub(crate) fn value(value: f64, unit: &str) -> String {
    if unit.is_empty() { number(value) } else { format!("{}\u{a0}{}", number(value), escape(unit)) }
}

/// A value that may be missing.
pub(crate) fn or_dash(value: Option<String>) -> String {
    value.unwrap_or_else(|| "–".to_owned())
}

/// A count, its digits in threes from ten thousand on.
pub(crate) fn count(n: u64) -> String {
    let digits = n.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

/// A share in per cent.
pub(crate) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    match percent {
        0.0 => "0\u{a0}%".to_owned(),
        p if p < 0.1 => "<0.1\u{a0}%".to_owned(),
        p if p < 9.95 => format!("{p:.1}\u{a0}%"),
        p => format!("{p:.0}\u{a0}%"),
    }
}

/// A count with what is counted: `1 run`, `3 runs`.
pub(crate) fn counted(n: u64, what: &str) -> String {
    format!("{}\u{a0}{what}{}", count(n), if n == 1 { "" } else { "s" })
}

/// A time span.
pub(crate) fn span(seconds: f64) -> String {
    let s = seconds.round().max(0.0) as u64;
    match s {
        0..60 => format!("{s}\u{a0}s"),
        60..3600 => format!("{}\u{a0}min {}\u{a0}s", s / 60, s % 60),
        _ => format!("{}\u{a0}h {}\u{a0}min", s / 3600, s % 3600 / 60),
    }
}

/// A table: its head, then its rows. Cells are markup. Columns whose name begins with `#` hold numbers.
pub(crate) fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let class =
        |i: usize| if head.get(i).is_some_and(|name| name.starts_with('#')) { " class=\"n\"" } else { "" };
    let line = |tag: &str, cells: &[String]| {
        let cells: String =
            cells.iter().enumerate().map(|(i, cell)| format!("<{tag}{}>{cell}</{tag}>", class(i))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let names: Vec<String> = head.iter().map(|name| name.trim_start_matches('#').to_owned()).collect();
    let rows: String = rows.iter().map(|row| line("td", row)).collect();
    format!(
        "<div class=\"table\"><table>\n<thead>{}</thead>\n<tbody>{rows}</tbody></table></div>\n",
        line("th", &names)
    )
}

/// A paragraph of plain words.
pub(crate) fn paragraph(sentences: &[String]) -> String {
    let text: Vec<&str> = sentences.iter().map(String::as_str).filter(|s| !s.is_empty()).collect();
    if text.is_empty() { String::new() } else { format!("<p>{}</p>\n", text.join(" ")) }
}

/// Pictures side by side.
pub(crate) fn figures(pictures: &[String]) -> String {
    let all: String = pictures.iter().map(|picture| format!("<figure>{picture}</figure>\n")).collect();
    format!("<div class=\"figures\">{all}</div>\n")
}

/// What marks mean: the class of each mark, and words.
pub(crate) fn key(marks: &[(String, String)]) -> String {
    let marks: String = marks
        .iter()
        .map(|(class, text)| format!("<span><i class=\"{class}\"></i>{}</span>", escape(text)))
        .collect();
    format!("<p class=\"key\">{marks}</p>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        let numbers = [0.0, -0.00001, 83.0331, -108.32604, 0.55348, 12345.6, 9.99999].map(number);
        assert_eq!(numbers, ["0", "0", "83.03", "−108.3", "0.5535", "12346", "10.000"]);
        assert_eq!(
            [9999, 10_000, 1_234_567].map(count),
            ["9999", "10\u{202f}000", "1\u{202f}234\u{202f}567"]
        );
        let shares = [0.0, 0.0001, 0.0123, 0.1, 0.999, 1.0].map(percent);
        assert_eq!(
            shares.map(|s| s.replace('\u{a0}', " ")),
            ["0 %", "<0.1 %", "1.2 %", "10 %", "100 %", "100 %"]
        );
        assert_eq!(
            [59.4, 60.0, 3700.0].map(|s| span(s).replace('\u{a0}', " ")),
            ["59 s", "1 min 0 s", "1 h 1 min"]
        );
        assert_eq!((counted(1, "run"), counted(2, "run")), ("1\u{a0}run".into(), "2\u{a0}runs".into()));
    }
}
