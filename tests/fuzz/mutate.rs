//! Mutates grammars by what they are made of: words, numbers, signs and lines.

/// A stream of random numbers: the same from the same seed.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number below `n`; 0 if there is none.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// One of the words of a text.
    fn word(&mut self, words: &'static str) -> &'static str {
        let at = self.below(words.split(' ').count());
        words.split(' ').nth(at).unwrap_or("")
    }

    /// One of several.
    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// Words and signs that mean something, or nearly.
const WORDS: &str = "\
    grammar use param part actuator symmetry begin rule require pattern actuation actuate model simulate \
    term maximize minimize search let enum record prefer task example variant place match choose when \
    unless attach set revert weight shared vary drive mutate flip bound because turned in for with where to \
    by of over at is adds and or not if then else otherwise forall exists true false nothing narrow drop \
    replace remove target step refuse expect add from about facing per as free port block core joint \
    elements count sum mean min max temperature iteration best idle gain cycle t pi start end duration \
    period connected no_overlap neighbours images bezier each repeat first last normal uniform clamp floor \
    sqrt exp ln sense state next noise delay now velocity load angle_rate sensors vector box sphere disk cylinder x p q a segments turn twin holder image depth mass density \
    shape friction cube ball bender travel fall Count Length Angle Bool Number Text Pattern radial mirror \
    none xy cm deg g s N*m/rad %";
const SIGNS: &str = "{ } ( ) [ ] , : = == != <= >= < > .. . + - * / -> \" # ## \\ ; @ %";
const NUMBERS: &[&str] = &[
    "0",
    "1",
    "2",
    "-1",
    "0.0",
    "0.5",
    "1.5",
    "3",
    "64",
    "65",
    "1000",
    "1e9",
    "1e15",
    "9007199254740993",
    "1e300",
    "1e308",
    "1e-300",
    "1e-320",
    "99999999999999999999999",
    "1e999",
    "0.1",
    "1 / 0",
    "0 / 0",
    "0 deg",
    "90 deg",
    "1e300 cm",
    "-1 cm",
    "1e-300 g",
    "3 mm",
    "1 s / 240",
];
const STRANGE: &[&str] = &[
    "\u{FEFF}",
    "\u{200B}",
    "\u{202E}",
    "\u{A0}",
    "\u{301}",
    "😀",
    "𝔘",
    "é",
    "µ",
    "°",
    "\r",
    "\r\n",
    "\t",
    "\u{0C}",
    "\u{0B}",
    "\0",
    "\u{FFFD}",
    "\u{2028}",
    "\u{85}",
    "“",
    "−",
    "\n\n",
    "\u{10FFFF}",
];

/// The pieces of a text, which make it up again: words, numbers, texts, spaces, signs.
pub fn pieces(text: &str) -> Vec<&str> {
    let kind = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' => 0,
        '\n' => 1,
        c if c.is_whitespace() => 2,
        _ => 3,
    };
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let kind_here = kind(first);
        let end = if kind_here == 1 || kind_here == 3 {
            first.len_utf8()
        } else {
            rest.find(|c| kind(c) != kind_here).unwrap_or(rest.len())
        };
        let (piece, after) = rest.split_at(end);
        pieces.push(piece);
        rest = after;
    }
    pieces
}

/// A text with some mutations; it may borrow from the others.
pub fn mutated(text: &str, corpus: &[String], random: &mut Random) -> String {
    let mut text = text.to_owned();
    for _ in 0..1 + random.below(4) {
        text = if random.below(3) == 0 { lines(&text, corpus, random) } else { tokens(&text, random) };
    }
    text
}

/// A text with some small mutations, after which it is likely to be as sound as before.
pub fn gently(text: &str, random: &mut Random) -> String {
    let mut text = text.to_owned();
    for _ in 0..1 + random.below(3) {
        text = match random.below(9) {
            0..3 => number(&text, random),
            3..5 => exchanged(&text, random),
            5 => renamed(&text, random),
            _ => clauses(&text, random),
        };
    }
    text
}

/// Words and signs in the place of which others of the same set can stand.
const EXCHANGED: &[&[&str]] = &[
    &["<", ">"],
    &["+", "-"],
    &["*", "/"],
    &["and", "or"],
    &["when", "unless"],
    &["min", "max"],
    &["maximize", "minimize"],
    &["forall", "exists"],
    &["front", "back", "left", "right", "top", "bottom"],
    &["part", "block", "actuator"],
    &["cube", "ball"],
    &["xy", "yz", "xz"],
    &["clamp", "reflect", "resample"],
    &["start", "end"],
    &["true", "false"],
];

fn number(text: &str, random: &mut Random) -> String {
    let mut pieces: Vec<String> = pieces(text).into_iter().map(str::to_owned).collect();
    let numbers: Vec<usize> = (0..pieces.len()).filter(|i| pieces[*i].parse::<u32>().is_ok()).collect();
    if !numbers.is_empty() {
        let at = *random.pick(&numbers);
        let old: u64 = pieces[at].parse().unwrap_or(1);
        pieces[at] =
            [old + 1, old.saturating_sub(1), old * 2, old / 2, 0, 1, 2, 10][random.below(8)].to_string();
    }
    pieces.concat()
}

fn exchanged(text: &str, random: &mut Random) -> String {
    let mut pieces = pieces(text);
    let set = |piece: &str| EXCHANGED.iter().find(|set| set.contains(&piece));
    let blank = |piece: Option<&&str>| piece.is_some_and(|p| p.trim().is_empty());
    // A sign that stands alone, as that of an operator does.
    let alone = |i: usize| pieces[i].len() > 1 || (blank(pieces.get(i.wrapping_sub(1))) && i > 0);
    let places: Vec<usize> = (0..pieces.len()).filter(|i| set(pieces[*i]).is_some() && alone(*i)).collect();
    if !places.is_empty() {
        let at = *random.pick(&places);
        let others = set(pieces[at]).copied().unwrap_or_default();
        pieces[at] = random.pick::<&str>(others);
    }
    pieces.concat()
}

