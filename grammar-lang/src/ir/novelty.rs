//! Sets of known designs: how novel another one is, follows from what it shares with them.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::text::{Names, Writer};
use super::{Expr, Ty};
use crate::source::Span;
use crate::units;

/// A set of known designs with the features that are compared (thesis 6.3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Novelty {
    /// What is compared.
    pub features: IndexMap<String, Feature>,
    /// The known designs by name: a value for each feature, in SI units; a Bool is 0 or 1, a value of an
    /// enumeration its place.
    pub known: IndexMap<String, Vec<f64>>,
    /// Where it is declared.
    pub span: Span,
}

/// What designs are compared by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Feature {
    /// A quantity, a Count, a Bool or an enumeration.
    pub ty: Ty,
    /// What it is for a design: an expression of the score stage.
    pub value: Expr,
    /// How much it counts.
    pub weight: f64,
}

impl Writer<'_> {
    pub(super) fn novelty(&mut self, name: &str, novelty: &Novelty) {
        let rules = self.rules;
        self.line(0, format!("novelty {name} {{"));
        for (name, Feature { value, weight, .. }) in &novelty.features {
            let value = self.expr(value, &Names::new());
            self.line(1, format!("feature {name} = {value} weight {weight}"));
        }
        for (name, values) in &novelty.known {
            let fields = novelty.features.iter().zip(values);
            let fields: Vec<String> = fields
                .map(|((name, feature), value)| match &feature.ty {
                    Ty::Enum(of) => format!("{name} = {}", rules.value_of(of, *value).unwrap_or("?")),
                    Ty::Bool => format!("{name} = {}", *value != 0.0),
                    ty => {
                        format!("{name} = {}", units::shown(*value, ty.dimension().unwrap_or_default()))
                    }
                })
                .collect();
            self.line(1, format!("known {name:?} {{ {} }}", fields.join("  ")));
        }
        self.line(0, "}");
    }
}
