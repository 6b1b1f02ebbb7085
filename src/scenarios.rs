//! The worlds of a set of scenarios, drawn: which they are depends on the set alone, on no run and no seed.

use grammar_lang::eval::order;
use grammar_lang::ir::{Difference, Scenarios};
use indexmap::IndexMap;

use crate::derive::random::Stream;
use crate::drive::Conditions;
use crate::simulate::World;

/// One world of a set.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// `nominal`, the name of a case, or `drawn 3`.
    pub name: String,
    /// What differs from the nominal world, in SI units. Of what is late this is the most.
    pub differences: IndexMap<Difference, f64>,
    /// About which level axis the body is tilted, rad.
    heading: f64,
    /// How late an actuator is at least, and the stream that says how much later each is.
    late: Option<(f64, Stream)>,
}

impl Scenario {
    fn named(name: String) -> Self {
        Self { name, differences: IndexMap::new(), heading: 0.0, late: None }
    }

    /// All is as the grammar says.
    #[must_use]
    pub fn nominal() -> Self {
        Self::named("nominal".to_owned())
    }

    /// There is no friction at all.
    #[must_use]
    pub fn ice() -> Self {
        let differences = IndexMap::from([(Difference::Friction, 0.0)]);
        Self { differences, ..Self::named("ice".to_owned()) }
    }

    fn factor(&self, difference: Difference) -> f64 {
        self.differences.get(&difference).copied().unwrap_or(1.0)
    }

    /// What of it the solvers apply.
    #[must_use]
    pub fn world(&self) -> World {
        let angle = |difference| self.differences.get(&difference).copied().unwrap_or(0.0);
        World {
            friction: self.factor(Difference::Friction),
            ground_friction: self.differences.get(&Difference::GroundFriction).copied(),
            mass: self.factor(Difference::Mass),
            torque: self.factor(Difference::Torque),
            // What is filled at a higher pressure bends faster, and its angles follow.
            speed: self.factor(Difference::Speed) * self.factor(Difference::Pressure).max(1.0),
            slope: angle(Difference::Slope),
            tilt: angle(Difference::Tilt),
            heading: self.heading,
        }
    }

    /// What of it the drive of a body with so many actuators applies.
    #[must_use]
    pub fn conditions(&self, actuators: usize) -> Conditions {
        let most = self.differences.get(&Difference::Late).copied().unwrap_or(0.0);
        let late = match &self.late {
            Some((least, stream)) => {
                let mut stream = stream.clone();
                (0..actuators).map(|_| least + (most - least) * stream.unit()).collect()
            }
            None => vec![most; actuators],
        };
        Conditions {
            speed: self.factor(Difference::Speed),
            pressure: self.factor(Difference::Pressure),
            late,
            world: self.name.clone(),
        }
    }

