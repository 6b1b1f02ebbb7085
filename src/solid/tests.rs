//! Closed forms, and values of another program.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::rubber::{Forces, Moduli, Points, Stiffness};
use super::section::{Hole, Outline};
use super::statics::{ElasticBody, Lost, TipMotion};
use super::surface::{self, FaceForces, FaceStiffness, Fibres};
use super::{Casting, Load, fit};

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
fn slope(outline: Outline, motion: TipMotion) -> f64 {
    let compliance = |length: f64, layers| {
        let solid = ElasticBody::new(&beam(outline, length), layers, 1);
        solid.compliance(&solid.rest(), Load::default(), motion).unwrap()
    };
    (compliance(0.12, 12) - compliance(0.08, 8)) / 0.04
}

#[test]
fn a_bar_bends_and_twists_as_beams_do() {
    let fourth = 16e-3_f64.powi(4);
    let shear = 0.6e6 / (2.0 * 1.49);
    near(slope(SQUARE, TipMotion::Bend), 12.0 / (0.6e6 * fourth), 1e-3);
    near(slope(SQUARE, TipMotion::Sideways), 12.0 / (0.6e6 * fourth), 1e-3);
    // Saint-Venant: 0.1406 of the fourth power of a square's side.
    near(slope(SQUARE, TipMotion::Twist), 1.0 / (shear * 0.1406 * fourth), 0.01);
    let round = Outline::Round { radius: 9e-3 };
    let second = PI * 9e-3_f64.powi(4) / 4.0;
    near(slope(round, TipMotion::Bend), 1.0 / (0.6e6 * second), 5e-3);
    near(slope(round, TipMotion::Twist), 1.0 / (shear * 2.0 * second), 5e-3);
}

#[test]
fn a_tube_bends_as_its_section_says() {
    let hole = |radius| Some(Hole { outline: Outline::Round { radius }, z: 0.0 });
    let compliance = |length: f64, layers| {
        let casting = Casting { hole: hole(5e-3), ..beam(Outline::Round { radius: 9e-3 }, length) };
        let solid = ElasticBody::new(&casting, layers, 1);
        solid.compliance(&solid.rest(), Load::default(), TipMotion::Bend).unwrap()
    };
    let second = PI * (9e-3_f64.powi(4) - 5e-3_f64.powi(4)) / 4.0;
    near((compliance(0.12, 12) - compliance(0.08, 8)) / 0.04, 1.0 / (0.6e6 * second), 5e-3);
}

#[test]
fn a_moment_bends_a_slender_bar_into_an_arc() {
    let solid = ElasticBody::new(&beam(SQUARE, 0.16), 12, 1);
    let straight = solid.compliance(&solid.rest(), Load::default(), TipMotion::Bend).unwrap();
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
    let solid = ElasticBody::new(&casting, 10, 1);
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
    let solid = ElasticBody::new(&casting, 8, 1);
    let compliance = solid.compliance(&solid.rest(), Load::default(), TipMotion::Bend).unwrap();
    let pull = 0.2;
    let pulled = solid.loaded(Load { pull, ..Load::default() }, &mut |_, _| {}).unwrap();
    near(solid.bend(&pulled), pull * 6e-3 * compliance, 0.03);
}

/// A finger of 80 x 16 x 16 mm with a chamber of 12 x 10 mm.
fn finger(z: f64, winding: f64, sheet: f64) -> Casting {
    let hole = Hole { outline: Outline::Box { width: 12e-3, height: 10e-3 }, z };
    Casting { hole: Some(hole), young: 0.94e6, winding, sheet, ..beam(SQUARE, 0.08) }
}

fn bends(casting: &Casting, pressure: f64) -> Vec<f64> {
    let solid = ElasticBody::new(casting, 10, 1);
    let mut bends = Vec::new();
    let mut seen = |share: f64, state: &_| {
        if (4.0 * share).fract() == 0.0 {
            bends.push(solid.bend(state).to_degrees());
        }
    };
    solid.loaded(Load { pressure, ..Load::default() }, &mut seen).unwrap();
    bends
}

/// Felupe on fine grids (`benches/peers/chamber.py`), deg at 30, 60, 90, 120 kPa. The grids here have one element through each wall.
#[test]
fn chambers_bend_as_with_felupe() {
    let both = bends(&finger(0.0, 2e5, 2e5), 120e3);
    for (found, due) in both.iter().zip([11.3, 26.15, 45.75, 73.3]) {
        near(*found, due, 0.06);
    }
    let wound = bends(&finger(-1e-3, 2e5, 0.0), 120e3);
    for (found, due) in wound.iter().zip([8.95, 21.1, 39.7, 66.9]) {
        near(*found, due, 0.06);
    }
    let bare = bends(&finger(-1e-3, 0.0, 0.0), 30e3);
    near(bare[3], 2.62, 0.03);
    let solid = ElasticBody::new(&finger(-1e-3, 0.0, 0.0), 10, 1);
    let compliance = solid.compliance(&solid.rest(), Load::default(), TipMotion::Bend).unwrap();
    near(1.0 / compliance, 0.0508, 0.01);
}

