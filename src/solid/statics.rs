//! Equilibria of an actuator, found with Newton's method, and how it gives way.

use nalgebra::{DVector, Vector3};

use super::factor::BlockFactor;
use super::freedoms::{Assembled, Freedoms, Parity};
use super::mesh::{Face, Mesh};
use super::rubber::{Forces, Moduli, Points, Stiffness};
use super::surface::{self, FaceForces, FaceStiffness, Fibres, Nodes};
use super::{Casting, Load};

/// The plate at the tip is so much stiffer than the rubber.
const RIGID: f64 = 100.0;
/// Poisson's ratio of the plate.
const PLATE_POISSON: f64 = 0.3;
/// Steps of Newton's method: a good start needs four or five.
const STEPS: usize = 25;
/// The longest step, and where steps end, as shares of the height.
const LONGEST: f64 = 0.5;
const SHORTEST: f64 = 1e-6;
/// The share of a load that is added first, and after how many good steps a share may be twice as large again.
const FIRST_SHARE: f64 = 0.125;
const MANY_GOOD: usize = 4;
/// The smallest share of a load that is added at once.
const LEAST_SHARE: f64 = 1.0 / 256.0;

/// A motion of the tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum TipMotion {
    /// Towards the upper side.
    Bend,
    /// To the side.
    Sideways,
    /// About the axis.
    Twist,
}

/// Why there is no equilibrium: up to which share of the load there was one.
#[derive(Clone, Copy, Debug, thiserror::Error, PartialEq)]
pub enum Lost {
    /// The stiffness is lost: it balloons, or it folds.
    #[error("it buckles at {:.0} % of the load", 100.0 * .0)]
    Buckles(f64),
    /// The steps do not come to an end.
    #[error("no equilibrium was found beyond {:.0} % of the load", 100.0 * .0)]
    Diverges(f64),
}

/// Where the nodes are, m.
#[derive(Clone, Debug)]
pub(super) struct Deformed {
    nodes: Vec<[f64; 3]>,
}

/// An actuator in elements.
#[derive(Clone, Debug)]
pub(super) struct ElasticBody {
    mesh: Mesh,
    points: Vec<Points>,
    rubber: Moduli,
    plate: Moduli,
    winding: f64,
    sheet: (Vec<Face>, f64),
    /// The points that a thread leads through, from the base to the plate.
    thread: Vec<Vec<(usize, f64)>>,
    /// The z axis of the tip, as weights of nodes.
    tip: Vec<(usize, f64)>,
    height: f64,
    even: Freedoms,
    odd: Freedoms,
}

impl ElasticBody {
    /// In so many layers along its length, and so many elements through a wall.
    pub(super) fn new(casting: &Casting, layers: usize, fineness: usize) -> Self {
        let mesh = Mesh::new(casting, layers, fineness);
        let (even, odd) = (Freedoms::new(&mesh, Parity::Even), Freedoms::new(&mesh, Parity::Odd));
        let place = |node: usize| mesh.nodes[node];
        let last = mesh.planes.len() - 1;
        let upper = mesh.point(last, 1.0);
        let lower = mesh.point(last, 0.0);
        Self {
            points: mesh.solids.iter().map(|solid| Points::new(&solid.nodes.map(place))).collect(),
            rubber: Moduli::new(casting.young, casting.poisson),
            plate: Moduli::new(RIGID * casting.young, PLATE_POISSON),
            winding: casting.winding,
            sheet: (mesh.upper_side(), casting.sheet),
            thread: (0..=2 * layers).map(|plane| mesh.point(plane, casting.thread)).collect(),
            tip: upper.iter().zip(&lower).map(|(&(node, a), (_, b))| (node, a - b)).collect(),
            height: casting.outline.height(),
            even,
            odd,
            mesh,
        }
    }

    /// Without a load.
    pub(super) fn rest(&self) -> Deformed {
        Deformed { nodes: self.mesh.nodes.clone() }
    }

    /// How far the tip is bent against the base (rad), within half a turn to either side.
    pub(super) fn bend(&self, state: &Deformed) -> f64 {
        let up = point(&self.tip, state);
        libm::atan2(-up.x, up.z)
    }

    /// The volume that the hole encloses, m^3.
    #[cfg(test)]
    pub(super) fn hole(&self, state: &Deformed) -> f64 {
        let volume = |(face, sign): &(Face, f64)| {
            let (mut forces, mut stiffness) = (FaceForces::zeros(), FaceStiffness::zeros());
            sign * surface::volume(&places(face, &state.nodes), 0.0, &mut forces, &mut stiffness)
        };
        2.0 * self.mesh.hole.iter().map(volume).sum::<f64>()
    }

    /// The equilibrium under a load that grows from nothing. `seen` is told each share of the load on the way, and the state there: all
    /// shares are multiples of a power of two, and each quarter is among them.
    pub(super) fn loaded(&self, load: Load, seen: &mut dyn FnMut(f64, &Deformed)) -> Result<Deformed, Lost> {
        self.moved((&self.rest(), Load::default()), load, seen)
    }

