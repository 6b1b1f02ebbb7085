//! The syntax tree: what a text says, before any name is looked up.

use std::rc::Rc;

use super::Direction;
use super::declarations::{self, BlockKind, Kind};
pub use super::operators::{Gather, Operator, Painting};
use crate::source::Span;

/// A word with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Name {
    /// The word.
    pub text: String,
    /// Its place.
    pub span: Span,
}

/// A whole text.
#[derive(Clone, Debug, Default)]
pub struct Module {
    /// What the text declares, in order. Variants of one text share what they do not change.
    pub items: Vec<Rc<Item>>,
    /// The warnings that it allows, but for those that a variant allows.
    pub allows: Vec<Allow>,
    /// Names of items that could not be read: uses of them are not errors of their own.
    pub broken: Vec<String>,
    /// The words that begin declarations that could not be read.
    pub unread: Vec<String>,
    /// Whether the first line of a declaration is missing: what it declares is not known.
    pub headless: bool,
}

/// `allow CODE because TEXT`: a warning that is meant.
#[derive(Clone, Debug, PartialEq)]
pub struct Allow {
    /// The code or the name of the warning.
    pub code: Name,
    /// Why.
    pub because: Option<String>,
    /// Its place.
    pub span: Span,
    /// The declaration that it stands in; none where it stands outside of all.
    pub within: Option<Span>,
}

/// A declaration.
#[derive(Clone, Debug)]
pub struct Item {
    /// What it declares.
    pub kind: ItemKind,
    /// Its place.
    pub span: Span,
    /// The `##` lines above it, without the marks.
    pub doc: String,
    /// Whether some of its clauses could not be read.
    pub damaged: bool,
}

/// The declarations.
#[derive(Clone, Debug)]
pub enum ItemKind {
    /// `grammar NAME`
    Grammar(Name),
    /// `use MODULE { names }`
    Use {
        /// What is imported: `std.blocks` or `./file.sgr`.
        module: Name,
        /// The names; `None` takes all.
        names: Option<Vec<Name>>,
    },
    /// `param NAME : TYPE in DOMAIN = DEFAULT`
    Param(Param),
    /// `WORD NAME { fields }`
    Block(BlockKind, Block),
    /// `search NAME from EXAMPLE`: the one that the grammar uses.
    UseSearch(Name, Option<Name>),
    /// `symmetry none`, `symmetry mirror PLANE`, `symmetry radial N about AXIS`
    Symmetry(Name, Option<Expr>, Option<Name>),
    /// `begin { place ... fill ... }`
    Begin(Vec<Place>, Vec<RuleClause>),
    /// `lattice N x N x N of CELL`
    Lattice([Expr; 3], Name),
    /// `fallback RULE when CONDITION because TEXT`
    Fallback {
        /// The rule that alone is drawn.
        rule: Name,
        /// When.
        condition: Expr,
        /// Why.
        because: Option<String>,
    },
    /// `rule NAME { clauses }`
    Rule(Name, Vec<RuleClause>),
    /// `require NAME : EXPR because TEXT`
    Require {
        /// Its name, if it has one.
        name: Option<Name>,
        /// What must hold.
        condition: Expr,
        /// Why.
        because: Option<String>,
    },
    /// `shared NAME : TYPE in DOMAIN mutate ...`: one variable for all actuations that read it.
    Shared(Box<Variable>),
    /// `pattern NAME = EXPR`
    Pattern(Name, Expr),
    /// `actuation NAME for a : KIND { clauses }`
    Actuation {
        /// Its name.
        name: Name,
        /// What its clauses call the actuator.
        binder: Name,
        /// Which actuators it drives.
        kind: Name,
        /// Its clauses.
        clauses: Vec<ActuationClause>,
    },
    /// `actuate KIND with ACTUATION`
    Actuate(Name, Name),
    /// `simulate MODEL for DURATION on TARGET, TARGET in SCENARIOS`
    Simulate {
        /// The model.
        model: Name,
        /// How long.
        duration: Expr,
        /// The hardware whose limits hold, too.
        on: Vec<Name>,
        /// The worlds beside the nominal one.
        scenarios: Option<Name>,
    },
    /// `table NAME : TYPE -> TYPE { x -> y, ... }`
    Table(Table),
    /// `target NAME on BACKEND for ACTUATOR { fields }`
    Target {
        /// Its name and fields.
        block: Block,
        /// How it bends actuators: with air, with threads.
        backend: Name,
        /// The actuators that it drives.
        kind: Name,
    },
    /// `prototype NAME on BACKEND { fields }`
    Prototype(Block, Name),
    /// `observe TERM, ...`
    Observe(Vec<Name>),
    /// `novelty NAME { feature ... known ... }`
    Novelty(Name, Vec<NoveltyClause>),
    /// `term NAME : TYPE = EXPR`
    Term(Name, Name, Expr),
    /// `sense NAME(a : KIND) : TYPE = EXPR noise EXPR delay EXPR`
    Sense(Box<Sense>),
    /// `state NAME(p : KIND) : TYPE from EXPR next EXPR`
    State(Box<BodyState>),
    /// `maximize EXPR`, `minimize EXPR`
    Objective {
        /// What is better.
        direction: Direction,
        /// The value.
        value: Expr,
    },
    /// `let NAME = EXPR`, or with parameters `let NAME(x : TYPE) = EXPR`
    Let(Name, Option<Vec<Typed>>, Expr),
    /// `enum NAME { names }`
    Enum(Name, Vec<Name>),
    /// `record NAME { field : TYPE = EXPR, ... }`
    Record(Name, Vec<RecordField>),
    /// `prefer NAME : EXPR weight EXPR because TEXT`
    Prefer {
        /// Its name, if it has one.
        name: Option<Name>,
        /// What should hold.
        condition: Expr,
        /// What it costs if it does not.
        weight: Expr,
        /// Why.
        because: Option<String>,
    },
    /// `task NAME { actuate ... simulate ... maximize ... }`
    Task(Name, Vec<Item>),
    /// `example NAME { clauses }`
    Example(Name, Vec<ExampleClause>),
    /// `variant NAME of BASE { edits }`
    Variant(Variant),
}

