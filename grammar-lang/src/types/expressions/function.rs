//! Calls of built-in functions.

use super::call::given;
use super::context::Context;
use super::stage::Stage;
use super::{Expressions, signature};
use crate::diagnostics::{Code, Diagnostic};
use crate::ir::{DesignFunction, Expr, ExprKind, Function, Ty};
use crate::names::Declaration;
use crate::source::Span;
use crate::syntax::ast;
use crate::types::found::Found;
use crate::units::Dimension;

impl Expressions<'_> {
    /// Checks the body of a function in every stage; it must fit one of them.
    pub(in crate::types) fn own_body(
        &mut self,
        declaration: Declaration,
        parameters: &[ast::Typed],
        value: &ast::Expr,
    ) {
        let known = std::mem::take(&mut self.errors);
        let outside = std::mem::replace(&mut self.tries_a_body, true);
        let mut fewest: Option<Found> = None;
        let anywhere = [
            Stage::Declaration,
            Stage::Derivation,
            Stage::Objective,
            Stage::Drive,
            Stage::Sense,
            Stage::Reward,
            Stage::Schedule,
            Stage::Weight,
        ];
        // What reads shared variables is known to actuations alone.
        let reads_shared = self.environment.sharing.reads(declaration);
        let tried = if reads_shared { &[Stage::Drive][..] } else { &anywhere };
        for stage in tried.iter().copied() {
            let mut cx = Context::new(stage, false);
            for parameter in parameters {
                let ty = self.type_named(&parameter.ty);
                self.bind_parameter(&parameter.name, ty, &mut cx);
            }
            self.open_functions.push(declaration);
            self.open.push(declaration);
            self.written.begin(Some(declaration));
            self.infer(value, &mut cx);
            self.open.pop();
            self.open_functions.pop();
            let found = std::mem::take(&mut self.errors);
            if fewest.as_ref().is_none_or(|f| found.len() < f.len()) {
                fewest = Some(found);
            }
        }
        self.tries_a_body = outside;
        self.errors = known;
        for error in fewest.unwrap_or_default().into_vec() {
            self.report(error);
        }
        // Whatever stage found it: the others no longer look.
        self.tell_too_large();
    }

    pub(super) fn function(
        &mut self,
        function: Function,
        arguments: &[ast::Argument],
        span: Span,
        cx: &mut Context,
    ) -> Expr {
        let unknown = Expr { kind: ExprKind::Bool(false), ty: Ty::Unknown, span };
        let (usage, arity) = signature::usage(function);
        if !cx.stage.sees_function(function) {
            self.report(
                Diagnostic::new(
                    Code::WRONG_STAGE,
                    span,
                    format!("`{}` cannot be called in {}", function.text(), cx.stage.name()),
                )
                .label("not known here"),
            );
            return unknown;
        }
        if !arity.contains(&arguments.len()) || arguments.iter().any(|a| a.name.is_some()) {
            let message = format!("wrong arguments: `{}` is called as `{usage}`", function.text());
            let help = unnamed(usage, arguments).or_else(|| self.decimal_comma(arguments));
            self.report(
                Diagnostic::new(Code::WRONG_ARGUMENTS, span, message)
                    .label(given(arguments))
                    .help(help.unwrap_or_else(|| function.doc().to_owned())),
            );
            return unknown;
        }
        let known = self.errors.len();
        let what = |i: usize| {
            let place =
                if arity == (1..=1) { "the argument".to_owned() } else { format!("argument {}", i + 1) };
            format!("{place} of `{}`", function.text())
        };
        let fixed = parameters(function);
        let mut checked: Vec<Expr> = Vec::new();
        for (i, argument) in arguments.iter().enumerate() {
            checked.push(match fixed.get(i) {
                Some(ty) => self.expect(&argument.value, cx, ty, &what(i)),
                None => self.infer(&argument.value, cx),
            });
        }
        let checked = self.fitted(function, checked, known, cx);
        let tys: Vec<Ty> = checked.iter().map(|e| e.ty.clone()).collect();
        if tys.contains(&Ty::Unknown) {
            return unknown;
        }
        let Some(ty) = result(function, &tys) else {
            let have = tys.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            let help = if tys.iter().any(|t| matches!(t, Ty::Track(_))) {
                "ask for it at a time: `e.position at end`".to_owned()
            } else {
                format!("call it as `{usage}`: {}", function.doc())
            };
            let message = format!("`{}` cannot take ({have})", function.text());
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, span, message).label("wrong kind of argument").help(help),
            );
            return unknown;
        };
        if function == Function::Clamp {
            self.ends_in_order(&checked);
        }
        Expr { kind: ExprKind::Call(function, checked), ty, span }
    }

    /// `clamp` takes the lower end first: the other way round it always gives the same.
    fn ends_in_order(&mut self, arguments: &[Expr]) {
        let [_, low, high] = arguments else { return };
        let (Some(least), Some(most)) = (self.quiet_number(low), self.quiet_number(high)) else { return };
        if least > most {
            self.report(
                Diagnostic::new(Code::BAD_VALUE, low.span, "the ends of `clamp` are the wrong way round")
                    .label(format!(
                        "above the other end: {} > {}",
                        super::shown(least, &low.ty),
                        super::shown(most, &high.ty)
                    ))
                    .also(high.span, "the other end")
                    .help("write the lower end first: `clamp(x, low, high)`"),
            );
        }
    }

    /// Arguments as a function takes them; `known` errors were there before them.
    fn fitted(
        &mut self,
        function: Function,
        mut checked: Vec<Expr>,
        known: usize,
        cx: &Context,
    ) -> Vec<Expr> {
        use Function as F;
        if matches!(function, F::Min | F::Max | F::Clamp | F::Normal | F::Uniform | F::Vector | F::Atan2) {
            // A literal 0 takes the dimension of its companions.
            let model =
                checked.iter().map(|e| e.ty.clone()).find(|t| matches!(t, Ty::Quantity(d) if !d.is_number()));
            let model = model.or_else(|| checked.iter().map(|e| e.ty.clone()).find(|t| *t == Ty::NUMBER));
            if let Some(model) = model {
                let what = format!("each argument of `{}`", function.text());
                checked = checked.into_iter().map(|e| self.fit(e, &model, &what)).collect();
            }
        }
        self.unit_of_others(known, &checked);
        if function == F::Design(DesignFunction::Region) {
            let whole = Ty::Domain(Box::new(Ty::Count));
            for offset in checked.iter_mut().skip(1) {
                let ty = if matches!(offset.ty, Ty::Domain(_)) { &whole } else { &Ty::Count };
                *offset = self.fit(offset.clone(), ty, "an offset of `region`");
            }
        }
        if function == F::Count {
            for counted in checked.iter_mut().filter(|e| !matches!(e.ty, Ty::List(_) | Ty::Unknown)) {
                let kind = self.fit(counted.clone(), &Ty::Group, "what is counted");
                let here = kind.ty != Ty::Group || cx.stage.sees_design();
                *counted = if here { kind } else { self.parts_unknown(kind.span, cx.stage) };
            }
        }
        checked
    }
}

