//! The messages of the protocol, as `firmware/PROTOCOL.md` says them. All numbers are little-endian.

use super::frame::MAX_PAYLOAD;
use super::pin::Pin;

/// The version of the protocol that this program speaks.
pub const VERSION: u8 = 1;
/// How many bytes of a table one message carries.
pub const PIECE: usize = MAX_PAYLOAD - 2;

/// What a host asks of a board.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Begins a session.
    Hello {
        /// Comes back in the answer.
        nonce: u32,
    },
    /// Forgets what was loaded, and says what holds of all channels.
    Config(Config),
    /// One channel; they come in order.
    Channel {
        /// Which.
        index: u8,
        /// What holds of it.
        setting: ChannelSetting,
    },
    /// A piece of the table.
    Load {
        /// Where it begins, in bytes.
        offset: u16,
        /// At most [`PIECE`] bytes.
        bytes: Vec<u8>,
    },
    /// All is loaded: the board checks it.
    Commit {
        /// The checksum of all of it.
        crc: u32,
    },
    /// Runs it.
    Start {
        /// How often; 0: until it is stopped.
        cycles: u32,
        /// How long the host may be silent, in milliseconds.
        timeout: u16,
    },
    /// Ends a run, in the safe state.
    Stop,
    /// The same, and nothing starts before [`Request::Clear`].
    Estop,
    /// Ends an emergency stop or a fault.
    Clear,
    /// The host is there; what is the status?
    Heartbeat,
}

/// What holds of all channels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Config {
    /// 1: valves; 2: servos.
    pub kind: u8,
    /// 0: hold; 1: vent; 2: release; 3: rest.
    pub safe: u8,
    /// How many channels.
    pub channels: u8,
    /// Changes of valves in the table, or points of each curve.
    pub rows: u16,
    /// The period in microseconds.
    pub period: u32,
}

/// What holds of one channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelSetting {
    /// The servo, or the valve that inflates.
    pub pin: u8,
    /// The valve that vents.
    pub vent: u8,
    /// The shortest pulse, in microseconds.
    pub least: u16,
    /// The longest pulse, in microseconds.
    pub most: u16,
    /// The pulse at rest, in microseconds.
    pub rest: u16,
}

impl Config {
    /// Its bytes in the message and in the checksum.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = vec![self.kind, self.safe, self.channels];
        out.extend(self.rows.to_le_bytes());
        out.extend(self.period.to_le_bytes());
        out
    }
}

impl ChannelSetting {
    /// Its bytes in the message and in the checksum.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = vec![self.pin, self.vent];
        out.extend([self.least, self.most, self.rest].into_iter().flat_map(u16::to_le_bytes));
        out
    }
}

impl Request {
    /// Its number.
    #[must_use]
    pub fn kind(&self) -> u8 {
        match self {
            Self::Hello { .. } => 0x01,
            Self::Config(_) => 0x02,
            Self::Channel { .. } => 0x03,
            Self::Load { .. } => 0x04,
            Self::Commit { .. } => 0x05,
            Self::Start { .. } => 0x06,
            Self::Stop => 0x07,
            Self::Estop => 0x08,
            Self::Clear => 0x09,
            Self::Heartbeat => 0x0A,
        }
    }

    /// Its payload.
    #[must_use]
    pub fn payload(&self) -> Vec<u8> {
        match self {
            Self::Hello { nonce } => [&[VERSION], &nonce.to_le_bytes()[..]].concat(),
            Self::Config(config) => config.to_bytes(),
            Self::Channel { index, setting } => [&[*index], &setting.to_bytes()[..]].concat(),
            Self::Load { offset, bytes } => [&offset.to_le_bytes(), &bytes[..]].concat(),
            Self::Commit { crc } => crc.to_le_bytes().to_vec(),
            Self::Start { cycles, timeout } => [&cycles.to_le_bytes()[..], &timeout.to_le_bytes()].concat(),
            Self::Stop | Self::Estop | Self::Clear | Self::Heartbeat => Vec::new(),
        }
    }
}

/// What a board is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Nothing is loaded.
    Idle,
    /// A schedule is loaded and not running.
    Armed,
    /// The schedule is running.
    Running,
    /// An emergency stop; needs [`Request::Clear`].
    Estopped,
    /// The host was silent, or the board hung; needs [`Request::Clear`].
    Fault,
}

