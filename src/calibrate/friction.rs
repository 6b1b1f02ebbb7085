//! Friction with the ground, from a board that is tilted or a balance that pulls.
//!
//! A bench measures the coefficient of a part on the ground. The simulation takes the geometric mean of the
//! two surfaces', so only their product is measured: the first part keeps its own, the ground gets what makes
//! the mean right, and other parts that were measured follow from that ground.

use grammar_lang::ir::{Model, RuleSet};
use indexmap::IndexMap;

use super::declared;
use super::finding::{Change, Figure, Finding, Plot, Residual};
use super::measurements::Section;
use super::problem::{Problem, listed};
use super::robust::Centre;

/// What was found of a part.
struct Slip {
    name: String,
    coefficients: Vec<f64>,
}

impl Slip {
    fn centre(&self, section: &Section) -> Centre {
        Centre::of(&self.coefficients, &format!("{} {}", section.name, self.name))
    }
}

/// Fits a section of kind `friction`: the ground, then each further part.
pub(super) fn fit(section: &Section, rules: &RuleSet) -> Result<Vec<Finding>, Vec<Problem>> {
    let parts = declared::parts(rules, section).map_err(|p| vec![p])?;
    let Some(model) = rules.first_task().map(|task| &task.model) else { return Ok(Vec::new()) };
    let mut slips: IndexMap<&str, Vec<f64>> = IndexMap::new();
    let mut problems = Vec::new();
    let coefficients = coefficients(section, model).map_err(|p| vec![p])?;
    for (row, (name, coefficient)) in parts.iter().zip(&coefficients).enumerate() {
        let said = section.setting("for").filter(|_| section.words("part").is_empty());
        let place = said.map_or_else(|| section.place(row), |(_, place)| place);
        match declared::part(rules, name, place) {
            Err(problem) if problems.contains(&problem) => {}
            Err(problem) => problems.push(problem),
            Ok(part) if part.friction().is_none() => problems.push(declared::varies(name, "friction", place)),
            Ok(part) if part.friction() <= Some(0.0) => problems.push(Problem::contradiction(
                place,
                format!("`{name}` has no friction in the grammar, so it has none on any ground: set `{name}.friction` first"),
            )),
            Ok(_) if !(*coefficient > 0.0 && *coefficient <= MOST) => problems.push(Problem::contradiction(
                section.place(row),
                "this gives no usable coefficient of friction: a tilt must lie between 0 and 89 deg, a force must be above 0, and the friction can be at most 100 times the weight",
            )),
            Ok(_) => slips.entry(name).or_default().push(*coefficient),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let slips: Vec<Slip> =
        slips.into_iter().map(|(name, coefficients)| Slip { name: name.to_owned(), coefficients }).collect();
    let Some((first, others)) = slips.split_first() else { return Ok(Vec::new()) };
    let friction = |name: &str| {
        let part = declared::part(rules, name, &section.place).map_err(|p| vec![p])?;
        part.friction().ok_or_else(|| vec![declared::varies(name, "friction", &section.place)])
    };
    let own = friction(&first.name)?;
    let mut findings = Vec::new();
    let mut ground = None;
    for model in models(rules) {
        let (finding, value) = on_ground(section, first, own, model);
        ground = Some(value);
        findings.push(finding);
    }
    for slip in others {
        let old = friction(&slip.name)?;
        findings.extend(ground.as_ref().map(|ground| on_part(section, slip, old, ground)));
    }
    Ok(findings)
}

/// A coefficient of friction is no more than this.
const MOST: f64 = 100.0;

/// The models of all tasks, each once.
fn models(rules: &RuleSet) -> Vec<&Model> {
    let mut models: Vec<&Model> = Vec::new();
    for task in rules.tasks.values() {
        if !models.iter().any(|model| model.name == task.model.name) {
            models.push(&task.model);
        }
    }
    models
}

/// The coefficient of each row.
fn coefficients(section: &Section, model: &Model) -> Result<Vec<f64>, Problem> {
    let [tilt, pull, weight, mass] = ["tilt", "pull", "weight", "mass"].map(|name| section.numbers(name));
    let twice = [
        (
            tilt,
            pull,
            "gives both `tilt` and `pull`, but each alone determines the friction: keep one of them, the same one for all rows",
        ),
        (weight, mass, "gives both `weight` and `mass`, but each alone is enough: keep one of them"),
    ];
    if let Some((.., what)) = twice.iter().find(|(one, other, _)| !one.is_empty() && !other.is_empty()) {
        return Err(Problem::contradiction(&section.place, format!("`{}` {what}", section.name)));
    }
    if !tilt.is_empty() {
        let slope =
            |tilt: &f64| if (0.0..89.0).contains(&tilt.to_degrees()) { libm::tan(*tilt) } else { f64::NAN };
        return Ok(tilt.iter().map(slope).collect());
    }
    let over = |weight: &[f64], unit: f64| pull.iter().zip(weight).map(|(p, w)| p / (w * unit)).collect();
    if !pull.is_empty() && !weight.is_empty() {
        return Ok(over(weight, 1.0));
    }
    if !pull.is_empty() && !mass.is_empty() {
        return Ok(over(mass, model.gravity));
    }
    Err(Problem::unreadable(
        &section.place,
        format!(
            "`{}` of kind `friction` needs `tilt [deg]`, or `pull [N]` with `weight [N]` or `mass [g]`; its columns are {}",
            section.name,
            listed(section.columns())
        ),
    ))
}

/// What the ground of a model is to be for the first part.
fn on_ground(section: &Section, slip: &Slip, own: f64, model: &Model) -> (Finding, Centre) {
    let centre = slip.centre(section);
    let coefficient = Figure::of(centre.value, centre.error(), "");
    let ground = centre.map(|slips| slips * slips / own);
    let path = format!("{}.ground_friction", model.name);
    let note = format!(
        "`{}` slips at {coefficient}; the friction of a contact is the geometric mean of the part's own {own} and the ground's, so the ground has {coefficient}^2 / {own}.",
        slip.name,
    );
    (finding(section, slip, path, model.ground_friction, &ground, note), ground)
}

/// What the surface of another part is to be on that ground.
fn on_part(section: &Section, slip: &Slip, old: f64, ground: &Centre) -> Finding {
    let centre = slip.centre(section);
    let value = centre.map(|slips| slips * slips).over(ground);
    let note = format!(
        "`{}` slips at {} on this ground; contacts with other parts change, too.",
        slip.name,
        Figure::of(centre.value, centre.error(), "")
    );
    finding(section, slip, format!("{}.friction", slip.name), old, &value, note)
}

fn finding(section: &Section, slip: &Slip, path: String, old: f64, value: &Centre, note: String) -> Finding {
    let mean = slip.centre(section).value;
    let many = slip.coefficients.len();
    let across = |i: usize| i as f64 + 1.0;
    let points = slip.coefficients.iter().enumerate();
    let plot = Plot {
        title: format!("Friction of `{}` on the ground", slip.name),
        x: "measurement".into(),
        y: "coefficient".into(),
        points: points.clone().map(|(i, c)| (across(i), *c, 0)).collect(),
        fit: vec![(vec![(1.0, mean), (many as f64, mean)], 0)],
        rows: Vec::new(),
        unit: String::new(),
        residuals: points.map(|(i, c)| (across(i), c - mean, 0)).collect(),
    };
    let residuals: Vec<f64> = slip.coefficients.iter().map(|c| c - mean).collect();
    Finding {
        section: section.name.clone(),
        place: section.place.clone(),
        source: section.source.clone(),
        quantity: path.clone(),
        old: Some(format!("{old}")),
        change: Change::Number { path, value: Figure::of(value.value, value.error(), "") },
        interval: value.figures(""),
        factor: (old > 0.0).then(|| value.value / old),
        residual: Residual::of(&residuals, "").filter(|_| many > 1),
        points: many,
        notes: vec![note],
        warnings: value.warnings(&section.name, "measurement", |i| {
            let coefficient = slip.coefficients.get(i).copied().unwrap_or(0.0);
            format!("a coefficient of {}", Figure::of(coefficient, None, ""))
        }),
        plots: if many > 1 { vec![plot] } else { Vec::new() },
    }
}
