//! Stages: when an expression is evaluated, and so what it may read.

use crate::ir::{
    Attribute, DesignFunction, DesignWord, ElementAttribute, Function, MotionWord, PartAttribute, SearchWord,
    Word,
};

/// When an expression is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::types) enum Stage {
    /// Once, before anything runs.
    Declaration,
    /// For a place in the cycle of a pattern.
    Pattern,
    /// On the design so far: guards, choices, effects, requirements.
    Derivation,
    /// When a rule draws its choices.
    Choice,
    /// When a rule is drawn.
    Weight,
    /// For an actuator at a time.
    Drive,
    /// When a sensor reads, at a control moment.
    Sense,
    /// When a policy decides, of what became of what it decided before.
    Reward,
    /// When a curve is mutated.
    Mutation,
    /// When the search decides how to go on.
    Schedule,
    /// On the recorded motion.
    Score,
    /// On the recorded motions of a task, one in each of its worlds.
    Objective,
    /// On the values of several tasks.
    Outcome,
}

impl Stage {
    /// What people call an expression of this stage.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Declaration => "a declaration",
            Self::Pattern => "a pattern",
            Self::Derivation => "the derivation of a design",
            Self::Choice => "a choice of a rule",
            Self::Weight => "a rule's weight",
            Self::Drive => "an actuation",
            Self::Sense => "a sensor",
            Self::Reward => "a reward",
            Self::Mutation => "a mutation",
            Self::Schedule => "a search schedule",
            Self::Score => "a term",
            Self::Objective => "an objective",
            Self::Outcome => "an objective over tasks",
        }
    }

    /// Whether the design may be read.
    pub(super) fn sees_design(self) -> bool {
        !matches!(self, Self::Declaration | Self::Pattern)
    }

    /// Where no body is around, in words, if none is. What is worked out before anything runs is asked for by what reads it.
    pub(super) fn sees_no_body(self) -> Option<&'static str> {
        match self {
            Self::Pattern => Some("in a pattern"),
            Self::Schedule => Some("in a search schedule"),
            _ => None,
        }
    }

    /// Whether a word has a value.
    pub(super) fn sees_word(self, word: Word) -> bool {
        stages_of(word).is_none_or(|stages| stages.contains(&self))
    }

    /// Whether a function can be called.
    pub(super) fn sees_function(self, function: Function) -> bool {
        match function {
            Function::Cycle => self == Self::Drive,
            Function::Gain => self == Self::Schedule,
            Function::Design(
                DesignFunction::Neighbours
                | DesignFunction::Images
                | DesignFunction::HangingOn
                | DesignFunction::Cell
                | DesignFunction::Region,
            ) => self.sees_design(),
            _ => true,
        }
    }

    /// Whether a word has a value in this stage, or in another one that reads what is bound in this one: what a rule chooses from
    /// is found when it draws, and how a curve is mutated when it is.
    pub(super) fn shares_word(self, word: Word) -> bool {
        let others: &[Self] = match self {
            Self::Derivation => &[Self::Choice, Self::Weight],
            Self::Drive => &[Self::Mutation, Self::Sense],
            _ => &[],
        };
        self.sees_word(word) || others.iter().any(|other| other.sees_word(word))
    }

    /// What can be done in this stage in place of reading a word or a term that is not known here.
    pub(super) fn instead(self, name: &str, where_known: &str) -> &'static str {
        let is_of_design = where_known.contains("rules");
        let is_of_search = where_known.contains("search schedule");
        let is_of_motion =
            !is_of_design && (where_known.contains("term") || where_known.contains("objective"));
        match self {
            Self::Weight | Self::Choice if name == "iteration" => {
                "; here, `temperature` falls with the iterations"
            }
            Self::Schedule if name == "t" => "; a schedule reads `iteration`",
            Self::Pattern if name == "t" => "; a pattern reads `cycle`, which goes from 0 to 1",
            Self::Drive => {
                "; a drive reads `t`, its actuator, what the actuation varies, and sensors (`sense`)"
            }
            Self::Sense if name == "t" || is_of_motion => {
                "; a sensor reads the present (`now`), as in `core.rotation at now`"
            }
            Self::Reward if name == "t" || is_of_motion => {
                "; a reward reads the present (`now`) and the previous decision (`before`), as in `core.position at now` and `core.position at before`"
            }
            Self::Declaration if is_of_design => {
                "; the fields of a part cannot read the design: for a number that may differ, declare a `param` of the grammar or of the part"
            }
            Self::Derivation if is_of_motion => {
                "; conditions on the motion belong in the objective, as in `maximize travel - 10 * fall in cm`"
            }
            Self::Derivation if is_of_search || name == "t" => {
                "; a rule reads the design, parameters, and what it matched and chose: nothing has moved yet, and no search is known"
            }
            Self::Score | Self::Objective | Self::Outcome if is_of_search => {
                "; an objective reads the motion and the design, and is the same at all times of a search"
            }
            _ => "",
        }
    }

    /// Whether elements have positions and rotations.
    pub(super) fn sees_motion(self) -> bool {
        matches!(self, Self::Score | Self::Objective)
    }

    /// Whether an attribute of what moves has a value: a sensor knows what is so now, terms know the whole motion.
    pub(super) fn sees_attribute(self, attribute: &Attribute) -> bool {
        if matches!(self, Self::Sense | Self::Reward) {
            return match attribute {
                Attribute::Element(of) => matches!(of, ElementAttribute::Size | ElementAttribute::Part),
                attribute => *attribute != Attribute::Part(PartAttribute::Work),
            };
        }
        !attribute.is_felt() && (!attribute.is_of_motion() || self.sees_motion())
    }

    /// Whether there are worlds to run over.
    pub(super) fn sees_worlds(self) -> bool {
        self == Self::Objective
    }
}

/// The stages that give a value to a word; `None` for all.
pub(super) fn stages_of(word: Word) -> Option<&'static [Stage]> {
    use Stage as S;
    Some(match word {
        Word::Pi => return None,
        Word::Cycle => &[S::Pattern],
        Word::Time | Word::Closed | Word::Inflate | Word::Vent => &[S::Drive],
        Word::Motion(
            MotionWord::Start
            | MotionWord::End
            | MotionWord::Duration
            | MotionWord::FrameInterval
            | MotionWord::Period,
        ) => &[S::Score, S::Objective],
        Word::Motion(MotionWord::Elements) => &[S::Score, S::Objective, S::Sense, S::Reward],
        Word::Now => &[S::Sense, S::Reward],
        Word::Before => &[S::Reward],
        Word::ControlInterval => &[S::Drive],
        Word::Search(SearchWord::Temperature) => &[S::Choice, S::Weight, S::Mutation, S::Schedule],
        Word::Search(SearchWord::Iteration) => &[S::Schedule, S::Mutation],
        Word::Search(
            SearchWord::Best
            | SearchWord::Idle
            | SearchWord::Refused
            | SearchWord::Stagnant
            | SearchWord::Deviation
            | SearchWord::Chain
            | SearchWord::Spread
            | SearchWord::Tuned
            | SearchWord::Parent
            | SearchWord::Spent,
        ) => &[S::Schedule],
        Word::Design(DesignWord::Connected | DesignWord::NoOverlap) => &[S::Derivation, S::Choice, S::Weight],
        Word::Design(DesignWord::Middle) => &[S::Derivation, S::Choice, S::Weight, S::Score, S::Objective],
    })
}
