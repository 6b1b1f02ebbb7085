//! The cross-section of an actuator, cut into quadrilaterals of nine nodes. It is the half at y >= 0: the other half is its mirror image.

use std::f64::consts::PI;

/// What a cross-section looks like from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A rectangle.
    Box {
        /// Along y, m.
        width: f64,
        /// Along z, m.
        height: f64,
    },
    /// A circle.
    Round {
        /// In m.
        radius: f64,
    },
}

impl Outline {
    /// How high it is along z, m.
    #[must_use]
    pub fn height(self) -> f64 {
        match self {
            Self::Box { height, .. } => height,
            Self::Round { radius } => 2.0 * radius,
        }
    }

    /// Its area, m^2.
    #[must_use]
    pub fn area(self) -> f64 {
        match self {
            Self::Box { width, height } => width * height,
            Self::Round { radius } => PI * radius * radius,
        }
    }
}

/// The hole of a cross-section: a box in a box, a circle in a circle. Its middle lies on the z axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// Its edge.
    pub outline: Outline,
    /// The z coordinate of its middle, m.
    pub z: f64,
}

/// A quadrilateral: its nodes in rows of three.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Quad {
    pub(super) nodes: [usize; 9],
    /// Whether it lies in the hole: only the plates at the ends have it.
    pub(super) is_hole: bool,
}

/// The nodes of each edge of a quadrilateral, from end to end.
const EDGES: [[usize; 3]; 4] = [[0, 1, 2], [6, 7, 8], [0, 3, 6], [2, 5, 8]];

/// The grid of a cross-section.
#[derive(Clone, Debug, Default)]
pub(super) struct CrossSection {
    /// y and z of each node, m.
    pub(super) nodes: Vec<[f64; 2]>,
    pub(super) quads: Vec<Quad>,
    /// The edges of the hole, each with the quadrilateral of the wall that it belongs to.
    pub(super) inner: Vec<([usize; 3], usize)>,
    /// The edges of the outside.
    pub(super) outer: Vec<[usize; 3]>,
}

impl CrossSection {
    /// The grid of a cross-section. `fineness` is the number of quadrilaterals through a wall.
    pub(super) fn new(outline: Outline, hole: Option<Hole>, fineness: usize) -> Self {
        let mut section = Self::default();
        match outline {
            Outline::Box { width, height } => section.boxes(width, height, hole, fineness),
            Outline::Round { radius } => section.rounds(radius, hole, fineness),
        }
        section.find_edges();
        section
    }

    fn boxes(&mut self, width: f64, height: f64, hole: Option<Hole>, fineness: usize) {
        let (mut ys, mut zs) = (vec![0.0, 0.5 * width], vec![-0.5 * height, 0.5 * height]);
        let mut inside = None;
        if let Some(Hole { outline: Outline::Box { width, height }, z }) = hole {
            ys.insert(1, 0.5 * width);
            zs.splice(1..1, [z - 0.5 * height, z + 0.5 * height]);
            inside = Some((0.5 * width, z - 0.5 * height, z + 0.5 * height));
        }
        let is_hollow = inside.is_some();
        // Walls get as many as asked for, what lies between them twice as many.
        let counts = |lines: &[f64]| -> Vec<usize> {
            let last = lines.len() - 2;
            let is_wall = |i: usize| is_hollow && (i == last || i == 0 && last == 2);
            (0..=last).map(|i| if is_wall(i) { fineness } else { 2 * fineness }).collect()
        };
        let (ys, zs) = (divided(&ys, &counts(&ys)), divided(&zs, &counts(&zs)));
        for z in zs.windows(2) {
            for y in ys.windows(2) {
                let middle = [0.5 * (y[0] + y[1]), 0.5 * (z[0] + z[1])];
                let is_hole =
                    inside.is_some_and(|(w, low, high)| middle[0] < w && low < middle[1] && middle[1] < high);
                self.quad(is_hole, |s, t| [y[0] + s * (y[1] - y[0]), z[0] + t * (z[1] - z[0])]);
            }
        }
    }

    /// A square core with a ring around it, and another ring around a hole: an "O-grid".
    fn rounds(&mut self, radius: f64, hole: Option<Hole>, fineness: usize) {
        let (inner, middle) = match hole {
            Some(Hole { outline: Outline::Round { radius }, z }) => (radius, z),
            _ => (radius, 0.0),
        };
        let is_hollow = hole.is_some();
        let core = 0.5 * inner;
        let parts = fineness as f64;
        for j in 0..2 * fineness {
            for i in 0..fineness {
                let (y, z) = (i as f64, j as f64 - parts);
                self.quad(is_hollow, |s, t| [core * (y + s) / parts, middle + core * (z + t) / parts]);
            }
        }
        // Around the core, from below to above: 0 to 1 is its lower side, 1 to 3 its right side, 3 to 4 its upper side.
        let square =
            |at: f64| [core * at.min(1.0).min(4.0 - at), middle + core * (at - 2.0).clamp(-1.0, 1.0)];
        let circle = |r: f64, z: f64, at: f64| {
            let (sin, cos) = libm::sincos(0.25 * PI * (at - 2.0));
            [r * cos, z + r * sin]
        };
        for k in 0..4 * fineness {
            let at = |t: f64| (k as f64 + t) / parts;
            self.quad(is_hollow, |s, t| mixed(square(at(t)), circle(inner, middle, at(t)), s));
            for i in 0..fineness * usize::from(is_hollow) {
                self.quad(false, |s, t| {
                    mixed(circle(inner, middle, at(t)), circle(radius, 0.0, at(t)), (i as f64 + s) / parts)
                });
            }
        }
    }

    /// Adds a quadrilateral; `place` says where its points are, from 0 to 1 in both directions.
    fn quad(&mut self, is_hole: bool, place: impl Fn(f64, f64) -> [f64; 2]) {
        let nodes = std::array::from_fn(|n| {
            let at = place(0.5 * (n % 3) as f64, 0.5 * (n / 3) as f64);
            let is_here = |known: &[f64; 2]| (known[0] - at[0]).abs() + (known[1] - at[1]).abs() < 1e-9;
            self.nodes.iter().position(is_here).unwrap_or_else(|| {
                self.nodes.push(at);
                self.nodes.len() - 1
            })
        });
        self.quads.push(Quad { nodes, is_hole });
    }

    fn find_edges(&mut self) {
        let edges: Vec<([usize; 3], usize)> = self
            .quads
            .iter()
            .enumerate()
            .flat_map(|(q, quad)| EDGES.map(|edge| (edge.map(|n| quad.nodes[n]), q)))
            .collect();
        for &(edge, q) in &edges {
            if self.quads[q].is_hole {
                continue;
            }
            let other = edges.iter().find(|(e, other)| e[1] == edge[1] && *other != q);
            match other {
                Some((_, other)) if self.quads[*other].is_hole => self.inner.push((edge, q)),
                None if edge.iter().any(|&n| self.nodes[n][0] > 1e-9) => self.outer.push(edge),
                _ => {}
            }
        }
    }
}

fn mixed(from: [f64; 2], to: [f64; 2], s: f64) -> [f64; 2] {
    [from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1])]
}

/// Lines, with each stretch between two of them in so many parts.
fn divided(lines: &[f64], counts: &[usize]) -> Vec<f64> {
    let mut out = vec![lines[0]];
    for (ends, &count) in lines.windows(2).zip(counts) {
        out.extend((1..=count).map(|k| ends[0] + (ends[1] - ends[0]) * k as f64 / count as f64));
    }
    out
}
