//! The pairs of the grammar that hold the tokens of a text, for a layer that cares for the form of a
//! text and not for its meaning.

use std::collections::BTreeMap;
use std::iter::Peekable;
use std::rc::Rc;

use pest::Parser;
use pest::iterators::{Pair, Pairs};

use super::levels::Level;
use super::parser::{Rule, SgrParser};

/// A leaf of the tree: a token or, of a unit or the name of a module, several that are never divided.
pub(crate) struct Leaf<'a> {
    /// How it is written.
    pub(crate) text: &'a str,
    /// Where it begins, in bytes.
    pub(crate) start: usize,
    /// The innermost pair that holds it.
    pub(crate) node: usize,
}

/// A pair of the grammar: a stretch of tokens with a name.
pub(crate) struct Node {
    /// The name in `grammar.pest`.
    pub(crate) rule: Rc<str>,
    /// The pair around it; the root is its own parent.
    pub(crate) parent: usize,
    /// How many pairs are around it.
    pub(crate) depth: usize,
    /// Its first token.
    pub(crate) first: usize,
    /// One past its last token.
    pub(crate) end: usize,
}

/// A text as tokens and comments in the order of the text, and pairs, outer before inner.
pub(crate) struct Tree<'a> {
    pub(crate) leaves: Vec<Leaf<'a>>,
    pub(crate) comments: Vec<Leaf<'a>>,
    nodes: Vec<Node>,
}

/// Pairs whose inside is not to be taken apart.
const WHOLE: &[Rule] = &[Rule::text];

/// Reads a text; `None` if it is not one that the grammar describes.
pub(crate) fn tree(text: &str) -> Option<Tree<'_>> {
    let file = SgrParser::parse(Rule::file, text).ok()?.next()?;
    let mut walk = Walk {
        names: BTreeMap::new(),
        levels: BTreeMap::new(),
        tree: Tree { leaves: Vec::new(), comments: Vec::new(), nodes: Vec::new() },
    };
    walk.pair(file, 0, 0);
    Some(walk.tree)
}

impl Tree<'_> {
    /// Every pair, outer before inner.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The names of the pairs that begin with a token, inner before outer.
    pub(crate) fn beginning_with(&self, token: usize) -> impl Iterator<Item = &str> {
        self.around(token).take_while(move |n| n.first == token).map(|n| &*n.rule)
    }

    /// The name of the pair that a token is a direct part of: the one around
    /// the token's own pair, or, for a sign without a pair of its own, the
    /// innermost.
    pub(crate) fn holder(&self, token: usize) -> usize {
        let Some(own) = self.leaves.get(token).map(|t| t.node) else { return 0 };
        match self.nodes.get(own) {
            Some(node) if node.end - node.first == 1 => node.parent,
            _ => own,
        }
    }

    /// The innermost pair that holds both a token and the one before it.
    pub(crate) fn meeting(&self, token: usize) -> usize {
        let of = |token: usize| self.leaves.get(token).map_or(0, |t| t.node);
        let (mut a, mut b) = (of(token.saturating_sub(1)), of(token));
        while a != b {
            let (Some(of_a), Some(of_b)) = (self.nodes.get(a), self.nodes.get(b)) else { return 0 };
            if of_a.depth >= of_b.depth {
                a = of_a.parent;
            }
            if of_b.depth >= of_a.depth {
                b = of_b.parent;
            }
        }
        a
    }

    /// The pairs around a token, from the inside out.
    fn around(&self, token: usize) -> impl Iterator<Item = &Node> {
        let innermost = self.leaves.get(token).and_then(|t| self.nodes.get(t.node));
        std::iter::successors(innermost, |n| (n.depth > 0).then(|| self.nodes.get(n.parent)).flatten())
    }
}

struct Walk<'a> {
    names: BTreeMap<Rule, Rc<str>>,
    levels: BTreeMap<&'static str, Rc<str>>,
    tree: Tree<'a>,
}

impl<'a> Walk<'a> {
    fn pair(&mut self, pair: Pair<'a, Rule>, parent: usize, depth: usize) {
        let (rule, span) = (pair.as_rule(), pair.as_span());
        if rule == Rule::COMMENT {
            let text = span.as_str().trim_end();
            self.tree.comments.push(Leaf { text, start: span.start(), node: parent });
            return;
        }
        let name = Rc::clone(self.names.entry(rule).or_insert_with(|| format!("{rule:?}").into()));
        let id = self.open(name, parent, depth);
        let mut inner = pair.into_inner().peekable();
        if WHOLE.contains(&rule) || inner.peek().is_none() && !span.as_str().is_empty() {
            self.tree.leaves.push(Leaf { text: span.as_str(), start: span.start(), node: id });
        } else if let Some(level) = Level::loosest(rule) {
            self.row(level, inner, rule, id, depth);
        } else {
            for child in inner {
                self.pair(child, id, depth + 1);
            }
        }
        self.close(id);
    }

    fn open(&mut self, rule: Rc<str>, parent: usize, depth: usize) -> usize {
        let (id, first) = (self.tree.nodes.len(), self.tree.leaves.len());
        self.tree.nodes.push(Node { rule, parent, depth, first, end: first });
        id
    }

