//! The grid of an actuator: its cross-section drawn out along x, in layers of hexahedra of 27 nodes, and a plate that closes its tip.

use super::Casting;
use super::section::CrossSection;

/// How thick the plate at the tip is, as a share of the height.
const PLATE: f64 = 0.25;

/// A hexahedron of 27 nodes: three planes of nine.
#[derive(Clone, Debug)]
pub(super) struct Hexahedron {
    pub(super) nodes: [usize; 27],
    /// Whether it is one of the plate.
    pub(super) is_plate: bool,
}

/// Nine nodes of a surface. The first three lie side by side in one plane.
pub(super) type Face = [usize; 9];

/// The grid of an actuator at rest. Its base is the plane x = 0, which is held.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    /// Where the nodes are, m.
    pub(super) nodes: Vec<[f64; 3]>,
    /// The nodes of each plane, from the base to the tip: two planes for each layer. The last layer is the plate.
    pub(super) planes: Vec<Vec<usize>>,
    pub(super) solids: Vec<Hexahedron>,
    /// The surface of the hole, and 1 or -1: by which the normal of a face is multiplied so that it points out of the hole.
    pub(super) hole: Vec<(Face, f64)>,
    /// The outside, without the plate.
    pub(super) skin: Vec<Face>,
}

impl Mesh {
    /// An actuator in so many layers. `fineness` is the number of elements through a wall.
    pub(super) fn new(casting: &Casting, layers: usize, fineness: usize) -> Self {
        let section = CrossSection::new(casting.outline, casting.hole, fineness);
        let end = 2 * layers;
        let step = casting.length / end as f64;
        let thick = 0.5 * PLATE * casting.outline.height();
        // What lies in the hole is there in the plate only.
        let is_wall: Vec<bool> = (0..section.nodes.len())
            .map(|node| section.quads.iter().any(|quad| !quad.is_hole && quad.nodes.contains(&node)))
            .collect();
        let (mut nodes, mut planes) = (Vec::new(), Vec::new());
        // The number of each node of the section in each plane.
        let mut numbers = vec![vec![0; section.nodes.len()]; end + 3];
        for (plane, numbers) in numbers.iter_mut().enumerate() {
            let x = step * plane.min(end) as f64 + thick * plane.saturating_sub(end) as f64;
            let first = nodes.len();
            for (node, [y, z]) in section.nodes.iter().enumerate() {
                if is_wall[node] || plane >= end {
                    numbers[node] = nodes.len();
                    nodes.push([x, *y, *z]);
                }
            }
            planes.push((first..nodes.len()).collect());
        }
        let mut solids = Vec::new();
        for layer in 0..=layers {
            let is_plate = layer == layers;
            for quad in section.quads.iter().filter(|quad| is_plate || !quad.is_hole) {
                let node = |n: usize| numbers[2 * layer + n / 9][quad.nodes[n % 9]];
                solids.push(Hexahedron { nodes: std::array::from_fn(node), is_plate });
            }
        }
        let face = |edge: [usize; 3], layer: usize| -> Face {
            std::array::from_fn(|n| numbers[2 * layer + n / 3][edge[n % 3]])
        };
        let along = |edges: &[[usize; 3]]| -> Vec<Face> {
            (0..layers)
                .flat_map(|layer| edges.iter().map(move |&edge| (edge, layer)))
                .map(|(e, l)| face(e, l))
                .collect()
        };
        let mut hole = Vec::new();
        for &(edge, quad) in &section.inner {
            let [from, middle, to] = edge.map(|n| section.nodes[n]);
            let wall = section.nodes[section.quads[quad].nodes[4]];
            // The normal is the edge times x: (0, a, b) x (1, 0, 0) = (0, b, -a).
            let out = (to[1] - from[1]) * (wall[0] - middle[0]) - (to[0] - from[0]) * (wall[1] - middle[1]);
            hole.extend(along(&[edge]).into_iter().map(|face| (face, out.signum())));
        }
        for quad in section.quads.iter().filter(|quad| quad.is_hole) {
            let [a, b, c] = [0, 2, 6].map(|n| section.nodes[quad.nodes[n]]);
            let x = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            hole.push((quad.nodes.map(|n| numbers[end][n]), x.signum()));
        }
        Self { skin: along(&section.outer), nodes, planes, solids, hole }
    }

    /// Whether a node lies in the plane of symmetry.
    pub(super) fn is_in_mirror(&self, node: usize) -> bool {
        self.nodes[node][1] < 1e-9
    }

    /// The faces of the skin that lie at the greatest z.
    pub(super) fn upper_side(&self) -> Vec<Face> {
        let highest = self.nodes.iter().map(|node| node[2]).fold(f64::NEG_INFINITY, f64::max);
        let is_upper = |face: &&Face| face.iter().all(|&node| self.nodes[node][2] > highest - 1e-9);
        self.skin.iter().filter(is_upper).copied().collect()
    }

    /// The nodes of a plane with weights: sums of weights times positions are the point of the plane that lies `z` above its middle,
    /// as it moves with the plane.
    pub(super) fn point(&self, plane: usize, z: f64) -> Vec<(usize, f64)> {
        let nodes = &self.planes[plane];
        let many = nodes.len() as f64;
        let middle = nodes.iter().map(|&node| self.nodes[node][2]).sum::<f64>() / many;
        let arm = |node: usize| self.nodes[node][2] - middle;
        let squares: f64 = nodes.iter().map(|&node| arm(node) * arm(node)).sum();
        nodes.iter().map(|&node| (node, 1.0 / many + (z - middle) * arm(node) / squares)).collect()
    }
}
