//! The page of a study: which factor matters and by how much, drawn.

use super::effects::{Effect, Estimate, of_cell};
use super::shell_word;
use super::standing::Standing;
use super::tables::{Gathered, ends};
use crate::markup::escape;
use crate::results::report::page::Document;
use crate::results::report::page::chart::{Chart, Scale, hint, line};
use crate::results::report::page::words::{
    counted, figures, key, number, or_dash, paragraph, percent, table, value,
};

/// A single chart must not fill the whole width.
const STYLE: &str = "figure { max-width: 560px; }\n";
/// The height of a row of a chart.
const ROW: f64 = 34.0;
/// Most cells and failed runs that the page lists; the tables have all.
const LISTED: usize = 200;

/// The whole page.
#[must_use]
pub(super) fn page(gathered: &Gathered<'_>) -> String {
    let study = gathered.study;
    let name = study.path().file_name().unwrap_or_default().to_string_lossy();
    let title = escape(&name);
    let sections = [
        ("matters", "What matters", matters(gathered)),
        ("levels", "Levels", levels(gathered)),
        ("cells", "Cells", cells(gathered)),
        ("runs", "Progress of the runs", runs(gathered)),
    ];
    let there = || sections.iter().filter(|(_, _, body)| !body.is_empty());
    let ways: String = there().map(|(id, heading, _)| format!("<a href=\"#{id}\">{heading}</a>")).collect();
    let main: String = there()
        .map(|(id, heading, body)| format!("<section id=\"{id}\">\n<h2>{heading}</h2>\n{body}</section>\n"))
        .collect();
    let question = match study.question() {
        "" => String::new(),
        question => format!("<p>{}</p>\n", escape(question)),
    };
    let open = gathered.outcomes.iter().filter(|one| one.standing != Standing::Complete).count();
    let note = match open {
        0 => String::new(),
        open => format!(
            "<p class=\"note\">{open} of {} are not complete: the page shows their results so far.</p>\n",
            counted(gathered.outcomes.len() as u64, "run")
        ),
    };
    let header = format!("<h1>{title}</h1>\n{question}{note}<nav>{ways}</nav>");
    Document { title: &title, kind: "study", refresh: "", style: STYLE, header: &header, main: &main }.html()
}

/// A mean with its margin.
fn with_margin(estimate: &Estimate, unit: &str) -> String {
    match estimate.margin {
        Some(margin) => format!("{}\u{a0}±\u{a0}{}", number(estimate.mean), value(margin, unit)),
        None => value(estimate.mean, unit),
    }
}

fn matters(gathered: &Gathered<'_>) -> String {
    let unit = gathered.unit();
    let mut said = vec![format!("Compared is {}.", gathered.by.text())];
    let Some(effects) = &gathered.effects else {
        said.push("Too few runs are complete to compare anything.".to_owned());
        return paragraph(&said);
    };
    if effects.factors.is_empty() {
        said.push("Only the seed is varied.".to_owned());
    }
    for effect in &effects.factors {
        said.push(sentence(gathered, effect));
    }
    if gathered.study.seeds().len() > 1 {
        said.push(format!(
            "Runs that differ only in the seed account for {} of the spread, and interactions of factors for {}.",
            escape(&percent(effects.seeds)),
            escape(&percent(effects.together))
        ));
    }
    let rows: Vec<Vec<String>> = effects
        .factors
        .iter()
        .map(|effect| {
            let widest = effect.widest.as_ref().filter(|widest| !widest.2.is_nothing());
            let named = |place: usize| escape(level(gathered, effect, place));
            vec![
                escape(name(gathered, effect)),
                escape(&percent(effect.share)),
                or_dash(widest.map(|widest| named(widest.0))),
                or_dash(widest.map(|widest| named(widest.1))),
                or_dash(effect.widest.as_ref().map(|widest| with_margin(&widest.2, unit))),
            ]
        })
        .collect();
    let head = ["factor", "#share of the spread", "highest", "lowest", "#difference (95 % interval)"];
    let table = if rows.is_empty() { String::new() } else { table(&head, &rows) };
    let note = match gathered.study.seeds().len() {
        1 => "There is only one seed, so it is unknown how much of these numbers is chance.",
        _ => {
            "Runs with the same seed begin with the same random numbers, so the seeds are the samples: sgc takes the differences between runs that differ in \
             nothing else, seed by seed, and the interval is that of Student's t over the seeds. Of more than two values it is widened for all pairs \
             (Bonferroni). The shares include chance. Of twenty factors without an effect, one will seem to have an effect."
        }
    };
    let over = match effects.over < gathered.study.seeds().len() {
        true => format!(
            " Means of levels and shares are over the {} that every cell has.",
            counted(effects.over as u64, "seed")
        ),
        false => String::new(),
    };
    let few = match gathered.study.seeds().len() {
        2..5 => {
            " With fewer than five seeds take the intervals as a hint: values of searches are often skewed."
        }
        _ => "",
    };
    paragraph(&said) + &table + &format!("<p class=\"small\">{note}{over}{few}</p>\n")
}

