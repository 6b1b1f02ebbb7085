//! A schedule as the board keeps it: settings, channels and one table of bytes.

use std::collections::BTreeMap;

use super::frame::crc;
use super::message::{ChannelSetting, Config};
use super::schedule::{Output, Safe, Schedule, ValveState};

/// What is loaded into a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    /// What holds of all channels.
    pub config: Config,
    /// The channels, in order.
    pub channels: Vec<ChannelSetting>,
    /// Changes of valves, or points of curves.
    pub table: Vec<u8>,
}

impl Program {
    /// The program of a schedule that [`Schedule::check`] found sound.
    #[must_use]
    pub fn of(schedule: &Schedule) -> Self {
        let rows = match schedule.channels.first().map(|channel| &channel.output) {
            Some(Output::Servo { pulses, .. }) => pulses.len(),
            _ => valve_rows(schedule).len(),
        };
        let config = Config {
            kind: if schedule.has_valves() { 1 } else { 2 },
            safe: match schedule.safe {
                Safe::Hold => 0,
                Safe::Vent => 1,
                Safe::Release => 2,
                Safe::Rest => 3,
            },
            channels: schedule.channels.len() as u8,
            rows: rows as u16,
            period: schedule.period,
        };
        let setting = |output: &Output| match output {
            Output::Valves { inflate, vent, .. } => {
                ChannelSetting { pin: inflate.number(), vent: vent.number(), least: 0, most: 0, rest: 0 }
            }
            Output::Servo { pin, range: [least, most], rest, .. } => {
                ChannelSetting { pin: pin.number(), vent: 0xFF, least: *least, most: *most, rest: *rest }
            }
        };
        let channels = schedule.channels.iter().map(|channel| setting(&channel.output)).collect();
        Self { config, channels, table: table(schedule) }
    }

    /// The checksum of all of it, as the board computes it of what it has.
    #[must_use]
    pub fn crc(&self) -> u32 {
        let mut bytes = self.config.to_bytes();
        bytes.extend(self.channels.iter().flat_map(ChannelSetting::to_bytes));
        bytes.extend(&self.table);
        crc(&bytes)
    }
}

/// When anything changes, and what is then open: bit n for channel n.
fn valve_rows(schedule: &Schedule) -> BTreeMap<u32, [u8; 2]> {
    let all = schedule.channels.iter().enumerate().flat_map(|(i, channel)| match &channel.output {
        Output::Valves { changes, .. } => changes.iter().map(|(at, state)| (*at, (i, *state))).collect(),
        Output::Servo { .. } => Vec::new(),
    });
    let mut by_time: BTreeMap<u32, Vec<(usize, ValveState)>> = BTreeMap::new();
    for (at, change) in all {
        by_time.entry(at).or_default().push(change);
    }
    let mut open = [0_u8; 2];
    let mut rows = BTreeMap::new();
    for (at, changes) in by_time {
        for (channel, state) in changes {
            let bit = 1_u8.checked_shl(channel as u32).unwrap_or(0);
            open = open.map(|mask| mask & !bit);
            match state {
                ValveState::Inflate => open[0] |= bit,
                ValveState::Vent => open[1] |= bit,
                ValveState::Closed => {}
            }
        }
        rows.insert(at, open);
    }
    rows
}

/// The bytes of the table.
pub(crate) fn table(schedule: &Schedule) -> Vec<u8> {
    let mut out = Vec::new();
    for (at, open) in valve_rows(schedule) {
        out.extend(at.to_le_bytes());
        out.extend(open);
    }
    for channel in &schedule.channels {
        if let Output::Servo { pulses, .. } = &channel.output {
            out.extend(pulses.iter().flat_map(|pulse| pulse.to_le_bytes()));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::super::schedule::tests::{servos, valves};
    use super::*;

    #[test]
    fn changes_at_the_same_time_share_a_row() {
        let program = Program::of(&valves(&["a", "b"]));
        assert_eq!(program.config.rows, 3);
        let rows: Vec<&[u8]> = program.table.chunks(6).collect();
        assert_eq!(rows[0], [0, 0, 0, 0, 0b11, 0]);
        assert_eq!(rows[1], [&300_000_u32.to_le_bytes()[..], &[0, 0]].concat());
        assert_eq!(rows[2], [&500_000_u32.to_le_bytes()[..], &[0, 0b11]].concat());
    }

    #[test]
    fn curves_follow_each_other() {
        let program = Program::of(&servos(&["a", "b"]));
        assert_eq!((program.config.rows, program.table.len()), (64, 256));
        assert_eq!(program.table[128..130], 1600_u16.to_le_bytes());
    }

    #[test]
    fn the_checksum_covers_all() {
        let program = Program::of(&valves(&["a", "b"]));
        let mut others = vec![program.clone(), program.clone(), program.clone()];
        others[0].config.safe = 1;
        others[1].channels[1].pin = 19;
        others[2].table[3] ^= 1;
        for other in others {
            assert_ne!(other.crc(), program.crc());
        }
    }
}