impl ItemKind {
    /// The word that opens it.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Grammar(_) => "grammar",
            Self::Use { .. } => "use",
            Self::Param(_) => "param",
            Self::Block(kind, _) => kind.word(),
            Self::UseSearch(..) => "search",
            Self::Symmetry(..) => "symmetry",
            Self::Begin(..) => "begin",
            Self::Lattice(..) => "lattice",
            Self::Fallback { .. } => "fallback",
            Self::Rule(..) => "rule",
            Self::Require { .. } => "require",
            Self::Shared(_) => "shared",
            Self::Pattern(..) => "pattern",
            Self::Actuation { .. } => "actuation",
            Self::Actuate(..) => "actuate",
            Self::Simulate { .. } => "simulate",
            Self::Table(_) => "table",
            Self::Target { .. } => "target",
            Self::Prototype(..) => "prototype",
            Self::Observe(_) => "observe",
            Self::Novelty(..) => "novelty",
            Self::Term(..) => "term",
            Self::Sense(_) => "sense",
            Self::State(_) => "state",
            Self::Objective { direction: Direction::Maximize, .. } => "maximize",
            Self::Objective { direction: Direction::Minimize, .. } => "minimize",
            Self::Let(..) => "let",
            Self::Enum(..) => "enum",
            Self::Record(..) => "record",
            Self::Prefer { .. } => "prefer",
            Self::Task(..) => "task",
            Self::Example(..) => "example",
            Self::Variant(_) => "variant",
        }
    }

    /// What is known of its kind.
    #[must_use]
    pub fn kind(&self) -> Option<&'static Kind> {
        declarations::kind(self.word())
    }

    /// The block of named values that it is, if it is one.
    #[must_use]
    pub fn block(&self) -> Option<&Block> {
        match self {
            Self::Block(_, block) | Self::Target { block, .. } | Self::Prototype(block, _) => Some(block),
            _ => None,
        }
    }

    /// The same, to change it.
    pub fn block_mut(&mut self) -> Option<&mut Block> {
        match self {
            Self::Block(_, block) | Self::Target { block, .. } | Self::Prototype(block, _) => Some(block),
            _ => None,
        }
    }
}

/// `sense NAME(a : KIND) : TYPE = EXPR noise EXPR delay EXPR`
#[derive(Clone, Debug)]
pub struct Sense {
    /// Its name.
    pub name: Name,
    /// What the part is called that has such a sensor, and its kind; none where the robot has one.
    pub of: Option<(Name, Name)>,
    /// The type of what it reads.
    pub ty: Name,
    /// What it reads.
    pub value: Expr,
    /// The standard deviation of its noise, or how likely it is wrong.
    pub noise: Option<Expr>,
    /// How old what it reads is at least.
    pub delay: Option<Expr>,
}