/// Without a winding the walls balloon: there is an end to what air can do, and it is found.
#[test]
fn a_chamber_without_a_winding_balloons() {
    let solid = ElasticBody::new(&finger(-1e-3, 0.0, 0.0), 6, 1);
    let lost = solid.loaded(Load { pressure: 120e3, ..Load::default() }, &mut |_, _| {}).unwrap_err();
    assert!(
        matches!(lost, Lost::Buckles(share) | Lost::Diverges(share) if share > 0.3 && share < 0.9),
        "{lost:?}"
    );
}

#[test]
fn a_long_finger_bends_beyond_half_a_turn() {
    let casting = Casting { thread: 6e-3, young: 0.3e6, ..beam(Outline::Round { radius: 9e-3 }, 0.0) };
    let fitted = fit(&casting, Load { pull: 6.0, ..Load::default() }, &[0.1, 0.15, 0.2], &|_| {}).unwrap();
    let driven = fitted.driven.unwrap();
    assert!(driven.bend.at(0.2) > 3.5, "{driven:?}");
    assert!(driven.curve.windows(2).all(|pair| pair[0].1 < pair[1].1), "{driven:?}");
    assert!(fitted.off < 0.02, "{}", fitted.off);
}

/// Places near some others: every node is moved by up to half a millimetre, always alike.
fn moved<const N: usize>(nodes: [[f64; 3]; N]) -> [[f64; 3]; N] {
    std::array::from_fn(|n| {
        std::array::from_fn(|axis| nodes[n][axis] + 5e-4 * libm::sin((7 * n + 3 * axis + 1) as f64))
    })
}

/// The forces are the slope of the energy, and the stiffnesses the slope of the forces: differences over a step say so.
fn is_slope<const N: usize>(
    nodes: [[f64; 3]; N],
    size: f64,
    energy: impl Fn(&[[f64; 3]; N]) -> (f64, Vec<f64>, Vec<Vec<f64>>),
) {
    let step = 1e-7;
    let (_, forces, stiffness) = energy(&nodes);
    let (most, stiffest) = (
        forces.iter().fold(0.0_f64, |most, f| most.max(f.abs())),
        stiffness.iter().flatten().fold(0.0_f64, |most, k| most.max(k.abs())),
    );
    for freedom in (0..3 * N).step_by(5) {
        let at = |step: f64| {
            let mut nodes = nodes;
            nodes[freedom / 3][freedom % 3] += step;
            energy(&nodes)
        };
        let (before, after) = (at(-step), at(step));
        let slope = (after.0 - before.0) / (2.0 * step);
        assert!((slope - forces[freedom]).abs() < size * most, "{freedom}: {slope} {}", forces[freedom]);
        for (row, stiffness) in stiffness.iter().enumerate() {
            let slope = (after.1[row] - before.1[row]) / (2.0 * step);
            let due = stiffness[freedom];
            assert!((slope - due).abs() < size * stiffest, "{row} {freedom}: {slope} {due}");
        }
    }
}

/// Sums of a face as rows.
fn rows(energy: f64, forces: &FaceForces, stiffness: &FaceStiffness) -> (f64, Vec<f64>, Vec<Vec<f64>>) {
    let rows = (0..27).map(|row| stiffness.row(row).iter().copied().collect()).collect();
    (energy, forces.iter().copied().collect(), rows)
}

#[test]
fn forces_are_slopes_of_energies() {
    let cube: [[f64; 3]; 27] = std::array::from_fn(|n| [n / 9, n % 3, n / 3 % 3].map(|k| 5e-3 * k as f64));
    let points = Points::new(&cube);
    is_slope(moved(cube), 1e-5, |nodes| {
        let (mut forces, mut stiffness) = (Forces::zeros(), Box::new(Stiffness::zeros()));
        let energy = points.energy(nodes, Moduli::new(0.6e6, 0.49), &mut forces, &mut stiffness).unwrap();
        let rows = (0..81).map(|row| stiffness.row(row).iter().copied().collect()).collect();
        (energy, forces.iter().copied().collect(), rows)
    });
    let square: [[f64; 3]; 9] = std::array::from_fn(|n| [n / 3, 0, n % 3].map(|k| 5e-3 * k as f64 + 1e-2));
    let vectors = |nodes: &[[f64; 3]; 9]| nodes.map(Vector3::from);
    is_slope(moved(square), 1e-5, |nodes| {
        let (mut forces, mut stiffness) = (FaceForces::zeros(), FaceStiffness::zeros());
        let energy = surface::volume(&vectors(nodes), 1.0, &mut forces, &mut stiffness);
        rows(energy, &forces, &stiffness)
    });
    // Stretched, so that the winding pulls everywhere.
    let stretched = square.map(|node| node.map(|x| 1.2 * x));
    for direction in [Fibres::Around, Fibres::Along] {
        is_slope(moved(stretched), 1e-5, |nodes| {
            let (mut forces, mut stiffness) = (FaceForces::zeros(), FaceStiffness::zeros());
            let (rest, now) = (vectors(&square), vectors(nodes));
            let energy = surface::fibres(&rest, &now, (direction, 2e5), &mut forces, &mut stiffness);
            rows(energy, &forces, &stiffness)
        });
    }
}
