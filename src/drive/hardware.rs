//! What hardware makes of an actuation: valves let air in and out, servos wind up threads, and a supply is
//! shared. The simulation follows these bends instead of the ones that were asked for.

use grammar_lang::eval::{EvalError, Valve, Valves};
use grammar_lang::ir::{Backend, Speed, Supply, Target, Tendon};

use super::{Conditions, Drive, Driven};
use crate::simulate::Targets;

/// The longest step in which bends are followed, s, where speeds change with the bend or with what the others do:
/// within a step they are taken as they are at its beginning.
const FINE: f64 = 2e-3;

/// A valve that changes within this time, s, changes now.
const NOW: f64 = 1e-9;

/// An actuator whose valves follow a schedule.
struct Inflated<'a> {
    valves: Valves,
    bending: &'a Speed,
    relaxing: &'a Speed,
    /// The greatest bend, rad.
    most: f64,
    /// How much later than they should its valves change, s.
    late: f64,
    /// Whether it hangs on a supply of air that others may share.
    supplied: bool,
}

/// Actuators that air moves, on one supply or on none, and their columns.
type Group<'a> = (Option<&'a Supply>, Vec<(usize, Inflated<'a>)>);

impl Inflated<'_> {
    /// The state at a time in s, and how long it still holds.
    fn state(&self, time: f64) -> (Valve, f64) {
        let Valves { period, changes } = &self.valves;
        let time = time - self.late;
        if time < -NOW {
            return (Valve::Closed, -time);
        }
        let time = time.max(0.0);
        let mut place = time - period * libm::floor(time / period);
        // Rounding must not hold a state that has ended.
        place += NOW;
        if place >= *period {
            place -= period;
        }
        let next = changes.partition_point(|(from, _)| *from <= place);
        let state =
            next.checked_sub(1).and_then(|i| changes.get(i)).map_or(Valve::Closed, |(_, state)| *state);
        let until = changes.get(next).map_or(*period, |(from, _)| *from);
        (state, until - place)
    }
}

impl Drive<'_> {
    /// The target that drives an actuator where the task is simulated, if one does.
    fn target(&self, driven: &Driven) -> Option<&Target> {
        let kind = self.kind_of(driven)?;
        let mut targets = self.candidate.rules.targets_of(self.task);
        targets.find_map(|(_, target)| (target.kind == kind).then_some(target))
    }

    /// The servos that wind up an actuator's threads where the task is simulated on them.
    pub(super) fn threads(&self, driven: &Driven) -> Option<&Tendon> {
        match &self.target(driven)?.backend {
            Backend::Tendon(threads) => Some(threads),
            Backend::Pneumatic(_) => None,
        }
    }

    /// What the hardware of an actuator makes of what it is asked for at moments of so many s, as fast as it is by a factor.
    pub(super) fn limit(&self, driven: &Driven, faster: f64, interval: f64) -> Limit<'_> {
        let wound = self.threads(driven).map(|threads| Wound::new(threads, faster, interval));
        let motor = self.made(driven).and_then(|made| made.motor.as_ref());
        let followed = motor.and_then(|motor| {
            let speeds = [&motor.speed, &motor.relaxing_speed];
            let varies = speeds.iter().any(|speed| matches!(speed, Speed::ByBend(_)));
            varies.then(|| Followed::new(speeds, faster, interval))
        });
        Limit { wound, followed }
    }

    /// Puts in what valves come to, and keeps the rest to what the hardware can do.
    pub(super) fn on_hardware(
        &self,
        parameters: &[f64],
        conditions: &Conditions,
        targets: &mut Targets,
    ) -> Result<(), EvalError> {
        // What hangs on one supply moves together.
        let mut groups: Vec<Group<'_>> = Vec::new();
        for (column, driven) in self.actuators.iter().enumerate() {
            let Some(motor) = self.made(driven).and_then(|made| made.motor.as_ref()) else { continue };
            if let Some(mut valves) = self.valves(driven, parameters)? {
                let mut supply = None;
                if let Some(Backend::Pneumatic(air)) = self.target(driven).map(|target| &target.backend) {
                    valves = valves.settled(air.shortest);
                    supply = air.supply.as_ref();
                }
                let one = Inflated {
                    valves,
                    bending: &motor.speed,
                    relaxing: &motor.relaxing_speed,
                    most: self.driven_range(driven).1,
                    late: conditions.late(column),
                    supplied: supply.is_some(),
                };
                let same = |group: &&mut Group<'_>| match (group.0, supply) {
                    (Some(one), Some(other)) => std::ptr::eq(one, other),
                    (one, other) => one.is_none() && other.is_none(),
                };
                match groups.iter_mut().find(same) {
                    Some(group) => group.1.push((column, one)),
                    None => groups.push((supply, vec![(column, one)])),
                }
                continue;
            }
            if self.reacts(driven) {
                continue;
            }
            let mut limit = self.limit(driven, conditions.speed, targets.interval);
            over(targets, column, |bend| limit.reach(bend));
        }
        for (supply, actuators) in groups {
            let (columns, inflated): (Vec<_>, Vec<_>) = actuators.into_iter().unzip();
            inflate(&inflated, supply, conditions, targets, &columns);
        }
        Ok(())
    }
}

