//! Contacts with Coulomb friction: projected Gauss-Seidel, one contact after the other, with the cone itself.

use nalgebra::{Matrix3, Vector3, Vector6};

use super::block::{Rows, transposed_product, zeros};
use super::factor::TreeFactor;
use super::links::{End, MEND, Motor, Place};
use crate::simulate::contacts::{GROUND_SOFTNESS, PAIR_SOFTNESS, Sweeps};

/// So deep an overlap is left, m, so that contacts last.
const SLOP: f64 = 2e-5;
/// No faster than this, m/s.
const MEND_SPEED: f64 = 0.2;
/// The columns of the rows of a contact: the normal, two directions along the surface, and one of zeros, which fills the vectors of the processor.
pub(super) const WAYS: usize = 4;

/// A contact in a step, in the factorised space: its speed is the product of its rows and the bodies' own vectors.
#[derive(Clone, Debug)]
pub(super) struct Contact {
    /// Along the paths of its bodies to the root: the normal and two directions along the surface.
    rows: Vec<(usize, Rows<WAYS>)>,
    own: Matrix3<f64>,
    /// What makes an impulse the root of twice an energy: the measure in which all changes are compared.
    measure: f64,
    /// The least speed apart, m/s.
    least: f64,
    /// The speed at which it gives way for an impulse of one, 1/kg.
    softness: f64,
    friction: f64,
    /// Impulses along the three directions, N s.
    pub(super) impulse: Vector3<f64>,
    /// The number that remembers them.
    pub(super) slot: usize,
}

/// Where two bodies, or a body and the ground, may touch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    pub(super) body: usize,
    pub(super) other: Option<usize>,
    pub(super) point: Vector3<f64>,
    /// Away from the other one.
    pub(super) normal: Vector3<f64>,
    pub(super) gap: f64,
    pub(super) friction: f64,
    pub(super) slot: usize,
}

impl Contact {
    /// A contact, of a body with a mass in kg. It begins with the impulse of the last step.
    #[inline(always)]
    pub(super) fn new(
        spot: &Spot,
        places: &[Place],
        factor: &TreeFactor,
        last: Vector3<f64>,
        (step, mass): (f64, f64),
        room: &mut [Rows<WAYS>],
    ) -> Self {
        let normal = spot.normal;
        let first = if normal.y.abs() > 0.9 { Vector3::x() } else { Vector3::y() };
        let first = (first - normal * normal.dot(&first)).normalize();
        let directions = [normal, first, normal.cross(&first)];
        let jacobian = |body: usize, sign: f64| {
            let arm = spot.point - places[body].centre;
            let mut rows: Rows<WAYS> = zeros();
            for (column, way) in directions.into_iter().enumerate() {
                let turn = arm.cross(&way);
                let along = [way.x, way.y, way.z, turn.x, turn.y, turn.z];
                rows.iter_mut().zip(along).for_each(|(row, value)| row[column] = value * sign);
            }
            rows
        };
        let mut path: Vec<usize> = factor.path(spot.body).collect();
        // No room is in use: a contact is between two bodies.
        room[spot.body] = jacobian(spot.body, 1.0);
        if let Some(other) = spot.other {
            path.extend(factor.path(other));
            room[other] = jacobian(other, -1.0);
            path.sort_unstable_by(|a, b| b.cmp(a));
            path.dedup();
        }
        let rows = factor.forward_rows(&path, room);
        let mut own = Matrix3::zeros();
        for (_, rows) in &rows {
            let squares = transposed_product(rows, rows);
            own += Matrix3::from_fn(|row, column| squares[row][column]);
        }
        let measure = own.norm().sqrt();
        let deep = (-spot.gap - SLOP).max(0.0);
        let least = if spot.gap > 0.0 { -spot.gap / step } else { (deep * MEND / step).min(MEND_SPEED) };
        let softness = if spot.other.is_some() { PAIR_SOFTNESS } else { GROUND_SOFTNESS } / mass;
        Self { rows, own, measure, least, softness, friction: spot.friction, impulse: last, slot: spot.slot }
    }

    /// Adds an impulse to what the bodies have.
    #[inline(always)]
    fn push(&self, impulse: &Vector3<f64>, vectors: &mut [[f64; 6]]) {
        for (body, rows) in &self.rows {
            for (value, [normal, first, second, _]) in vectors[*body].iter_mut().zip(rows) {
                *value += normal * impulse.x + first * impulse.y + second * impulse.z;
            }
        }
    }

    /// The speeds along its three directions.
    #[inline(always)]
    fn speeds(&self, vectors: &[[f64; 6]]) -> Vector3<f64> {
        let mut speeds = [0.0; WAYS];
        for (body, rows) in &self.rows {
            let mut sums = [0.0; WAYS];
            for (row, value) in rows.iter().zip(&vectors[*body]) {
                sums.iter_mut().zip(row).for_each(|(sum, way)| *sum += way * value);
            }
            speeds.iter_mut().zip(sums).for_each(|(speed, sum)| *speed += sum);
        }
        Vector3::new(speeds[0], speeds[1], speeds[2])
    }