    /// The equilibrium under another load, to which that of a state changes bit by bit.
    pub(super) fn moved(
        &self,
        (from, begin): (&Deformed, Load),
        end: Load,
        seen: &mut dyn FnMut(f64, &Deformed),
    ) -> Result<Deformed, Lost> {
        let (mut state, mut before) = (from.clone(), None::<(Deformed, f64)>);
        let (mut share, mut step, mut good) = (0.0, FIRST_SHARE, 0);
        while share < 1.0 {
            // Steps get longer again, but shares stay multiples of them.
            if good >= MANY_GOOD && step < FIRST_SHARE && share % (2.0 * step) == 0.0 {
                (step, good) = (2.0 * step, 0);
            }
            let next = f64::min(share + step, 1.0);
            // It goes on as it did.
            let start = before.as_ref().map_or_else(
                || state.clone(),
                |(older, at)| further(older, &state, (next - share) / (share - at)),
            );
            let found = self
                .equilibrium(&start, begin.mixed(end, next))
                .or_else(|_| self.equilibrium(&state, begin.mixed(end, next)));
            match found {
                Ok(found) => {
                    before = Some((std::mem::replace(&mut state, found), share));
                    share = next;
                    good += 1;
                    seen(share, &state);
                }
                Err(_) if step > LEAST_SHARE => {
                    (step, good) = (0.5 * step, 0);
                }
                Err(Lost::Buckles(_)) => return Err(Lost::Buckles(share)),
                Err(Lost::Diverges(_)) => return Err(Lost::Diverges(share)),
            }
        }
        Ok(state)
    }

    /// The equilibrium under a load, from a state that is near.
    pub(super) fn equilibrium(&self, from: &Deformed, load: Load) -> Result<Deformed, Lost> {
        let mut state = from.clone();
        for _ in 0..STEPS {
            let sum = self.sum(&state, load, &self.even).ok_or(Lost::Diverges(0.0))?;
            let step = BlockFactor::new(sum.stiffness).ok_or(Lost::Buckles(0.0))?.solve(sum.forces);
            let longest = step.iter().map(|part| part.amax()).fold(0.0, f64::max);
            if !longest.is_finite() || longest > 20.0 * self.height {
                return Err(Lost::Diverges(0.0));
            }
            let share = (LONGEST * self.height / longest).min(1.0);
            for ((node, axis), moved) in self.even.values(&step) {
                state.nodes[node][axis] -= share * moved;
            }
            if longest < SHORTEST * self.height {
                return Ok(state);
            }
        }
        Err(Lost::Diverges(0.0))
    }

    /// How far the tip moves for each moment, rad / (N m), about a state.
    pub(super) fn compliance(&self, state: &Deformed, load: Load, motion: TipMotion) -> Result<f64, Lost> {
        let freedoms = if motion == TipMotion::Bend { &self.even } else { &self.odd };
        let sum = self.sum(state, load, freedoms).ok_or(Lost::Diverges(1.0))?;
        let factor = BlockFactor::new(sum.stiffness).ok_or(Lost::Buckles(1.0))?;
        let slope = self.slope(state, motion, freedoms);
        let moved = factor.solve(slope.clone());
        // Half of the moment acts on each half.
        Ok(0.5 * slope.iter().zip(&moved).map(|(slope, moved)| slope.dot(moved)).sum::<f64>())
    }

    /// How the angle of a motion changes with the degrees of freedom, rad/m.
    fn slope(&self, state: &Deformed, motion: TipMotion, freedoms: &Freedoms) -> Vec<DVector<f64>> {
        let mut slope = freedoms.zeros();
        let rest = &self.mesh.nodes;
        let nodes = self.mesh.planes.last().map_or(&[][..], |plane| &plane[..]);
        let middle = nodes.iter().map(|&node| rest[node][2]).sum::<f64>() / nodes.len() as f64;
        match motion {
            TipMotion::Bend => {
                let up = point(&self.tip, state);
                let square = up.x * up.x + up.z * up.z;
                for &(node, weight) in &self.tip {
                    freedoms.put(&mut slope, (node, 0), -weight * up.z / square);
                    freedoms.put(&mut slope, (node, 2), weight * up.x / square);
                }
            }
            TipMotion::Sideways => {
                let squares: f64 = nodes.iter().map(|&node| rest[node][1] * rest[node][1]).sum();
                for &node in nodes {
                    freedoms.put(&mut slope, (node, 0), -rest[node][1] / squares);
                }
            }
            TipMotion::Twist => {
                let arm = |node: usize| (rest[node][1], rest[node][2] - middle);
                let squares: f64 =
                    nodes.iter().map(|&node| arm(node).0 * arm(node).0 + arm(node).1 * arm(node).1).sum();
                for &node in nodes {
                    freedoms.put(&mut slope, (node, 2), arm(node).0 / squares);
                    freedoms.put(&mut slope, (node, 1), -arm(node).1 / squares);
                }
            }
        }
        slope
    }

