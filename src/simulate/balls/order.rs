//! In which order springs are computed.

use std::collections::BTreeMap;

use crate::simulate::lattice::{Gains, Lattice};

/// The springs that what strains them has in common, in the order of computing.
pub(super) struct Class {
    /// What strains them.
    pub(super) gains: Gains,
    /// Places in [`Lattice::links`].
    pub(super) links: Vec<usize>,
}

/// The springs by what strains them, those that nothing strains first.
///
/// Within a class a ball's springs are kept apart, so that no sum of forces waits for the last addition
/// to it: springs get the lowest colour that neither end has yet, and go colour by colour.
pub(super) fn classes(lattice: &Lattice) -> Vec<Class> {
    let mut classes: BTreeMap<Vec<(usize, u64)>, Class> = BTreeMap::new();
    for (index, link) in lattice.links.iter().enumerate() {
        let key = key(&link.gains);
        let class = || Class { gains: link.gains.clone(), links: Vec::new() };
        classes.entry(key).or_insert_with(class).links.push(index);
    }
    let mut classes: Vec<Class> = classes.into_values().collect();
    for class in &mut classes {
        colour(lattice, &mut class.links);
    }
    classes
}

/// Gains as something that has an order.
pub(super) fn key(gains: &Gains) -> Vec<(usize, u64)> {
    gains.iter().map(|(actuator, gain)| (*actuator, gain.to_bits())).collect()
}

/// Sorts springs by colour, so that no two of a colour share a ball.
fn colour(lattice: &Lattice, links: &mut [usize]) {
    let mut taken: Vec<Vec<bool>> = vec![Vec::new(); lattice.balls.len()];
    let mut colours = vec![0; lattice.links.len()];
    for &link in &*links {
        let ends = lattice.links[link].ends;
        let free = |colour: &usize| ends.iter().all(|&end| !taken[end].get(*colour).unwrap_or(&false));
        let colour = (0..).find(free).unwrap_or(0);
        for end in ends {
            let own = &mut taken[end];
            own.resize(own.len().max(colour + 1), false);
            own[colour] = true;
        }
        colours[link] = colour;
    }
    links.sort_by_key(|&link| colours[link]);
}
