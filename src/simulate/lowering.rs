//! Lowers an assembly to rigid bodies joined by joints of one degree of freedom.
//!
//! The solvers of joints start from this: elements joined rigidly are one body, every
//! other joint is one degree of freedom, and the whole is a tree whose root is
//! the body of the core. Bodies are numbered depth first, parents before
//! children, so that a limb is a contiguous range. Body frames have their
//! origin at the centre of mass and the world's axes at rest. SI units.

use std::sync::Arc;

use nalgebra::{Isometry3, Matrix3, Vector3};

use super::check;
use super::motion::Placement;
use super::run::Driven;
use super::servo::Servo;
use super::{Settings, Unfit, World};
use crate::design::assembly::{Assembly, Dof, Element, Shape};

/// A rigid body: one or more elements. Between two degrees of freedom of one joint it has none, and no mass.
#[derive(Clone, Debug)]
pub(super) struct Body {
    /// The body nearer to the root; the root names itself.
    pub(super) parent: usize,
    /// Mass in kg.
    pub(super) mass: f64,
    /// Centre of mass in the world at rest, m.
    pub(super) centre: Vector3<f64>,
    /// Inertia about the centre of mass, world axes at rest, kg m^2.
    pub(super) inertia: Matrix3<f64>,
    /// What joins it to its parent; nothing joins the root.
    pub(super) dof: Option<Dof>,
    /// Which of [`Lowered::servos`] moves it.
    pub(super) servo: usize,
}

impl Body {
    /// Whether it is nothing but a place between two degrees of freedom of one joint.
    pub(super) fn is_massless(&self) -> bool {
        self.mass == 0.0
    }
}

/// An element with its place.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Its body.
    pub(super) body: usize,
    /// Its pose in the body's frame.
    pub(super) local: Isometry3<f64>,
    /// Its geometry.
    pub(super) shape: Shape,
    /// Its Coulomb coefficient.
    pub(super) friction: f64,
}

/// A whole assembly as a tree of bodies, its lowest point on the ground.
#[derive(Clone, Debug)]
pub(super) struct Lowered {
    /// Depth first; the root comes first.
    pub(super) bodies: Vec<Body>,
    /// One for each element, in the assembly's order.
    pub(super) pieces: Vec<Piece>,
    /// The servos at rest; joints that always have the same target share one.
    pub(super) servos: Vec<Servo>,
    /// How many actuators the joints refer to.
    pub(super) actuators: usize,
    /// The two elements of every moving joint.
    joined: Vec<(usize, usize)>,
}

impl Lowered {
    /// Checks and lowers an assembly.
    pub(super) fn new(assembly: &Assembly, settings: &Settings) -> Result<Self, Unfit> {
        check::settings(settings)?;
        check::assembly(assembly)?;
        check::recording(settings, assembly)?;
        let groups = Groups::of(assembly)?;
        let lowest = |element: &Element| element.shape.lowest(&element.pose);
        let lift = -assembly.elements.iter().map(lowest).fold(f64::INFINITY, f64::min);
        let order = groups.depth_first();
        let mut place = vec![0; order.len()];
        for (new, &old) in order.iter().enumerate() {
            place[old] = new;
        }
        let mut members = vec![Vec::new(); order.len()];
        for (element, &group) in groups.of_element.iter().enumerate() {
            members[place[group]].push(element);
        }
        let (mut bodies, mut servos) = (Vec::with_capacity(order.len()), Vec::new());
        for (new, &old) in order.iter().enumerate() {
            let dof = groups.dofs[old].map(|dof| raised(dof, lift));
            let servo = dof.as_ref().map_or(0, |dof| servo(&mut servos, dof));
            bodies.push(body(assembly, &members[new], place[groups.parents[old]], dof, servo, lift));
        }
        let pieces = assembly
            .elements
            .iter()
            .zip(&groups.of_element)
            .map(|(element, &group)| piece(element, place[group], &bodies, lift))
            .collect();
        let moving = assembly.joints.iter().filter(|joint| !joint.kind.dofs().is_empty());
        let joined = moving.map(|joint| (joint.parent, joint.child)).collect();
        Ok(Self { bodies, pieces, servos, actuators: assembly.actuators, joined })
    }

    /// What runs it.
    pub(super) fn driven(&self) -> Driven {
        let dofs: Vec<&Dof> = self.bodies.iter().filter_map(|body| body.dof.as_ref()).collect();
        let placement = |piece: &Piece| Placement::new(piece.body, piece.local, piece.shape);
        let placements: Arc<[Placement]> = self.pieces.iter().map(placement).collect();
        Driven::joints(&dofs, &self.servos, self.bodies.len(), self.actuators, placements)
    }

