//! How long an evaluation of balls and springs takes, and what rapier's springs need for the same error.
//!
//! `cargo bench --bench balls` (add `-- 9` for nine rounds instead of three). Times are of the processor, of all
//! threads, least of the rounds; all methods take turns. On an idle machine, please.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stdout, missing_docs)]

use std::time::Instant;

use cpu_time::ProcessTime;
use nalgebra::{Isometry3, Vector3};
use sgc::design::assembly::{Assembly, Element, Shape, Spring, Swelling};
use sgc::simulate::rapier::Rapier;
use sgc::simulate::{Model, Motion, Settings, Targets, model};

/// Distance between balls, m.
const PITCH: f64 = 0.01;
/// Springs of flesh, N/m; damping over stiffness, s.
const FLESH: f64 = 100.0;
const LAG: f64 = 2e-4;

/// What a body is made of.
#[derive(Clone, Copy)]
struct Material {
    name: &'static str,
    /// Stiffness of trunk and legs, N/m.
    stiffness: [f64; 2],
    /// Of a ball, kg.
    mass: f64,
    /// Steps in a second: one for evaluations, one twice as fine.
    rate: f64,
}

/// The rigid and the firm silicone of `std.lattice`.
const SILICONE: Material = Material { name: "silicone", stiffness: [600.0, 250.0], mass: 1e-3, rate: 2400.0 };
/// Bones that carry light legs.
const BONE: Material = Material { name: "bone", stiffness: [1000.0, FLESH], mass: 5e-4, rate: 4800.0 };

fn main() {
    let rounds = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(3);
    evaluations(rounds);
    cantilever(rounds);
}

/// A trunk on four softer legs, bent to and fro.
fn quadruped(material: Material, trunk: [i32; 3], leg: [i32; 3]) -> (Assembly, Targets) {
    let [length, height, width] = trunk;
    let mut cells = cells([0, leg[1], 0], trunk);
    assert!(height > 0);
    let ends = |all: i32, part: i32| [0, all - part];
    let feet: Vec<_> =
        ends(length, leg[0]).into_iter().flat_map(|x| ends(width, leg[2]).map(|z| [x, 0, z])).collect();
    feet.iter().for_each(|foot| cells.extend(self::cells(*foot, leg)));
    let Material { stiffness: [hard, soft], mass, .. } = material;
    let mut body = lattice(&cells, |cell| if cell[1] >= leg[1] { hard } else { soft });
    body.elements.iter_mut().for_each(|ball| ball.mass = mass);
    for (element, cell) in cells.iter().enumerate() {
        let within = |foot: &[i32; 3]| {
            cell[1] < leg[1]
                && (foot[0]..foot[0] + leg[0]).contains(&cell[0])
                && (foot[2]..foot[2] + leg[2]).contains(&cell[2])
        };
        if let Some(actuator) = feet.iter().position(within) {
            let gain = if cell[0] - feet[actuator][0] < leg[0] / 2 { 1.0 } else { -1.0 };
            body.swellings.push(Swelling { element, actuator, gain });
        }
    }
    body.actuators = 4;
    let angle = |sample: i32, actuator: i32| {
        let phase = f64::from((actuator + actuator / 2) % 2) * 0.5;
        0.25 * libm::sin(std::f64::consts::TAU * (f64::from(sample) * 0.025 + phase))
    };
    let angles = (0..=900).flat_map(|sample| (0..4).map(move |actuator| angle(sample, actuator))).collect();
    (body, Targets { interval: 1.0 / 60.0, actuators: 4, angles })
}

/// The cells of a box from its lowest corner.
fn cells(from: [i32; 3], [x, y, z]: [i32; 3]) -> Vec<[i32; 3]> {
    (0..x * y * z).map(|n| [from[0] + n % x, from[1] + n / x % y, from[2] + n / (x * y)]).collect()
}

/// Balls of half a gram in cells, with springs between those that share a face or an edge.
fn lattice(cells: &[[i32; 3]], stiffness: impl Fn(&[i32; 3]) -> f64) -> Assembly {
    let place = |cell: &[i32; 3]| Vector3::from(cell.map(|n| f64::from(n) * PITCH));
    let shape = Shape::Ball { radius: PITCH / 2.0 };
    let ball = |cell| Element { shape, pose: Isometry3::from(place(cell)), mass: 5e-4, friction: 0.8 };
    let mut springs = Vec::new();
    for (to, there) in cells.iter().enumerate() {
        for (from, here) in cells[..to].iter().enumerate() {
            let apart = [0, 1, 2].map(|axis: usize| (there[axis] - here[axis]).abs());
            if apart.iter().all(|n| *n <= 1) && apart.iter().sum::<i32>() <= 2 {
                let stiffness = stiffness(here).min(stiffness(there));
                springs.push(Spring { from, to, stiffness, damping: LAG * stiffness });
            }
        }
    }
    Assembly { elements: cells.iter().map(ball).collect(), springs, ..Assembly::default() }
}

fn settings(step: f64, duration: f64) -> Settings {
    Settings {
        step,
        duration,
        record: 0.1,
        gravity: 9.81,
        ground_friction: 0.8,
        iterations: 10,
        tolerance: 1e-3,
        self_collision: true,
        speed_limit: 10.0,
        pace_limit: None,
    }
}

