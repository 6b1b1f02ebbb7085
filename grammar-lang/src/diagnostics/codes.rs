//! The registry of codes: every finding that the language or the engine reports.
//!
//! A new code costs one line here and one page `catalogue/CODE.md`; without its page it does not
//! compile. `tests/catalogue.rs` of the engine says what a page must hold.

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The grammar cannot be used.
    Error,
    /// The grammar can be used, but probably says something that was not meant.
    Warning,
}

impl Severity {
    /// The word that machine formats use.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Error => "error",
            Self::Warning => "warning",
        }
    }
}

/// A kind of finding.
#[derive(PartialEq, Eq)]
pub struct Code {
    /// What scripts match on: `E0301`.
    pub id: &'static str,
    /// What people say: `wrong-dimension`.
    pub name: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// The page that explains it, in Markdown: title, meaning, failing and mended example, reason.
    pub page: &'static str,
}

impl Code {
    /// What the finding is, in one sentence: the first paragraph of its page.
    #[must_use]
    pub fn title(&self) -> &'static str {
        self.page.split("\n\n").nth(1).unwrap_or("").trim()
    }

    /// What the finding means: the page between its heading and its first example.
    #[must_use]
    pub fn meaning(&self) -> &'static str {
        let body = self.page.split_once("\n\n").map_or("", |(_, body)| body);
        body.split("```").next().unwrap_or("").trim()
    }

    /// The text of the page's fenced block that is called `name`: `fails` or `mended`.
    #[must_use]
    pub fn example(&self, name: &str) -> Option<&'static str> {
        let (_, rest) = self.page.split_once(&format!("```sgr {name}\n"))?;
        rest.split_once("```").map(|(block, _)| block)
    }
}

impl std::fmt::Debug for Code {
    /// Its page is too long to be of use where findings are printed.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.id, self.name)
    }
}

macro_rules! codes {
    ($($constant:ident $id:literal $name:literal $severity:ident;)*) => {
        impl Code {
            $(#[doc = concat!("`", $id, "`: ", $name)] pub const $constant: &'static Code =
                &Code {
                    id: $id,
                    name: $name,
                    severity: Severity::$severity,
                    page: include_str!(concat!("catalogue/", $id, ".md")),
                };)*
        }
        /// Every code, in order.
        pub const CODES: &[&Code] = &[$(Code::$constant),*];
    };
}

