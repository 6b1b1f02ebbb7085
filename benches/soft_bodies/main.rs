//! Repeats what a doctoral thesis (2021) saw when it tried force-based springs and position-based dynamics for soft robots.
//!
//! Run it with `cargo bench --bench soft_bodies`. It prints Markdown tables. Only the CPU times change from run to run.
//! docs/particles.md has them with what they mean.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

mod force_based;
mod position_based;
mod scenes;
mod voxels;

use force_based::{Contact, ForceBased};
use position_based::{Friction, PositionBased, Softness};
use scenes::{
    Lost, Sag, Solver, beam_theory, cantilever, cantilever_voxels, creep, hover, stopping_distance, walker,
};

/// Frames per second for position-based dynamics.
const FRAMES: [f64; 2] = [60.0, 240.0];
/// Steps per second for force-based springs.
const FINE: [f64; 3] = [4096.0, 8192.0, 16384.0];

fn main() {
    println!("## A cantilever\n");
    println!("Beam theory with shear and small deflections gives a sag of {:.2} mm.\n", beam_theory());
    let springs = sag_of_springs();
    sag_of_pbd();
    sag_of_xpbd(&springs);
    sag_of_small_steps();
    println!("## A block\n");
    block();
    contacts();
    println!("## A walker\n");
    walkers();
}

/// Prints the head of a table.
fn head(cells: &[&str]) {
    println!("| {} |\n|{}", cells.join(" | "), "---|".repeat(cells.len()));
}

/// Prints a row of a table.
fn row(cells: &[String]) {
    println!("| {} |", cells.join(" | "));
}

fn sag_cell(sag: Result<Sag, Lost>) -> String {
    match sag {
        Ok(sag) if sag.rests => format!("{:.1}", sag.millimetres),
        Ok(sag) => format!("{:.1}, moves", sag.millimetres),
        Err(lost) => lost.to_string(),
    }
}

fn millimetres(way: Result<f64, Lost>, digits: usize) -> String {
    way.map_or_else(|lost| lost.to_string(), |way| format!("{:.digits$}", 1e3 * way))
}

/// Sag of the cantilever with force-based springs at the largest step that lets it rest. Gives sizes (mm) and sags (mm).
fn sag_of_springs() -> Vec<(f64, f64)> {
    head(&["voxels, mm", "number", "sag, mm", "largest stable step, ms", "CPU seconds per second"]);
    let mut sags = Vec::new();
    for h in [16.0, 8.0, 16.0 / 3.0, 4.0] {
        // Steps fall from 2^-8 s by a fourth root of 2.
        let steps = (32..80).map(|n| libm::exp2(-f64::from(n) / 4.0));
        let runs = steps.map(|step| (step, cantilever(h / 1e3, &mut ForceBased::new(step, Contact::TUNED))));
        let mut stable =
            runs.filter_map(|(step, sag)| sag.ok().filter(|sag| sag.rests).map(|sag| (step, sag)));
        if let Some((step, sag)) = stable.next() {
            let number = cantilever_voxels(h / 1e3).iter().product::<usize>();
            let (length, sagging) = (format!("{h:.1}"), format!("{:.2}", sag.millimetres));
            row(&[
                length,
                number.to_string(),
                sagging,
                format!("{:.3}", 1e3 * step),
                format!("{:.3}", sag.cpu),
            ]);
            sags.push((h, sag.millimetres));
        }
    }
    println!();
    sags
}

/// Sag of the cantilever with PBD.
fn sag_of_pbd() {
    println!("PBD, sag in mm for a stiffness factor `k` and a number of iterations per step:\n");
    let columns = [("k = 1", Softness::EachIteration(1.0)), ("k = 0.5", Softness::EachIteration(0.5))];
    let mut titles = vec!["step, s".to_string(), "voxels, mm".to_string()];
    titles.extend(columns.iter().flat_map(|(name, _)| [5, 20, 100].map(|n| format!("{name}, {n}"))));
    titles.push("k = 0.5 a step, 20".to_string());
    head(&titles.iter().map(String::as_str).collect::<Vec<_>>());
    for rate in FRAMES {
        for h in [16.0, 8.0, 4.0] {
            let sag = |iterations, softness| {
                let mut solver = PositionBased::new(1.0 / rate, iterations, softness, Friction::Share);
                sag_cell(cantilever(h / 1e3, &mut solver))
            };
            let mut cells = vec![format!("1/{rate}"), h.to_string()];
            cells.extend(columns.iter().flat_map(|(_, softness)| [5, 20, 100].map(|n| sag(n, *softness))));
            cells.push(sag(20, Softness::WholeStep(0.5)));
            row(&cells);
        }
    }
    println!();
}

/// Sag of the cantilever with XPBD, and the number of iterations that brings it near the sag of the same springs as forces.
fn sag_of_xpbd(springs: &[(f64, f64)]) {
    println!("XPBD, sag in mm for a number of iterations per step:\n");
    let counts = [5, 20, 100, 1000];
    head(&[
        "step, s",
        "voxels, mm",
        "springs",
        "5",
        "20",
        "100",
        "1000",
        "iterations for 5 % of the springs",
    ]);
    for rate in FRAMES {
        for (h, truth) in springs.iter().filter(|(h, _)| h.fract() == 0.0) {
            let sag = |iterations| {
                let mut solver =
                    PositionBased::new(1.0 / rate, iterations, Softness::Compliance, Friction::Share);
                cantilever(h / 1e3, &mut solver)
            };
            let near =
                |sag: &Result<Sag, Lost>| sag.is_ok_and(|sag| (sag.millimetres / truth - 1.0).abs() < 0.05);
            let sags = counts.map(sag);
            let enough = sags.iter().position(near).map(|i| {
                let mut bounds = [if i > 0 { counts[i - 1] } else { 0 }, counts[i]];
                for _ in 0..2 {
                    let middle = ((bounds[0] * bounds[1]) as f64).sqrt() as usize;
                    bounds[usize::from(middle > 0 && near(&sag(middle)))] = middle;
                }
                format!("{} to {}", bounds[0], bounds[1])
            });
            let mut cells = vec![format!("1/{rate}"), h.to_string(), format!("{truth:.1}")];
            cells.extend(sags.map(sag_cell));
            cells.push(enough.unwrap_or("more than 1000".to_string()));
            row(&cells);
        }
    }
    println!();
}

