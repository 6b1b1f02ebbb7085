//! Designs that are lattices: places of a grid, each with a cell or without.
//!
//! A cell is a [`Part`] that nothing holds; its number says where it is. Parts stand in the order of their
//! places, x first, then y, then z.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use grammar_lang::eval::{KindValue, Made, MadeCell, Unmade, Value, WithValues};
use grammar_lang::ir::{JOINED, Kind, Lattice, RuleSet, Symmetry};
use indexmap::IndexMap;
use nalgebra::Isometry3;

use super::assembly::{Assembly, Element, Shape, Spring, Swelling};
use super::{Body, Design, Part, PartId, Refusal, change};

/// Set in the numbers of cells, and of no other parts.
const CELL: u64 = 1 << 62;
/// How many bits of a number say where a cell is along one side: those of x are the lowest.
const BITS: u32 = 17;

/// A place of a grid: how many cells lie before it along x, y and z.
pub type Place = [usize; 3];

/// Whether a part is a cell.
#[must_use]
pub fn is_cell(id: PartId) -> bool {
    id.number() & CELL != 0
}

/// The number of the cell at a place; none beyond the grid.
#[must_use]
pub fn cell_at(lattice: &Lattice, place: [i64; 3]) -> Option<PartId> {
    let mut number = CELL;
    for ((axis, at), side) in (0..).zip(place).zip(lattice.sides) {
        if !(0..side as i64).contains(&at) {
            return None;
        }
        number |= (at as u64) << (axis * BITS);
    }
    Some(PartId::from_number(number))
}

/// The place of a cell.
#[must_use]
pub fn place_of(id: PartId) -> Option<Place> {
    let along = |axis: u32| (id.number() >> (axis * BITS) & ((1 << BITS) - 1)) as usize;
    is_cell(id).then(|| [along(0), along(1), along(2)])
}

/// The place in the middle of the grid.
#[must_use]
pub fn middle(lattice: &Lattice) -> Option<PartId> {
    cell_at(lattice, lattice.sides.map(|side| (side / 2) as i64))
}

/// The cell whose place differs by an offset, if the grid reaches there.
#[must_use]
pub fn beside(lattice: &Lattice, id: PartId, offset: [i64; 3]) -> Option<PartId> {
    let place = place_of(id)?;
    let mut other = [0; 3];
    for ((to, from), by) in other.iter_mut().zip(place).zip(offset) {
        *to = (from as i64).checked_add(by)?;
    }
    cell_at(lattice, other)
}

/// The images of a place under a symmetry of the grid, without itself.
fn images(lattice: &Lattice, symmetry: Symmetry, id: PartId) -> Vec<PartId> {
    let Some(place) = place_of(id).map(|place| place.map(|at| at as i64)) else { return Vec::new() };
    let last = lattice.sides.map(|side| side as i64 - 1);
    let flipped = |axes: &[usize]| {
        let mut image = place;
        for (axis, (at, last)) in image.iter_mut().zip(last).enumerate() {
            if axes.contains(&axis) {
                *at = last - *at;
            }
        }
        image
    };
    let others = match symmetry {
        Symmetry::None => Vec::new(),
        Symmetry::Mirror(normal) => vec![flipped(&[normal])],
        Symmetry::Radial(count, axis) => {
            let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
            let half = flipped(&[a, b]);
            // A quarter turn: b follows a, and a the mirror image of b.
            let quarter = |from: [i64; 3]| {
                let mut image = from;
                image[a] = last[b] - from[b];
                image[b] = from[a];
                image
            };
            if count == 2 { vec![half] } else { vec![quarter(place), half, quarter(half)] }
        }
    };
    others.into_iter().filter_map(|place| cell_at(lattice, place)).collect()
}