    /// In words what differs: `mass 104.2 %, tilt 1.3 deg`; empty in the nominal world.
    #[must_use]
    pub fn described(&self) -> String {
        let one = |(difference, value): (&Difference, &f64)| {
            let most = if self.late.is_some() && *difference == Difference::Late { "up to " } else { "" };
            format!("{} {most}{}", difference.text(), rounded(*difference, *value))
        };
        self.differences.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}

/// A value in its usual unit.
fn rounded(difference: Difference, value: f64) -> String {
    match difference {
        Difference::GroundFriction => digits(value, 2),
        Difference::Tilt | Difference::Slope => format!("{} deg", digits(value.to_degrees(), 1)),
        Difference::Late => format!("{} ms", digits(1e3 * value, 0)),
        Difference::Friction
        | Difference::Mass
        | Difference::Torque
        | Difference::Speed
        | Difference::Pressure => format!("{} %", digits(100.0 * value, 0)),
    }
}

/// A number with so many decimals, or with more: a value that somebody wrote with up to six digits in full, and of one
/// that was drawn at least two digits. More say nothing of it.
fn digits(value: f64, decimals: usize) -> String {
    // Adding zero makes minus zero zero.
    let at = |decimals: usize| format!("{:.decimals$}", value + 0.0);
    let written = (decimals..=6).map(at).find(|text| text.parse().is_ok_and(|x| order::is_same(x, value)));
    let small = if value == 0.0 { 0 } else { 1 - libm::floor(libm::log10(value.abs())) as i32 };
    written.unwrap_or_else(|| at(decimals.max(small.clamp(0, 9) as usize)))
}

/// All worlds of a set: the nominal one, the cases, and those that are drawn, a Latin hypercube.
#[must_use]
pub fn worlds(name: &str, set: &Scenarios) -> Vec<Scenario> {
    let case = |(name, differences): (&String, &IndexMap<Difference, f64>)| Scenario {
        differences: differences.clone(),
        ..Scenario::named(name.clone())
    };
    let drawn = drawn(set, "drawn", &format!("scenarios {name}"));
    std::iter::once(Scenario::nominal()).chain(set.cases.iter().map(case)).chain(drawn).collect()
}

/// So many worlds show a best that no search has seen.
const TESTS: usize = 64;

/// Worlds between the same ends as the drawn ones of a set, which no search sees: what it found is tested in them. None
/// where a set has cases only.
#[must_use]
pub fn tests(name: &str, set: &Scenarios) -> Vec<Scenario> {
    let drawn_of = if set.ranges.is_empty() { 0 } else { TESTS };
    drawn(&Scenarios { drawn: drawn_of, ..set.clone() }, "test", &format!("tests {name}"))
}

/// The drawn worlds of a set, by what they are called and by the name of their streams.
fn drawn(set: &Scenarios, called: &str, streams: &str) -> Vec<Scenario> {
    let mut worlds: Vec<Scenario> =
        (1..=set.drawn).map(|number| Scenario::named(format!("{called} {number}"))).collect();
    let stream = |what: &str| Stream::named(0, &format!("{streams} {what}"));
    for (&difference, &(low, high)) in &set.ranges {
        if difference == Difference::Late {
            for (number, world) in worlds.iter_mut().enumerate() {
                world.late = Some((low, stream(&format!("late {number}"))));
                world.differences.insert(difference, high);
            }
            continue;
        }
        let places = spread(set.drawn, &mut stream(difference.text()));
        for (world, place) in worlds.iter_mut().zip(places) {
            world.differences.insert(difference, low + (high - low) * place);
        }
        if difference == Difference::Tilt {
            let places = spread(set.drawn, &mut stream("heading"));
            for (world, place) in worlds.iter_mut().zip(places) {
                world.heading = std::f64::consts::TAU * place;
            }
        }
    }
    worlds
}

/// So many places in 0 .. 1, one in each of as many equal shares, in any order.
fn spread(count: usize, random: &mut Stream) -> Vec<f64> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, random.below(last + 1));
    }
    order.into_iter().map(|share| (share as f64 + random.unit()) / count as f64).collect()
}

#[cfg(test)]
mod tests {
    use grammar_lang::source::Span;

    use super::*;

    fn set(drawn: usize) -> Scenarios {
        let ranges = [
            (Difference::Friction, (0.75, 1.25)),
            (Difference::Mass, (0.9, 1.1)),
            (Difference::Tilt, (0.0, 0.035)),
            (Difference::Late, (0.01, 0.05)),
        ];
        let ice = IndexMap::from([(Difference::GroundFriction, 0.2)]);
        let cases = IndexMap::from([("ice".to_owned(), ice)]);
        Scenarios { ranges: ranges.into_iter().collect(), drawn, cases, span: Span::default() }
    }

