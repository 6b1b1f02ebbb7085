//! Aggregates: over the items of collections, in any number of worlds.

use super::{EvalError, Evaluation, MOST, OPERATIONS, Reference, Result_, Value, fail, missing};
use crate::ir::{Binder, Expr, ExprKind, Gather, Ty, Word};

impl Evaluation<'_> {
    pub(super) fn aggregate(&mut self, expr: &Expr) -> Result_ {
        let ExprKind::Aggregate { how, share, binders, condition, otherwise, .. } = &expr.kind else {
            return Err(missing(expr));
        };
        if *how == Gather::Clusters {
            return self.clusters(expr);
        }
        let depth = self.locals.len();
        let mut gathered = Gathered {
            count: 0,
            sum: 0.0,
            vector: [0.0; 3],
            least: f64::INFINITY,
            greatest: f64::NEG_INFINITY,
            values: Vec::new(),
            all: true,
            any: false,
            sizes: vec![0; binders.len()],
        };
        let mut ran = self.gather(expr, binders, condition.as_deref(), &mut gathered);
        if ran.is_ok() && gathered.count == 0 && self.stands_for_all(expr) {
            ran = self.gather(expr, binders, None, &mut gathered);
        }
        self.locals.truncate(depth);
        if ran.is_err() && self.left == 0 {
            self.sizes.splice(..0, gathered.sizes);
            return Err(self.spent(expr));
        }
        ran?;
        let nothing = gathered.count == 0;
        Ok(match how {
            Gather::Count | Gather::Clusters => Value::Number(gathered.count as f64),
            Gather::Sum if is_vector(expr) => Value::Vector(gathered.vector),
            Gather::Sum => Value::Number(gathered.sum),
            Gather::Forall => Value::Bool(gathered.all),
            Gather::Exists => Value::Bool(gathered.any),
            _ if nothing => match otherwise {
                Some(value) => self.value(value)?,
                None => {
                    return fail(
                        expr,
                        "there are no values to combine here; give a value for this case with `otherwise`",
                    );
                }
            },
            Gather::Mean if is_vector(expr) => {
                Value::Vector(gathered.vector.map(|x| x / gathered.count as f64))
            }
            Gather::Mean => Value::Number(gathered.sum / gathered.count as f64),
            Gather::Min => Value::Number(gathered.least),
            Gather::Max => Value::Number(gathered.greatest),
            Gather::Deviation => Value::Number(deviation(&gathered.values)),
            Gather::Quantile => {
                let share = share.as_ref().ok_or_else(|| missing(expr))?;
                let place = self.number(share)?;
                if !(0.0..=1.0).contains(&place) {
                    return fail(
                        share,
                        format!("the share of a quantile is {place}: it must lie within 0 .. 1"),
                    );
                }
                Value::Number(quantile(&mut gathered.values, place))
            }
        })
    }

    /// Whether the condition of an aggregate over worlds is left out where nothing meets it, as there is but one: a motion that is judged
    /// alone stands for all worlds, also for those that a condition picks. A condition on the motion itself decides, unless
    /// there would be no value.
    fn stands_for_all(&self, expr: &Expr) -> bool {
        let ExprKind::Aggregate { how, binders, condition: Some(condition), otherwise, .. } = &expr.kind
        else {
            return false;
        };
        let [binder] = binders.as_slice() else { return false };
        let has_value_of_nothing = otherwise.is_some()
            || matches!(
                how,
                Gather::Count | Gather::Sum | Gather::Forall | Gather::Exists | Gather::Clusters
            );
        let mut reads_motion = |e: &Expr| {
            matches!(
                e.kind,
                ExprKind::Term(_)
                    | ExprKind::At(..)
                    | ExprKind::Word(Word::Motion(_))
                    | ExprKind::Shared(..)
                    | ExprKind::Placed(_)
                    | ExprKind::Group(_)
                    | ExprKind::Aggregate { .. }
            )
        };
        matches!(binder.over.kind, ExprKind::Scenarios(_))
            && self.scope.worlds() == Some(1)
            && !(has_value_of_nothing && condition.any(&mut reads_motion))
    }

    fn clusters(&mut self, expr: &Expr) -> Result_ {
        let ExprKind::Aggregate { binders, condition, body, .. } = &expr.kind else {
            return Err(missing(expr));
        };
        let Some(binder) = binders.first() else { return Err(missing(expr)) };
        let depth = self.locals.len();
        let mut cells = Vec::new();
        for cell in self.value(&binder.over)?.items() {
            self.put(binder.slot, cell.clone());
            if let Some(condition) = condition
                && !self.bool(condition)?
            {
                continue;
            }
            let value = match body {
                Some(body) => self.value(body)?,
                None => Value::Bool(true),
            };
            cells.push((cell.clone(), value));
        }
        self.locals.truncate(depth);
        let count = self.scope.clusters(&cells).ok_or_else(|| missing(expr))?;
        Ok(Value::Number(count as f64))
    }

    fn gather(
        &mut self,
        expr: &Expr,
        binders: &[Binder],
        condition: Option<&Expr>,
        into: &mut Gathered,
    ) -> Result<(), EvalError> {
        let Some((binder, rest)) = binders.split_first() else {
            let ExprKind::Aggregate { how, body, .. } = &expr.kind else { return Err(missing(expr)) };
            self.spend(expr, OPERATIONS)?;
            if let Some(condition) = condition
                && !self.bool(condition)?
            {
                return Ok(());
            }
            into.count += 1;
            match (how, body) {
                (Gather::Count, _) | (_, None) => {}
                (Gather::Forall | Gather::Exists, Some(body)) => {
                    let holds = self.bool(body)?;
                    into.all &= holds;
                    into.any |= holds;
                }
                (Gather::Sum | Gather::Mean, Some(body)) if is_vector(expr) => {
                    let Value::Vector(vector) = self.value(body)? else { return Err(missing(body)) };
                    into.vector.iter_mut().zip(vector).for_each(|(sum, x)| *sum += x);
                }
                (how, Some(body)) => into.take(*how, self.number(body)?),
            }
            return Ok(());
        };
        let items = self.value(&binder.over)?;
        let items: Vec<Value> = match &items {
            Value::Domain(domain) if domain.count() > MOST => {
                return fail(&binder.over, format!("this runs over more than {MOST} values"));
            }
            Value::Domain(domain) => domain.items().collect(),
            list => list.items().to_vec(),
        };
        let outer = into.sizes.len() - binders.len();
        if let Some(size) = into.sizes.get_mut(outer) {
            *size = items.len();
        }
        for item in items {
            let world = if let Value::Reference(Reference::World(place)) = item { Some(place) } else { None };
            self.put(binder.slot, item);
            match world {
                None => self.gather(expr, rest, condition, into)?,
                // All that follows is asked of the motion in that world.
                Some(place) => {
                    let here = self.scope;
                    self.scope = here.world(place).ok_or_else(|| missing(&binder.over))?;
                    let ran = self.gather(expr, rest, condition, into);
                    self.scope = here;
                    ran?;
                }
            }
        }
        Ok(())
    }
}

struct Gathered {
    count: usize,
    sum: f64,
    /// The sum of vectors.
    vector: [f64; 3],
    least: f64,
    greatest: f64,
    /// One by one, where it matters how they are spread.
    values: Vec<f64>,
    all: bool,
    any: bool,
    /// Over how many values each binder ran last.
    sizes: Vec<usize>,
}

impl Gathered {
    fn take(&mut self, how: Gather, x: f64) {
        self.sum += x;
        self.least = self.least.min(x);
        self.greatest = self.greatest.max(x);
        if matches!(how, Gather::Deviation | Gather::Quantile) {
            self.values.push(x);
        }
    }
}

/// Whether vectors are gathered.
fn is_vector(expr: &Expr) -> bool {
    matches!(expr.ty, Ty::Vector(_))
}

/// The standard deviation of values that are all there are.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    libm::sqrt(values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / count)
}

/// What a share of values lies below: between two of them in proportion. There is at least one; afterwards they
/// are sorted.
#[must_use]
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = share * (values.len() - 1) as f64;
    let below = libm::floor(place) as usize;
    let low = values[below];
    values.get(below + 1).map_or(low, |next| low + (next - low) * (place - below as f64))
}