impl Design {
    /// Puts cells at places and at their images, in the place of what was there.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn fill(
        &mut self,
        rules: &RuleSet,
        lattice: &Lattice,
        places: &[PartId],
        with: &KindValue,
        step: u64,
    ) -> Result<(), Refusal> {
        let (params, made) = change::params(&self.known(rules), &with.name, &with.params, 0)?;
        for id in with_images(lattice, rules.symmetry, places) {
            let cell = Part {
                kind: with.name.clone(),
                params: params.clone(),
                made: made.clone(),
                turn: 0.0,
                held_by: None,
                holding: 0,
                image_of: None,
                image: 0,
                alone: false,
                step,
                pose: pose(lattice, id),
            };
            self.parts.insert(id, cell);
        }
        self.parts.sort_unstable_keys();
        Ok(())
    }

    /// Gives the cells that are at places, and at their images, some parameters.
    ///
    /// # Errors
    ///
    /// A [`Refusal`]; the design is then to be thrown away.
    pub fn paint(
        &mut self,
        rules: &RuleSet,
        lattice: &Lattice,
        places: &[PartId],
        with: &KindValue,
    ) -> Result<(), Refusal> {
        let known = WithValues { rules, values: &self.values };
        let mut cells = Cells::new(known, lattice);
        for id in with_images(lattice, rules.symmetry, places) {
            let Some(cell) = self.parts.get_mut(&id) else { continue };
            let mut other = false;
            for (name, value) in &with.params {
                change::in_domain(rules, &with.name, name, value)?;
                other |= cell.params.insert(name.clone(), value.clone()).as_ref() != Some(value);
            }
            if other {
                cell.made = cells.made(&cell.params).map_err(Refusal::NoSuchPart)?;
            }
        }
        Ok(())
    }

    /// Works out again what each cell is.
    pub(super) fn remake_cells(&mut self, rules: &RuleSet, lattice: &Lattice) -> Result<(), Unmade> {
        let mut cells = Cells::new(WithValues { rules, values: &self.values }, lattice);
        for cell in self.parts.values_mut() {
            cell.made = cells.made(&cell.params)?;
        }
        Ok(())
    }

    /// Takes away the cells that are at places and at their images.
    ///
    /// # Errors
    ///
    /// A [`Refusal`] where nothing would be left.
    pub fn clear(&mut self, lattice: &Lattice, symmetry: Symmetry, places: &[PartId]) -> Result<(), Refusal> {
        for id in with_images(lattice, symmetry, places) {
            self.parts.shift_remove(&id);
        }
        if self.parts.is_empty() { Err(Refusal::Empty) } else { Ok(()) }
    }

    /// The cells that a cell is joined to.
    #[must_use]
    pub fn joined(&self, lattice: &Lattice, id: PartId) -> Vec<PartId> {
        let others = JOINED.iter().filter_map(|offset| beside(lattice, id, offset.map(i64::from)));
        others.filter(|other| self.parts.contains_key(other)).collect()
    }

    /// Whether all cells hang together.
    #[must_use]
    pub fn is_one_piece(&self, lattice: &Lattice) -> bool {
        let mut open: Vec<PartId> = self.parts.keys().take(1).copied().collect();
        let mut seen: BTreeSet<PartId> = open.iter().copied().collect();
        while let Some(id) = open.pop() {
            open.extend(self.joined(lattice, id).into_iter().filter(|other| seen.insert(*other)));
        }
        seen.len() == self.parts.len()
    }
}

/// How many groups of cells there are that share faces and a value.
#[must_use]
pub fn clusters(lattice: &Lattice, cells: &[(PartId, Value)]) -> usize {
    let mut open: BTreeMap<PartId, &Value> = cells.iter().map(|(id, value)| (*id, value)).collect();
    let mut count = 0;
    while let Some((first, value)) = open.pop_first() {
        count += 1;
        let mut next = vec![first];
        while let Some(id) = next.pop() {
            for axis in 0..3 {
                for by in [-1, 1] {
                    let mut offset = [0; 3];
                    offset[axis] = by;
                    let Some(other) = beside(lattice, id, offset) else { continue };
                    if open.get(&other) == Some(&value) {
                        open.remove(&other);
                        next.push(other);
                    }
                }
            }
        }
    }
    count
}

/// Places and their images, each once.
fn with_images(lattice: &Lattice, symmetry: Symmetry, places: &[PartId]) -> BTreeSet<PartId> {
    let mut all: BTreeSet<PartId> = places.iter().copied().collect();
    for id in places {
        all.extend(images(lattice, symmetry, *id));
    }
    all
}