/// Keeps a bend to speeds that may change with it: away from zero at the first, back at the second.
pub(super) fn follow(speeds: [&Speed; 2], faster: f64, targets: &mut Targets, column: usize) {
    let mut followed = Followed::new(speeds, faster, targets.interval);
    over(targets, column, |bend| followed.next(bend));
}

/// Changes the targets of an actuator, in the order of time.
fn over(targets: &mut Targets, column: usize, mut next: impl FnMut(f64) -> f64) {
    for sample in 0..targets.samples() {
        if let Some(bend) = targets.cell(sample, column) {
            *bend = next(*bend);
        }
    }
}

/// What hardware makes of what an actuator is asked for, moment by moment: what its servo reaches and how fast, and speeds that
/// change with the bend.
#[derive(Debug)]
pub(super) struct Limit<'a> {
    wound: Option<Wound<'a>>,
    followed: Option<Followed<'a>>,
}

impl Limit<'_> {
    /// The next bend, where so much is asked for. The first is that at rest.
    pub(super) fn reach(&mut self, asked: f64) -> f64 {
        let reached = self.wound.as_mut().map_or(asked, |wound| wound.next(asked));
        self.followed.as_mut().map_or(reached, |followed| followed.next(reached))
    }
}

/// What a servo reaches, and how fast: its turn and its speed hold where the thread is wound.
#[derive(Debug)]
struct Wound<'a> {
    threads: &'a Tendon,
    /// How far it turns between two moments at most, rad.
    most: f64,
    turned: f64,
    is_begun: bool,
}

impl<'a> Wound<'a> {
    fn new(threads: &'a Tendon, faster: f64, interval: f64) -> Self {
        let most = threads.speed * faster * interval;
        Self { threads, most, turned: threads.turned(0.0), is_begun: false }
    }

    fn next(&mut self, bend: f64) -> f64 {
        // At rest before it begins.
        let wanted = self.threads.turned(bend);
        if std::mem::replace(&mut self.is_begun, true) {
            self.turned += (wanted - self.turned).max(-self.most).min(self.most);
        }
        self.threads.bend(self.turned)
    }
}

/// A bend that is kept to speeds that may change with it: away from zero at the first, back at the second.
#[derive(Debug)]
struct Followed<'a> {
    bending: &'a Speed,
    relaxing: &'a Speed,
    faster: f64,
    /// How many steps there are between two moments, and how long each lasts, s.
    steps: usize,
    step: f64,
    bend: f64,
    is_begun: bool,
}

