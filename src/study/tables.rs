//! The tables of a study: its runs, its cells and what its factors do.

use csv::WriterBuilder;

use super::effects::{CellValues, Effects, Estimate, effects, of_cell};
use super::folder::Study;
use super::outcome::{By, Outcome, compared_by};

/// All that is known of a study, put together.
pub struct Gathered<'a> {
    /// The study.
    pub study: &'a Study,
    /// What its runs came to, in their order.
    pub outcomes: &'a [Outcome],
    /// The number that is compared.
    pub by: By,
    /// The levels of each factor, in the order of the file.
    pub levels: Vec<Vec<String>>,
    /// The numbers of each cell.
    pub values: Vec<CellValues>,
    /// What the factors do, as far as there is something to compare.
    pub effects: Option<Effects>,
}

impl<'a> Gathered<'a> {
    /// Puts it together.
    #[must_use]
    pub fn new(study: &'a Study, outcomes: &'a [Outcome]) -> Self {
        let by = compared_by(outcomes);
        let mut levels: Vec<Vec<String>> = vec![Vec::new(); study.factors().len()];
        let mut values: Vec<CellValues> = Vec::with_capacity(study.cells().len());
        for cell in study.cells() {
            let places = cell.levels.iter().zip(&mut levels).map(|(level, known)| {
                known.iter().position(|one| one == level).unwrap_or_else(|| {
                    known.push(level.clone());
                    known.len() - 1
                })
            });
            let by_seed = vec![None; study.seeds().len()];
            values.push(CellValues { levels: places.collect(), by_seed });
        }
        for outcome in outcomes {
            let seed = study.seeds().iter().position(|seed| *seed == outcome.run.seed);
            let place = values
                .get_mut(outcome.run.cell)
                .zip(seed)
                .and_then(|(cell, seed)| cell.by_seed.get_mut(seed));
            if let Some(place) = place {
                *place = outcome.number(by);
            }
        }
        let counts: Vec<usize> = levels.iter().map(Vec::len).collect();
        let effects = effects(&counts, &values);
        Self { study, outcomes, by, levels, values, effects }
    }

    /// The unit of the numbers.
    #[must_use]
    pub fn unit(&self) -> &str {
        self.study.cells().first().map_or("", |cell| &cell.unit)
    }

    /// Whether a lower number is better.
    #[must_use]
    pub fn minimizes(&self) -> bool {
        self.study.cells().first().is_some_and(|cell| cell.minimizes)
    }

    /// The run with the best number.
    #[must_use]
    pub fn best(&self) -> Option<(&Outcome, f64)> {
        let sign = if self.minimizes() { -1.0 } else { 1.0 };
        let numbers = self.outcomes.iter().filter_map(|one| Some((one, one.number(self.by)?)));
        // Of several, the first.
        numbers.reduce(|best, one| if sign * one.1 > sign * best.1 { one } else { best })
    }

    /// A row for each run.
    #[must_use]
    pub fn runs(&self) -> String {
        let factors = self.study.factors().iter().map(String::as_str);
        let own = [
            "seed",
            "standing",
            "value",
            "unit",
            "nine_of_ten",
            "over_worlds",
            "checks_kept",
            "checks",
            "motions",
            "end",
        ];
        let rows = self.outcomes.iter().map(|one| {
            let cell = self.study.cell(one.run);
            let finished = one.finished.as_ref();
            let number = |of: Option<f64>| of.map(|value| value.to_string());
            let checks = finished.and_then(|finished| finished.checks);
            let cells = [
                Some(one.run.seed.to_string()),
                Some(one.standing.text().to_owned()),
                number(finished.and_then(|finished| finished.value)),
                Some(cell.unit.clone()),
                number(finished.and_then(|finished| finished.nine_of_ten)),
                number(finished.and_then(|finished| finished.over_worlds)),
                checks.map(|(kept, _)| kept.to_string()),
                checks.map(|(_, all)| all.to_string()),
                finished.map(|finished| finished.evaluations.to_string()),
                finished.map(|finished| finished.end.clone()),
            ];
            let name = self.study.name(one.run);
            let cells = cells.into_iter().map(Option::unwrap_or_default);
            std::iter::once(name).chain(cell.levels.iter().cloned()).chain(cells).collect()
        });
        table(std::iter::once("run").chain(factors).chain(own), rows)
    }

    /// A row for each cell.
    #[must_use]
    pub fn cells(&self) -> String {
        let factors = self.study.factors().iter().map(String::as_str);
        let own = ["runs", "with_value", "mean", "margin", "least", "greatest", "unit"];
        let rows = self.study.cells().iter().zip(&self.values).map(|(cell, own)| {
            let estimate = of_cell(own);
            let [least, greatest] = ends(own);
            let cells = [
                Some(self.study.seeds().len().to_string()),
                Some(own.values().count().to_string()),
                estimate.map(|estimate| estimate.mean.to_string()),
                estimate.and_then(|estimate| estimate.margin).map(|margin| margin.to_string()),
                least.map(|value| value.to_string()),
                greatest.map(|value| value.to_string()),
                Some(cell.unit.clone()),
            ];
            cell.levels.iter().cloned().chain(cells.into_iter().map(Option::unwrap_or_default)).collect()
        });
        table(factors.chain(own), rows)
    }

    /// A row for each level of each factor.
    #[must_use]
    pub fn effects(&self) -> String {
        let head = [
            "factor",
            "share",
            "level",
            "mean",
            "margin",
            "highest",
            "lowest",
            "difference",
            "difference_margin",
        ];
        let found = self.effects.iter().flat_map(|effects| &effects.factors);
        let rows = found.flat_map(|effect| {
            let factor = self.study.factors().get(effect.factor).cloned().unwrap_or_default();
            let names = self.levels.get(effect.factor).into_iter().flatten();
            names.zip(&effect.levels).map(move |(level, estimate)| {
                let of = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
                let margin = |estimate: &Estimate| estimate.margin;
                let named = |place: Option<usize>| {
                    let names = self.levels.get(effect.factor);
                    place.and_then(|place| names?.get(place).cloned()).unwrap_or_default()
                };
                let widest = effect.widest.as_ref();
                vec![
                    factor.clone(),
                    effect.share.to_string(),
                    level.clone(),
                    of(estimate.map(|estimate| estimate.mean)),
                    of(estimate.as_ref().and_then(margin)),
                    named(widest.map(|widest| widest.0)),
                    named(widest.map(|widest| widest.1)),
                    of(widest.map(|widest| widest.2.mean)),
                    of(widest.and_then(|widest| margin(&widest.2))),
                ]
            })
        });
        let rest = self.effects.iter().flat_map(|effects| {
            [("(seeds)", effects.seeds), ("(together)", effects.together)].map(|(name, share)| {
                let mut row = vec![String::new(); head.len()];
                row[0] = name.to_owned();
                row[1] = share.to_string();
                row
            })
        });
        table(head.into_iter(), rows.chain(rest))
    }
}

/// The least and the greatest number of a cell.
pub(super) fn ends(cell: &CellValues) -> [Option<f64>; 2] {
    [cell.values().reduce(f64::min), cell.values().reduce(f64::max)]
}

/// A table as text.
fn table<'a>(head: impl Iterator<Item = &'a str>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = WriterBuilder::new().from_writer(Vec::new());
    // Writing into memory never fails, and all rows have as many cells.
    let _ = writer.write_record(head);
    for row in rows {
        let _ = writer.write_record(row);
    }
    writer.into_inner().ok().and_then(|bytes| String::from_utf8(bytes).ok()).unwrap_or_default()
}