    /// Finds its impulse while the others keep theirs. By how much it changes.
    #[inline(always)]
    fn relax(&mut self, vectors: &mut [[f64; 6]]) -> f64 {
        let speeds = self.speeds(vectors);
        let excess = speeds.x - self.least + self.softness * self.impulse.x;
        let normal = (self.impulse.x - excess / (self.own[(0, 0)] + self.softness)).max(0.0);
        let change = normal - self.impulse.x;
        // The tangents know what the normal changes.
        let along =
            Vector3::new(0.0, speeds.y + self.own[(1, 0)] * change, speeds.z + self.own[(2, 0)] * change);
        let size = self.own[(1, 1)].max(self.own[(2, 2)]);
        let mut tangent = Vector3::new(0.0, self.impulse.y, self.impulse.z) - along / size;
        let (most, length) = (self.friction * normal, tangent.norm());
        if length > most {
            tangent *= if length > 0.0 { most / length } else { 0.0 };
        }
        let now = Vector3::new(normal, tangent.y, tangent.z);
        let by = now - self.impulse;
        self.push(&by, vectors);
        self.impulse = now;
        by.norm() * self.measure
    }

    /// How much it does.
    #[inline(always)]
    fn size(&self) -> f64 {
        self.impulse.norm() * self.measure
    }
}

/// What holds of the speed of a link at the end of a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Law {
    /// A drive with a limit.
    Motor(Motor),
    /// An end of its range.
    End(End),
}

impl Law {
    /// What an impulse can be.
    fn clamp(self, impulse: f64) -> f64 {
        match self {
            Self::Motor(motor) => impulse.clamp(-motor.most, motor.most),
            Self::End(End { away, .. }) => (impulse * away).max(0.0) * away,
        }
    }
}

/// A condition on a link in a step, in the factorised space.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    rows: Vec<(usize, Rows<1>)>,
    own: f64,
    law: Law,
    pub(super) impulse: f64,
}

impl Drive {
    /// A condition on a link between a body and its parent, by what its speed is along their velocities and spins. It begins with the impulse of the
    /// last step.
    pub(super) fn new(
        (law, last): (Law, f64),
        (body, parent): (usize, usize),
        along: [Vector6<f64>; 2],
        factor: &TreeFactor,
        room: &mut [Rows<1>],
    ) -> Self {
        let path: Vec<usize> = factor.path(body).collect();
        for (body, along) in [body, parent].into_iter().zip(along) {
            room[body].iter_mut().zip(&along).for_each(|([sum], along)| *sum += along);
        }
        let rows = factor.forward_rows(&path, room);
        let own = rows.iter().map(|(_, row)| row.iter().map(|[value]| value * value).sum::<f64>()).sum();
        Self { rows, own, law, impulse: law.clamp(last) }
    }

    /// Adds an impulse to what the bodies have.
    #[inline(always)]
    fn push(&self, impulse: f64, vectors: &mut [[f64; 6]]) {
        for (body, row) in &self.rows {
            vectors[*body].iter_mut().zip(row).for_each(|(value, [along])| *value += along * impulse);
        }
    }

    /// Finds its impulse while all others keep theirs. By how much it changes, as an impulse of what moves.
    #[inline(always)]
    fn relax(&mut self, vectors: &mut [[f64; 6]]) -> f64 {
        let along = |(body, row): &(usize, Rows<1>)| -> f64 {
            row.iter().zip(&vectors[*body]).map(|([along], value)| along * value).sum()
        };
        let speed: f64 = self.rows.iter().map(along).sum();
        let change = match self.law {
            Law::Motor(Motor { offset, slope, .. }) => {
                (offset + speed + self.impulse / slope) / (self.own + 1.0 / slope)
            }
            Law::End(End { away, least }) => (speed - least * away) / self.own,
        };
        let now = self.law.clamp(self.impulse - change);
        let by = now - self.impulse;
        self.push(by, vectors);
        self.impulse = now;
        by.abs() * self.own.sqrt()
    }

    fn size(&self) -> f64 {
        self.impulse.abs() * self.own.sqrt()
    }
}

/// Finds the impulses of all drives and contacts.
#[inline(always)]
pub(super) fn solve(
    drives: &mut [Drive],
    contacts: &mut [Contact],
    vectors: &mut [[f64; 6]],
    Sweeps { most, tolerance }: Sweeps,
) {
    for drive in drives.iter() {
        drive.push(drive.impulse, vectors);
    }
    for contact in contacts.iter() {
        contact.push(&contact.impulse, vectors);
    }
    for _ in 0..most {
        let mut changed = 0.0;
        for drive in drives.iter_mut() {
            changed += drive.relax(vectors);
        }
        for contact in contacts.iter_mut() {
            changed += contact.relax(vectors);
        }
        let all: f64 = contacts.iter().map(Contact::size).chain(drives.iter().map(Drive::size)).sum();
        if changed <= tolerance * all {
            return;
        }
    }
}