fn name<'a>(gathered: &'a Gathered<'_>, effect: &Effect) -> &'a str {
    gathered.study.factors().get(effect.factor).map_or("", String::as_str)
}

fn level<'a>(gathered: &'a Gathered<'_>, effect: &Effect, place: usize) -> &'a str {
    gathered.levels.get(effect.factor).and_then(|levels| levels.get(place)).map_or("", String::as_str)
}

/// What a factor does, in words.
fn sentence(gathered: &Gathered<'_>, effect: &Effect) -> String {
    let name = escape(name(gathered, effect));
    let Some((high, low, apart)) = &effect.widest else {
        return format!("<b>{name}</b>: no two complete runs differ in it alone.");
    };
    let [high, low] = [*high, *low].map(|place| escape(level(gathered, effect, place)));
    if apart.is_nothing() {
        format!("<b>{name}</b> changed no run that was compared.")
    } else if apart.is_apart_from_zero() {
        format!(
            "<b>{name}</b> makes a difference: {high} is {} above {low}.",
            with_margin(apart, gathered.unit())
        )
    } else if apart.margin.is_some() {
        format!(
            "<b>{name}</b>: these runs are too few to tell a difference from chance ({high} is {} above {low}).",
            with_margin(apart, gathered.unit())
        )
    } else {
        format!(
            "<b>{name}</b>: {high} is {} above {low}; how much of that is chance is not known.",
            value(apart.mean, gathered.unit())
        )
    }
}

fn levels(gathered: &Gathered<'_>) -> String {
    let Some(effects) = gathered.effects.as_ref().filter(|effects| !effects.factors.is_empty()) else {
        return String::new();
    };
    let marks = [("point soft", "a run"), ("line ink", "mean of a level, with its 95 % interval")];
    let marks = marks.map(|(class, text)| (class.to_owned(), text.to_owned()));
    let charts: Vec<String> = effects.factors.iter().map(|effect| chart(gathered, effect)).collect();
    key(&marks) + &figures(&charts)
}

fn chart(gathered: &Gathered<'_>, effect: &Effect) -> String {
    let unit = gathered.unit();
    let names = gathered.levels.get(effect.factor).cloned().unwrap_or_default();
    let all = || gathered.values.iter().flat_map(|cell| cell.values());
    let of_interval = |estimate: &Estimate| {
        let margin = estimate.margin.unwrap_or(0.0);
        [estimate.mean - margin, estimate.mean + margin]
    };
    let intervals = effect.levels.iter().flatten().flat_map(of_interval);
    let x = Scale::of(all().chain(intervals).chain([0.0]), 5);
    let label = if unit.is_empty() { "value".to_owned() } else { format!("value ({unit})") };
    let mut chart = Chart::rows(name(gathered, effect), &names, ROW, (x, &label));
    for (place, estimate) in effect.levels.iter().enumerate() {
        let own = gathered.values.iter().filter(|cell| cell.levels.get(effect.factor) == Some(&place));
        let y = chart.y(place as f64 + 0.5);
        for one in own.flat_map(|cell| cell.values()) {
            let told = hint(&value(one, unit));
            let at = chart.x(one);
            chart.add(&format!(
                "<circle class=\"cell g0\" cx=\"{at:.1}\" cy=\"{y:.1}\" r=\"3.2\">{told}</circle>"
            ));
        }
        let Some(estimate) = estimate else { continue };
        let [from, to] = of_interval(estimate).map(|end| chart.x(end));
        let at = chart.x(estimate.mean);
        chart.add(&line((from, y + 9.0), (to, y + 9.0), "line ink"));
        let told = hint(&with_margin(estimate, unit));
        let y = y + 9.0;
        chart.add(&format!(
            "<circle class=\"dot ink\" cx=\"{at:.1}\" cy=\"{y:.1}\" r=\"3.4\">{told}</circle>"
        ));
    }
    chart.finish(&format!("value by {}", name(gathered, effect)))
}

