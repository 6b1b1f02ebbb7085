//! The fronts of several objectives: drawn, as tables, and in words.

use grammar_lang::ir::Direction;

use super::chart::{Chart, Scale, hint};
use super::words::{counted, figures, key, number, or_dash, percent, table, value};
use super::{Link, colour, heading, label, told};
use crate::markup::escape;
use crate::results::report::gather::front::{Front, Valued, Wanted, alike, bend, course, fronts, shares};
use crate::results::report::read::Group;

pub(super) fn section(groups: &[Group], link: Link) -> String {
    let all = fronts(groups);
    if all.iter().all(Option::is_none) {
        return String::new();
    }
    let marks = [
        ("point", "a design that no other design of its run beats in every objective"),
        ("point soft", "other bodies that were tried"),
    ];
    let mut out = key(&marks.map(|(class, text)| (class.to_owned(), text.to_owned())));
    let shares = shares(&all);
    for (place, (group, found)) in groups.iter().zip(&all).enumerate() {
        let Some((wanted, fronts)) = found else { continue };
        out += &heading(groups, place);
        let mut charts: Vec<String> =
            (1..wanted.len()).map(|beside| chart(fronts, wanted, beside, &colour(place), link)).collect();
        charts.push(growth(fronts, &alike(&all, wanted), wanted, &colour(place)));
        out += &figures(&charts);
        let best = fronts.iter().zip(&shares[place]).max_by(|a, b| a.1.total_cmp(b.1));
        out += &told(groups, group, &said(fronts, best, wanted));
        if fronts.len() > 1 || groups.len() > 1 {
            out += &runs(groups, group, fronts, &shares[place]);
        }
        if let Some((best, _)) = best {
            out += &designs(groups, group, best, wanted, link);
        }
    }
    let mut wanted = all.iter().flatten().map(|(wanted, _)| wanted);
    let first = wanted.next();
    let apart = if wanted.any(|other| Some(other) != first) {
        "<p class=\"small\">Here are fronts of different objectives, or of the same in different units. Each kind has a box of its own: do not compare their shares.</p>\n"
    } else {
        ""
    };
    out + apart
        + "<p class=\"small\">A front covers the share of the box between the worst and the best values on all the fronts of the same objectives here (the hypervolume): 100\u{a0}% if one design were the best in everything. \
           <code>sgc view RUN</code> writes a page for each design on a front; pages that exist are linked.</p>\n"
}

/// What an axis shows.
fn axis(wanted: &Wanted) -> String {
    let better = match wanted.direction {
        Direction::Maximize => "more is better",
        Direction::Minimize => "less is better",
    };
    let unit = if wanted.unit.is_empty() { String::new() } else { format!(" in {}", wanted.unit) };
    format!("{}{unit}, {better}", wanted.name)
}

/// The first objective against another one.
fn chart(fronts: &[Front<'_>], wanted: &[Wanted], beside: usize, class: &str, link: Link) -> String {
    let shown = |front: &Front<'_>| -> Vec<(f64, f64)> {
        front.best.iter().map(|one| (one.each[beside], one.each[0])).collect()
    };
    let ends: Vec<(f64, f64)> = fronts.iter().flat_map(shown).collect();
    let x = Scale::of(ends.iter().map(|(x, _)| *x).chain([0.0]), 6);
    let y = Scale::of(ends.iter().map(|(_, y)| *y).chain([0.0]), 6);
    let (across, up) = (axis(&wanted[beside]), axis(&wanted[0]));
    let mut chart = Chart::new(Chart::HALF, (x, &across), (y, &up));
    let inside = |(a, b): (f64, f64)| (x.low..=x.high).contains(&a) && (y.low..=y.high).contains(&b);
    for one in fronts.iter().flat_map(|front| &front.tried) {
        // What is far from every front would make it a line at the edge.
        let (a, b) = (one.each[beside], one.each[0]);
        if inside((a, b)) {
            let (cx, cy) = (chart.x(a), chart.y(b));
            chart.add(&format!("<circle class=\"cell {class}\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"1.5\"/>"));
        }
    }
    for front in fronts {
        let steps: Vec<(f64, f64)> =
            front.trade(beside, wanted).iter().map(|one| (one.each[beside], one.each[0])).collect();
        let course = chart.course(&steps);
        chart.add(&format!("<path class=\"line ink\" d=\"{course}\"/>"));
        for one in &front.best {
            let (cx, cy) = (chart.x(one.each[beside]), chart.y(one.each[0]));
            let dot = format!(
                "<circle class=\"dot ink\" cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"4\">{}</circle>",
                hint(&format!("move {}: {}", one.made.number, values(one, wanted)))
            );
            chart.add(&linked(dot, front, one, link));
        }
    }
    chart.finish(&format!("{} against {}", wanted[0].name, wanted[beside].name))
}

/// How the fronts of a group grow.
fn growth(fronts: &[Front<'_>], others: &[&Front<'_>], wanted: &[Wanted], class: &str) -> String {
    let end = |front: &Front<'_>| front.run.evaluations() as f64;
    let x = Scale::until(fronts.iter().map(end).chain([0.0]).collect::<Vec<_>>(), 5);
    let y = Scale::of([0.0, 100.0], 5);
    let mut chart = Chart::new(Chart::HALF, (x, "evaluations (simulated motions)"), (y, "covered in %"));
    for front in fronts {
        let mut steps = Vec::new();
        let mut last = 0.0;
        for (evaluations, share) in course(front, others, wanted) {
            steps.extend([(evaluations as f64, last), (evaluations as f64, 100.0 * share)]);
            last = 100.0 * share;
        }
        steps.push((end(front), last));
        let drawn = chart.course(&steps);
        let told = hint(&format!("seed {}", front.run.asked.seed));
        chart.add(&format!("<path class=\"line {class}\" d=\"{drawn}\">{told}</path>"));
    }
    chart.finish("how much the fronts cover against evaluations")
}