/// What the robot, or each part of a kind, remembers from one control moment to the next.
#[derive(Clone, Debug)]
pub struct BodyState {
    /// What the part is called that has such a state, and its kind; none where the robot has one.
    pub of: Option<(Name, Name)>,
    /// What is remembered.
    pub state: State,
}

/// A clause of a novelty set.
#[derive(Clone, Debug)]
pub enum NoveltyClause {
    /// `feature NAME = EXPR weight EXPR`
    Feature {
        /// Its name.
        name: Name,
        /// What it is for a design.
        value: Expr,
        /// How much it counts.
        weight: Option<Expr>,
    },
    /// `known TEXT { fields }`
    Known(Block),
}

/// `NAME : TYPE`
#[derive(Clone, Debug)]
pub struct Typed {
    /// The name.
    pub name: Name,
    /// Its type.
    pub ty: Name,
}

/// `NAME : TYPE`, or `NAME : TYPE = EXPR`
#[derive(Clone, Debug)]
pub struct RecordField {
    /// Its name and type.
    pub typed: Typed,
    /// Its value where a record does not give one.
    pub default: Option<Expr>,
}

/// A clause of an example.
#[derive(Clone, Debug)]
pub enum ExampleClause {
    /// `step NAME = RULE(arguments)`
    Step(Name, Application),
    /// `refuse RULE(arguments) by REASON`
    Refuse(Application, Option<Name>),
    /// `expect CONDITION`
    Expect(Expr),
}

/// A rule applied by name.
#[derive(Clone, Debug)]
pub struct Application {
    /// The rule.
    pub rule: Name,
    /// A value for everything that it matches and chooses.
    pub arguments: Vec<Argument>,
    /// Its place.
    pub span: Span,
}

/// A grammar as the difference from another.
#[derive(Clone, Debug)]
pub struct Variant {
    /// Its name.
    pub name: Name,
    /// What it starts from: a grammar or variant of this file, or another file.
    pub base: Name,
    /// Whether the base is the path of a file.
    pub from_file: bool,
    /// The differences.
    pub edits: Vec<Edit>,
}

/// A difference of a variant from its base.
#[derive(Clone, Debug)]
pub struct Edit {
    /// What it does.
    pub kind: EditKind,
    /// Its place.
    pub span: Span,
}

/// What an edit does.
#[derive(Clone, Debug)]
pub enum EditKind {
    /// `set PATH = EXPR`
    Set(Vec<Name>, Expr),
    /// `set KIND.joint = KIND about AXIS passive`
    SetJoint(Vec<Name>, Box<Joint>),
    /// `narrow PATH in EXPR`
    Narrow(Vec<Name>, Expr),
    /// `drop PATH`
    Drop(Vec<Name>),
    /// `drop observe TERM, ...`
    DropObserved(Vec<Name>),
    /// `allow CODE because TEXT`
    Allow(Allow),
    /// `replace ITEM`
    Replace(Box<Item>),
    /// `add ITEM`
    Add(Box<Item>),
}

/// `table NAME : TYPE -> TYPE { x -> y, ... }`
#[derive(Clone, Debug)]
pub struct Table {
    /// Its name.
    pub name: Name,
    /// What it is asked with.
    pub from: Name,
    /// What it answers with.
    pub to: Name,
    /// What was measured, in order.
    pub rows: Vec<(Expr, Expr)>,
}

/// A parameter of a grammar or of an actuator.
#[derive(Clone, Debug)]
pub struct Param {
    /// Its name.
    pub name: Name,
    /// Its type.
    pub ty: Name,
    /// The values that it may take.
    pub domain: Option<Expr>,
    /// Its value if nobody says otherwise.
    pub default: Option<Expr>,
}

/// A named block of fields.
#[derive(Clone, Debug)]
pub struct Block {
    /// Its name.
    pub name: Name,
    /// The word behind its name: the method of a loop of a search.
    pub method: Option<Name>,
    /// Its fields, in order.
    pub fields: Vec<Field>,
}

/// A line of a block.
#[derive(Clone, Debug)]
pub enum Field {
    /// `name = value`
    Value(Name, Expr),
    /// `name { fields }` or `name method { fields }`
    Group(Block),
    /// `param ...`
    Param(Param),
    /// `port ...`
    Port(Box<Port>),
    /// `joint = ...`, where it is more than a name.
    Joint(Box<Joint>),
}

