//! Measurements for people, run by hand:
//! `cargo test --release --lib report -- --ignored --nocapture`.

use std::time::Instant;

use super::bodies::{gait, m2, m4, m8};
use super::settings;
use crate::design::assembly::Assembly;
use crate::simulate::{Model, Motion, Settings, Targets, model};

/// The least horizontal way of any element, cm.
fn value(motion: &Motion) -> f64 {
    let ways = (0..motion.placements.len()).map(|element| {
        let (from, to) = (motion.pose(element, 0.0).unwrap(), motion.pose(element, motion.duration).unwrap());
        let way = to.translation.vector - from.translation.vector;
        100.0 * libm::hypot(way.x, way.z)
    });
    ways.fold(f64::INFINITY, f64::min)
}

/// Root height lost and gained, to see that nothing sinks or flies.
fn heights(motion: &Motion) -> (f64, f64) {
    let of = |t: f64| motion.pose(0, t).unwrap().translation.vector.y * 100.0;
    let all = (0..motion.frames()).map(|frame| of(motion.time(frame)));
    (all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max))
}

fn run(
    model: &dyn Model,
    body: &Assembly,
    settings: &Settings,
    drives: &[Targets],
) -> (f64, Vec<f64>, String) {
    let mut simulation = model.prepare(body, settings).unwrap();
    simulation.run(&drives[..1]);
    let start = Instant::now();
    let motions = simulation.run(drives);
    let time = start.elapsed().as_secs_f64() * 1e3 / drives.len() as f64;
    let values = motions.iter().map(|m| m.as_ref().map_or(f64::NAN, value)).collect();
    let notes = motions.iter().map(|m| match m {
        Ok(motion) => {
            let (low, high) = heights(motion);
            format!("{low:.1}..{high:.1}")
        }
        Err(error) => format!("{error:?}"),
    });
    (time, values, notes.collect::<Vec<_>>().join(" "))
}

#[test]
#[ignore = "prints measurements"]
fn timings() {
    for name in ["articulated"] {
        for (title, body) in [("M2", m2()), ("M4", m4()), ("M8", m8())] {
            let drives: Vec<_> = (0..16).map(|n| gait(body.actuators, n + 1, n % 2 == 0)).collect();
            for collision in [true, false] {
                let settings = Settings { self_collision: collision, ..settings() };
                let mut simulation = model(name).unwrap().prepare(&body, &settings).unwrap();
                print!("{name} {title} self-collision {collision}, ms by lanes:");
                for lanes in [1, 4, 8, 16] {
                    simulation.run(&drives[..lanes]);
                    let start = Instant::now();
                    drives.chunks(lanes).for_each(|some| drop(simulation.run(some)));
                    print!("{lanes:4}: {:5.1}", start.elapsed().as_secs_f64() * 1e3 / drives.len() as f64);
                }
                println!();
            }
        }
    }
}

#[test]
#[ignore = "prints measurements"]
fn half_steps() {
    for name in ["articulated"] {
        for (title, body) in [("M2", m2()), ("M4", m4()), ("M8", m8())] {
            let drives: Vec<_> = (0..6).map(|n| gait(body.actuators, n + 1, n % 2 == 0)).collect();
            for (rate, iterations) in
                [(240.0, 5), (240.0, 8), (240.0, 30), (480.0, 8), (960.0, 8), (1920.0, 10)]
            {
                let settings = Settings { step: 1.0 / rate, iterations, ..settings() };
                let (time, values, _) = run(model(name).unwrap(), &body, &settings, &drives);
                println!("{name} {title} 1/{rate} x{iterations}: {values:.1?} ({time:.0} ms)");
            }
        }
    }
}

#[test]
#[ignore = "prints measurements"]
fn agreement() {
    for (title, body, numbers) in [("M2", m2(), 3..9), ("M4", m4(), 1..7)] {
        for number in numbers {
            let drive = gait(body.actuators, number, number % 2 == 1);
            let ends = [(240.0, 8), (1920.0, 20)].map(|(rate, iterations)| {
                let settings = Settings { step: 1.0 / rate, iterations, ..settings() };
                run(model("articulated").unwrap(), &body, &settings, std::slice::from_ref(&drive)).1[0]
            });
            let other = run(model("rapier").unwrap(), &body, &settings(), std::slice::from_ref(&drive));
            println!(
                "{title} gait {number}: {:.1?} articulated, {:.1?} rapier ({:.0} ms)",
                ends, other.1, other.0
            );
        }
    }
}

/// How far each count of sweeps is from many, over random gaits.
#[test]
#[ignore = "prints measurements"]
fn sweeps() {
    for (title, body) in [("M2", m2()), ("M4", m4()), ("M8", m8())] {
        let drives: Vec<_> = (1..25).map(|n| gait(body.actuators, n, n % 2 == 1)).collect();
        let values = |iterations| {
            let settings = Settings { iterations, ..settings() };
            run(model("articulated").unwrap(), &body, &settings, &drives)
        };
        let (_, truth, _) = values(200);
        for iterations in [4, 6, 8, 10, 14, 20, 40] {
            let (time, own, _) = values(iterations);
            let off: f64 = own.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum();
            let bad = own.iter().zip(&truth).filter(|(a, b)| (*a - *b).abs() > 0.5).count();
            let mean = off / drives.len() as f64;
            println!(
                "{title} x{iterations}: mean {mean:.2} cm off, {bad} of 24 by more than 0.5; {time:.1} ms"
            );
        }
    }
}

#[test]
#[ignore = "something to profile"]
fn profile() {
    let lanes = std::env::var("LANES").map_or(16, |lanes| lanes.parse().unwrap());
    for body in [m2(), m4(), m8()] {
        let drives: Vec<_> = (0..16).map(|n| gait(body.actuators, n + 1, n % 2 == 0)).collect();
        let mut simulation = model("articulated").unwrap().prepare(&body, &settings()).unwrap();
        drives.chunks(lanes).for_each(|some| drop(simulation.run(some)));
    }
}
