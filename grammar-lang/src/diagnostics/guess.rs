//! Guesses what a misspelt word was meant to be.

use super::Fix;
use crate::source::Span;

/// Nobody misspells a word that is longer, in bytes: comparing two takes as long as both lengths multiplied.
const LONGEST: usize = 64;

/// How many slips of the finger lie between two words, whatever their capitals.
fn distance(word: &str, candidate: &str) -> usize {
    strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase())
}

/// Whether so few slips can lie between two words, as far as their lengths and letters say: nearly all
/// words are told apart by these, and [`distance`] takes long.
fn may_be_within(word: &str, candidate: &str, most: usize) -> bool {
    // One bit for each letter, small or capital. A slip takes one away, adds one, or both.
    let letters = |text: &str| match text.is_ascii() {
        true => (text.bytes().fold(0u32, |all, b| all | 1 << (b & 31)), text.len()),
        false => text
            .chars()
            .flat_map(char::to_lowercase)
            .fold((0, 0), |(all, length), c| (all | 1 << (u32::from(c) & 31), length + 1)),
    };
    let ((word, length), (candidate, other)) = (letters(word), letters(candidate));
    length.abs_diff(other) <= most && (word ^ candidate).count_ones() as usize <= 2 * most
}

/// How many slips of the finger are likely in words of this length.
fn likely(word: &str, candidate: &str) -> usize {
    let (word, candidate) = (word.chars().count(), candidate.chars().count());
    // One letter is no slip of another.
    if word == 1 && candidate == 1 { 0 } else { 1.max(word.min(candidate) / 3) }
}

/// The word among `candidates` that `word` was probably meant to be.
#[must_use]
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .filter(|c| word.len().max(c.len()) <= LONGEST && may_be_within(word, c, likely(word, c)))
        .map(|c| (distance(word, c), c))
        .filter(|(distance, c)| *distance <= likely(word, c))
        .min_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(b.1)))
        .map(|(_, c)| c)
}

/// The only candidate of which a word is the first part: `hinge` of `hinge_model`.
fn begun<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let is_begun = |c: &str| word.len() > 3 && c.strip_prefix(word).is_some_and(|rest| rest.starts_with('_'));
    let mut those = candidates.iter().copied().filter(|c| is_begun(c));
    let only = those.next()?;
    those.all(|c| c == only).then_some(only)
}

/// How the ends of ranges are called elsewhere, and here.
const ENDS: [(&str, &str); 4] =
    [("max_", "greatest_"), ("maximum_", "greatest_"), ("min_", "least_"), ("minimum_", "least_")];

/// The candidate that a word means in other words: `greatest_distance` for `max_distance`.
fn renamed<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let own = |(theirs, ours): &(&str, &str)| Some(format!("{ours}{}", word.strip_prefix(theirs)?));
    let own = ENDS.iter().find_map(own)?;
    candidates.iter().copied().find(|c| *c == own)
}

/// Whether one is about the upper end of a range, and the other about the lower.
fn are_opposite(a: &str, b: &str) -> bool {
    let begins = |word: &str, with: [&str; 2]| with.iter().any(|start| word.starts_with(start));
    let (upper, lower) = (["max", "greatest"], ["min", "least"]);
    begins(a, upper) && begins(b, lower) || begins(a, lower) && begins(b, upper)
}

/// "did you mean `x`?" for the nearest candidate, or the only one that begins with the word.
#[must_use]
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let meant = renamed(word, &candidates)
        .or_else(|| nearest(word, candidates.iter().copied()).filter(|c| !are_opposite(word, c)))
        .or_else(|| begun(word, &candidates));
    meant.filter(|c| *c != word).map(|c| format!("did you mean `{c}`?"))
}

/// The word that `word` was certainly meant to be: no other candidate is as near, the two are one slip of the fingers apart,
/// the word is long enough to be recognised, and it is no sibling of the other. Words that
/// differ by another letter are two words: `bell` is no `ball`, `max_gain` no `min_gain`, `symmetric` no `asymmetric`.
#[must_use]
pub fn sure<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let found = nearest(word, candidates.iter().copied())?;
    let near = distance(word, found);
    let farther = |c: &str| !may_be_within(word, c, near) || c.len() <= LONGEST && distance(word, c) > near;
    let alone = candidates.iter().all(|c| *c == found || farther(c));
    let (length, other) = (word.chars().count(), found.chars().count());
    let likely = match length.min(other) {
        0..=2 => 0,
        3 if length == other || length < 4 => swapped(word, found),
        4 if length == other => swapped(word, found),
        _ => 1,
    };
    (alone && near <= likely && is_slip(word, found) && !siblings(word, found)).then_some(found)
}

