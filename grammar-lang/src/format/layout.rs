//! Where a line that is too long, or that holds comments, is broken.
//!
//! One rule, applied again to each piece: a line that does not fit is broken at
//! its outermost places. A list is broken inside its brackets and filled;
//! anything else is broken at all places of the same rank.

use std::collections::BTreeMap;
use std::ops::Range;

use super::gaps::Gap;
use super::table::STEP;

/// The places of a text, and the breaks that were decided on.
pub(super) struct Layout {
    pub(super) gaps: Vec<Gap>,
    /// For every token that begins a new line inside its line: how far that stands in.
    pub(super) breaks: BTreeMap<usize, usize>,
}

/// How a stretch is broken.
enum Cut {
    /// Before these tokens.
    Chain(Vec<usize>),
    /// Inside the brackets that are these tokens.
    List(usize, usize),
}

impl Layout {
    /// The width of a stretch of tokens on one line, from the first to the last.
    pub(super) fn width(&self, stretch: Range<usize>) -> usize {
        let before = self.gaps.get(stretch.start).map_or(0, |g| g.space);
        let gaps = self.gaps.get(stretch).unwrap_or(&[]);
        gaps.iter().map(|g| g.space + g.width).sum::<usize>().saturating_sub(before)
    }

    /// Whether a stretch cannot stand on one line, however wide.
    pub(super) fn is_broken(&self, stretch: Range<usize>) -> bool {
        self.must_break(&stretch).next().is_some() || self.kept_open(&stretch).is_some()
    }

    /// Breaks a stretch that begins at `column` of a line that stands in by `indent`.
    pub(super) fn plan(&mut self, stretch: Range<usize>, column: usize, indent: usize, limit: usize) {
        if !self.is_broken(stretch.clone()) && column + self.width(stretch.clone()) <= limit {
            return;
        }
        match self.cut(&stretch, indent, limit) {
            Some(Cut::Chain(places)) => self.chain(stretch, &places, column, indent, limit),
            Some(Cut::List(open, close)) => {
                self.plan(stretch.start..open + 1, column, indent, limit);
                self.fill(open + 1..close, indent + STEP, limit);
                self.breaks.insert(close, indent);
                self.plan(close..stretch.end, indent, indent, limit);
            }
            None => {}
        }
    }

    /// Breaks before each of some tokens.
    fn chain(&mut self, stretch: Range<usize>, places: &[usize], column: usize, indent: usize, limit: usize) {
        let inner = indent + STEP;
        let first = places.first().copied().unwrap_or(stretch.end);
        self.plan(stretch.start..first, column, indent, limit);
        let ends = places.iter().skip(1).copied().chain([stretch.end]);
        for (from, to) in places.iter().copied().zip(ends) {
            self.breaks.insert(from, inner);
            self.plan(from..to, inner, inner, limit);
        }
    }

    /// Puts as many items of a list on each line as fit. A list whose last item
    /// has a comma is laid out by its author: it keeps its lines.
    fn fill(&mut self, inside: Range<usize>, indent: usize, limit: usize) {
        let bracket = self.gaps.get(inside.start).and_then(|g| g.bracket);
        let kept = bracket.is_some_and(|b| self.has_last_comma(b));
        let pair = self.gaps.get(inside.start).map(|g| g.pair);
        let starts_item = |g: &Gap| g.may_break && g.bracket == bracket && Some(g.pair) == pair;
        let starts: Vec<usize> =
            (inside.start + 1..inside.end).filter(|i| self.gaps.get(*i).is_some_and(starts_item)).collect();
        let mut column = indent;
        self.breaks.insert(inside.start, indent);
        let mut from = inside.start;
        for to in starts.into_iter().chain([inside.end]) {
            let item = from..to;
            let space = self.gaps.get(from).map_or(0, |g| g.space);
            let wide = self.is_broken(item.clone());
            let width = self.width(item.clone());
            let newline = kept && self.gaps.get(from).is_some_and(|g| g.newline);
            if from > inside.start {
                if wide || newline || self.is_hard(from) || column + space + width > limit {
                    self.breaks.insert(from, indent);
                    column = indent;
                } else {
                    column += space;
                }
            }
            self.plan(item, column, indent, limit);
            // Nothing follows an item that takes several lines.
            column = if wide || column + width > limit { limit } else { column + width };
            from = to;
        }
    }