/// Where a cell is: the grid stands on the ground, its middle above the origin.
fn pose(lattice: &Lattice, id: PartId) -> Isometry3<f64> {
    let spacing = lattice.cell.spacing;
    let [x, y, z] = place_of(id).unwrap_or_default().map(|at| at as f64);
    let [nx, _, nz] = lattice.sides.map(|side| (side as f64 - 1.0) / 2.0);
    Isometry3::translation((x - nx) * spacing, (y + 0.5) * spacing, (z - nz) * spacing)
}

/// How many operations the fields of all cells of a body may take together.
const MOST_OF_CELLS: u64 = 20_000_000;

/// Works out what cells are: those that are alike one behind the other are worked out once.
struct Cells<'a> {
    known: WithValues<'a>,
    lattice: &'a Lattice,
    left: AtomicU64,
    last: Option<(IndexMap<String, Value>, Arc<Made>)>,
}

impl<'a> Cells<'a> {
    fn new(known: WithValues<'a>, lattice: &'a Lattice) -> Self {
        Self { known, lattice, left: AtomicU64::new(MOST_OF_CELLS), last: None }
    }

    /// What a cell with these parameters is.
    fn made(&mut self, params: &IndexMap<String, Value>) -> Result<Arc<Made>, Unmade> {
        if let Some((_, made)) = self.last.as_ref().filter(|(last, _)| last == params) {
            return Ok(Arc::clone(made));
        }
        let made = Made::within(Kind::Cell(self.lattice), &self.known, params, &self.left);
        let reason = || {
            format!(
                "the fields of all cells take {MOST_OF_CELLS} operations at most; sum over fewer values, or let fewer cells differ"
            )
        };
        let made = Arc::new(made.unwrap_or_else(|| Err(Unmade { field: "mass", reason: reason() }))?);
        self.last = Some((params.clone(), Arc::clone(&made)));
        Ok(made)
    }
}

/// Half of a spring is of each cell: the two halves, one behind the other.
fn in_series(a: f64, b: f64) -> f64 {
    if a + b == 0.0 { 0.0 } else { 2.0 * a * b / (a + b) }
}

/// Balls and springs. Cells that are alike are strained together, as one actuator.
pub(super) fn body(design: &Design, rules: &RuleSet, lattice: &Lattice) -> Body {
    let mut body =
        Body { assembly: Assembly::default(), parts_of_elements: Vec::new(), actuators: Vec::new() };
    let mut alike: Vec<(&IndexMap<String, Value>, &MadeCell)> = Vec::new();
    let mut class_of = Vec::with_capacity(design.parts.len());
    let is_driven = |kind: &str| rules.tasks.values().any(|task| task.actuated.contains_key(kind));
    for (id, cell) in &design.parts {
        // A lattice has cells only.
        let Made::Cell(made) = cell.made.as_ref() else { continue };
        let class = alike.iter().position(|(params, _)| **params == cell.params).unwrap_or_else(|| {
            alike.push((&cell.params, made));
            if is_driven(&cell.kind) {
                body.actuators.push(*id);
            }
            alike.len() - 1
        });
        class_of.push(class);
        let element = body.assembly.elements.len();
        let shape = Shape::Ball { radius: lattice.cell.spacing / 2.0 };
        body.assembly.elements.push(Element {
            shape,
            pose: cell.pose,
            mass: made.mass,
            friction: made.friction,
        });
        body.parts_of_elements.push(*id);
        if is_driven(&cell.kind) {
            body.assembly.swellings.push(Swelling { element, actuator: class, gain: 1.0 });
        }
    }
    for (from, id) in design.parts.keys().enumerate() {
        for other in design.joined(lattice, *id) {
            // Each pair once.
            let Some(to) = design.parts.get_index_of(&other).filter(|to| *to > from) else { continue };
            let of = |element: usize| alike.get(*class_of.get(element)?).map(|(_, made)| *made);
            let (Some(a), Some(b)) = (of(from), of(to)) else { continue };
            body.assembly.springs.push(Spring {
                from,
                to,
                stiffness: in_series(a.stiffness, b.stiffness),
                damping: in_series(a.damping, b.damping),
            });
        }
    }
    body.assembly.actuators = body.actuators.len();
    body
}