impl State {
    fn from_byte(byte: u8) -> Option<Self> {
        [Self::Idle, Self::Armed, Self::Running, Self::Estopped, Self::Fault].get(usize::from(byte)).copied()
    }
}

/// What has gone wrong since the last [`Request::Clear`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults(pub u8);

impl Faults {
    /// The host was silent during a run.
    #[must_use]
    pub fn link(self) -> bool {
        self.0 & 1 != 0
    }

    /// The board's program hung, and its watchdog made a reset.
    #[must_use]
    pub fn watchdog(self) -> bool {
        self.0 & 2 != 0
    }

    /// The stop circuit was opened.
    #[must_use]
    pub fn stop_circuit(self) -> bool {
        self.0 & 4 != 0
    }

    /// A host asked for an emergency stop.
    #[must_use]
    pub fn stop_message(self) -> bool {
        self.0 & 8 != 0
    }
}

/// What a board can do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limits {
    /// How many actuators it drives.
    pub channels: usize,
    /// Bytes of its table.
    pub table: usize,
    /// The shortest and the longest pulse, in microseconds.
    pub pulses: (u16, u16),
    /// The shortest and the longest period, in microseconds.
    pub periods: (u32, u32),
    /// Its outputs: bit n for the pin of that [number](Pin::number).
    pub pins: u32,
    /// How late valves may be, in microseconds.
    pub tick: u16,
}

/// The limits of the firmware that comes with this program.
impl Default for Limits {
    fn default() -> Self {
        Self {
            channels: 8,
            table: 1024,
            pulses: (500, 2400),
            periods: (100_000, 600_000_000),
            pins: Pin::all().map(|pin| 1 << pin.number()).sum(),
            tick: 100,
        }
    }
}

/// What a board says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Welcome {
    /// The nonce of the request.
    pub nonce: u32,
    /// Its version of the protocol.
    pub version: u8,
    /// Whether it drives valves.
    pub valves: bool,
    /// Whether it drives servos.
    pub servos: bool,
    /// What it is doing.
    pub state: State,
    /// What has gone wrong.
    pub faults: Faults,
    /// The chip's register `MCUSR` at the last reset: bit 0 power, 1 button, 2 brown-out, 3 watchdog. Zero where
    /// the boot loader has cleared it.
    pub reset_cause: u8,
    /// What it can do.
    pub limits: Limits,
}

/// How a run stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// What the board is doing.
    pub state: State,
    /// What has gone wrong.
    pub faults: Faults,
    /// Complete cycles.
    pub cycle: u32,
    /// The time since the present cycle began, in microseconds.
    pub phase: u32,
    /// The most that the stack of the board has held since its reset, in bytes.
    pub stack_used: u16,
    /// What was never used of its memory, in bytes.
    pub stack_free: u16,
    /// Broken frames since its reset.
    pub bad_frames: u16,
}

/// What a board says without being asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The last cycle is complete.
    Done,
    /// The host was silent; the board is in the safe state.
    LinkLost,
    /// The stop circuit was opened.
    StopPressed,
    /// The board has begun anew.
    Reset,
}

/// Why a board refuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Another host drives it.
    Busy,
    /// It knows no such session: it was reset.
    NoSession,
    /// An older request came after a newer one.
    OldSequence,
    /// It does not know the message.
    Unknown,
    /// Not in its present state.
    WrongState,
    /// No output, or used twice.
    BadPin,
    /// A setting is beyond its limits.
    OutOfLimits,
    /// A row of the table is wrong.
    BadTable,
    /// What it has is not what the host meant.
    OtherTable,
    /// The stop circuit is open.
    StopCircuitOpen,
    /// It speaks another version.
    OtherVersion,
    /// Something comes before it.
    NothingLoaded,
    /// A number that this version does not know.
    Other(u8),
}

impl Refusal {
    fn from_byte(byte: u8) -> Self {
        match byte {
            1 => Self::Busy,
            2 => Self::NoSession,
            3 => Self::OldSequence,
            4 => Self::Unknown,
            5 => Self::WrongState,
            6 => Self::BadPin,
            7 => Self::OutOfLimits,
            8 => Self::BadTable,
            9 => Self::OtherTable,
            10 => Self::StopCircuitOpen,
            11 => Self::OtherVersion,
            12 => Self::NothingLoaded,
            other => Self::Other(other),
        }
    }
}