/// `joint = KIND about AXIS passive`
#[derive(Clone, Debug)]
pub struct Joint {
    /// Where the word `joint` stands.
    pub word: Span,
    /// What the segments do: `bend`, `slide`, ...
    pub kind: Name,
    /// `about` or `along`, and which axis.
    pub axis: Option<(Name, Expr)>,
    /// Where it says that nothing drives it.
    pub passive: Option<Span>,
}

impl Joint {
    /// The word, as the name of a field.
    #[must_use]
    pub fn named(&self) -> Name {
        Name { text: "joint".to_owned(), span: self.word }
    }
}

/// `port NAME[i in DOMAIN] at POINT facing DIRECTION`
#[derive(Clone, Debug)]
pub struct Port {
    /// Its name.
    pub name: Name,
    /// The number of one of several, and the values that it takes.
    pub index: Option<(Name, Expr)>,
    /// Its place in the part's frame.
    pub at: Expr,
    /// Where it looks.
    pub facing: Expr,
}

/// `place NAME : KIND to PORT turned ANGLE by PORT`
#[derive(Clone, Debug)]
pub struct Place {
    /// What rules call it.
    pub name: Name,
    /// What it is, with its parameters.
    pub what: Expr,
    /// What holds it; nothing holds the core.
    pub to: Option<Expr>,
    /// By how much it is turned about the port.
    pub turned: Option<Expr>,
    /// The port of its own that it is held by.
    pub by: Option<Name>,
    /// Whether it has no images.
    pub alone: bool,
}

/// A clause of a rule with its place.
#[derive(Clone, Debug)]
pub struct RuleClause {
    /// What it says.
    pub kind: RuleClauseKind,
    /// Its place.
    pub span: Span,
}

/// The clauses of a rule.
#[derive(Clone, Debug)]
pub enum RuleClauseKind {
    /// `match nothing`
    MatchNothing,
    /// `match p : part with free port q where CONDITION`, or a chain of joined parts.
    Match {
        /// What is matched; in a chain, each is joined to the one before.
        links: Vec<Link>,
        /// A condition on it.
        condition: Option<Expr>,
    },
    /// `choose n in DOMAIN by DISTRIBUTION`
    Choose(Name, Expr, Option<Expr>),
    /// `let x = EXPR`
    Let(Name, Expr),
    /// `when CONDITION` or, with `false`, `unless CONDITION`
    Guard(bool, Expr),
    /// `attach WHAT to PORT turned ANGLE`
    Attach {
        /// What is attached.
        what: Expr,
        /// Where.
        port: Expr,
        /// By how much it is turned about the port.
        turned: Option<Expr>,
        /// The port of its own that it is held by.
        by: Option<Name>,
        /// Whether it has no images.
        alone: bool,
        /// What later effects of the rule call it.
        product: Option<Name>,
    },
    /// `set TARGET = VALUE`
    Set {
        /// What is set.
        target: Expr,
        /// To what.
        value: Expr,
    },
    /// `remove PART`
    Remove(Expr),
    /// `replace PART with KIND from PART to PART`
    Replace {
        /// The part that goes.
        part: Expr,
        /// What comes in its place.
        with: Expr,
        /// The neighbours that hold the new part and that it holds.
        between: Option<(Expr, Expr)>,
        /// What later effects of the rule call it.
        product: Option<Name>,
    },
    /// `revert STEP`
    Revert(Expr),
    /// `fill REGION with CELL`, and so `paint` and `clear`.
    Cells {
        /// What is done with the places.
        how: Painting,
        /// The places.
        region: Expr,
        /// What their cells are like; nothing where they are cleared.
        with: Option<Expr>,
    },
    /// `for i in RANGE { ... }`, or one clause with `for i in RANGE` behind it.
    Repeat {
        /// What it is repeated for; nothing where it is done once, under a condition that comes first.
        over: Vec<Binder>,
        /// What is repeated.
        clauses: Vec<RuleClause>,
    },
    /// `then`: clauses below it read the design as those above have left it.
    Then,
    /// `always`: the rule is never drawn, but carried out after `begin` and after each step.
    Always,
    /// `weight EXPR`
    Weight(Expr),
}

/// One thing that a rule matches.
#[derive(Clone, Debug)]
pub struct Link {
    /// Its name.
    pub name: Name,
    /// Its kind; any part if nothing is said.
    pub kind: Option<Name>,
    /// Whose port it is.
    pub owner: Option<Name>,
    /// The name of its free port, if one is asked for.
    pub port: Option<Name>,
}

