//! Closed forms, and values of another program.
#![expect(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::PI;

use super::section::{Hole, Outline};
use super::statics::{Motion, Solid};
use super::{Casting, Load};

const SQUARE: Outline = Outline::Box { width: 16e-3, height: 16e-3 };

fn beam(outline: Outline, length: f64) -> Casting {
    Casting {
        outline,
        hole: None,
        length,
        young: 0.6e6,
        poisson: 0.49,
        winding: 0.0,
        sheet: 0.0,
        thread: 0.0,
    }
}

fn near(found: f64, due: f64, share: f64) {
    assert!((found / due - 1.0).abs() < share, "{found} instead of {due}");
}

/// The slope of a compliance with the length does not feel the ends: there it is a beam.
fn slope(outline: Outline, motion: Motion) -> f64 {
    let compliance = |length: f64, layers| {
        let solid = Solid::new(&beam(outline, length), layers, 1);
        solid.compliance(&solid.rest(), Load::default(), motion).unwrap()
    };
    (compliance(0.12, 12) - compliance(0.08, 8)) / 0.04
}

#[test]
fn a_bar_bends_and_twists_as_beams_do() {
    let fourth = 16e-3_f64.powi(4);
    let shear = 0.6e6 / (2.0 * 1.49);
    near(slope(SQUARE, Motion::Bend), 12.0 / (0.6e6 * fourth), 1e-3);
    near(slope(SQUARE, Motion::Sideways), 12.0 / (0.6e6 * fourth), 1e-3);
    // Saint-Venant: 0.1406 of the fourth power of a square's side.
    near(slope(SQUARE, Motion::Twist), 1.0 / (shear * 0.1406 * fourth), 0.01);
    let round = Outline::Round { radius: 9e-3 };
    let second = PI * 9e-3_f64.powi(4) / 4.0;
    near(slope(round, Motion::Bend), 1.0 / (0.6e6 * second), 5e-3);
    near(slope(round, Motion::Twist), 1.0 / (shear * 2.0 * second), 5e-3);
}

#[test]
fn a_tube_bends_as_its_section_says() {
    let hole = |radius| Some(Hole { outline: Outline::Round { radius }, z: 0.0 });
    let compliance = |length: f64, layers| {
        let casting = Casting { hole: hole(5e-3), ..beam(Outline::Round { radius: 9e-3 }, length) };
        let solid = Solid::new(&casting, layers, 1);
        solid.compliance(&solid.rest(), Load::default(), Motion::Bend).unwrap()
    };
    let second = PI * (9e-3_f64.powi(4) - 5e-3_f64.powi(4)) / 4.0;
    near((compliance(0.12, 12) - compliance(0.08, 8)) / 0.04, 1.0 / (0.6e6 * second), 5e-3);
}

#[test]
fn a_moment_bends_a_slender_bar_into_an_arc() {
    let solid = Solid::new(&beam(SQUARE, 0.16), 12, 1);
    let straight = solid.compliance(&solid.rest(), Load::default(), Motion::Bend).unwrap();
    let moment = 0.5 / straight;
    let bent = solid.loaded(Load { moment, ..Load::default() }, &mut |_, _| {}).unwrap();
    // Rubber is a little softer in compression and firmer in tension: the moment of an arc is that of a beam to the second order.
    near(solid.bend(&bent), 0.5, 0.01);
}

#[test]
fn air_stretches_a_wound_tube_by_the_force_on_its_plate() {
    let (radius, hole, pressure) = (9e-3_f64, 5e-3_f64, 5e3);
    let casting = Casting {
        hole: Some(Hole { outline: Outline::Round { radius: hole }, z: 0.0 }),
        poisson: 0.3,
        ..beam(Outline::Round { radius }, 0.1)
    };
    let solid = Solid::new(&casting, 10, 1);
    let volume = solid.hole(&solid.rest());
    near(volume, PI * hole * hole * 0.1, 2e-3);
    let full = solid.loaded(Load { pressure, ..Load::default() }, &mut |_, _| {}).unwrap();
    assert!(solid.bend(&full).abs() < 1e-9, "it bends by {}", solid.bend(&full));
    // Lamé: a closed thick tube under internal pressure, E = 0.6 MPa, nu = 0.3. Axial strain and strain of the bore.
    let k = hole * hole / (radius * radius - hole * hole);
    let (axial, hoop, radial) =
        (pressure * k, pressure * k * (1.0 + radius * radius / (hole * hole)), -pressure);
    let young = 0.6e6;
    let strain = |along: f64, across: [f64; 2]| (along - 0.3 * (across[0] + across[1])) / young;
    let grown = strain(axial, [hoop, radial]) + 2.0 * strain(hoop, [axial, radial]);
    near(solid.hole(&full) / volume - 1.0, grown, 0.06);
}

#[test]
fn a_thread_bends_by_its_pull_and_its_distance_from_the_axis() {
    let casting = Casting { thread: 6e-3, ..beam(SQUARE, 0.08) };
    let solid = Solid::new(&casting, 8, 1);
    let compliance = solid.compliance(&solid.rest(), Load::default(), Motion::Bend).unwrap();
    let pull = 0.2;
    let pulled = solid.loaded(Load { pull, ..Load::default() }, &mut |_, _| {}).unwrap();
    near(solid.bend(&pulled), pull * 6e-3 * compliance, 0.03);
}
