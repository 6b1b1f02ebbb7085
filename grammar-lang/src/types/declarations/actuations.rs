//! Checks actuations: what varies, and what drives actuators.

use super::Declarations;
use super::everyones::Everyones;
use super::lets::Lets;
use crate::diagnostics::{Code, Diagnostic, did_you_mean, respell};
use crate::ir::{self, Expr, ExprKind, Group, Ty};
use crate::syntax::ast::{self, ActuationClause, Name};
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::types::expressions::stage::Stage;
use crate::units::Dimension;

/// More states than this, no actuator needs.
const MOST_STATES: usize = 100;

impl Declarations<'_> {
    pub(in crate::types) fn actuation(
        &mut self,
        name: &Name,
        binder: &Name,
        kind: &Name,
        clauses: &[ActuationClause],
        damaged: bool,
    ) -> Option<ir::Actuation> {
        let everyones = self.everyones(name, binder, kind, clauses);
        self.actuation_with(&everyones, name, binder, kind, clauses, damaged)
    }

    pub(super) fn actuation_with(
        &mut self,
        everyones: &Everyones<'_>,
        name: &Name,
        binder: &Name,
        kind: &Name,
        clauses: &[ActuationClause],
        damaged: bool,
    ) -> Option<ir::Actuation> {
        let found = self.expressions.errors.len();
        let mut cx = Context::new(Stage::Drive, damaged);
        let driven = self.actuated(binder, kind, &mut cx);
        let of_cells = driven == Ty::Cell;
        self.expressions.bind(binder, driven, &mut cx);
        let mut variables = self.variables_of_everyone(everyones, &mut cx);
        for clause in clauses {
            let ActuationClause::Variable(variable) = clause else { continue };
            let checked = self.variable(variable, &cx);
            let item = checked.as_ref().map_or(Ty::Unknown, |v| v.ty.clone());
            let ty = Self::type_of_variable(variable, item);
            self.expressions.bind(&variable.name, ty, &mut cx);
            variables.extend(checked);
        }
        let states = self.states(clauses, &mut cx);
        let complete = variables.len() + states.len() + 1 == cx.locals.len();
        let actions = self.actions(clauses, &mut cx);
        let first_state = 1 + variables.len();
        let remembered = first_state..cx.locals.len();
        let mut values = Lets::new(remembered);
        self.values_of_everyone(everyones, &mut cx, &mut values);
        let shared_lets = values.lets.len();
        let mut drive = None;
        for clause in clauses {
            match clause {
                ActuationClause::Let(name, value) => {
                    let value = self.expressions.infer(value, &mut cx);
                    self.expressions.bind(name, value.ty.clone(), &mut cx);
                    values.add(name, value);
                }
                ActuationClause::Drive(what, value) => {
                    let value = self.drive(what, value, of_cells, &variables, &mut cx);
                    if let Some(first) = drive.replace(value) {
                        self.report(
                            Diagnostic::new(
                                Code::DUPLICATE,
                                what.span,
                                "an actuation can have only one `drive`",
                            )
                            .label("another one")
                            .also(first.span, "the first one")
                            .help("keep one of them; angles can be added: `drive angle = a + b`"),
                        );
                    }
                }
                ActuationClause::Variable(_) | ActuationClause::State(_) | ActuationClause::Action(_) => {}
            }
        }
        let states = self.state_changes(clauses, states, &mut cx);
        if drive.as_ref().is_some_and(|drive| drive.ty == Ty::Valves) {
            self.no_memory_of_valves(clauses);
        }
        if drive.is_none() && !damaged {
            self.report(
                Diagnostic::new(
                    Code::MISSING_FIELD,
                    name.span,
                    format!("the actuation `{}` drives nothing", name.text),
                )
                .label("without `drive`")
                .help("add a line such as `drive angle = 30 deg * sin(t / period * 360 deg)`"),
            );
        }
        if !damaged && self.expressions.errors.len() == found {
            self.unread(clauses.iter().filter_map(varied_by), "use it in `drive`, or take it out");
        }
        if !complete {
            return None;
        }
        let span = name.span;
        Some(ir::Actuation {
            variables,
            states: states?,
            actions: actions?,
            lets: values.lets,
            moving: values.moving,
            shared_lets,
            drive: drive?,
            span,
        })
    }

    /// Valves repeat a cycle that is known before the motion: nothing is remembered or decided meanwhile.
    fn no_memory_of_valves(&mut self, clauses: &[ActuationClause]) {
        let kept = clauses.iter().find_map(|clause| match clause {
            ActuationClause::State(state) => Some(("state", &state.name)),
            ActuationClause::Action(action) => Some(("action", &action.name)),
            _ => None,
        });
        let Some((word, name)) = kept else { return };
        self.report(
            Diagnostic::new(
                Code::WRONG_STAGE,
                name.span,
                format!("an actuation with the {word} `{}` cannot drive valves", name.text),
            )
            .label("changes during the motion")
            .help(
                "valves repeat a cycle that is fixed in advance: use `vary` and `shared` to say when they open",
            ),
        );
    }

    /// Where the states of an actuation begin; each has a slot from here on.
    fn states(&mut self, clauses: &[ActuationClause], cx: &mut Context) -> Vec<(Ty, Expr)> {
        let known = cx.locals.len();
        let mut states = Vec::new();
        for clause in clauses {
            let ActuationClause::State(state) = clause else { continue };
            if states.len() == MOST_STATES {
                self.report(
                    Diagnostic::new(
                        Code::OUT_OF_DOMAIN,
                        state.name.span,
                        format!("an actuation has at most {MOST_STATES} states"),
                    )
                    .label("one too many")
                    .help("move some states to the actuations of other kinds of actuators"),
                );
                break;
            }
            let (ty, from) = self.begun(state, cx, known);
            self.expressions.bind(&state.name, ty.clone(), cx);
            states.push((ty, from));
        }
        states
    }

    /// What states will be at the next control moment, where all values are known.
    fn state_changes(
        &mut self,
        clauses: &[ActuationClause],
        begun: Vec<(Ty, Expr)>,
        cx: &mut Context,
    ) -> Option<Vec<ir::State>> {
        let states = clauses.iter().filter_map(|clause| match clause {
            ActuationClause::State(state) => Some(state),
            _ => None,
        });
        let mut sound = true;
        let mut all = Vec::new();
        for (state, begun) in states.zip(begun) {
            let changed = self.state_change(state, begun, cx);
            sound &= changed.is_some();
            all.extend(changed);
        }
        sound.then_some(all)
    }

    /// The type of what an actuation is for.
    fn actuated(&mut self, binder: &Name, kind: &Name, cx: &mut Context) -> Ty {
        let group = self.group_named(kind, cx);
        group.iter().for_each(|group| self.expressions.note_group(binder, group));
        let is_fine = match &group {
            Some(Group::Actuator | Group::Cell) | None => true,
            Some(Group::Kind(name)) => {
                self.expressions.is_actuator(name, kind.span) || self.expressions.is_cell(name, kind.span)
            }
            _ => false,
        };
        if !is_fine {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, kind.span, format!("`{}` cannot be driven", kind.text))
                    .label("not an actuator")
                    .help("write `for a : actuator`"),
            );
        }
        group.as_ref().map_or(Ty::Actuator, |group| self.expressions.member_of(group, kind.span))
    }

    /// What an actuation drives: a strain of cells, valves, or an angle.
    fn drive(
        &mut self,
        what: &Name,
        value: &ast::Expr,
        of_cells: bool,
        variables: &[ir::Variable],
        cx: &mut Context,
    ) -> Expr {
        self.check_driven(what, of_cells);
        let known = ir::DRIVEN.into_iter().find(|(word, _)| *word == what.text);
        let is_known = known.is_some() || of_cells;
        let (ty, said) = match known {
            _ if of_cells => (Ty::NUMBER, "the driven strain".to_owned()),
            Some((_, Ty::Valves)) => (Ty::Valves, "what drives the valves".to_owned()),
            Some((word, ty)) => (ty, format!("the driven {word}")),
            None => (Ty::Quantity(Dimension::ANGLE), "the driven angle".to_owned()),
        };
        if !is_known {
            // What it should drive is not known, nor what its value must be.
            return self.expressions.infer(value, cx);
        }
        let value = self.expressions.infer(value, cx);
        // What has the dimension of another drive is that drive.
        let other = ir::DRIVEN.iter().find(|(_, other)| *other == value.ty && *other != ty && !of_cells);
        let known_errors = self.expressions.errors.len();
        let value = self.expressions.fit(value, &ty, &said);
        for mut error in self.expressions.errors.split_off(known_errors) {
            if let Some((word, _)) = other
                && error.code == Code::WRONG_DIMENSION
                && error.fix.is_none()
                && !error.help.as_ref().is_some_and(|help| help.starts_with("write it in a unit"))
            {
                error.help = Some(format!("of what {}, write `drive {word} = ...`", ir::moved_by(word)));
            }
            self.expressions.errors.add(error);
        }
        if ty == Ty::Valves {
            self.check_valves(&value, variables);
        }
        value
    }

    /// An actuator has an angle, a distance, a speed or valves to drive, a cell a strain.
    fn check_driven(&mut self, what: &Name, of_cells: bool) {
        let known =
            if of_cells { vec!["strain"] } else { ir::DRIVEN.iter().map(|(word, _)| *word).collect() };
        if known.contains(&what.text.as_str()) {
            return;
        }
        let (owner, help) = if of_cells {
            (
                "a cell",
                "write `drive strain = ...`: the relative growth of the cell, as in `10 % * sin(t / 2 s * 360 deg)`",
            )
        } else {
            (
                "an actuator",
                "write `drive angle = ...`, `drive distance = ...` (of what slides), `drive speed = ...` (of what spins) or `drive valves = ...`",
            )
        };
        let message = format!("{owner} has no `{}` to drive", what.text);
        self.report(
            Diagnostic::new(Code::UNKNOWN_FIELD, what.span, message)
                .label("not known")
                .help(help)
                .fix_if(respell(what.span, &what.text, known.iter().copied())),
        );
    }

    /// A schedule of valves repeats: what it is made of does not change with the time.
    fn check_valves(&mut self, valves: &Expr, variables: &[ir::Variable]) {
        if let ExprKind::Call(ir::Function::Cycle, arguments) = &valves.kind
            && let [_, shares, states, _] = arguments.as_slice()
        {
            let length = |list: &Expr| match &list.kind {
                ExprKind::List(items) => Some(items.len()),
                // The actuator has the first slot.
                ExprKind::Local(slot) => variables.get(slot.checked_sub(1)?)?.size,
                _ => None,
            };
            if let (Some(n), Some(m)) = (length(shares), length(states))
                && n != m
            {
                self.report(
                    Diagnostic::new(
                        Code::WRONG_ARGUMENTS,
                        shares.span,
                        format!("a cycle needs one share for each state, but has {n} shares and {m} states"),
                    )
                    .label(format!("{n} shares"))
                    .also(states.span, format!("{m} states"))
                    .help(format!("declare `share[{m}]`, or name {n} states")),
                );
            }
        }
        let mut time = None;
        valves.any(&mut |e| {
            if matches!(
                e.kind,
                ExprKind::Word(ir::Word::Time | ir::Word::ControlInterval) | ExprKind::Sensor(..)
            ) {
                time = Some(e.span);
            }
            false
        });
        if let Some(span) = time {
            let what = self.environment.sources.slice(span).to_owned();
            self.report(
                Diagnostic::new(
                    Code::WRONG_STAGE,
                    span,
                    format!("`{what}` cannot be read in a schedule of valves"),
                )
                .label("the same cycle repeats")
                .help("use the period, the shares and the phase to say when valves open"),
            );
        }
    }

    /// Who has a variable of its own.
    fn owner(&mut self, variable: &ast::Variable, cx: &Context) -> Option<ir::Owner> {
        let Some(per) = &variable.per else {
            return Some(if variable.shared { ir::Owner::Body } else { ir::Owner::Actuator });
        };
        if variable.shared {
            self.report(
                Diagnostic::new(
                    Code::DUPLICATE,
                    per.span,
                    "a shared variable cannot have `per`: it has one value for the whole body",
                )
                .label("only one of them can count")
                .help("write `vary` instead of `shared`, or take `per` out"),
            );
            return None;
        }
        // Only the actuator itself is known: its variables are what is being declared.
        let mut cx = Context { stage: Stage::Derivation, ..cx.clone() };
        cx.locals.truncate(1);
        // Each by itself: what groups by several things need not be of one type.
        let several = match &per.kind {
            ast::ExprKind::List(items) if !items.is_empty() => items.as_slice(),
            _ => std::slice::from_ref(per),
        };
        let mut values = Vec::with_capacity(several.len());
        for one in several {
            let value = self.expressions.infer(one, &mut cx);
            match value.ty {
                Ty::Count | Ty::Quantity(_) | Ty::Enum(_) | Ty::Bool => values.push(value),
                Ty::Unknown => return None,
                ref other => {
                    self.report(
                        Diagnostic::new(Code::WRONG_TYPE, one.span, "`per` needs a number")
                            .label(format!("this is {}", article(other)))
                            .help("write for example `per a.channel`, or `per [a is finger, a.level]` for several at once"),
                    );
                    return None;
                }
            }
        }
        if let (false, Some(value)) = (matches!(per.kind, ast::ExprKind::List(_)), values.first()) {
            return Some(ir::Owner::Group(value.clone()));
        }
        let ty = Ty::List(Box::new(Ty::NUMBER));
        Some(ir::Owner::Group(Expr { kind: ExprKind::List(values), ty, span: per.span }))
    }

    pub(super) fn variable(&mut self, variable: &ast::Variable, cx: &Context) -> Option<ir::Variable> {
        let ty = self.expressions.type_named(&variable.ty);
        let owner = self.owner(variable, cx);
        let size = match &variable.size {
            None => None,
            Some(size) => Some(self.list_length(size, cx)?),
        };
        let domain = self.varied_domain(variable, &ty, cx)?;
        let from = match &variable.from {
            Some(from) => Some(self.beginning(variable, from, (&ty, domain, size), cx)?),
            None => None,
        };
        let (probability, kernel) = self.mutation(variable, &ty, cx)?;
        let bound = variable.bound.as_ref().map_or(ir::Bound::Clamp, |bound| self.bound(bound));
        Some(ir::Variable {
            name: variable.name.text.clone(),
            owner: owner?,
            size,
            ty,
            domain,
            from,
            mutation: ir::Mutation { probability, kernel, bound },
            span: variable.name.span,
        })
    }

    /// Where a search for curves begins with a variable. One that each actuator has may read the actuator.
    fn beginning(
        &mut self,
        variable: &ast::Variable,
        from: &ast::Expr,
        (ty, (low, high), size): (&Ty, (f64, f64), Option<usize>),
        cx: &Context,
    ) -> Option<Expr> {
        let mut known = Context { stage: Stage::Derivation, ..cx.clone() };
        known.locals.truncate(if variable.shared { 0 } else { 1 });
        let what = format!("where `{}` begins", variable.name.text);
        let before = self.expressions.errors.len();
        let value = match size {
            Some(_) => {
                let wanted = Ty::List(Box::new(ty.clone()));
                self.expressions.expect(from, &mut known, &wanted, &what)
            }
            None => self.expressions.expect(from, &mut known, ty, &what),
        };
        for mut error in self.expressions.errors.split_off(before) {
            if error.code == Code::UNKNOWN_NAME && variable.shared {
                error.help = Some(
                    "a shared variable begins with one value for all: no actuator is known here".to_owned(),
                );
            }
            self.expressions.errors.add(error);
        }
        if value.ty == Ty::Unknown {
            return None;
        }
        let items = match &value.kind {
            ExprKind::List(items) => items.iter().collect(),
            _ => vec![&value],
        };
        if let (Some(many), ExprKind::List(items)) = (size, &value.kind)
            && items.len() != many
        {
            self.report(
                Diagnostic::new(
                    Code::WRONG_TYPE,
                    from.span,
                    format!("`{}` needs {many} values", variable.name.text),
                )
                .label(format!("{} values", items.len()))
                .help("give one value for each item"),
            );
            return None;
        }
        let outside = items.into_iter().find(|item| {
            self.expressions
                .quiet_number(item)
                .is_some_and(|x| *ty != Ty::Bool && !crate::eval::order::is_within(low, x, high))
        });
        if let Some(outside) = outside {
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    outside.span,
                    format!("`{}` begins outside its domain", variable.name.text),
                )
                .label("outside")
                .help("choose a first value within the domain"),
            );
            return None;
        }
        Some(value)
    }

    fn list_length(&mut self, size: &ast::Expr, cx: &Context) -> Option<usize> {
        let mut constant = Context::new(Stage::Declaration, cx.damaged);
        let span = size.span;
        let size = self.expressions.expect(size, &mut constant, &Ty::Count, "the length of a list");
        let n = self.expressions.constant_number(&size)?;
        if (1.0..=64.0).contains(&n) {
            return Some(n as usize);
        }
        self.report(
            Diagnostic::new(Code::OUT_OF_DOMAIN, span, "the length of a list must lie within 1 .. 64")
                .label(format!("this is {n}"))
                .help("leave the brackets out for a single value"),
        );
        None
    }

    /// The least and greatest value of what the search varies.
    fn varied_domain(&mut self, variable: &ast::Variable, ty: &Ty, cx: &Context) -> Option<(f64, f64)> {
        let name = &variable.name;
        let error = match (ty, &variable.domain) {
            (Ty::Unknown, _) => return None,
            (Ty::Bool, None) => return Some((0.0, 1.0)),
            (Ty::Bool, Some(domain)) => {
                let message = format!("`{}` is a Bool, and cannot have a domain", name.text);
                Diagnostic::new(Code::WRONG_TYPE, domain.span, message).label("a domain would have no effect").help(
                    format!(
                        "leave the domain out, and write `{0} : Bool flip 0.1`; for a fixed value, write `let {0} = false`",
                        name.text
                    ),
                )
            }
            (Ty::Quantity(_) | Ty::Count, Some(domain)) => {
                let mut constant = Context::new(Stage::Declaration, cx.damaged);
                let what = format!("the domain of `{}`", name.text);
                let known = self.expressions.errors.len();
                let domain =
                    self.expressions.expect(domain, &mut constant, &Ty::Domain(Box::new(ty.clone())), &what);
                let own: Vec<&str> = cx.locals.iter().map(|local| local.name.as_str()).collect();
                for mut error in self.expressions.errors.split_off(known) {
                    if error.code == Code::UNKNOWN_NAME
                        && own.contains(&self.environment.sources.slice(error.span()))
                    {
                        error.help = Some(
                            "the domain is the same for all actuators: vary a share, as in `: Number in 0 .. 1`, and multiply it in \
                             `drive` by what the actuator has"
                                .to_owned(),
                        );
                    }
                    self.expressions.errors.add(error);
                }
                return self.expressions.constant_range(&domain);
            }
            (Ty::Quantity(_) | Ty::Count, None) => {
                Diagnostic::new(Code::MISSING_FIELD, name.span, format!("`{}` has no domain", name.text))
                    .label("without a domain")
                    .help("write `in LEAST .. GREATEST` after its type")
            }
            _ => {
                let message = "only a quantity, a Count or a Bool can be varied";
                Diagnostic::new(Code::WRONG_TYPE, variable.ty.span, message).label("not one of these")
            }
        };
        self.report(error);
        None
    }

    /// How often and by what something changes in a move of the search.
    fn mutation(&mut self, variable: &ast::Variable, ty: &Ty, cx: &Context) -> Option<(Expr, ir::Kernel)> {
        let name = &variable.name;
        let mut mutating = Context::new(Stage::Mutation, cx.damaged);
        let (label, help) = match (ty, &variable.mutate, &variable.flip) {
            (Ty::Bool, None, Some(p)) => return Some((self.chance(p, &mut mutating), ir::Kernel::Flip)),
            (Ty::Bool, ..) => ("without `flip`", "write `flip 0.1` after its type"),
            (_, Some((p, kernel)), None) => {
                let p = self.chance(p, &mut mutating);
                let wanted = match ty {
                    Ty::Count => Dimension::NUMBER,
                    ty => ty.dimension()?,
                };
                let kernel = self.expressions.expect(
                    kernel,
                    &mut mutating,
                    &Ty::Distribution(wanted),
                    "what follows `by`",
                );
                let ExprKind::Call(function, arguments) = kernel.kind else { return None };
                let [a, b] = <[Expr; 2]>::try_from(arguments).ok()?;
                let normal = function == ir::Function::Normal;
                return Some((p, if normal { ir::Kernel::Normal(a, b) } else { ir::Kernel::Uniform(a, b) }));
            }
            _ => ("without `mutate`", "write `mutate 0.5 by normal(0, ...)` after its domain"),
        };
        let message = format!("`{}` is never varied", name.text);
        self.report(Diagnostic::new(Code::MISSING_FIELD, name.span, message).label(label).help(help));
        None
    }

    fn chance(&mut self, tree: &ast::Expr, cx: &mut Context) -> Expr {
        let expr = self.expressions.expect(tree, cx, &Ty::NUMBER, "a probability");
        if let Some(p) = self.expressions.quiet_number(&expr)
            && !(0.0..=1.0).contains(&p)
        {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, expr.span, "a probability must lie within 0 .. 1")
                    .label(format!("this is {p}"))
                    .help("write for example `0.3` or `30 %`"),
            );
        }
        expr
    }

    /// What happens to a value beyond the ends of its domain.
    fn bound(&mut self, bound: &Name) -> ir::Bound {
        const WORDS: [&str; 3] = ["clamp", "reflect", "resample"];
        match bound.text.as_str() {
            "clamp" => ir::Bound::Clamp,
            "reflect" => ir::Bound::Reflect,
            "resample" => ir::Bound::Resample,
            other => {
                let message = format!("`bound` cannot be `{other}`");
                let help = did_you_mean(other, WORDS);
                self.report(
                    Diagnostic::new(Code::UNKNOWN_FIELD, bound.span, message)
                        .label("not known")
                        .help(help.unwrap_or_else(|| "write `clamp`, `reflect` or `resample`".to_owned()))
                        .fix_if(respell(bound.span, other, WORDS)),
                );
                ir::Bound::Reflect
            }
        }
    }
}

/// The name that a clause of an actuation binds, unless others can read it:
/// terms read the period and what the whole body shares.
fn varied_by(clause: &ActuationClause) -> Option<&Name> {
    match clause {
        ActuationClause::Variable(variable) if !variable.shared => Some(&variable.name),
        ActuationClause::Let(name, _) if name.text != "period" => Some(name),
        ActuationClause::State(state) => Some(&state.name),
        ActuationClause::Action(action) => Some(&action.name),
        _ => None,
    }
}
