//! Checks policies, and the actions that they decide.

use indexmap::IndexMap;

use super::Declarations;
use super::fields::{Fields, Values};
use super::loops::whole;
use super::tasks::Tasks;
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, ActionSpace, Expr, ExprKind, Ty};
use crate::syntax::ast::{self, ActuationClause, Block, ItemKind};
use crate::syntax::declarations::BlockKind;
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

const POLICY: Fields<'static> = Fields {
    all: &["inputs", "mirrored", "hidden", "every", "reward", "mutation_chance", "mutation_size"],
    blocks: &[],
};

/// Hidden layers of a policy, at most.
const MOST_LAYERS: usize = 4;
/// Nodes of a hidden layer, at most.
const WIDEST: f64 = 256.0;
/// Inputs that are listed in one place, and values between which one is decided, at most.
const LONGEST: usize = 64;
/// The longest time between two decisions, s.
const SLOWEST: f64 = 60.0;

/// What a policy is if it does not say: one layer, and how a search by mutation moves.
const USUAL_HIDDEN: &[usize] = &[16];
const USUAL_CHANCE: f64 = 0.1;
const USUAL_SIZE: f64 = 0.5;

impl Declarations<'_> {
    pub(super) fn policy(&mut self, block: &Block, damaged: bool) -> Option<ir::Policy> {
        let from = self.values(block, "a policy", POLICY);
        let inputs = match from.values.get("inputs") {
            Some((_, tree)) => {
                let tree = *tree;
                self.inputs(tree, &mut Context::new(Stage::Drive, damaged))
            }
            None => Some(Vec::new()),
        };
        let mirrored = from.values.get("mirrored").map(|(_, tree)| {
            let tree = *tree;
            self.mirrored(tree, &mut Context::new(Stage::Drive, damaged))
        });
        let hidden = self.hidden(&from, "hidden", USUAL_HIDDEN, &Context::new(Stage::Declaration, damaged));
        let time = Ty::Quantity(Dimension::TIME);
        let every = match from.values.contains_key("every") {
            true => self.bounded(&from, "every", &time, (1e-3, SLOWEST), "0.2 s", damaged).map(Some),
            false => Some(None),
        };
        let reward = from.values.get("reward").map(|(_, tree)| {
            let tree = *tree;
            self.reward(tree, damaged)
        });
        let mut share = |name: &str, usual: f64, most: f64, example: &str| {
            if !from.values.contains_key(name) {
                return Some(usual);
            }
            self.bounded(&from, name, &Ty::NUMBER, (0.0, most), example, damaged)
        };
        let mutation_chance = share("mutation_chance", USUAL_CHANCE, 1.0, "10 %");
        let mutation_size = share("mutation_size", USUAL_SIZE, 4.0, "0.5");
        Some(ir::Policy {
            inputs: inputs?,
            mirrored: whole(mirrored)?,
            hidden: hidden?,
            every: every?,
            reward: whole(reward)?,
            mutation_chance: mutation_chance?,
            mutation_size: mutation_size?,
            span: block.name.span,
        })
    }

    /// What changes its sign in the mirror.
    fn mirrored(&mut self, tree: &ast::Expr, cx: &mut Context) -> Option<Vec<Expr>> {
        let inputs = self.inputs(tree, cx)?;
        if let Some(yes) = inputs.iter().find(|input| input.ty == Ty::Bool) {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, yes.span, "what is `mirrored` must be a Number")
                    .label("a Bool has no sign")
                    .help("write it among the `inputs`, if it is the same in the mirror"),
            );
            return None;
        }
        Some(inputs)
    }

    /// What a learner gets.
    fn reward(&mut self, tree: &ast::Expr, damaged: bool) -> Option<Expr> {
        let value = self.expressions.infer(tree, &mut Context::new(Stage::Reward, damaged));
        if matches!(value.ty, Ty::Count | Ty::Bool) || value.ty == Ty::NUMBER {
            return Some(value);
        }
        if value.ty != Ty::Unknown {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, tree.span, "a reward must be a number")
                    .label(format!("this is {}", article(&value.ty)))
                    .help("divide it by a good value, so that the reward is about 1: `(core.velocity at now).x / (5 cm/s)`"),
            );
        }
        None
    }

    /// A number of a field that lies between two others.
    pub(super) fn bounded(
        &mut self,
        from: &Values<'_>,
        name: &str,
        ty: &Ty,
        (least, most): (f64, f64),
        example: &str,
        damaged: bool,
    ) -> Option<f64> {
        let cx = Context::new(Stage::Declaration, damaged);
        let (value, span) = self.value(from, name, ty, example, &cx)?;
        let value = value.as_number()?;
        if (least..=most).contains(&value) {
            return Some(value);
        }
        let dimension = ty.dimension().unwrap_or_default();
        let shown = |x: f64| crate::units::shown(x, dimension);
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                span,
                format!("`{name}` must lie within {} .. {}", shown(least), shown(most)),
            )
            .label(format!("this is {}", shown(value)))
            .help(format!("write for example `{name} = {example}`")),
        );
        None
    }

    /// The sizes of the hidden layers of a network.
    pub(super) fn hidden(
        &mut self,
        from: &Values<'_>,
        name: &'static str,
        usual: &[usize],
        cx: &Context,
    ) -> Option<Vec<usize>> {
        let Some((_, tree)) = from.values.get(name) else { return Some(usual.to_vec()) };
        if is_empty_list(tree) {
            return Some(Vec::new());
        }
        let list = Ty::List(Box::new(Ty::Count));
        let (value, span) = self.value(from, name, &list, "[16, 16]", cx)?;
        let sizes: Vec<f64> = value.items().iter().filter_map(Value::as_number).collect();
        let wrong = sizes.iter().find(|size| !(1.0..=WIDEST).contains(*size));
        if wrong.is_none() && sizes.len() <= MOST_LAYERS {
            return Some(sizes.iter().map(|size| *size as usize).collect());
        }
        let label = wrong.map_or_else(|| format!("{} layers", sizes.len()), |size| format!("{size} nodes"));
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                span,
                format!(
                    "a network can have at most {MOST_LAYERS} hidden layers, each of 1 to {WIDEST} nodes"
                ),
            )
            .label(label)
            .help(format!("write for example `{name} = [16, 16]`; small networks learn faster")),
        );
        None
    }

    /// A list of numbers that a policy knows.
    fn inputs(&mut self, tree: &ast::Expr, cx: &mut Context) -> Option<Vec<Expr>> {
        if is_empty_list(tree) {
            return Some(Vec::new());
        }
        // Each by itself: numbers and Bools may stand side by side.
        let items = if let ast::ExprKind::List(items) = &tree.kind {
            items.iter().map(|item| self.expressions.infer(item, cx)).collect()
        } else {
            let list = self.expressions.infer(tree, cx);
            let ExprKind::List(items) = list.kind else {
                if list.ty != Ty::Unknown {
                    self.report(
                        Diagnostic::new(
                            Code::WRONG_TYPE,
                            tree.span,
                            "the inputs after `from` must be a list of numbers",
                        )
                        .label(format!("this is {}", article(&list.ty)))
                        .help("write a list, as in `[lean / 30 deg, speed / (10 cm/s)]`"),
                    );
                }
                return None;
            };
            items
        };
        if items.len() > LONGEST {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    tree.span,
                    format!("at most {LONGEST} numbers can be listed here"),
                )
                .label(format!("these are {}", items.len()))
                .help("leave out inputs that the policy does not need"),
            );
            return None;
        }
        let mut inputs = Vec::new();
        for item in items {
            let sound = matches!(item.ty, Ty::Count | Ty::Bool) || item.ty == Ty::NUMBER;
            if !sound && item.ty != Ty::Unknown {
                self.report(
                    Diagnostic::new(Code::WRONG_TYPE, item.span, "an input of a policy must be a Number or a Bool")
                        .label(format!("this is {}", article(&item.ty)))
                        .help("divide it by a usual value, so that the number lies near -1 .. 1: `bent(a) / 60 deg`"),
                );
                return None;
            }
            if item.ty == Ty::Unknown {
                return None;
            }
            inputs.push(item);
        }
        Some(inputs)
    }

    /// The actions of an actuation; each has a slot from here on.
    pub(super) fn actions(
        &mut self,
        clauses: &[ActuationClause],
        cx: &mut Context,
    ) -> Option<Vec<ir::Action>> {
        let actions = clauses.iter().filter_map(|clause| match clause {
            ActuationClause::Action(action) => Some(&**action),
            _ => None,
        });
        let mut kinds = Vec::new();
        for action in actions.clone() {
            let ty = self.expressions.type_named(&action.ty);
            let space = self.action_space(action, &ty, cx);
            let is_policy = |kind: &ItemKind| matches!(kind, ItemKind::Block(BlockKind::Policy, _));
            let policy = self.named(&action.policy, "policy", is_policy).is_some();
            self.expressions.read.extend(self.declared_at(&action.policy));
            self.expressions.bind(&action.name, ty.clone(), cx);
            kinds.push((ty, space.filter(|_| policy)));
        }
        // What it decided last is known of each.
        let mut all = Some(Vec::new());
        for (action, (ty, space)) in actions.zip(kinds) {
            let inputs = match &action.inputs {
                Some(inputs) => self.inputs(inputs, cx),
                None => Some(Vec::new()),
            };
            let one = space.zip(inputs).map(|(space, inputs)| ir::Action {
                name: action.name.text.clone(),
                ty,
                space,
                policy: action.policy.text.clone(),
                inputs,
            });
            all = all.zip(one).map(|(mut all, one)| {
                all.push(one);
                all
            });
        }
        all
    }

    /// The values between which a policy decides.
    fn action_space(&mut self, action: &ast::Action, ty: &Ty, cx: &Context) -> Option<ActionSpace> {
        if !matches!(ty, Ty::Quantity(_) | Ty::Count | Ty::Bool | Ty::Unknown) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    action.ty.span,
                    "an action is a quantity, a Count or a Bool",
                )
                .label(format!("this is {}", article(ty)))
                .help("write for example `action push : Number in -1 .. 1 of brain from [...]`"),
            );
            return None;
        }
        let mut constant = Context::new(Stage::Declaration, cx.damaged);
        let wanted = Ty::Domain(Box::new(ty.clone()));
        let what = format!("the range of `{}`", action.name.text);
        let known = self.expressions.errors.len();
        let domain = self.expressions.expect(&action.domain, &mut constant, &wanted, &what);
        let own: Vec<&str> = cx.locals.iter().map(|local| local.name.as_str()).collect();
        for mut error in self.expressions.errors.split_off(known) {
            if error.code == Code::UNKNOWN_NAME && own.contains(&self.environment.sources.slice(error.span()))
            {
                error.help = Some(
                    "all actuators have the same range of actions: let the policy decide a share, as in `: Number in 0 .. 1`, and multiply it in `drive` by a value of the actuator"
                        .to_owned(),
                );
            }
            self.expressions.errors.add(error);
        }
        let values: Vec<f64> = match &domain.kind {
            ExprKind::Range(..) if *ty != Ty::Count => {
                let (low, high) = self.expressions.constant_range(&domain)?;
                return Some(ActionSpace::Continuous(low, high));
            }
            _ => {
                let Value::Domain(items) = self.expressions.constant(&domain)? else { return None };
                let number = |value: Value| match value {
                    Value::Bool(yes) => Some(f64::from(u8::from(yes))),
                    value => value.as_number(),
                };
                items.items().take(LONGEST + 1).filter_map(number).collect()
            }
        };
        if (2..=LONGEST).contains(&values.len()) {
            return Some(ActionSpace::Discrete(values));
        }
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                action.domain.span,
                format!("an action needs a range, or a set of 2 to {LONGEST} values"),
            )
            .label(if values.len() < 2 { "only one value: there is nothing to decide" } else { "too many" })
            .help("write for example `in { -1, 0, 1 }` or `in -1 .. 1`"),
        );
        None
    }

    /// A network is of one body: how many inputs it has follows from the actuators.
    pub(in crate::types) fn check_policies(
        &mut self,
        tasks: &Tasks,
        actuations: &IndexMap<String, ir::Actuation>,
        searches_bodies: bool,
    ) {
        if !searches_bodies {
            return;
        }
        for (_, actuated) in tasks.values() {
            let decided = actuated.values().find_map(|(with, place)| {
                let action = actuations.get(with)?.actions.first()?;
                Some((with, *place, action.policy.clone()))
            });
            let Some((with, place, policy)) = decided else { continue };
            self.report(
                Diagnostic::new(
                    Code::MODEL_MISFIT,
                    place,
                    format!("`{with}` leaves actions to `{policy}`, but the search changes bodies"),
                )
                .label("the network fits one body only")
                .help("place the body with `begin` (`sgc export --to begin` writes it), and search its curves only, as `gait_evolution` of `std.search` does"),
            );
            return;
        }
    }
}

/// `[]`: nothing, in words that mean it.
fn is_empty_list(tree: &ast::Expr) -> bool {
    matches!(&tree.kind, ast::ExprKind::List(items) if items.is_empty())
}
