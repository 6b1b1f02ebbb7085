//! Bodies of balls and springs to try the solvers on.

use nalgebra::{Isometry3, Vector3};

use crate::design::assembly::{Assembly, Element, Shape, Spring, Swelling};
use crate::simulate::{Settings, Targets};

/// Distance between balls, m.
pub(crate) const PITCH: f64 = 0.01;
/// Of a ball, kg.
pub(crate) const MASS: f64 = 5e-4;
/// Of a spring, N/m and N s/m.
pub(crate) const STIFFNESS: f64 = 200.0;
pub(crate) const DAMPING: f64 = 0.05;
/// Of every surface.
pub(crate) const FRICTION: f64 = 0.6;

/// Of balls for so many seconds.
pub(crate) fn lattice_settings(duration: f64) -> Settings {
    let fine = 1.0 / 2400.0;
    Settings { step: fine, duration, ground_friction: FRICTION, iterations: 30, ..super::settings() }
}

/// Balls in cells, with springs between those that share a face or an edge.
pub(crate) fn lattice(cells: &[[i32; 3]]) -> Assembly {
    let place = |cell: &[i32; 3]| Vector3::from(cell.map(|n| f64::from(n) * PITCH));
    let ball = |cell: &[i32; 3]| Element {
        shape: Shape::Ball { radius: PITCH / 2.0 },
        pose: Isometry3::from(place(cell)),
        mass: MASS,
        friction: FRICTION,
    };
    let mut springs = Vec::new();
    for (to, there) in cells.iter().enumerate() {
        for (from, here) in cells[..to].iter().enumerate() {
            let apart = [0, 1, 2].map(|axis: usize| (there[axis] - here[axis]).abs());
            if apart.iter().all(|n| *n <= 1) && apart.iter().sum::<i32>() <= 2 {
                springs.push(Spring { from, to, stiffness: STIFFNESS, damping: DAMPING });
            }
        }
    }
    let elements = cells.iter().map(ball).collect();
    Assembly { elements, springs, ..Assembly::default() }
}

/// The cells of a box, x fastest, from its lowest corner.
pub(crate) fn cells(from: [i32; 3], count: [i32; 3]) -> Vec<[i32; 3]> {
    let [x, y, z] = count;
    let cell = |n: i32| [from[0] + n % x, from[1] + n / x % y, from[2] + n / (x * y)];
    (0..x * y * z).map(cell).collect()
}

/// Bends cells by an actuator of their own: those whose coordinate along an axis is above a middle grow, the others shrink.
pub(crate) fn bend(body: &mut Assembly, cells: &[[i32; 3]], which: impl Fn(&[i32; 3]) -> f64) {
    let actuator = body.actuators;
    body.actuators += 1;
    for (element, cell) in cells.iter().enumerate() {
        let gain = which(cell);
        if gain != 0.0 {
            body.swellings.push(Swelling { element, actuator, gain });
        }
    }
}

/// A trunk of 9 x 3 x 5 on four legs of 2 x 6 x 2, each bent forwards and backwards: 231 balls, 4 actuators. Mirrored in z.
pub(crate) fn quadruped() -> Assembly {
    let mut all = cells([0, 6, 0], [9, 3, 5]);
    let feet = [[0, 0, 0], [0, 0, 3], [7, 0, 0], [7, 0, 3]];
    feet.iter().for_each(|foot| all.extend(cells(*foot, [2, 6, 2])));
    let mut body = lattice(&all);
    for [x, _, z] in feet {
        bend(&mut body, &all, |cell| {
            let inside = cell[1] < 6 && (x..x + 2).contains(&cell[0]) && (z..z + 2).contains(&cell[2]);
            if !inside {
                0.0
            } else if cell[0] == x {
                1.0
            } else {
                -1.0
            }
        });
    }
    body
}

/// Legs bent to and fro by a strain, the pairs by turns, or mirrored ones together.
pub(crate) fn trot(actuators: usize, strain: f64, mirrored: bool) -> Targets {
    let interval = 1.0 / 60.0;
    let mut angles = Vec::new();
    for sample in 0..=900 {
        for actuator in 0..actuators {
            let phase = if mirrored { actuator / 2 } else { (actuator + actuator / 2) % 2 };
            let turn = f64::from(sample) * interval * 1.5 + 0.5 * phase as f64;
            angles.push(strain * libm::sin(std::f64::consts::TAU * turn));
        }
    }
    Targets { interval, actuators, angles }
}