    fn close(&mut self, id: usize) {
        let end = self.tree.leaves.len();
        if let Some(node) = self.tree.nodes.get_mut(id) {
            node.end = end;
        }
    }

    /// The inside of a flat row of operators and operands, with the levels that it stands for.
    fn row(
        &mut self,
        level: Level,
        mut row: Peekable<Pairs<'a, Rule>>,
        rule: Rule,
        node: usize,
        depth: usize,
    ) {
        if rule == Rule::expr {
            self.level(Some(level), &mut row, node, depth + 1);
        } else {
            // The pair is the level itself.
            self.inside(level, &mut row, node, depth);
        }
        for rest in row {
            self.pair(rest, node, depth + 1);
        }
    }

    /// As much of a row as belongs to a level, as a pair of its own.
    fn level(
        &mut self,
        level: Option<Level>,
        row: &mut Peekable<Pairs<'a, Rule>>,
        parent: usize,
        depth: usize,
    ) {
        self.comments(row, parent, depth);
        let Some(level) = level else {
            if let Some(operand) = row.next() {
                self.pair(operand, parent, depth);
            }
            return;
        };
        let name = level.name();
        let name = Rc::clone(self.levels.entry(name).or_insert_with(|| name.into()));
        let id = self.open(name, parent, depth);
        self.inside(level, row, id, depth);
        self.close(id);
    }

    fn inside(&mut self, level: Level, row: &mut Peekable<Pairs<'a, Rule>>, node: usize, depth: usize) {
        if level.is_prefix() {
            let operator = row.next_if(|n| level.has(n.as_rule()));
            let inner = if operator.is_some() { Some(level) } else { level.tighter() };
            if let Some(operator) = operator {
                self.pair(operator, node, depth + 1);
            }
            return self.level(inner, row, node, depth + 1);
        }
        self.level(level.tighter(), row, node, depth + 1);
        self.comments(row, node, depth + 1);
        while let Some(operator) = row.next_if(|n| level.has(n.as_rule())) {
            self.pair(operator, node, depth + 1);
            self.level(level.tighter(), row, node, depth + 1);
            self.comments(row, node, depth + 1);
        }
    }

    /// The comments that come next in a row.
    fn comments(&mut self, row: &mut Peekable<Pairs<'a, Rule>>, node: usize, depth: usize) {
        while let Some(comment) = row.next_if(|n| n.as_rule() == Rule::COMMENT) {
            self.pair(comment, node, depth);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::tokens::{TokenKind, tokens};

    /// The parser and the scanner see the same comments and the same text between them.
    fn agree(text: &str) {
        let Some(tree) = tree(text).filter(|tree| tree.nodes().iter().all(|node| &*node.rule != "junk"))
        else {
            return;
        };
        let all: Vec<_> = tokens(text).filter(|t| t.kind != TokenKind::Space).collect();
        let comments: Vec<_> = all.iter().filter(|t| t.kind == TokenKind::Comment).map(|t| t.start).collect();
        assert_eq!(tree.comments.iter().map(|c| c.start).collect::<Vec<_>>(), comments, "{text}");
        let mut rest = all.iter().filter(|t| t.kind != TokenKind::Comment).peekable();
        for leaf in &tree.leaves {
            let end = leaf.start + leaf.text.len();
            let first = rest.next().unwrap_or_else(|| panic!("`{}` is no token: {text}", leaf.text));
            assert_eq!(first.start, leaf.start, "`{}` of {text}", leaf.text);
            let last = std::iter::from_fn(|| rest.next_if(|t| t.start < end)).last().unwrap_or(first);
            assert_eq!(last.end(), end, "`{}` of {text}", leaf.text);
        }
        assert_eq!(rest.next(), None, "{text}");
    }

    #[test]
    fn parser_and_scanner_agree_on_every_grammar_of_the_project() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let mut read = 0;
        for folder in ["grammars", "grammars/experiments", "std-rules", "tests/cases"] {
            for entry in std::fs::read_dir(root.join(folder)).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_some_and(|e| e == "sgr")
                    && let Ok(text) = std::fs::read_to_string(&path)
                {
                    agree(&text);
                    read += 1;
                }
            }
        }
        assert!(read > 100, "{read}");
    }

    proptest::proptest! {
        #[test]
        fn parser_and_scanner_agree_on_any_declaration(
            name in "[a-zé_][a-z0-9_]{0,5}",
            number in "[0-9]{1,3}(\\.[0-9]{1,2})?(e-?[0-9])?",
            unit in "( ?(cm|N/m\\^2|deg|%))?",
            sign in "[-+*/<]|<=|\\.\\.|->| *# a \"\n *\\+",
            quoted in "([a-z #.]|\\\\\"|\\\\\\\\|\\\\\n){0,6}",
            space in "[ \t\n]{0,2}",
        ) {
            agree(&format!("let {name}={space}{number}{unit}{space}{sign}{space}{name}\nuse \"{quoted}\"{space}#{quoted}\n"));
        }
    }
}