/// Markup that leads to the page of a design, if there is one.
fn linked(markup: String, front: &Front<'_>, one: &Valued<'_>, link: Link) -> String {
    let page = one.file(front.run).and_then(|file| link(&file));
    match page {
        Some(address) => format!("<a href=\"{}\">{markup}</a>", escape(&address)),
        None => markup,
    }
}

/// All values of a design.
fn values(one: &Valued<'_>, wanted: &[Wanted]) -> String {
    let told = |(wanted, x): (&Wanted, &f64)| format!("{} {}", wanted.name, value(*x, &wanted.unit));
    wanted.iter().zip(&one.each).map(told).collect::<Vec<_>>().join(", ")
}

/// The runs of a group, and how much each front covers.
fn runs(groups: &[Group], group: &Group, fronts: &[Front<'_>], shares: &[f64]) -> String {
    let rows: Vec<Vec<String>> = fronts
        .iter()
        .zip(shares)
        .map(|(front, share)| {
            vec![
                escape(&label(groups, group, front.run)),
                front.tried.len().to_string(),
                front.best.len().to_string(),
                percent(*share),
            ]
        })
        .collect();
    table(&["run", "#bodies with values", "#on the front", "#covered"], &rows)
}

/// The designs on a front.
fn designs(groups: &[Group], group: &Group, front: &Front<'_>, wanted: &[Wanted], link: Link) -> String {
    let knee = front.knee(wanted).map(|one| one.made.number);
    let is_saved = |one: &&Valued<'_>| one.file(front.run).is_some();
    let saved = front.best.iter().filter(is_saved).count();
    let rows: Vec<Vec<String>> = front
        .best
        .iter()
        .filter(|one| saved == 0 || is_saved(one))
        .map(|one| {
            let name = format!("move {}", one.made.number);
            let mark = if knee == Some(one.made.number) { " (knee)" } else { "" };
            let file = one
                .file(front.run)
                .map(|file| format!("<code>{}</code>", escape(&file.display().to_string())));
            let mut cells = vec![format!("{}{mark}", linked(name, front, one, link))];
            cells.extend(wanted.iter().zip(&one.each).map(|(wanted, x)| value(*x, &wanted.unit)));
            cells.extend([one.made.parts.to_string(), one.made.actuators.to_string(), or_dash(file)]);
            cells
        })
        .collect();
    let names: Vec<String> = wanted.iter().map(|wanted| format!("#{}", escape(&wanted.name))).collect();
    let mut head = vec!["design"];
    head.extend(names.iter().map(String::as_str));
    head.extend(["#parts", "#actuators", "saved in"]);
    let title = escape(&label(groups, group, front.run));
    let left_out = match front.best.len() - saved {
        _ if saved == 0 => String::new(),
        0 => String::new(),
        more => format!(
            " {more} more are not among the designs that the search keeps: the front loses least without them."
        ),
    };
    let which = if groups.iter().map(|group| group.runs.len()).sum::<usize>() > 1 {
        ", the one that covers most"
    } else {
        ""
    };
    format!("<p>The front of {title}{which}.{left_out}</p>\n{}", table(&head, &rows))
}

/// A count has no unit and only whole values, and few of them.
const FEW_STEPS: usize = 12;

/// What is seen, in words: what each objective costs in the first.
fn said(fronts: &[Front<'_>], best: Option<(&Front<'_>, &f64)>, wanted: &[Wanted]) -> Vec<String> {
    let Some((front, _)) = best.filter(|(front, _)| !front.best.is_empty()) else {
        return vec!["No body has a value in every objective yet.".to_owned()];
    };
    let of = if fronts.len() > 1 { format!(" (seed {})", front.run.asked.seed) } else { String::new() };
    let mut said = vec![format!("{} on the front{of}.", counted(front.best.len() as u64, "design"))];
    for (beside, other) in wanted.iter().enumerate().skip(1) {
        let trade = front.trade(beside, wanted);
        let is_count = |one: &&Valued<'_>| one.each[beside].fract() == 0.0;
        if other.unit.is_empty() && trade.len() <= FEW_STEPS && trade.iter().all(is_count) {
            said.extend(trade.windows(2).map(|pair| price(pair[0], pair[1], beside, wanted)));
        } else if let (Some(first), Some(last)) = (trade.first(), trade.last()) {
            // By way of the design where the trade bends, if it does.
            let knee = bend(&trade, wanted, &[0, beside]);
            let stops: Vec<&Valued<'_>> = [*first].into_iter().chain(knee).chain([*last]).collect();
            let pairs = stops.windows(2).filter(|pair| pair[0].made.number != pair[1].made.number);
            said.extend(pairs.map(|pair| price(pair[0], pair[1], beside, wanted)));
        }
    }
    said
}

/// What it costs in the first objective to go from one design to another that is better in a second.
fn price(from: &Valued<'_>, to: &Valued<'_>, beside: usize, wanted: &[Wanted]) -> String {
    let (first, other) = (&wanted[0], &wanted[beside]);
    let lost = first.direction.fitness(from.each[0]) - first.direction.fitness(to.each[0]);
    let cost = if lost >= 0.0 {
        format!("costs {}", value(lost, &first.unit))
    } else {
        format!("gains {}", value(-lost, &first.unit))
    };
    format!(
        "Going from {} to {} of {} {cost} of {} ({} to {}, moves {} and {}).",
        number(from.each[beside]),
        value(to.each[beside], &other.unit),
        escape(&other.name),
        escape(&first.name),
        number(from.each[0]),
        value(to.each[0], &first.unit),
        from.made.number,
        to.made.number,
    )
}