/// The clauses of an actuation.
#[derive(Clone, Debug)]
pub enum ActuationClause {
    /// `shared ...` or `vary ...`
    Variable(Box<Variable>),
    /// `state NAME : TYPE from EXPR next EXPR`
    State(Box<State>),
    /// `action NAME : TYPE in DOMAIN of POLICY from [EXPR, ...]`
    Action(Box<Action>),
    /// `let NAME = EXPR`
    Let(Name, Expr),
    /// `drive angle = EXPR`
    Drive(Name, Expr),
}

/// What an actuator remembers from one control moment to the next.
#[derive(Clone, Debug)]
pub struct State {
    /// Its name.
    pub name: Name,
    /// Its type.
    pub ty: Name,
    /// What it is at the first control moment.
    pub from: Expr,
    /// What it will be at the next one.
    pub next: Expr,
}

/// What a policy decides of an actuator.
#[derive(Clone, Debug)]
pub struct Action {
    /// Its name.
    pub name: Name,
    /// Its type.
    pub ty: Name,
    /// The values to decide between.
    pub domain: Expr,
    /// The policy.
    pub policy: Name,
    /// What the policy knows of the actuator.
    pub inputs: Option<Expr>,
}

/// A quantity that the search varies.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Whether the whole design has one, not each actuator.
    pub shared: bool,
    /// Its name.
    pub name: Name,
    /// How many there are, if it is a list.
    pub size: Option<Expr>,
    /// Its type.
    pub ty: Name,
    /// The values that it may take.
    pub domain: Option<Expr>,
    /// Where a search for curves begins.
    pub from: Option<Expr>,
    /// Actuators for which this has the same value share one.
    pub per: Option<Expr>,
    /// Probability and kernel of its mutation.
    pub mutate: Option<(Expr, Expr)>,
    /// Probability of flipping, for a Bool.
    pub flip: Option<Expr>,
    /// What happens at the ends of the domain.
    pub bound: Option<Name>,
}

/// An expression with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it says.
    pub kind: ExprKind,
    /// Its place.
    pub span: Span,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct Argument {
    /// Its name, if it is given by name.
    pub name: Option<Name>,
    /// Its value.
    pub value: Expr,
}

/// A binder: `e in elements`.
#[derive(Clone, Debug, PartialEq)]
pub struct Binder {
    /// The name.
    pub name: Name,
    /// What it runs over.
    pub over: Expr,
}

/// The expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A number with its unit, if it has one.
    Quantity(f64, Option<Name>),
    /// A text.
    Text(String),
    /// `true`, `false`
    Bool(bool),
    /// A word.
    Name(String),
    /// `a.b`
    Member(Box<Expr>, Name),
    /// `f(a, b = c)`
    Call(Box<Expr>, Vec<Argument>),
    /// `a[i]`
    Index(Box<Expr>, Box<Expr>),
    /// `x at t`
    At(Box<Expr>, Box<Expr>),
    /// `-x`
    Negate(Box<Expr>),
    /// `not x`
    Not(Box<Expr>),
    /// `a OP b`
    Binary(Box<Expr>, Operator, Box<Expr>),
    /// `if a then b else c`
    If(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `match x { a -> b, else -> c }`
    Cases(Box<Expr>, Vec<(Expr, Expr)>, Option<Box<Expr>>),
    /// A domain that a variant made narrower: the new one within the old one.
    Narrowed(Box<Expr>, Box<Expr>),
    /// A domain that a variant put in the place of another: the new one and the old one.
    Exchanged(Box<Expr>, Box<Expr>),
    /// `forall`, `exists`, `sum over ...`
    Aggregate {
        /// What is done with the items.
        how: Gather,
        /// Of a quantile, how much of the items lies below it.
        share: Option<Box<Expr>>,
        /// What is run over.
        binders: Vec<Binder>,
        /// Which items count.
        condition: Option<Box<Expr>>,
        /// What is gathered; `None` for a count.
        body: Option<Box<Expr>>,
        /// The value over nothing.
        otherwise: Option<Box<Expr>>,
    },
    /// `a .. b`
    Range(Box<Expr>, Box<Expr>),
    /// `{ a, b }`
    Set(Vec<Expr>),
    /// `[ a, b ]`
    List(Vec<Expr>),
    /// `x in cm`
    Convert(Box<Expr>, Name),
}