/// Gives one name another one wherever it stands.
fn renamed(text: &str, random: &mut Random) -> String {
    let names: Vec<&str> = text.lines().filter_map(declared).collect();
    let Some(name) = (!names.is_empty()).then(|| *random.pick::<&str>(&names)) else {
        return text.to_owned();
    };
    let other = format!("{name}_{}", random.below(1000));
    pieces(text).into_iter().map(|piece| if piece == name { other.as_str() } else { piece }).collect()
}

/// What a line declares.
fn declared(line: &str) -> Option<&str> {
    let mut words = line.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|w| !w.is_empty());
    let word = words.next().filter(|_| line.starts_with(char::is_alphabetic))?;
    let declares = ["rule", "part", "actuator", "actuation", "term", "let", "param", "pattern", "require"];
    declares.contains(&word).then(|| words.next())?
}

/// One mutation of a declaration or of a clause: left out, said twice, or said earlier.
fn clauses(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<String> = text.split_inclusive('\n').map(str::to_owned).collect();
    let begins = |line: &String| ["rule ", "require ", "prefer "].iter().any(|w| line.starts_with(w));
    let is_clause = |line: &String| line.starts_with("  ") && !line.trim().is_empty();
    let whole: Vec<usize> = (0..lines.len()).filter(|i| begins(&lines[*i])).collect();
    let inner: Vec<usize> = (0..lines.len()).filter(|i| is_clause(&lines[*i])).collect();
    match random.below(5) {
        kind @ (0 | 1) if !whole.is_empty() => {
            let at = *random.pick(&whole);
            let open = lines[at].trim_end().ends_with('{');
            let length = lines[at..].iter().position(|l| !open || l.starts_with('}')).unwrap_or(0) + 1;
            let end = (at + length).min(lines.len());
            let mut again = lines[at..end].to_vec();
            if kind == 0 {
                lines.drain(at..end);
            } else {
                // Two of a name are an error.
                if let Some(name) = declared(&again[0]).map(str::to_owned) {
                    again[0] = again[0].replacen(&name, &format!("{name}_again"), 1);
                }
                lines.splice(end..end, again);
            }
        }
        2 if !inner.is_empty() => drop(lines.remove(*random.pick(&inner))),
        3 if !inner.is_empty() => {
            let at = *random.pick(&inner);
            lines.insert(at, lines[at].clone());
        }
        _ if !inner.is_empty() => {
            let at = *random.pick(&inner);
            lines.swap(at, at.saturating_sub(1));
        }
        _ => {}
    }
    lines.concat()
}

/// One mutation of whole lines.
fn lines(text: &str, corpus: &[String], random: &mut Random) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let at = random.below(lines.len());
    let to = random.below(lines.len());
    match random.below(6) {
        0 if !lines.is_empty() => drop(lines.remove(at)),
        1 if !lines.is_empty() => lines.insert(to, lines[at]),
        2 if !lines.is_empty() => lines.swap(at, to),
        3 => lines.truncate(at),
        4 => {
            // A declaration, or a piece of one, of another text.
            let other: Vec<&str> = random.pick(corpus).split_inclusive('\n').collect();
            let from = random.below(other.len());
            let some = other.iter().skip(from).take(1 + random.below(12)).copied();
            lines.splice(at..at, some);
        }
        _ => {
            let (low, high) = (at.min(to), at.max(to));
            let several = lines.get(low..high.min(low + 8)).unwrap_or(&[]).to_vec();
            lines.splice(high..high, several);
        }
    }
    lines.concat()
}

/// One mutation of words, numbers or signs.
fn tokens(text: &str, random: &mut Random) -> String {
    let mut pieces: Vec<&str> = pieces(text);
    let solid: Vec<usize> = (0..pieces.len()).filter(|i| !pieces[*i].trim().is_empty()).collect();
    if solid.is_empty() {
        return random.word(WORDS).to_owned();
    }
    let at = *random.pick(&solid);
    let to = *random.pick(&solid);
    let number = |p: &str| p.starts_with(|c: char| c.is_ascii_digit());
    match random.below(10) {
        0 => drop(pieces.remove(at)),
        1 => pieces.insert(at, pieces[at]),
        2 => pieces.swap(at, to),
        3 => pieces[at] = pieces[to],
        4 => pieces.splice(at..at, [random.word(WORDS), " "]).for_each(drop),
        5 => pieces[at] = random.word(WORDS),
        6 => pieces.insert(at, random.word(SIGNS)),
        7 => pieces.insert(at, *random.pick::<&str>(STRANGE)),
        8 => {
            let numbers: Vec<usize> = solid.into_iter().filter(|i| number(pieces[*i])).collect();
            let place = if numbers.is_empty() { at } else { *random.pick(&numbers) };
            pieces[place] = *random.pick::<&str>(NUMBERS);
        }
        _ => {
            // Brackets around a stretch, several at once.
            let (low, high) = (at.min(to), at.max(to).min(at.min(to) + 12));
            let (open, close) =
                *random.pick(&[("(", ")"), ("[", "]"), ("{", "}"), ("not (", ")"), ("-", "")]);
            for _ in 0..1 + random.below(3) {
                pieces.insert(high, close);
                pieces.insert(low, open);
            }
        }
    }
    pieces.concat()
}