/// Sag of the cantilever with XPBD, with the same work per second as above but one iteration in each of many small steps.
fn sag_of_small_steps() {
    println!("XPBD with one iteration per step, sag in mm (CPU seconds per second):\n");
    head(&["step, s", "16 mm", "8 mm", "4 mm"]);
    for rate in [1200.0, 4800.0, 24000.0] {
        let mut cells = vec![format!("1/{rate}")];
        for h in [16.0, 8.0, 4.0] {
            let mut solver = PositionBased::new(1.0 / rate, 1, Softness::Compliance, Friction::Share);
            let sag = cantilever(h / 1e3, &mut solver);
            let cpu = sag.map_or(String::new(), |sag| format!(" ({:.2})", sag.cpu));
            cells.push(sag_cell(sag) + &cpu);
        }
        row(&cells);
    }
    println!();
}

/// The position-based methods that meet the ground.
const METHODS: [(&str, Softness, Friction); 3] = [
    ("PBD, k = 1, thesis's friction", Softness::EachIteration(1.0), Friction::Share),
    ("XPBD, thesis's friction", Softness::Compliance, Friction::Share),
    ("XPBD, Coulomb friction", Softness::Compliance, Friction::Coulomb),
];

/// A block that slides, and one on a slope. A cell has the results for three steps.
fn block() {
    head(&["method", "steps, s", "slides, mm (truth 102)", "creeps, mm (truth 0)"]);
    let line = |name: &str, rates: [f64; 3], make: &dyn Fn(f64) -> Box<dyn Solver>| {
        let slides = rates.map(|rate| millimetres(stopping_distance(make(1.0 / rate).as_mut()), 0));
        let creeps = rates.map(|rate| millimetres(creep(make(1.0 / rate).as_mut()), 1));
        let steps = rates.map(|rate| format!("1/{rate}"));
        row(&[name.to_string(), steps.join(", "), slides.join(" / "), creeps.join(" / ")]);
    };
    line("forces", FINE, &|step| Box::new(ForceBased::new(step, Contact::TUNED)));
    for (name, softness, friction) in METHODS {
        let make = |step| PositionBased::new(step, 20, softness, friction);
        line(name, [60.0, 120.0, 240.0], &|step| Box::new(make(step)));
    }
    println!();
}

/// A block that rests on penalty contacts.
fn contacts() {
    println!(
        "A resting block on penalty contacts: highest place of its lowest particle, mm (range of its centre's height, mm):\n"
    );
    head(&["contact stiffness per depth, N/m^2", "damping", "1/4096 s", "1/8192 s", "1/16384 s"]);
    for (stiffening, damping) in [(2e4, 0.0), (2e4, 0.2), (2e6, 0.2), (2e8, 0.2), (2e10, 0.2)] {
        let mut cells = vec![format!("{stiffening:e}"), damping.to_string()];
        cells.extend(FINE.map(|rate| {
            let heights = hover(&mut ForceBased::new(1.0 / rate, Contact { stiffening, damping }));
            heights.map_or_else(
                |lost| lost.to_string(),
                |[top, range]| format!("{:.3} ({:.3})", 1e3 * top, 1e3 * range),
            )
        }));
        row(&cells);
    }
    println!();
}

/// The way a walker goes in 10 s. A cell has the results for each step, and each number of iterations.
fn walkers() {
    head(&["method", "steps, s", "iterations", "16 mm: way, mm", "CPU, s", "8 mm: way, mm", "CPU, s"]);
    let line = |name: &str, rates: &[f64], counts: &[usize], make: &dyn Fn(f64, usize) -> Box<dyn Solver>| {
        let steps: Vec<String> = rates.iter().map(|rate| format!("1/{rate}")).collect();
        let iterations: Vec<String> = counts.iter().map(usize::to_string).collect();
        let mut cells = vec![name.to_string(), steps.join(", "), iterations.join(", ")];
        for finer in [1, 2] {
            let pairs = rates.iter().flat_map(|rate| counts.iter().map(move |count| (1.0 / rate, *count)));
            let runs = pairs.map(|(step, count)| walker(finer, make(step, count).as_mut()));
            let texts = runs.map(|(way, cpu)| (millimetres(way, 1), format!("{cpu:.2}")));
            let (ways, times): (Vec<_>, Vec<_>) = texts.unzip();
            cells.extend([ways.join(" / "), times.join(" / ")]);
        }
        row(&cells);
    };
    line("forces", &FINE[..2], &[1], &|step, _| Box::new(ForceBased::new(step, Contact::TUNED)));
    for (name, softness, friction) in [METHODS[0], METHODS[2]] {
        let make = |step, count| PositionBased::new(step, count, softness, friction);
        for rate in FRAMES {
            line(name, &[rate], &[10, 20], &|step, count| Box::new(make(step, count)));
        }
    }
    let (name, softness, friction) = METHODS[2];
    let make = |step, count| PositionBased::new(step, count, softness, friction);
    line(name, &[2400.0, 4800.0], &[1], &|step, count| Box::new(make(step, count)));
}