/// Seconds of the processor that something takes, and of the clock.
fn timed(work: impl FnOnce()) -> (f64, f64) {
    let (clock, cpu) = (Instant::now(), ProcessTime::now());
    work();
    (cpu.elapsed().as_secs_f64(), clock.elapsed().as_secs_f64())
}

/// 15 s of two bodies, with one thread and with two, preparation included.
fn evaluations(rounds: usize) {
    println!("s of processor time for 15 s of a quadruped, the least of {rounds} rounds");
    println!(
        "{:>10}{:>7}{:>9}{:>9}{:>9}{:>13}{:>13}",
        "material", "balls", "springs", "step", "self", "one thread", "two at once"
    );
    let sizes = [([9, 3, 5], [2, 7, 2]), ([13, 3, 9], [4, 8, 2])];
    for (material, (trunk, leg)) in [SILICONE, BONE].into_iter().flat_map(|m| sizes.map(|size| (m, size))) {
        let (body, drive) = quadruped(material, trunk, leg);
        let rate = material.rate;
        for (rate, self_collision) in [(rate, true), (2.0 * rate, true), (rate, false)] {
            let settings = Settings { self_collision, ..settings(1.0 / rate, 15.0) };
            let run = || {
                let mut simulation = model("balls").unwrap().prepare(&body, &settings).unwrap();
                let motion = simulation.run(std::slice::from_ref(&drive)).remove(0);
                assert!(motion.is_ok(), "{:?}", motion.err());
            };
            let (mut one, mut clock, mut two) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
            for _ in 0..rounds {
                let (cpu, wall) = timed(run);
                (one, clock) = (one.min(cpu), clock.min(wall));
                let both = || std::thread::scope(|scope| drop([scope.spawn(run), scope.spawn(run)]));
                two = two.min(timed(both).1);
            }
            println!(
                "{:>10}{:>7}{:>9}{:>9}{:>9}{one:>13.3}{:>12.2}x",
                material.name,
                body.elements.len(),
                body.springs.len(),
                format!("1/{rate}"),
                self_collision,
                2.0 * clock / two
            );
        }
    }
}

/// A block of 4 x 6 x 4 heavy balls with a beam of 7 x 2 x 2 that hangs over.
fn overhang() -> Assembly {
    let mut all = cells([0, 0, 0], [4, 6, 4]);
    all.extend(cells([4, 4, 1], [7, 2, 2]));
    let mut body = lattice(&all, |_| FLESH * 3.0);
    for (element, cell) in body.elements.iter_mut().zip(&all) {
        element.mass = if cell[0] < 4 { 1e-3 } else { element.mass };
    }
    body.springs.iter_mut().for_each(|spring| spring.damping = 1e-3 * spring.stiffness);
    body
}

/// How far the tip of a cantilever has come down: while it swings, and when it rests.
fn cantilever(rounds: usize) {
    const TIMES: [f64; 3] = [0.1, 0.2, 2.0];
    let body = overhang();
    let drive = Targets { interval: 1.0, actuators: 0, angles: Vec::new() };
    let tip = body.elements.len() - 1;
    let sags = |motion: &Motion| {
        let height = |t: f64| motion.pose(tip, t).unwrap().translation.vector.y;
        TIMES.map(|t| height(0.0) - height(t))
    };
    let run = |model: &dyn Model, settings: &Settings| {
        let (mut least, mut sag) = (f64::INFINITY, [0.0; 3]);
        for _ in 0..rounds {
            let own = || {
                sag = sags(
                    model.prepare(&body, settings).unwrap().run(std::slice::from_ref(&drive))[0]
                        .as_ref()
                        .unwrap(),
                )
            };
            least = least.min(timed(own).0);
        }
        (least, sag)
    };
    let balls = model("balls").unwrap();
    let truth = run(balls, &settings(1.0 / 76800.0, 2.0)).1;
    println!("\ntip of a cantilever of {} balls after {TIMES:?} s: {truth:.6?} m", body.elements.len());
    println!("{:>10}{:>10}{:>8}{:>10}   errors, % of the sag at rest", "", "step", "sweeps", "s of 2 s");
    let show = |name: &str, rate: f64, sweeps: usize, (time, sag): (f64, [f64; 3])| {
        let off: Vec<_> =
            sag.iter().zip(truth).map(|(a, b)| format!("{:8.3}", 100.0 * (a - b) / truth[2])).collect();
        println!("{name:>10}{:>10}{sweeps:>8}{time:>10.3}   {}", format!("1/{rate}"), off.join(" "));
    };
    for rate in [4800.0, 9600.0, 19200.0] {
        show("balls", rate, 10, run(balls, &settings(1.0 / rate, 2.0)));
    }
    for (rate, iterations) in [(960.0, 1), (3840.0, 1), (3840.0, 8), (15360.0, 1), (15360.0, 4), (61440.0, 1)]
    {
        let settings = Settings { iterations, ..settings(1.0 / rate, 2.0) };
        let rapier = Rapier { substep: settings.step };
        show("rapier", rate, iterations, run(&rapier, &settings));
    }
}
