//! A page for people: what was measured, drawn, with what is left between points and fit. No script is in it,
//! and nothing is loaded.

use super::finding::{Change, Finding, Plot};
use crate::markup::escape;
use crate::results::report::page::Document;
use crate::results::report::page::chart::{Chart, Scale, line};
use crate::results::report::page::words::{counted, table};

const OWN_STYLE: &str = include_str!("page.css");
/// How many colours the style has for runs.
const COLOURS: usize = 6;
/// The height of a chart of residuals is less than that of a plot.
const LOW: (f64, f64) = (Chart::HALF.0, 190.0);

/// The whole page of a variant: `base` is the grammar, `measurements` the file that was read.
#[must_use]
pub fn page(name: &str, base: &str, measurements: &str, findings: &[Finding]) -> String {
    let title = escape(name);
    let bodies: String = findings.iter().map(section).collect();
    let header = format!(
        "<h1>{title}</h1>\n<p class=\"from\">{} of <code>{}</code>, for the grammar <code>{}</code></p>",
        counted(findings.len() as u64, "quantity").replace("quantitys", "quantities"),
        escape(measurements),
        escape(base),
    );
    let main = format!("<section>\n<h2>What was measured</h2>\n{}</section>\n{bodies}", summary(findings));
    let document = Document {
        title: &title,
        kind: "calibration",
        refresh: "",
        style: OWN_STYLE,
        header: &header,
        main: &main,
    };
    document.html()
}

fn summary(findings: &[Finding]) -> String {
    let dash = || "–".to_owned();
    let rows: Vec<Vec<String>> = findings
        .iter()
        .map(|finding| {
            let residual = finding.residual.as_ref();
            let name = escape(&finding.quantity);
            let link = format!("<a href=\"#{}\">{name}</a>", id(finding));
            vec![
                if is_drawn(finding) { link } else { name },
                finding.old.as_deref().map_or_else(dash, escape),
                format!("<b>{}</b>", escape(&finding.change.shown())),
                residual.map_or_else(dash, |r| escape(&r.rms.to_string())),
                residual.map_or_else(dash, |r| escape(&r.largest.to_string())),
                finding.points.to_string(),
            ]
        })
        .collect();
    table(&["quantity", "#in the grammar", "#measured", "#residual (rms)", "#largest", "#points"], &rows)
}

/// Whether a finding has a section of its own.
fn is_drawn(finding: &Finding) -> bool {
    !(finding.plots.is_empty() && finding.notes.is_empty() && finding.warnings.is_empty())
}

/// The place of a finding in addresses.
fn id(finding: &Finding) -> String {
    finding.quantity.chars().map(|c| if c.is_alphanumeric() || c == '.' { c } else { '-' }).collect()
}

fn section(finding: &Finding) -> String {
    if !is_drawn(finding) {
        return String::new();
    }
    let from = format!(
        "{} · {} · {}",
        escape(&finding.source),
        escape(&finding.section),
        counted(finding.points as u64, "point")
    );
    let old = finding
        .old
        .as_ref()
        .map_or(String::new(), |old| format!("<small>in the grammar: {}</small>", escape(old)));
    let notes = finding.warnings.iter().chain(&finding.notes);
    let notes: String = notes.map(|note| format!("<li>{}</li>", plain(note))).collect();
    let notes = if notes.is_empty() { notes } else { format!("<ul class=\"notes\">{notes}</ul>\n") };
    let pictures: String = finding
        .plots
        .iter()
        .map(|plot| format!("<figure>{}{}</figure>\n", drawn(plot), residuals(plot).unwrap_or_default()))
        .collect();
    format!(
        "<section id=\"{}\">\n<h2>{}</h2>\n<p class=\"value\">{}{old}</p>\n<p class=\"from\">{from}</p>\n\
         <div class=\"bench\">\n{pictures}<div class=\"said\">\n{notes}{}</div>\n</div>\n</section>\n",
        id(finding),
        escape(&finding.quantity),
        escape(&finding.change.shown()),
        rows(&finding.change)
    )
}

