//! What the layout knows about the grammar. All names are names of pairs in
//! `grammar.pest`; a pair that is not here flows on in its line.

/// The widest a line may be before it is broken.
pub(super) const WIDTH: usize = 100;
/// The widest a line of a table may be: what is read by columns may go on a little.
const TABLE_WIDTH: usize = 120;
/// How far the inside of a block, and the rest of a broken line, stands in.
pub(super) const STEP: usize = 2;

/// How the names of pairs end that stand on a line of their own in a text or a
/// block: declarations and clauses.
pub(super) const LINES: &[&str] = &["item", "_clause", "_edit"];

/// Lines whose first word is padded to a column, and how wide that is.
pub(super) const FIRST_WORDS: &[(&str, usize)] = &[("rule_clause", 8), ("actuation_clause", 7)];

/// Lines that are aligned with each other where they follow one upon the other.
pub(super) struct Columns {
    /// The pairs that are its rows.
    pub(super) rows: &'static [&'static str],
    /// What begins each further column: one of some direct parts of the row.
    pub(super) columns: &'static [&'static [&'static str]],
    /// The widest that a row may be.
    pub(super) width: usize,
}

/// A column that begins with the second word of the line, whatever it is.
pub(super) const SECOND: &[&str] = &[];

pub(super) const TABLES: &[Columns] = &[
    table(&["use_item"], &[&["name_list"]]),
    table(&["param_item"], &[&["colon"], &["kw_in"], &["equals"]]),
    table(&["let_item", "drive_clause"], &[&["equals"]]),
    table(&["pattern_item"], &[&["equals"]]),
    table(&["term_item", "sense_item"], &[&["colon"], &["equals"]]),
    wide_table(&["require_item"], &[&["colon"], &["kw_because"]]),
    table(&["actuate_item", "simulate_item", "objective_item", "search_item"], &[SECOND]),
    table(&["field", "joint_clause"], &[&["equals"]]),
    table(&["row"], &[&["arrow"]]),
    table(&["place_clause"], &[&["colon"]]),
    table(&["match_clause"], &[&["colon"], &["free_port"], &["where_part"]]),
    table(&["choose_clause"], &[&["kw_in"]]),
    table(&["set_clause"], &[&["equals"]]),
    table(&["set_edit"], &[&["equals"]]),
    table(&["step_clause"], &[&["equals"]]),
    table(&["typed_name"], &[&["colon"]]),
    wide_table(&["variable"], &[&["colon"], &["kw_in"], &["mutate_part", "flip_part"], &["bound_part"]]),
];

/// A line that is too long may be broken before these.
pub(super) const BREAK_BEFORE: &[&str] = &[
    "kw_because",
    "kw_where",
    "kw_with",
    "kw_for",
    "kw_to",
    "kw_turned",
    "kw_by",
    "kw_facing",
    "kw_as",
    "kw_weight",
    "kw_mutate",
    "kw_flip",
    "kw_bound",
    "kw_noise",
    "kw_delay",
    "kw_next",
    "kw_then",
    "kw_always",
    "kw_else",
    "kw_of",
    "kw_otherwise",
    "kw_and",
    "kw_or",
    "compare_op",
    "sum_op",
    "product_op",
];

/// Signs that stand right before what follows, by the pair that they are part of.
pub(super) const PREFIXES: &[(&str, &str)] = &[("sign", "-")];
/// Signs that stand right after what precedes them, by the pair that they are part of.
pub(super) const SUFFIXES: &[(&str, &str)] = &[("quantifier", ":")];

const fn table(rows: &'static [&'static str], columns: &'static [&'static [&'static str]]) -> Columns {
    Columns { rows, columns, width: WIDTH }
}

const fn wide_table(rows: &'static [&'static str], columns: &'static [&'static [&'static str]]) -> Columns {
    Columns { rows, columns, width: TABLE_WIDTH }
}