/// The types of the first arguments that a function takes whatever the others are.
fn parameters(function: Function) -> Vec<Ty> {
    use Function as F;
    match function {
        F::Floor | F::Ceil | F::Round | F::Fraction | F::Exp | F::Ln | F::Asin | F::Acos => vec![Ty::NUMBER],
        F::Sin | F::Cos | F::Tan => vec![Ty::Quantity(Dimension::ANGLE)],
        F::Angle => vec![Ty::Rotation, Ty::Rotation],
        F::Heading | F::Inclination | F::Inverse => vec![Ty::Rotation],
        F::Wrap => vec![Ty::Quantity(Dimension::ANGLE)],
        F::Cycle => vec![
            Ty::Quantity(Dimension::TIME),
            Ty::List(Box::new(Ty::NUMBER)),
            Ty::List(Box::new(Ty::Valve)),
            Ty::NUMBER,
        ],
        F::Gain => vec![Ty::Count],
        F::Design(DesignFunction::Neighbours | DesignFunction::Images | DesignFunction::HangingOn) => {
            vec![Ty::Part]
        }
        F::Solid(solid) => vec![Ty::Quantity(Dimension::LENGTH); solid.lengths()],
        F::Design(DesignFunction::Cell) => vec![Ty::Count; 3],
        F::Design(DesignFunction::Region) => vec![Ty::Cell],
        _ => Vec::new(),
    }
}