/// What a board answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// To [`Request::Hello`].
    Welcome(Box<Welcome>),
    /// Done.
    Ack,
    /// To [`Request::Heartbeat`].
    Status(Status),
    /// Not done.
    Error {
        /// Why.
        refusal: Refusal,
        /// The number of the request.
        request: u8,
        /// A row, a version: depends on why.
        detail: u16,
    },
    /// No answer: something has happened.
    Event {
        /// What.
        event: Event,
        /// The state since then.
        state: State,
    },
}

/// Numbers out of bytes, one after the other.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*first)
    }

    fn u8(&mut self) -> Option<u8> {
        self.take::<1>().map(|[byte]| byte)
    }

    fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }
}

impl Reply {
    /// Reads an answer; nothing if it is none.
    #[must_use]
    pub fn decode(kind: u8, payload: &[u8]) -> Option<Self> {
        let mut from = Reader(payload);
        let reply = match kind {
            0x81 => Self::Welcome(Box::new(welcome(&mut from)?)),
            0x82 => Self::Ack,
            0x83 => Self::Status(Status {
                state: State::from_byte(from.u8()?)?,
                faults: Faults(from.u8()?),
                cycle: from.u32()?,
                phase: from.u32()?,
                stack_used: from.u16()?,
                stack_free: from.u16()?,
                bad_frames: from.u16()?,
            }),
            0x84 => Self::Error {
                refusal: Refusal::from_byte(from.u8()?),
                request: from.u8()?,
                detail: from.u16()?,
            },
            0x85 => Self::Event {
                event: match from.u8()? {
                    1 => Event::Done,
                    2 => Event::LinkLost,
                    3 => Event::StopPressed,
                    4 => Event::Reset,
                    _ => return None,
                },
                state: State::from_byte(from.u8()?)?,
            },
            _ => return None,
        };
        from.0.is_empty().then_some(reply)
    }
}

fn welcome(from: &mut Reader<'_>) -> Option<Welcome> {
    let nonce = from.u32()?;
    let version = from.u8()?;
    let kinds = from.u8()?;
    let channels = usize::from(from.u8()?);
    let state = State::from_byte(from.u8()?)?;
    let faults = Faults(from.u8()?);
    let reset_cause = from.u8()?;
    let table = usize::from(from.u16()?);
    let tick = from.u16()?;
    let pulses = (from.u16()?, from.u16()?);
    let periods = (from.u32()?, from.u32()?);
    let limits = Limits { channels, table, pulses, periods, pins: from.u32()?, tick };
    let (valves, servos) = (kinds & 1 != 0, kinds & 2 != 0);
    Some(Welcome { nonce, version, valves, servos, state, faults, reset_cause, limits })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn any_bytes_are_an_answer_or_none(kind: u8, payload in proptest::collection::vec(any::<u8>(), 0..40)) {
            let _ = Reply::decode(kind, &payload);
        }
    }

    #[test]
    fn an_answer_has_its_length() {
        let status = [2, 0, 7, 0, 0, 0, 9, 0, 0, 0, 1, 0, 2, 0, 3, 0];
        let Some(Reply::Status(read)) = Reply::decode(0x83, &status) else { panic!("no status") };
        assert_eq!((read.state, read.cycle, read.phase, read.bad_frames), (State::Running, 7, 9, 3));
        assert_eq!(Reply::decode(0x83, &status[1..]), None);
        assert_eq!(Reply::decode(0x83, &[&status[..], &[0]].concat()), None);
        assert_eq!(Reply::decode(0x82, &[0]), None);
    }

    #[test]
    fn requests_are_as_documented() {
        assert_eq!(Request::Hello { nonce: 0x0403_0201 }.payload(), [1, 1, 2, 3, 4]);
        assert_eq!(Request::Start { cycles: 3, timeout: 500 }.payload(), [3, 0, 0, 0, 0xF4, 1]);
        let config = Config { kind: 1, safe: 1, channels: 8, rows: 4, period: 0x0102_0304 };
        assert_eq!(Request::Config(config).payload(), [1, 1, 8, 4, 0, 4, 3, 2, 1]);
        let setting = ChannelSetting { pin: 3, vent: 255, least: 600, most: 2400, rest: 1500 };
        let payload = [2, 3, 255, 0x58, 2, 0x60, 9, 0xDC, 5];
        assert_eq!(Request::Channel { index: 2, setting }.payload(), payload);
    }
}
