//! The springs: forces, lengths at rest, and the work of changing them.

use std::ops::Range;

use fearless_simd::f32x4;
use fearless_simd::prelude::*;

use super::order::Class;
use crate::simulate::lattice::Lattice;

/// So many balls can be named by 16 bits: a place among these needs no check.
pub(super) const PLACES: usize = 1 << 16;

/// A vector for each ball.
pub(super) type Vectors<K> = Box<[f32x4<K>; PLACES]>;

/// All vectors zero. None never happens.
pub(super) fn vectors<K: Simd>(kit: K) -> Option<Vectors<K>> {
    vec![f32x4::splat(kit, 0.0); PLACES].into_boxed_slice().try_into().ok()
}

/// Four springs.
#[derive(Clone, Copy)]
pub(super) struct Four<K: Simd> {
    /// Where they begin and end.
    ends: [[u16; 4]; 2],
    /// N/m.
    stiffness: f32x4<K>,
    /// Damping over the step, N/m.
    damping: f32x4<K>,
    /// Length that they want, m.
    rest: f32x4<K>,
    /// Length at the last look, m.
    length: f32x4<K>,
}

impl<K: Simd> Four<K> {
    /// What each unit of strain takes, J.
    #[inline(always)]
    fn push(&self, unstrained: f32x4<K>) -> f32x4<K> {
        self.stiffness * (self.rest - self.length) * unstrained
    }
}

/// All springs, class by class, each class filled up with springs that do nothing.
pub(super) struct Springs<K: Simd> {
    fours: Vec<Four<K>>,
    /// Length at rest of four springs without strain, m.
    unstrained: Vec<f32x4<K>>,
}

impl<K: Simd> Springs<K> {
    /// The springs of classes, and the range of fours of each class. Springs that do nothing lie between
    /// the two balls after the last.
    pub(super) fn new(kit: K, lattice: &Lattice, classes: &[Class], step: f64) -> (Self, Vec<Range<usize>>) {
        let spare = lattice.balls.len() as u16;
        let (mut fours, mut ranges) = (Vec::new(), Vec::new());
        for class in classes {
            let start = fours.len();
            for links in class.links.chunks(4) {
                let none = f32x4::splat(kit, 0.0);
                let length = f32x4::splat(kit, 1.0);
                let ends = [[spare; 4], [spare + 1; 4]];
                let mut four = Four { ends, stiffness: none, damping: none, rest: length, length };
                for (place, &link) in links.iter().enumerate() {
                    let link = &lattice.links[link];
                    four.ends[0][place] = link.ends[0] as u16;
                    four.ends[1][place] = link.ends[1] as u16;
                    four.stiffness[place] = link.stiffness as f32;
                    four.damping[place] = (link.damping / step) as f32;
                    four.rest[place] = link.length as f32;
                }
                four.length = four.rest;
                fours.push(four);
            }
            ranges.push(start..fours.len());
        }
        let unstrained = fours.iter().map(|four: &Four<K>| four.rest).collect();
        (Self { fours, unstrained }, ranges)
    }

    /// Back to rest.
    pub(super) fn reset(&mut self) {
        for (four, rest) in self.fours.iter_mut().zip(&self.unstrained) {
            (four.rest, four.length) = (*rest, *rest);
        }
    }

    /// Adds the forces of all springs to the balls, N. The speed of a spring is what its length changed by
    /// since the last look, over the step.
    #[inline(always)]
    pub(super) fn pull(&mut self, at: &Vectors<K>, force: &mut Vectors<K>) {
        for four in &mut self.fours {
            let [from, to] = four.ends;
            let way = |n: usize| at[usize::from(to[n])] - at[usize::from(from[n])];
            let ways = [way(0), way(1), way(2), way(3)];
            let length = sums(ways.map(|way| way * way)).sqrt();
            let pull = four.stiffness * (length - four.rest) + four.damping * (length - four.length);
            // Balls in one place push nowhere instead of everywhere.
            let share = pull / length.max(f32x4::splat(length.simd, 1e-12));
            four.length = length;
            for n in 0..4 {
                let pull = ways[n] * f32x4::splat(length.simd, share[n]);
                let (from, to) = (usize::from(from[n]), usize::from(to[n]));
                force[from] += pull;
                force[to] -= pull;
            }
        }
    }

    /// Gives the springs of a class a strain. Returns what it takes for each unit of strain, J, as the sums over
    /// the springs that resist and over those that help, before the change.
    #[inline(always)]
    pub(super) fn strain(&mut self, kit: K, class: Range<usize>, strain: f32) -> [f64; 2] {
        let none = f32x4::splat(kit, 0.0);
        let grown = f32x4::splat(kit, 1.0 + strain);
        let (mut against, mut along) = (none, none);
        for (four, unstrained) in self.fours[class.clone()].iter_mut().zip(&self.unstrained[class]) {
            let push = four.push(*unstrained);
            against += push.max(none);
            along += push.min(none);
            four.rest = *unstrained * grown;
        }
        let sum = |v: f32x4<K>| (0..4).map(|n| f64::from(v[n])).sum();
        [sum(against), sum(along)]
    }

    /// What each unit of strain takes of the springs of a class, J, at the last pull.
    pub(super) fn push(&self, class: Range<usize>) -> f64 {
        let fours = self.fours[class.clone()].iter().zip(&self.unstrained[class]);
        let sum = |v: f32x4<K>| (0..4).map(|n| f64::from(v[n])).sum::<f64>();
        fours.map(|(four, unstrained)| sum(four.push(*unstrained))).sum()
    }

    /// Elastic energy at the last pull, J.
    pub(super) fn energy(&self) -> f64 {
        let one = |four: &Four<K>, n: usize| {
            let stretch = f64::from(four.length[n]) - f64::from(four.rest[n]);
            0.5 * f64::from(four.stiffness[n]) * stretch * stretch
        };
        self.fours.iter().map(|four| (0..4).map(|n| one(four, n)).sum::<f64>()).sum()
    }
}

/// The sums of the components of four vectors.
#[inline(always)]
fn sums<K: Simd>([a, b, c, d]: [f32x4<K>; 4]) -> f32x4<K> {
    let ab = a.unzip_low(b) + a.unzip_high(b);
    let cd = c.unzip_low(d) + c.unzip_high(d);
    ab.unzip_low(cd) + ab.unzip_high(cd)
}