/// The type of a call with arguments of these types; `None` if it cannot take them.
fn result(function: Function, tys: &[Ty]) -> Option<Ty> {
    use Function as F;
    let first = tys.first().cloned().unwrap_or(Ty::Unknown);
    match function {
        F::Abs | F::Min | F::Max | F::Clamp => first.dimension().map(|_| first.clone()),
        F::Floor | F::Ceil | F::Round | F::Count => Some(Ty::Count),
        F::Fraction | F::Exp | F::Ln | F::Sin | F::Cos | F::Tan | F::Gain => Some(Ty::NUMBER),
        F::Sqrt => first.dimension().and_then(Dimension::root).map(Ty::Quantity),
        F::Arc => match (first.dimension(), tys.get(1).and_then(Ty::dimension)) {
            (Some(radius), Some(Dimension::ANGLE)) => Some(Ty::Quantity(radius)),
            _ => None,
        },
        F::Length | F::Horizontal | F::Height => match &first {
            Ty::Vector(d) => Some(Ty::Quantity(*d)),
            _ => None,
        },
        F::Angle | F::Heading | F::Inclination | F::Wrap | F::Asin | F::Acos => {
            Some(Ty::Quantity(Dimension::ANGLE))
        }
        F::Atan2 => match (first.dimension(), tys.get(1).and_then(Ty::dimension)) {
            (Some(y), Some(x)) if y == x => Some(Ty::Quantity(Dimension::ANGLE)),
            _ => None,
        },
        F::Bearing => match &first {
            Ty::Vector(_) => Some(Ty::Quantity(Dimension::ANGLE)),
            _ => None,
        },
        F::Vector => first.dimension().map(Ty::Vector),
        F::Rotated => match (&first, tys.get(1)) {
            (Ty::Vector(_), Some(Ty::Rotation)) => Some(first.clone()),
            _ => None,
        },
        F::Inverse => Some(Ty::Rotation),
        F::Each => match (&first, tys.get(1)) {
            (Ty::List(_), Some(Ty::Count)) => Some(first.clone()),
            _ => None,
        },
        F::Repeat => (tys.get(1) == Some(&Ty::Count)).then(|| Ty::List(Box::new(first.clone()))),
        F::First | F::Last => match &first {
            Ty::List(item) => Some((**item).clone()),
            _ => None,
        },
        F::Bezier => match &first {
            Ty::List(item) => item.dimension().map(Ty::Curve),
            _ => None,
        },
        F::Cycle => Some(Ty::Valves),
        F::Solid(_) => Some(Ty::Shape),
        F::Normal | F::Uniform => first.dimension().map(Ty::Distribution),
        F::Design(DesignFunction::Neighbours) if first == Ty::Cell => Some(Ty::List(Box::new(Ty::Cell))),
        F::Design(DesignFunction::Neighbours | DesignFunction::Images | DesignFunction::HangingOn) => {
            Some(Ty::List(Box::new(Ty::Part)))
        }
        F::Design(DesignFunction::Cell) => Some(Ty::Cell),
        F::Design(DesignFunction::Region) => Some(Ty::List(Box::new(Ty::Cell))),
    }
}

/// What helps where arguments have names, as in OpenSCAD and Python.
fn unnamed(usage: &str, arguments: &[ast::Argument]) -> Option<String> {
    let mut names = arguments.iter().filter_map(|argument| argument.name.as_ref()).peekable();
    names.peek()?;
    let half = usage.contains("radius") && names.any(|name| ["d", "diameter"].contains(&name.text.as_str()));
    let half = if half { "; the radius is half of the diameter" } else { "" };
    Some(format!("write the values without names, in this order: `{usage}`{half}"))
}