/// Whether two words differ as typing goes wrong, and hardly as words are told apart on purpose: by capitals, by two
/// neighbouring letters that changed places, by a letter that is missing or too much inside of the word, or doubled, or
/// by `-ise` and `-ize`.
fn is_slip(word: &str, found: &str) -> bool {
    let letters = |text: &str| text.to_lowercase().chars().collect::<Vec<char>>();
    let (a, b) = (letters(word), letters(found));
    let begin = a.iter().zip(&b).take_while(|(a, b)| a == b).count();
    let end = a[begin..].iter().rev().zip(b[begin..].iter().rev()).take_while(|(a, b)| a == b).count();
    let (longer, middle) = if a.len() > b.len() { (&a, &b) } else { (&b, &a) };
    let rest = (&longer[begin..longer.len() - end], &middle[begin..middle.len() - end]);
    match rest {
        ([], []) => true,
        ([first, second], [other, last]) => first == last && second == other,
        // British and American: `maximise`, `maximize`.
        (['s'], ['z']) | (['z'], ['s']) => begin > 0 && longer[begin - 1] == 'i' && end > 0,
        ([letter], []) => {
            let inside = begin > 0 && end > 0;
            let doubled = begin.checked_sub(1).is_some_and(|before| longer[before] == *letter);
            inside || doubled
        }
        _ => false,
    }
}

/// 1 if two words have the same letters, else 0: how many slips a short word may have.
fn swapped(a: &str, b: &str) -> usize {
    let sorted = |text: &str| {
        let mut letters: Vec<char> = text.to_lowercase().chars().collect();
        letters.sort_unstable();
        letters
    };
    usize::from(sorted(a) == sorted(b))
}

/// Whether two names are told apart on purpose: by a number, as `leg_1` and `leg_2`, or by an
/// initial, as `leg_l` and `leg_r`.
fn siblings(a: &str, b: &str) -> bool {
    let digits = |text: &str| text.chars().filter(|c| c.is_numeric()).collect::<String>();
    let initials = a.split('_').zip(b.split('_')).any(|(a, b)| a != b && a.len().min(b.len()) <= 1);
    digits(a) != digits(b) || a.contains('_') && initials
}

/// The fix that replaces a misspelt word, where it is certain what was meant.
#[must_use]
pub fn respell<'a>(span: Span, word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<Fix> {
    let meant = sure(word, candidates).filter(|meant| *meant != word)?;
    Some(Fix::replace(span, meant, format!("write `{meant}` instead of `{word}`")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_guess_is_sure_only_if_nothing_else_is_as_near() {
        assert_eq!(sure("cueb", ["cube", "ball"]), Some("cube"));
        assert_eq!(sure("Cube", ["cube", "ball"]), Some("cube"));
        assert_eq!(nearest("cubs", ["cube", "cubo"]), Some("cube"));
        assert_eq!(sure("cubs", ["cube", "cubo"]), None, "two are as near");
        assert_eq!(sure("maximise", ["maximize", "minimize"]), Some("maximize"));
        assert_eq!(sure("buss", ["buzz"]), None, "neither British nor American");
        assert_eq!(sure("leg_2", ["leg_1"]), None, "another number is no slip");
        assert_eq!(sure("leg_l", ["leg_r"]), None, "another initial is no slip");
        assert_eq!(sure("leg_lenght", ["leg_length"]), Some("leg_length"));
        assert_eq!(sure("p", ["q"]), None, "too short to be recognised");
        let long = "leg".repeat(1_000_000);
        assert_eq!(nearest(&format!("{long}s"), [long.as_str()]), None, "too long to be compared");
        assert_eq!(sure("brick", ["cube"]), None);
        assert_eq!(sure("len", ["ln", "abs"]), None, "another function");
        assert_eq!(sure("bell", ["ball"]), None, "another word");
        assert_eq!(sure("blal", ["ball"]), Some("ball"));
        assert_eq!(sure("balll", ["ball"]), Some("ball"));
        assert_eq!(sure("lett", ["let", "set"]), Some("let"));
        assert_eq!(sure("repeat", ["revert", "replace"]), None, "two slips in a short word");
        assert_eq!(sure("workshp", ["workshop"]), Some("workshop"));
        assert_eq!(sure("flors", ["floors"]), Some("floors"));
        for (word, other) in [
            ("min_gain", "max_gain"),
            ("decrease", "increase"),
            ("deflation", "inflation"),
            ("internal", "external"),
            ("north_east", "north_west"),
            ("unbalanced", "balanced"),
            ("unweighted", "weighted"),
            ("asymmetric", "symmetric"),
            ("gainB", "gainA"),
            ("amplitude_up", "amplitude_dn"),
            ("foot_lift", "foot_left"),
            ("swung", "swing"),
            ("legs", "leg"),
        ] {
            assert_eq!(sure(word, [other]), None, "{word} and {other}");
            assert_eq!(sure(other, [word]), None, "{other} and {word}");
        }
        assert_eq!(nearest("r", ["p", "q"]), None, "another letter is no slip");
        assert_eq!(nearest("P", ["p", "q"]), Some("p"));
        assert_eq!(did_you_mean("mirror", ["mirror"]), None, "a word is no guess for itself");
    }
}