/// The rows of a table, to be unfolded.
fn rows(change: &Change) -> String {
    let Change::Table { table: measured, .. } = change else { return String::new() };
    let rows: Vec<Vec<String>> = measured
        .rows
        .iter()
        .map(|(x, y)| vec![escape(&format!("{} {}", x.digits(true), x.unit)), escape(&y.to_string())])
        .collect();
    let head = [format!("#{}", measured.from), format!("#{}", measured.to)];
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    format!(
        "<details class=\"rows\" open><summary>{}</summary>{}</details>\n",
        counted(rows.len() as u64, "row"),
        table(&head, &rows)
    )
}

/// Words with `` `names` `` in them, as markup.
fn plain(text: &str) -> String {
    let parts = text.split('`').enumerate();
    parts
        .map(|(i, part)| if i % 2 == 1 { format!("<code>{}</code>", escape(part)) } else { escape(part) })
        .collect()
}

fn colour(run: usize) -> String {
    format!("g{}", run % COLOURS)
}

/// The size of a point: many are small.
fn radius(points: usize) -> f64 {
    if points > 120 { 2.0 } else { 3.4 }
}

fn drawn(plot: &Plot) -> String {
    let all = || {
        plot.points
            .iter()
            .map(|p| (p.0, p.1))
            .chain(plot.fit.iter().flat_map(|(line, _)| line.iter().copied()))
            .chain(plot.rows.iter().copied())
    };
    let x = Scale::of(all().map(|p| p.0), 6);
    // Speeds are seen from zero; other values by their differences.
    let zero = (plot.points.is_empty()).then_some(0.0);
    let y = Scale::of(all().map(|p| p.1).chain(zero), 6);
    let mut chart = Chart::new(Chart::HALF, (x, &plot.x), (y, &plot.y));
    let r = radius(plot.points.len());
    for (px, py, run) in &plot.points {
        let mark = format!(
            "<circle class=\"measured {}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{r}\"/>",
            colour(*run),
            chart.x(*px),
            chart.y(*py)
        );
        chart.add(&mark);
    }
    for (line, run) in &plot.fit {
        let mark = format!("<path class=\"course {}\" d=\"{}\"/>", colour(*run), chart.course(line));
        chart.add(&mark);
    }
    for (px, py) in &plot.rows {
        let mark = format!(
            "<circle class=\"row g0\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.2\"/>",
            chart.x(*px),
            chart.y(*py)
        );
        chart.add(&mark);
    }
    let title = plot.title.replace('`', "");
    format!("<figcaption>{}</figcaption>{}", plain(&plot.title), chart.finish(&title))
}

fn residuals(plot: &Plot) -> Option<String> {
    if plot.residuals.is_empty() {
        return None;
    }
    let x = Scale::of(plot.points.iter().map(|p| p.0).chain(plot.rows.iter().map(|p| p.0)), 6);
    let most = plot.residuals.iter().map(|r| r.1.abs()).fold(0.0, f64::max);
    let y = Scale::of([-most, most], 4);
    let name = if plot.unit.is_empty() { "residual".to_owned() } else { format!("residual ({})", plot.unit) };
    let mut chart = Chart::new(LOW, (x, &plot.x), (y, &name));
    let r = radius(plot.residuals.len());
    for (px, py, run) in &plot.residuals {
        let (at, zero, high) = (chart.x(*px), chart.y(0.0), chart.y(*py));
        let mark = format!(
            "<g class=\"{}\">{}<circle class=\"measured\" cx=\"{at:.1}\" cy=\"{high:.1}\" r=\"{r}\"/></g>",
            colour(*run),
            if plot.residuals.len() > 120 { String::new() } else { line((at, zero), (at, high), "stem") }
        );
        chart.add(&mark);
    }
    Some(chart.finish(&format!("{}: residuals", plot.title.replace('`', ""))))
}