    #[test]
    fn worlds_are_the_nominal_one_the_cases_and_those_that_are_drawn() {
        let worlds = worlds("workshop", &set(13));
        assert_eq!(worlds.len(), set(13).count());
        assert_eq!(
            (worlds[0].world(), worlds[0].conditions(3)),
            (
                World::NOMINAL,
                Conditions { late: vec![0.0; 3], world: "nominal".to_owned(), ..Conditions::NOMINAL }
            )
        );
        assert_eq!((worlds[1].name.as_str(), worlds[1].world().ground_friction), ("ice", Some(0.2)));
        assert_eq!(worlds[14].name, "drawn 13");
        assert_eq!(worlds, super::worlds("workshop", &set(13)), "not the same again");
        assert_ne!(worlds, super::worlds("field", &set(13)), "another set draws others");
    }

    /// Every share of a range has one world: that is what a Latin hypercube is.
    #[test]
    fn drawn_worlds_fill_each_range_evenly() {
        for count in [1, 2, 13, 200] {
            let worlds = drawn(&set(count), "drawn", "scenarios workshop");
            for (difference, (low, high)) in &set(count).ranges {
                if *difference == Difference::Late {
                    continue;
                }
                let share = |world: &Scenario| {
                    let place = (world.differences[difference] - low) / (high - low);
                    libm::floor(place * count as f64) as usize
                };
                let mut shares: Vec<usize> = worlds.iter().map(share).collect();
                shares.sort_unstable();
                assert_eq!(shares, (0..count).collect::<Vec<_>>(), "{difference:?} of {count}");
            }
        }
    }

    #[test]
    fn every_actuator_is_late_by_its_own() {
        let worlds = drawn(&set(40), "drawn", "scenarios workshop");
        let mut all: Vec<f64> = worlds.iter().flat_map(|world| world.conditions(10).late).collect();
        assert!(all.iter().all(|late| (0.01..0.05).contains(late)));
        all.sort_by(f64::total_cmp);
        all.dedup();
        assert_eq!(all.len(), 400);
        let mean = all.iter().sum::<f64>() / 400.0;
        assert!((mean - 0.03).abs() < 0.002, "{mean}");
        // A body with more actuators has the same lateness of those that both have.
        assert_eq!(worlds[3].conditions(4).late, worlds[3].conditions(9).late[..4]);
    }

    /// What is filled at a higher pressure bends faster than it does in the nominal world; at a lower one the flow alone is less.
    #[test]
    fn actuators_follow_a_higher_pressure() {
        let speed = |pressure: f64| {
            let differences = IndexMap::from([(Difference::Pressure, pressure), (Difference::Speed, 0.9)]);
            Scenario { differences, ..Scenario::nominal() }.world().speed
        };
        assert_eq!((speed(0.8), speed(1.0), speed(1.2)), (0.9, 0.9, 0.9 * 1.2));
    }

    /// What somebody wrote is shown as it was written; what was drawn, with two digits at least.
    #[test]
    fn no_difference_is_rounded_away() {
        let words = |difference, value| {
            let differences = IndexMap::from([(difference, value)]);
            Scenario { differences, ..Scenario::nominal() }.described()
        };
        assert_eq!(words(Difference::Friction, 1.004), "friction 100.4 %");
        assert_eq!(words(Difference::GroundFriction, 0.125), "ground_friction 0.125");
        assert_eq!(words(Difference::GroundFriction, 0.004), "ground_friction 0.004");
        assert_eq!(words(Difference::GroundFriction, 0.812_345_678), "ground_friction 0.81");
        assert_eq!(words(Difference::Late, 0.4e-3), "late 0.4 ms");
        assert_eq!(words(Difference::Tilt, 0.04_f64.to_radians()), "tilt 0.04 deg");
        assert_eq!(words(Difference::Tilt, -0.0), "tilt 0.0 deg");
        assert_eq!(words(Difference::Slope, 0.000_712_345_678), "slope 0.041 deg");
        assert_eq!(words(Difference::Mass, 1.0434567891), "mass 104 %");
        assert_eq!(words(Difference::Mass, 0.9), "mass 90 %");
    }
}