codes! {
    // Text
    NOT_TEXT          "E0101" "not-text" Error;
    EMPTY             "E0102" "empty-file" Error;
    SYNTAX            "E0103" "syntax" Error;
    UNCLOSED          "E0104" "missing-brace" Error;
    UNKNOWN_KEYWORD   "E0105" "unknown-keyword" Error;
    TOO_DEEP          "E0106" "too-deeply-nested" Error;
    BAD_NUMBER        "E0107" "number-too-large" Error;
    // Names and modules
    UNKNOWN_NAME      "E0201" "unknown-name" Error;
    DUPLICATE         "E0202" "duplicate-name" Error;
    NO_MODULE         "E0203" "no-such-module" Error;
    IMPORT_CYCLE      "E0204" "import-cycle" Error;
    NOT_EXPORTED      "E0205" "not-in-module" Error;
    MISSING_ITEM      "E0206" "missing-declaration" Error;
    UNKNOWN_PARAMETER "E0207" "unknown-parameter" Error;
    NO_BASE           "E0208" "no-base" Error;
    VARIANT_CYCLE     "E0209" "variant-cycle" Error;
    NOTHING_TO_CHANGE "E0210" "nothing-to-change" Error;
    DROPPED           "E0211" "dropped-name" Error;
    BUILT_IN          "E0212" "built-in-name" Error;
    // Types and units
    WRONG_DIMENSION   "E0301" "wrong-dimension" Error;
    MISSING_UNIT      "E0302" "missing-unit" Error;
    UNKNOWN_UNIT      "E0303" "unknown-unit" Error;
    WRONG_TYPE        "E0304" "wrong-type" Error;
    UNKNOWN_TYPE      "E0305" "unknown-type" Error;
    UNKNOWN_FIELD     "E0306" "unknown-field" Error;
    MISSING_FIELD     "E0307" "missing-field" Error;
    WRONG_ARGUMENTS   "E0308" "wrong-arguments" Error;
    OUT_OF_DOMAIN     "E0309" "outside-domain" Error;
    EMPTY_DOMAIN      "E0310" "empty-domain" Error;
    BAD_VALUE         "E0312" "unusable-value" Error;
    MISSING_CASE      "E0313" "missing-case" Error;
    NOT_NARROWER      "E0314" "not-narrower" Error;
    TABLE_ORDER       "E0315" "table-out-of-order" Error;
    TARGET_MISFIT     "E0316" "target-cannot" Error;
    MIXED_SPACES      "E0317" "parts-and-cells" Error;
    MODEL_MISFIT      "E0318" "model-cannot" Error;
    // Stages
    WRONG_STAGE       "E0401" "wrong-stage" Error;
    // The grammar as a whole
    NEVER_MATCHES     "E0501" "rule-never-matches" Error;
    NO_EFFECT         "E0502" "rule-without-effect" Error;
    NOT_ACTUATED      "E0503" "actuator-without-actuation" Error;
    OBJECTIVE_UNIT    "E0504" "objective-without-unit" Error;
    CONSTANT_REQUIRE  "E0505" "requirement-never-holds" Error;
    NO_PERIOD         "E0506" "no-period" Error;
    OTHER_WORLDS      "E0507" "other-worlds" Error;
    NEVER_APPLIES     "E0510" "condition-never-holds" Error;
    NO_SUCH_PORT      "E0511" "no-such-port" Error;
    OUT_OF_REACH      "E0512" "rule-out-of-reach" Error;
    NOTHING_DRAWN     "E0513" "no-rule-drawn" Error;
    NEGATIVE_WEIGHT   "E0514" "negative-weight" Error;
    CLASH             "E0515" "clashing-requirements" Error;
    BAD_SCHEDULE      "E0516" "impossible-schedule" Error;
    BAD_SPREAD        "E0517" "impossible-spread" Error;
    OUTSIDE_MOTION    "E0518" "outside-the-motion" Error;
    NO_POSSIBLE_VALUE "E0519" "no-possible-value" Error;
    FRONT_MISFIT      "E0520" "front-misfit" Error;
    START_BREAKS      "E0601" "start-breaks-requirement" Error;
    NO_VALUE          "E0602" "no-value" Error;
    EXAMPLE_FAILS     "E0603" "example-fails" Error;
    // Probably not meant
    UNUSED            "W0701" "unused" Warning;
    POINTLESS         "W0710" "condition-always-holds" Warning;
    CONSTANT_IF       "W0711" "constant-if" Warning;
    EXCLUDES_NOTHING  "W0712" "requirement-excludes-nothing" Warning;
    NEVER_DRAWN       "W0713" "rule-never-drawn" Warning;
    WEIGHT_BELOW      "W0714" "weight-below-zero" Warning;
    COLD              "W0715" "temperature-below-zero" Warning;
    SPREAD_BEYOND     "W0716" "spread-beyond-its-limits" Warning;
    ODD_SIZE          "W0717" "odd-size" Warning;
    NO_ROOM           "W0718" "no-room-to-grow" Warning;
    ENDLESS           "W0719" "endless-growth" Warning;
    NOTHING_TO_SEARCH "W0720" "nothing-to-search" Warning;
    TWICE_IN_SET      "W0721" "twice-in-a-set" Warning;
    FEW_CHANNELS      "W0722" "too-few-channels" Warning;
    OUT_OF_RANGE      "W0723" "bend-out-of-range" Warning;
    OF_PARTS          "W0724" "not-of-lattices" Warning;
    UNUSUAL           "W0725" "unusual-value" Warning;
    WEAK              "W0726" "weaker-than-its-weight" Warning;
    STRAY_PORT        "W0727" "port-off-its-shape" Warning;
    PORTS_TOGETHER    "W0728" "ports-in-one-place" Warning;
    BEYOND_BEND       "W0729" "drive-beyond-bend" Warning;
    NEAR_ZERO         "W0730" "divisor-may-be-zero" Warning;
    NO_SPREAD         "W0731" "spread-of-zero" Warning;
    TOO_SHORT         "W0732" "valves-too-slow" Warning;
    LITTLE_TURN       "W0733" "little-of-its-turn" Warning;
    CONSTANT_AIM      "W0734" "constant-objective" Warning;
    SETTLES_LATE      "W0735" "settles-too-late" Warning;
    UNUSED_ALLOW      "W0736" "unused-allow" Warning;
    NO_GRIP           "W0737" "no-grip" Warning;
    STILL_DRIVE       "W0738" "still-drive" Warning;
    AGAINST_REQUIREMENT "W0739" "against-a-requirement" Warning;
    FIRST_OF_SEVERAL  "W0740" "first-of-several" Warning;
    UNEVEN_SWING      "W0741" "uneven-swing" Warning;
    SAID_TWICE        "W0742" "said-twice" Warning;
    GIVEN_TO_ONE_KIND "W0743" "given-to-one-kind" Warning;
    BEST_STILL        "W0744" "best-at-rest" Warning;
    NEVER_APPLIED     "W0745" "rule-never-applied" Warning;
    SHORT_MOTIONS     "W0746" "odd-short-motions" Warning;
    FAILING_EXAMPLE   "W0747" "failing-example" Warning;
}

/// The code with this id or name, in capitals or not.
#[must_use]
pub fn find(id_or_name: &str) -> Option<&'static Code> {
    let is = |word: &str| word.eq_ignore_ascii_case(id_or_name);
    CODES.iter().copied().find(|c| is(c.id) || is(c.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_and_names_are_unique_and_in_order() {
        for pair in CODES.windows(2) {
            assert!(pair[0].id[1..] < pair[1].id[1..], "{} before {}", pair[0].id, pair[1].id);
        }
        for (i, code) in CODES.iter().enumerate() {
            assert_eq!(find(code.name).map(|c| c.id), Some(CODES[i].id));
            assert_eq!(find(&code.name.to_uppercase()).map(|c| c.id), Some(CODES[i].id));
            assert_eq!(code.id.starts_with('W'), code.severity == Severity::Warning);
        }
    }

    #[test]
    fn every_page_has_its_heading_a_title_and_both_examples() {
        for code in CODES {
            let heading = code.page.lines().next().unwrap();
            assert_eq!(heading, format!("# {} {}", code.id, code.name));
            let title = code.title();
            assert!(
                title.ends_with('.') && !title.contains('\n') && title.len() <= 90,
                "{}: {title}",
                code.id
            );
            assert!(code.meaning().len() > title.len(), "{} says no more than its title", code.id);
            assert!(code.example("fails").is_some(), "{} has no failing example", code.id);
            assert!(code.example("mended").is_some(), "{} has no mended example", code.id);
            let reason = code.page.rsplit("```").next().unwrap().trim();
            assert!(!reason.is_empty(), "{} does not say why", code.id);
        }
    }
}