    /// Slope and curvature of the energy of one half. None where an element is turned inside out.
    fn sum<'f>(&self, state: &Deformed, load: Load, freedoms: &'f Freedoms) -> Option<Assembled<'f>> {
        let mut sum = Assembled::new(freedoms);
        let mut stiffness = Box::new(Stiffness::zeros());
        for (solid, points) in self.mesh.solids.iter().zip(&self.points) {
            let mut forces = Forces::zeros();
            stiffness.fill(0.0);
            let moduli = if solid.is_plate { self.plate } else { self.rubber };
            points.energy(&solid.nodes.map(|node| state.nodes[node]), moduli, &mut forces, &mut stiffness)?;
            sum.add(&solid.nodes, forces.as_slice(), |i, j| stiffness[(i, j)]);
        }
        if load.pressure != 0.0 {
            for (face, sign) in &self.mesh.hole {
                self.add_face(&mut sum, face, |forces, stiffness| {
                    surface::volume(&places(face, &state.nodes), -load.pressure * sign, forces, stiffness);
                });
            }
        }
        let kinds =
            [(&self.mesh.skin, Fibres::Around, self.winding), (&self.sheet.0, Fibres::Along, self.sheet.1)];
        for (faces, fibres, stiff) in kinds.into_iter().filter(|(_, _, stiff)| *stiff > 0.0) {
            for face in faces {
                let (rest, now) = (places(face, &self.mesh.nodes), places(face, &state.nodes));
                self.add_face(&mut sum, face, |forces, stiffness| {
                    surface::fibres(&rest, &now, (fibres, stiff), forces, stiffness);
                });
            }
        }
        if load.pull != 0.0 {
            for ends in self.thread.windows(2) {
                add_thread(&mut sum, state, ends, 0.5 * load.pull);
            }
        }
        if load.moment != 0.0 {
            self.add_moment(&mut sum, state, 0.5 * load.moment);
        }
        Some(sum)
    }

    fn add_face(
        &self,
        sum: &mut Assembled<'_>,
        face: &Face,
        energy: impl FnOnce(&mut FaceForces, &mut FaceStiffness),
    ) {
        let (mut forces, mut stiffness) = (FaceForces::zeros(), FaceStiffness::zeros());
        energy(&mut forces, &mut stiffness);
        sum.add(face, forces.as_slice(), |i, j| stiffness[(i, j)]);
    }

    /// The energy of a moment on the tip: minus the moment times the bend.
    fn add_moment(&self, sum: &mut Assembled<'_>, state: &Deformed, moment: f64) {
        let up = point(&self.tip, state);
        let square = up.x * up.x + up.z * up.z;
        // Slope and curvature of the bend, atan2(-x, z), in x and z.
        let slope = [-up.z / square, 0.0, up.x / square];
        let (same, cross) =
            (2.0 * up.x * up.z / (square * square), (up.z * up.z - up.x * up.x) / (square * square));
        let curvature = [[same, 0.0, cross], [0.0; 3], [cross, 0.0, -same]];
        let nodes: Vec<usize> = self.tip.iter().map(|(node, _)| *node).collect();
        let force: Vec<f64> =
            self.tip.iter().flat_map(|(_, weight)| slope.map(|slope| -moment * slope * weight)).collect();
        sum.add(&nodes, &force, |i, j| {
            -moment * curvature[i % 3][j % 3] * self.tip[i / 3].1 * self.tip[j / 3].1
        });
    }
}

/// The energy of a stretch of a thread: its pull times its length.
fn add_thread(sum: &mut Assembled<'_>, state: &Deformed, ends: &[Vec<(usize, f64)>], pull: f64) {
    let [from, to] = ends else { return };
    let way = point(to, state) - point(from, state);
    let length = way.norm();
    let along = way / length;
    let across = (nalgebra::Matrix3::identity() - along * along.transpose()) * (pull / length);
    let all: Vec<(usize, f64)> =
        from.iter().map(|&(node, weight)| (node, -weight)).chain(to.iter().copied()).collect();
    let nodes: Vec<usize> = all.iter().map(|(node, _)| *node).collect();
    let force: Vec<f64> =
        all.iter().flat_map(|(_, weight)| [0, 1, 2].map(|axis| pull * along[axis] * weight)).collect();
    sum.add(&nodes, &force, |i, j| across[(i % 3, j % 3)] * all[i / 3].1 * all[j / 3].1);
}

/// Where a point is that moves with some nodes.
fn point(weights: &[(usize, f64)], state: &Deformed) -> Vector3<f64> {
    weights.iter().map(|(node, weight)| Vector3::from(state.nodes[*node]) * *weight).sum()
}

fn places(face: &Face, nodes: &[[f64; 3]]) -> Nodes {
    face.map(|node| Vector3::from(nodes[node]))
}

/// A state that lies beyond another, on the way from an older one.
fn further(older: &Deformed, state: &Deformed, share: f64) -> Deformed {
    let beyond = |(old, now): (&[f64; 3], &[f64; 3])| {
        std::array::from_fn(|axis| now[axis] + share * (now[axis] - old[axis]))
    };
    Deformed { nodes: older.nodes.iter().zip(&state.nodes).map(beyond).collect() }
}