impl<'a> Followed<'a> {
    fn new([bending, relaxing]: [&'a Speed; 2], faster: f64, interval: f64) -> Self {
        let steps = libm::ceil(interval / FINE).max(1.0);
        let step = interval / steps;
        Self { bending, relaxing, faster, steps: steps as usize, step, bend: 0.0, is_begun: false }
    }

    fn next(&mut self, asked: f64) -> f64 {
        if std::mem::replace(&mut self.is_begun, true) {
            for _ in 0..self.steps {
                let back = asked * self.bend < 0.0 || asked.abs() < f64::abs(self.bend);
                let speed = if back { self.relaxing } else { self.bending }.at(self.bend) * self.faster;
                self.bend += (asked - self.bend).max(-speed * self.step).min(speed * self.step);
            }
        }
        self.bend
    }
}

/// The bends of actuators under their valves, from rest: air that comes in bends, air that goes out relaxes,
/// each at the actuator's speed; closed valves hold.
fn inflate(
    actuators: &[Inflated<'_>],
    supply: Option<&Supply>,
    conditions: &Conditions,
    targets: &mut Targets,
    columns: &[usize],
) {
    let mut bends = vec![0.0; actuators.len()];
    let mut states = vec![Valve::Closed; actuators.len()];
    let mut shares = vec![1.0; actuators.len()];
    // Constant speeds need no steps between changes.
    let constant = |actuator: &Inflated<'_>| {
        [actuator.bending, actuator.relaxing].iter().all(|speed| matches!(speed, Speed::Constant(_)))
    };
    let fine = if supply.is_none() && actuators.iter().all(constant) { f64::INFINITY } else { FINE };
    for sample in 0..targets.samples() {
        for (bend, column) in bends.iter().zip(columns) {
            if let Some(cell) = targets.cell(sample, *column) {
                *cell = *bend;
            }
        }
        let (mut now, end) = (sample as f64 * targets.interval, (sample + 1) as f64 * targets.interval);
        while now < end {
            // No further than to the next change of a valve, so that its moment counts exactly.
            let mut step = (end - now).min(fine);
            for (state, actuator) in states.iter_mut().zip(actuators) {
                let left;
                (*state, left) = actuator.state(now);
                step = step.min(left.max(NOW));
            }
            if let Some(supply) = supply {
                share(supply, conditions.pressure, actuators, &states, &bends, &mut shares);
            }
            for (((bend, state), actuator), share) in
                bends.iter_mut().zip(&states).zip(actuators).zip(&shares)
            {
                let speed = match state {
                    Valve::Closed => 0.0,
                    Valve::Inflate => actuator.bending.at(*bend) * share,
                    Valve::Vent => -actuator.relaxing.at(*bend),
                };
                *bend = (*bend + speed * conditions.speed * step).max(0.0).min(actuator.most);
            }
            now += step;
        }
    }
}

/// How fast each actuator that is being inflated bends, as a share of its speed alone.
///
/// Flow is proportional to difference of pressure, in the line from the reservoir and in each valve behind it. Where
/// the line ends, at a pressure p, what comes in goes out: `line (reservoir - p) = sum of valve (p - own)`. An
/// actuator's own pressure grows in proportion to its bend. Where p is below it, air goes back into the others.
fn share(
    supply: &Supply,
    of_pressure: f64,
    actuators: &[Inflated<'_>],
    states: &[Valve],
    bends: &[f64],
    shares: &mut [f64],
) {
    let Supply { pressure, full, line, valve } = *supply;
    let own = |bend: f64, actuator: &Inflated<'_>| full * (bend / actuator.most);
    let open = || {
        let all = states.iter().zip(bends).zip(actuators);
        all.filter(|((state, _), actuator)| **state == Valve::Inflate && actuator.supplied)
    };
    let count = open().count() as f64;
    let pressures: f64 = open().map(|((_, bend), actuator)| own(*bend, actuator)).sum();
    let node = (line * pressure * of_pressure + valve * pressures) / (line + valve * count);
    for ((share, bend), actuator) in shares.iter_mut().zip(bends).zip(actuators) {
        let own = own(*bend, actuator);
        let alone = (line * pressure + valve * own) / (line + valve);
        *share = if actuator.supplied { (node - own) / (alone - own) } else { 1.0 };
    }
}

#[cfg(test)]
mod tests {
    use grammar_lang::ir::Table;

    use super::*;

    fn wind(threads: &Tendon, faster: f64, targets: &mut Targets, column: usize) {
        let mut wound = Wound::new(threads, faster, targets.interval);
        over(targets, column, |bend| wound.next(bend));
    }

    fn valves(period: f64, shares: &[f64]) -> Valves {
        let states = [Valve::Closed, Valve::Inflate, Valve::Closed, Valve::Vent];
        Valves::cycle(period, shares, &states, 0.0).unwrap()
    }

    fn inflated<'a>(valves: Valves, bending: &'a Speed, relaxing: &'a Speed) -> Inflated<'a> {
        Inflated { valves, bending, relaxing, most: 1.5, late: 0.0, supplied: true }
    }

    fn rest(seconds: f64, interval: f64, actuators: usize) -> Targets {
        let samples = (seconds / interval).ceil() as usize + 1;
        Targets { interval, actuators, angles: vec![0.0; samples * actuators] }
    }

    #[test]
    fn a_bend_grows_holds_and_relaxes_at_its_speeds() {
        let (up, down) = (Speed::Constant(1.0), Speed::Constant(0.5));
        // Closed until 0.55 s, open until 1.35 s, closed until 2 s, emptied until 4 s.
        let one = inflated(valves(4.0, &[0.55, 0.8, 0.65, 2.0]), &up, &down);
        let mut targets = rest(8.0, 0.1, 1);
        inflate(&[one], None, &Conditions::NOMINAL, &mut targets, &[0]);
        for (time, bend) in
            [(0.5, 0.0), (1.0, 0.45), (1.4, 0.8), (2.0, 0.8), (3.0, 0.3), (3.7, 0.0), (5.0, 0.45)]
        {
            assert!((targets.at(0, time) - bend).abs() < 1e-9, "{time} s: {}", targets.at(0, time));
        }
    }

    #[test]
    fn a_speed_that_falls_with_the_bend_slows_down_as_it_should() {
        // db/dt = 1 - b, from zero: b = 1 - exp(-t).
        let up = Speed::ByBend(Table { rows: vec![[0.0, 1.0], [1.0, 0.0001]] });
        let down = Speed::Constant(1.0);
        let one = inflated(valves(10.0, &[0.0, 1.0, 0.0, 0.0]), &up, &down);
        let mut targets = rest(2.0, 0.02, 1);
        inflate(&[one], None, &Conditions::NOMINAL, &mut targets, &[0]);
        for time in [0.5, 1.0, 2.0] {
            let truth = 1.0 - libm::exp(-time);
            assert!((targets.at(0, time) - truth).abs() < 1e-3, "{time} s: {}", targets.at(0, time));
        }
    }

    #[test]
    fn actuators_that_inflate_together_share_the_flow() {
        let supply = Supply { pressure: 1.5e5, full: 1e5, line: 3.0, valve: 1.0 };
        let (up, down) = (Speed::Constant(0.2), Speed::Constant(0.2));
        let slow = || inflated(valves(100.0, &[0.0, 1.0, 0.0, 0.0]), &up, &down);
        for count in [1, 2, 5] {
            let all: Vec<_> = (0..count).map(|_| slow()).collect();
            let columns: Vec<usize> = (0..count).collect();
            let mut targets = rest(1.0, 0.1, count);
            inflate(&all, Some(&supply), &Conditions::NOMINAL, &mut targets, &columns);
            // Equal pressures: alone 1 / (1/3 + 1), together 1 / (n/3 + 1).
            let share = (1.0 / 3.0 + 1.0) / (count as f64 / 3.0 + 1.0);
            assert!((targets.at(count - 1, 1.0) - 0.2 * share).abs() < 1e-9, "{count} together");
        }
    }

    /// What flows into the actuators is what comes through the line, also where some give air to others.
    #[test]
    fn no_air_is_lost() {
        let supply = Supply { pressure: 1.5e5, full: 1.4e5, line: 0.5, valve: 1.0 };
        let speed = Speed::Constant(1.0);
        let all: Vec<_> =
            (0..3).map(|_| inflated(valves(1.0, &[0.0, 1.0, 0.0, 0.0]), &speed, &speed)).collect();
        let bends = [0.0, 0.2, 1.5];
        let mut shares = [1.0; 3];
        share(&supply, 1.0, &all, &[Valve::Inflate; 3], &bends, &mut shares);
        let own = bends.map(|bend| supply.full * bend / 1.5);
        let flows: Vec<f64> = (0..3)
            .map(|i| {
                let alone =
                    (supply.line * supply.pressure + supply.valve * own[i]) / (supply.line + supply.valve);
                supply.valve * (alone - own[i]) * shares[i]
            })
            .collect();
        let node = own[0] + flows[0] / supply.valve;
        let line = supply.line * (supply.pressure - node);
        assert!((flows.iter().sum::<f64>() - line).abs() < 1e-6 * line.abs());
        assert!(flows[2] < 0.0, "the fullest gives air to the others");
    }

    #[test]
    fn a_servo_stops_at_its_ends_and_turns_no_faster_than_it_can() {
        let thread = Table { rows: vec![[-1.0, -0.01], [0.0, 0.0], [1.0, 0.02]] };
        let threads = Tendon {
            servo: vec!["D3".to_owned()],
            opposite: Vec::new(),
            thread,
            wheel: 0.01,
            turn: (-1.0, 1.5),
            speed: 2.0,
            pulse: (1e-3, 2e-3),
            rests: true,
        };
        assert_eq!(threads.reach(), (-1.0, 0.75));
        let mut targets = Targets { interval: 0.1, actuators: 1, angles: vec![1.0; 21] };
        wind(&threads, 1.0, &mut targets, 0);
        // 2 rad/s of 10 mm wind up 20 mm/s, of which 20 mm bend by 1 rad.
        assert!((targets.at(0, 0.3) - 0.3).abs() < 1e-9 && (targets.at(0, 2.0) - 0.75).abs() < 1e-9);
    }

    #[test]
    fn what_is_late_holds_its_start_and_then_does_the_same() {
        let (up, down) = (Speed::Constant(1.0), Speed::Constant(0.5));
        let one = |late| Inflated { late, ..inflated(valves(4.0, &[0.55, 0.8, 0.65, 2.0]), &up, &down) };
        let run = |late| {
            let mut targets = rest(8.0, 0.1, 1);
            inflate(&[one(late)], None, &Conditions::NOMINAL, &mut targets, &[0]);
            targets
        };
        let (prompt, late) = (run(0.0), run(0.2));
        for sample in 0..78 {
            let time = f64::from(sample) * 0.1;
            assert!((late.at(0, time + 0.2) - prompt.at(0, time)).abs() < 1e-6, "{time} s");
        }
        // Valves that are open at once are closed until then.
        let open = Inflated { late: 0.25, ..inflated(valves(4.0, &[0.0, 1.0, 1.0, 2.0]), &up, &down) };
        let mut targets = rest(1.0, 0.05, 1);
        inflate(&[open], None, &Conditions::NOMINAL, &mut targets, &[0]);
        for (time, bend) in [(0.0, 0.0), (0.25, 0.0), (0.5, 0.25)] {
            assert!((targets.at(0, time) - bend).abs() < 1e-9, "{time} s: {}", targets.at(0, time));
        }
    }

    #[test]
    fn speeds_and_pressures_are_those_of_the_conditions() {
        let (up, down) = (Speed::Constant(0.2), Speed::Constant(0.2));
        let slow = || inflated(valves(100.0, &[0.0, 1.0, 0.0, 0.0]), &up, &down);
        let supply = Supply { pressure: 1.5e5, full: 1e5, line: 3.0, valve: 1.0 };
        let bend = |supply: Option<&Supply>, speed, pressure| {
            let mut targets = rest(1.0, 0.1, 1);
            let conditions = Conditions { speed, pressure, ..Conditions::NOMINAL };
            inflate(&[slow()], supply, &conditions, &mut targets, &[0]);
            targets.at(0, 0.1)
        };
        assert!((bend(None, 1.2, 1.0) - 0.1 * 0.2 * 1.2).abs() < 1e-9);
        // Without a supply there is no pressure; with one the flow into what is empty is as its pressure.
        assert_eq!(bend(None, 1.0, 0.5), bend(None, 1.0, 1.0));
        assert!((bend(Some(&supply), 1.0, 1.1) / bend(Some(&supply), 1.0, 1.0) - 1.1).abs() < 5e-3);
        let threads = Tendon {
            servo: vec!["D3".to_owned()],
            opposite: Vec::new(),
            thread: Table { rows: vec![[-1.0, -0.01], [0.0, 0.0], [1.0, 0.02]] },
            wheel: 0.01,
            turn: (-1.0, 1.5),
            speed: 2.0,
            pulse: (1e-3, 2e-3),
            rests: true,
        };
        let mut targets = Targets { interval: 0.1, actuators: 1, angles: vec![1.0; 21] };
        wind(&threads, 0.5, &mut targets, 0);
        assert!((targets.at(0, 0.4) - 0.2).abs() < 1e-9);
        let mut targets = Targets { interval: 0.1, actuators: 1, angles: vec![1.0; 11] };
        follow([&up, &down], 1.5, &mut targets, 0);
        assert!((targets.at(0, 1.0) - 0.3).abs() < 1e-9);
    }
}
