//! What the outputs of an emulated board have done.

use std::collections::BTreeMap;

use sgc::hardware::Pin;

use super::MHZ;

/// Changes of outputs, in cycles since the beginning.
pub(crate) struct Trace {
    /// For each pin, when it was changed to which level.
    changes: BTreeMap<Pin, Vec<(u64, bool)>>,
    /// When the chip was reset, without the first time.
    pub(crate) resets: Vec<u64>,
}

/// A pulse or an opened valve: from when to when, in cycles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Span {
    pub(crate) from: u64,
    /// Nothing, if it has not ended.
    pub(crate) to: Option<u64>,
}

impl Trace {
    pub(crate) fn read(text: &str) -> Self {
        let mut changes: BTreeMap<Pin, Vec<(u64, bool)>> = BTreeMap::new();
        let mut resets = Vec::new();
        for line in text.lines() {
            let words: Vec<&str> = line.split(' ').collect();
            let at = words[0].parse().unwrap();
            match (words[1], words.get(2)) {
                ("reset", _) => resets.push(at),
                // The lamp.
                ("D13", _) => {}
                (pin, level) => {
                    changes.entry(pin.parse().unwrap()).or_default().push((at, level == Some(&"1")))
                }
            }
        }
        resets.remove(0);
        Self { changes, resets }
    }

    /// How often any output has changed.
    pub(crate) fn changes(&self) -> usize {
        self.changes.values().map(Vec::len).sum()
    }

    /// When a pin was changed to which level.
    pub(crate) fn of(&self, pin: Pin) -> &[(u64, bool)] {
        self.changes.get(&pin).map_or(&[], Vec::as_slice)
    }

    /// When a pin was high.
    pub(crate) fn spans(&self, pin: Pin) -> Vec<Span> {
        let changes = self.of(pin);
        let span = |(i, (from, high)): (usize, &(u64, bool))| {
            high.then(|| Span { from: *from, to: changes.get(i + 1).map(|(to, _)| *to) })
        };
        changes.iter().enumerate().filter_map(span).collect()
    }

    /// Whether a pin is high at the end.
    pub(crate) fn is_high(&self, pin: Pin) -> bool {
        self.of(pin).last().is_some_and(|(_, high)| *high)
    }

    /// The pins that are high at the end.
    pub(crate) fn high(&self) -> Vec<Pin> {
        Pin::all().filter(|pin| self.is_high(*pin)).collect()
    }

    /// When an output was last raised, in cycles.
    pub(crate) fn last_rise(&self) -> u64 {
        self.last(true)
    }

    /// When an output last fell, in cycles.
    pub(crate) fn last_fall(&self) -> u64 {
        self.last(false)
    }

    fn last(&self, level: bool) -> u64 {
        let all = self.changes.values().flatten().filter(|(_, high)| *high == level);
        all.map(|(at, _)| *at).max().unwrap_or(0)
    }

    /// Whether two pins were ever high at the same time.
    pub(crate) fn overlap(&self, one: Pin, other: Pin) -> bool {
        let others = self.spans(other);
        self.spans(one).iter().any(|a| {
            others.iter().any(|b| a.from < b.to.unwrap_or(u64::MAX) && b.from < a.to.unwrap_or(u64::MAX))
        })
    }
}

/// Cycles as microseconds.
pub(crate) fn us(cycles: u64) -> f64 {
    cycles as f64 / MHZ as f64
}

#[test]
fn overlaps_are_seen() {
    let trace = |text: &str| Trace::read(&format!("0 reset\n{text}"));
    let pins: Vec<Pin> = ["D3", "D4"].iter().map(|name| name.parse().unwrap()).collect();
    assert!(trace("10 D3 1\n20 D4 1\n30 D3 0\n").overlap(pins[0], pins[1]));
    assert!(trace("10 D3 1\n20 D4 1\n20 D4 0\n30 D3 0\n40 D4 1\n").high() == vec![pins[1]]);
    assert!(!trace("10 D3 1\n20 D3 0\n20 D4 1\n").overlap(pins[0], pins[1]));
}