    /// Where the centre of the root is, m, when the body is set on the ground of a world.
    pub(super) fn set_down(&self, world: &World) -> Vector3<f64> {
        let root = self.bodies[0].centre;
        if world.tilt == 0.0 {
            return root;
        }
        let turn = world.turn();
        let lowest = |piece: &Piece| {
            let place = self.bodies[piece.body].centre + piece.local.translation.vector - root;
            let pose = Isometry3::from_parts((turn * place).into(), turn * piece.local.rotation);
            piece.shape.lowest(&pose)
        };
        let low = self.pieces.iter().map(lowest).fold(f64::INFINITY, f64::min);
        Vector3::new(root.x, -low, root.z)
    }

    /// Whether a moving joint joins just these two elements.
    pub(super) fn are_joined(&self, first: usize, second: usize) -> bool {
        self.joined.iter().any(|&pair| pair == (first, second) || pair == (second, first))
    }

    /// Number of moving joints between two bodies; the degrees of freedom of a socket are one joint.
    pub(super) fn distance(&self, mut a: usize, mut b: usize) -> usize {
        let mut joints = 0;
        // A parent has the smaller number, so climbing from the larger one meets.
        while a != b {
            let last = if a > b { &mut a } else { &mut b };
            joints += usize::from(!self.bodies[*last].is_massless());
            *last = self.bodies[*last].parent;
        }
        joints
    }
}

/// Elements grouped by rigid joints, before the bodies are numbered.
struct Groups<'a> {
    of_element: Vec<usize>,
    parents: Vec<usize>,
    dofs: Vec<Option<&'a Dof>>,
}

impl<'a> Groups<'a> {
    fn of(assembly: &'a Assembly) -> Result<Self, Unfit> {
        let mut of_element = vec![None; assembly.elements.len()];
        of_element[0] = Some(0);
        let (mut parents, mut dofs) = (vec![0], vec![None]);
        for joint in &assembly.joints {
            let Some(parent) = of_element[joint.parent] else {
                return Err(Unfit {
                    reason: format!(
                        "element {} is joined to element {}, which nothing has joined to the core yet; \
                         list joints from the core outwards",
                        joint.child, joint.parent
                    ),
                });
            };
            if of_element[joint.child].is_some() {
                return Err(Unfit {
                    reason: format!(
                        "element {} is the child of two joints; joints must form a tree, remove one",
                        joint.child
                    ),
                });
            }
            of_element[joint.child] = Some(joint.kind.dofs().iter().fold(parent, |parent, dof| {
                parents.push(parent);
                dofs.push(Some(dof));
                parents.len() - 1
            }));
        }
        let of_element = of_element.into_iter().map(|group| group.unwrap_or(0)).collect();
        Ok(Self { of_element, parents, dofs })
    }

    fn depth_first(&self) -> Vec<usize> {
        let mut children = vec![Vec::new(); self.parents.len()];
        for (group, &parent) in self.parents.iter().enumerate().skip(1) {
            children[parent].push(group);
        }
        let (mut order, mut stack) = (Vec::new(), vec![0]);
        while let Some(group) = stack.pop() {
            order.push(group);
            stack.extend(children[group].iter().rev());
        }
        order
    }
}

/// The place of a joint's servo among all, where it is put if there is none like it.
fn servo(servos: &mut Vec<Servo>, dof: &Dof) -> usize {
    let own = Servo::new(dof);
    servos.iter().position(|servo| *servo == own).unwrap_or_else(|| {
        servos.push(own);
        servos.len() - 1
    })
}

fn raised(dof: &Dof, lift: f64) -> Dof {
    let mut dof = dof.clone();
    dof.anchor.y += lift;
    dof
}

fn body(
    assembly: &Assembly,
    members: &[usize],
    parent: usize,
    dof: Option<Dof>,
    servo: usize,
    lift: f64,
) -> Body {
    let elements = || members.iter().map(|&member| &assembly.elements[member]);
    let mass: f64 = elements().map(|element| element.mass).sum();
    let moment: Vector3<f64> = elements().map(|e| e.mass * e.pose.translation.vector).sum();
    // What has no mass is where it turns.
    let centre = match (&dof, mass > 0.0) {
        (Some(dof), false) => dof.anchor.coords - Vector3::y() * lift,
        _ => moment / mass,
    };
    let mut inertia = Matrix3::zeros();
    for element in elements() {
        let turn = element.pose.rotation.to_rotation_matrix();
        let own = Matrix3::from_diagonal(&element.shape.moments(element.mass));
        let arm = element.pose.translation.vector - centre;
        inertia += turn.matrix() * own * turn.matrix().transpose();
        inertia += element.mass * (Matrix3::identity() * arm.norm_squared() - arm * arm.transpose());
    }
    Body { parent, mass, centre: centre + Vector3::y() * lift, inertia, dof, servo }
}

fn piece(element: &Element, body: usize, bodies: &[Body], lift: f64) -> Piece {
    let mut local = element.pose;
    local.translation.vector += Vector3::y() * lift - bodies[body].centre;
    Piece { body, local, shape: element.shape, friction: element.friction }
}