    fn is_hard(&self, token: usize) -> bool {
        self.gaps.get(token).is_some_and(|g| g.must_break)
    }

    /// The places inside a stretch where a comment breaks it.
    fn must_break(&self, stretch: &Range<usize>) -> impl Iterator<Item = usize> {
        (stretch.start + 1..stretch.end).filter(|i| self.is_hard(*i))
    }

    fn has_last_comma(&self, open: usize) -> bool {
        let close = self.gaps.get(open).and_then(|g| g.close);
        close.and_then(|c| self.gaps.get(c)).is_some_and(|g| g.after_comma)
    }

    /// The first list of a stretch whose last item has a comma.
    fn kept_open(&self, stretch: &Range<usize>) -> Option<usize> {
        stretch.clone().find(|i| {
            let close = self.gaps.get(*i).and_then(|g| g.close);
            close.is_some_and(|c| c < stretch.end) && self.has_last_comma(*i)
        })
    }

    fn cut(&self, stretch: &Range<usize>, indent: usize, limit: usize) -> Option<Cut> {
        let outermost = |place: usize| self.outermost_bracket(place, stretch.start);
        let loose: Vec<usize> = self.must_break(stretch).filter(|i| outermost(*i).is_none()).collect();
        if !loose.is_empty() {
            return Some(Cut::Chain(loose));
        }
        let commented = self.must_break(stretch).find_map(outermost);
        let kept = self.kept_open(stretch).map(|open| outermost(open).unwrap_or(open));
        if let Some(open) = commented.into_iter().chain(kept).min() {
            return self.list(open, stretch);
        }
        self.by_rank(stretch, stretch.start, indent, limit)
    }

    /// Breaks inside a bracket, or inside the bracket that is all there is in it.
    fn list(&self, open: usize, stretch: &Range<usize>) -> Option<Cut> {
        let close = self.gaps.get(open)?.close?;
        let only = self.gaps.get(open + 1)?.close.is_some_and(|c| c + 1 == close);
        if only && !self.is_hard(open + 1) && !self.is_hard(close) {
            return self.list(open + 1, stretch);
        }
        (close < stretch.end).then_some(Cut::List(open, close))
    }

    /// The outermost bracket around a place that opens at or after `start`.
    fn outermost_bracket(&self, place: usize, start: usize) -> Option<usize> {
        let around = |i: usize| self.gaps.get(i)?.bracket.filter(|b| *b >= start);
        std::iter::successors(around(place), |b| around(*b)).last()
    }

    /// The outermost places where a stretch may be broken; of several equally
    /// far out, those of the widest pair.
    fn by_rank(&self, stretch: &Range<usize>, after: usize, indent: usize, limit: usize) -> Option<Cut> {
        let mut groups: BTreeMap<_, Vec<usize>> = BTreeMap::new();
        for i in after + 1..stretch.end {
            if let Some(gap) = self.gaps.get(i).filter(|g| g.may_break) {
                groups.entry((gap.pair.1, gap.nesting, gap.pair.0, gap.bracket)).or_default().push(i);
            }
        }
        let rank = groups.keys().next().map(|k| (k.0, k.1))?;
        let extent = |places: &Vec<usize>| match places.as_slice() {
            [first, .., last] => self.width(*first..*last + 1),
            _ => 0,
        };
        let ((_, _, _, bracket), places) =
            groups.iter().filter(|(k, _)| (k.0, k.1) == rank).max_by_key(|(_, places)| extent(places))?;
        if let Some(open) = bracket.filter(|b| places.contains(&(b + 1))) {
            return self.list(open, stretch);
        }
        // A line ends after `=` only if what follows then stands on one line.
        let (equals, others): (Vec<usize>, Vec<usize>) =
            places.iter().partition(|i| self.gaps.get(**i).is_some_and(|g| g.after_equals));
        if !others.is_empty() {
            return Some(Cut::Chain(others));
        }
        let last = equals.last().copied()?;
        if indent + STEP + self.width(last..stretch.end) <= limit {
            return Some(Cut::Chain(vec![last]));
        }
        self.by_rank(stretch, last, indent, limit).or(Some(Cut::Chain(vec![last])))
    }
}