fn cells(gathered: &Gathered<'_>) -> String {
    let (study, unit) = (gathered.study, gathered.unit());
    let own = ["#runs with a value", "#mean (95 % interval)", "#least", "#greatest"];
    let varied: Vec<usize> = (0..study.factors().len()).filter(|f| gathered.levels[*f].len() > 1).collect();
    let head: Vec<&str> = varied.iter().map(|factor| study.factors()[*factor].as_str()).chain(own).collect();
    let sign = if gathered.minimizes() { -1.0 } else { 1.0 };
    let mut rows: Vec<(f64, Vec<String>)> = study
        .cells()
        .iter()
        .zip(&gathered.values)
        .map(|(cell, own)| {
            let estimate = of_cell(own);
            let [least, greatest] = ends(own).map(|end| or_dash(end.map(|end| value(end, unit))));
            let levels = varied.iter().map(|factor| escape(&cell.levels[*factor]));
            let numbers = [
                format!("{} of {}", own.values().count(), study.seeds().len()),
                or_dash(estimate.map(|estimate| with_margin(&estimate, unit))),
                least,
                greatest,
            ];
            let order = estimate.map_or(f64::NEG_INFINITY, |estimate| sign * estimate.mean);
            (order, levels.chain(numbers).collect())
        })
        .collect();
    // The best first.
    rows.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = rows.len().saturating_sub(LISTED);
    rows.truncate(LISTED);
    let rows: Vec<Vec<String>> = rows.into_iter().map(|(_, row)| row).collect();
    let mut said = Vec::new();
    if let Some((best, number)) = gathered.best() {
        said.push(format!(
            "The best of all runs is <code>{}</code>: {}. To look at it: <code>sgc view {}</code>.",
            escape(&study.name(best.run)),
            value(number, unit),
            escape(&shell_word(&study.folder(best.run)))
        ));
    }
    if more > 0 {
        said.push(format!("The table shows the best {LISTED} cells; {more} more are in cells.csv."));
    }
    paragraph(&said) + &table(&head, &rows)
}

fn runs(gathered: &Gathered<'_>) -> String {
    let counts = Standing::ALL.map(|standing| {
        let many = gathered.outcomes.iter().filter(|one| one.standing == standing).count();
        (standing, many)
    });
    let rows: Vec<Vec<String>> = counts
        .iter()
        .filter(|(_, many)| *many > 0)
        .map(|(standing, many)| vec![standing.text().to_owned(), many.to_string()])
        .collect();
    let without = gathered.outcomes.iter().filter(|one| {
        one.standing == Standing::Complete
            && one.finished.as_ref().is_some_and(|finished| finished.value.is_none())
    });
    let mut said = Vec::new();
    match without.count() {
        0 => {}
        many => said.push(format!(
            "{} found no robot, and the means leave these runs out.",
            counted(many as u64, "complete run")
        )),
    }
    let failed: Vec<Vec<String>> = gathered
        .outcomes
        .iter()
        .filter(|one| one.standing == Standing::Failed)
        .take(LISTED)
        .map(|one| {
            let why = one.problem.as_deref().unwrap_or_default();
            vec![format!("<code>{}</code>", escape(&gathered.study.name(one.run))), escape(why)]
        })
        .collect();
    let failures = match failed.is_empty() {
        true => String::new(),
        false => table(&["failed run", "why"], &failed),
    };
    table(&["runs", "#number"], &rows) + &paragraph(&said) + &failures
}
