//! A session with a board: requests and their answers, said again when they are lost.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::Duration;

use super::error::Error;
use super::frame::{Decoder, Frame};
use super::link::Link;
use super::message::{Event, PIECE, Refusal, Reply, Request, State, Status, VERSION, Welcome};
use super::program::Program;
use super::schedule::Schedule;

/// How long an answer may take before the request is said again.
const ANSWER: Duration = Duration::from_millis(100);
/// How often a request is said.
const TRIES: usize = 10;
/// How long a board may take to greet: an Uno needs 1.5 s, as it resets when its port is opened.
const GREETING: Duration = Duration::from_secs(5);
/// How long another host that has just ended may still seem alive.
const OTHER: Duration = Duration::from_secs(2);

/// A session with a board. When it is dropped while the board runs, the board is told to stop.
#[derive(Debug)]
pub struct Session<L: Link> {
    link: L,
    id: u32,
    sequence: u8,
    decoder: Decoder,
    events: Vec<Event>,
    welcome: Welcome,
    running: bool,
    /// How long a cycle of what was loaded takes; none if nothing was.
    period: Duration,
}

/// A number that no other host has.
fn random() -> u32 {
    let number = RandomState::new().build_hasher().finish();
    (number as u32).max(1)
}

impl<L: Link> Session<L> {
    /// Greets the board, again and again while it starts.
    ///
    /// # Errors
    ///
    /// [`Error::Silent`] after five seconds, [`Error::OtherHost`], [`Error::OtherVersion`], or what befalls the line.
    pub fn open(link: L) -> Result<Self, Error> {
        Self::open_as(link, random())
    }

    /// The same with a session number of one's own, not zero: for tests.
    ///
    /// # Errors
    ///
    /// As [`Session::open`].
    pub fn open_as(mut link: L, id: u32) -> Result<Self, Error> {
        let begun = link.now();
        let mut decoder = Decoder::default();
        let mut refused = None;
        let nonce = id.rotate_left(16) ^ 0x5A5A_5A5A;
        let hello = Request::Hello { nonce };
        let frame = Frame { kind: hello.kind(), session: id, sequence: 0, payload: hello.payload() };
        while link.now() - begun < GREETING {
            link.send(&frame.encode())?;
            let until = link.now() + ANSWER * 2;
            while link.now() < until {
                let bytes = link.receive(until.saturating_sub(link.now()))?;
                for answer in decoder.feed(&bytes) {
                    let ours = answer.session == id && answer.sequence == 0;
                    match Reply::decode(answer.kind, &answer.payload) {
                        Some(Reply::Welcome(welcome)) if ours && welcome.nonce == nonce => {
                            if welcome.version != VERSION {
                                return Err(Error::OtherVersion { board: welcome.version });
                            }
                            let (events, welcome) = (Vec::new(), *welcome);
                            return Ok(Self {
                                link,
                                id,
                                sequence: 0,
                                decoder,
                                events,
                                welcome,
                                running: false,
                                period: Duration::ZERO,
                            });
                        }
                        Some(Reply::Error { refusal: Refusal::OtherVersion, detail, .. }) if ours => {
                            return Err(Error::OtherVersion { board: detail as u8 });
                        }
                        Some(Reply::Error { refusal: Refusal::Busy, .. }) if ours => {
                            let since = *refused.get_or_insert(link.now());
                            if link.now() - since > OTHER {
                                return Err(Error::OtherHost);
                            }
                        }
                        _ => {}
                    }
                }
            }
        }
        Err(Error::Silent { waited: GREETING })
    }

    /// What the board has said of itself at the beginning.
    #[must_use]
    pub fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    /// The line.
    pub fn link(&mut self) -> &mut L {
        &mut self.link
    }

    /// Takes what the board has told by itself since the last call.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Ends an emergency stop or a fault. Nothing moves; what was loaded must be loaded again.
    ///
    /// # Errors
    ///
    /// [`Error::StopCircuit`] while the stop circuit is open, or what befalls the line.
    pub fn clear(&mut self) -> Result<(), Error> {
        self.ask(&Request::Clear).map(|_| ())
    }

    /// Loads a schedule and lets the board verify it. Nothing moves.
    ///
    /// # Errors
    ///
    /// [`Error::Unfit`] with all that is wrong with it, [`Error::Latched`], or what befalls the line.
    pub fn load(&mut self, schedule: &Schedule) -> Result<(), Error> {
        let problems = schedule.check(&self.welcome.limits);
        if !problems.is_empty() {
            return Err(Error::Unfit(problems));
        }
        let status = self.status()?;
        if matches!(status.state, State::Estopped | State::Fault) {
            return Err(Error::Latched { state: status.state, faults: status.faults });
        }
        self.period = Duration::from_micros(u64::from(schedule.period));
        let program = Program::of(schedule);
        let crc = program.crc();
        self.ask(&Request::Config(program.config))?;
        for (index, setting) in program.channels.into_iter().enumerate() {
            self.ask(&Request::Channel { index: index as u8, setting })?;
        }
        for (i, piece) in program.table.chunks(PIECE).enumerate() {
            self.ask(&Request::Load { offset: (i * PIECE) as u16, bytes: piece.to_vec() })?;
        }
        self.ask(&Request::Commit { crc }).map(|_| ())
    }

    /// Starts what was loaded: so many cycles, or until it is stopped if 0. From now on the board stops by itself
    /// when it does not hear of this session for so long; [`Session::status`] is what it wants to hear.
    ///
    /// # Errors
    ///
    /// [`Error::Timeout`] if the time is not between 0.1 s and 5 s, [`Error::Latched`], or what befalls the line.
    pub fn start(&mut self, cycles: u32, silence: Duration) -> Result<(), Error> {
        let timeout = u16::try_from(silence.as_millis()).ok().filter(|ms| (100..=5000).contains(ms));
        let timeout = timeout.ok_or(Error::Timeout { asked: silence })?;
        // It may run although its answer is lost.
        self.running = true;
        self.ask(&Request::Start { cycles, timeout }).map(|_| ())
    }

    /// Asks how the run stands; the board takes it as a sign of life.
    ///
    /// # Errors
    ///
    /// [`Error::Reset`] if the board has forgotten this session, or what befalls the line.
    pub fn status(&mut self) -> Result<Status, Error> {
        match self.ask(&Request::Heartbeat)? {
            Reply::Status(status) => {
                self.running &= status.state == State::Running;
                Ok(status)
            }
            // An answer to something else: no board of this version gives it.
            _ => Err(Error::Refused {
                request: Request::Heartbeat.kind(),
                refusal: Refusal::Unknown,
                detail: 0,
            }),
        }
    }

    /// Ends a run; the outputs go to the safe state.
    ///
    /// # Errors
    ///
    /// [`Error::StillRunning`] if the board says that it does not, or what befalls the line.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.ask(&Request::Stop)?;
        self.is_still()
    }

    /// Ends a run; nothing starts before [`Session::clear`].
    ///
    /// # Errors
    ///
    /// [`Error::StillRunning`] if the board says that it does not end, or what befalls the line.
    pub fn emergency_stop(&mut self) -> Result<(), Error> {
        self.ask(&Request::Estop)?;
        self.is_still()
    }

    /// Sees that the board does what it was told to: the answer to an order says only that it was heard.
    fn is_still(&mut self) -> Result<(), Error> {
        if self.status()?.state == State::Running { Err(Error::StillRunning) } else { Ok(()) }
    }

    /// The time since some moment that stays the same, by the clock of the line.
    pub(super) fn now(&self) -> Duration {
        self.link.now()
    }

    /// For how long the board says that it has run.
    pub(super) fn run_for(&self, status: &Status) -> Duration {
        self.period.saturating_mul(status.cycle) + Duration::from_micros(u64::from(status.phase))
    }

    /// Waits, and hears what the board tells by itself.
    ///
    /// # Errors
    ///
    /// What befalls the line.
    pub fn wait(&mut self, time: Duration) -> Result<(), Error> {
        let until = self.link.now() + time;
        while self.link.now() < until && self.events.is_empty() {
            self.hear(until)?;
        }
        Ok(())
    }

    /// Says a request until it is answered. The board executes it once, however often it comes.
    fn ask(&mut self, request: &Request) -> Result<Reply, Error> {
        self.sequence = self.sequence.wrapping_add(1);
        let frame = Frame {
            kind: request.kind(),
            session: self.id,
            sequence: self.sequence,
            payload: request.payload(),
        };
        for _ in 0..TRIES {
            self.link.send(&frame.encode())?;
            let until = self.link.now() + ANSWER;
            while self.link.now() < until {
                for (sequence, reply) in self.hear(until)? {
                    if sequence == self.sequence {
                        return self.accept(request, reply);
                    }
                }
            }
        }
        Err(Error::Silent { waited: ANSWER * TRIES as u32 })
    }

    /// Answers that have come; events are kept.
    fn hear(&mut self, until: Duration) -> Result<Vec<(u8, Reply)>, Error> {
        let bytes = self.link.receive(until.saturating_sub(self.link.now()))?;
        let mut answers = Vec::new();
        for frame in self.decoder.feed(&bytes) {
            match Reply::decode(frame.kind, &frame.payload) {
                Some(Reply::Event { event, .. }) => self.events.push(event),
                Some(reply) if frame.session == self.id => answers.push((frame.sequence, reply)),
                _ => {}
            }
        }
        Ok(answers)
    }

    fn accept(&mut self, request: &Request, reply: Reply) -> Result<Reply, Error> {
        let Reply::Error { refusal, request: number, detail } = reply else { return Ok(reply) };
        match refusal {
            Refusal::NoSession => {
                self.running = false;
                Err(Error::Reset)
            }
            Refusal::StopCircuitOpen => Err(Error::StopCircuit),
            Refusal::WrongState if !matches!(request, Request::Heartbeat) => {
                let status = self.status()?;
                match status.state {
                    State::Estopped | State::Fault => {
                        Err(Error::Latched { state: status.state, faults: status.faults })
                    }
                    _ => Err(Error::Refused { request: number, refusal, detail }),
                }
            }
            _ => Err(Error::Refused { request: number, refusal, detail }),
        }
    }
}

impl<L: Link> Drop for Session<L> {
    fn drop(&mut self) {
        if self.running {
            // If this is not heard, the board stops by itself, as it hears nothing else.
            let _ = self.stop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::supervise::{Outcome, Plan, Wish, run};
    use super::*;

    /// A line to something that says the same whatever it hears.
    struct Parrot {
        says: fn(&Frame) -> Vec<u8>,
        heard: Decoder,
        answers: Vec<u8>,
        clock: Duration,
    }

    impl Link for Parrot {
        fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
            for frame in self.heard.feed(bytes) {
                self.answers.extend((self.says)(&frame));
            }
            Ok(())
        }

        fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
            self.clock += wait;
            Ok(std::mem::take(&mut self.answers))
        }

        fn now(&self) -> Duration {
            self.clock
        }
    }

    fn greeted(says: fn(&Frame) -> Vec<u8>) -> Error {
        let link = Parrot { says, heard: Decoder::default(), answers: Vec::new(), clock: Duration::ZERO };
        match Session::open_as(link, 7) {
            Err(error) => error,
            Ok(_) => panic!("a session with a parrot"),
        }
    }

    #[test]
    fn a_board_with_another_firmware_is_told() {
        let hello = greeted(|_| b"Hello from another sketch\r\n\0".to_vec());
        assert!(matches!(hello, Error::Silent { .. }), "{hello}");
        // The code 11: another version.
        let older =
            greeted(|frame| Frame { kind: 0x84, payload: vec![11, 1, 9, 0], ..frame.clone() }.encode());
        assert!(matches!(older, Error::OtherVersion { board: 9 }), "{older}");
    }

    /// A board that takes every order and says of itself what it is told to: by how long it has run, and whether it was
    /// told to stop.
    struct Liar {
        says: fn(Duration, bool) -> (State, u32, u32),
        heard: Decoder,
        answers: Vec<u8>,
        clock: Duration,
        begun: Duration,
        is_stopped: bool,
    }

    impl Link for Liar {
        fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
            for frame in self.heard.feed(bytes) {
                self.is_stopped |= frame.kind == Request::Stop.kind();
                let (kind, payload) = if frame.kind == 1 {
                    let nonce = frame.payload.get(1..5).unwrap();
                    (0x81, [nonce, &[VERSION], &[0; 25]].concat())
                } else if frame.kind == Request::Heartbeat.kind() {
                    let (state, cycle, phase) = (self.says)(self.clock - self.begun, self.is_stopped);
                    let state =
                        [State::Idle, State::Armed, State::Running].iter().position(|s| *s == state).unwrap();
                    let numbers = [cycle.to_le_bytes(), phase.to_le_bytes()].concat();
                    (0x83, [&[state as u8, 0], &numbers[..], &[0; 6]].concat())
                } else {
                    // The start is 6.
                    self.begun = if frame.kind == 6 { self.clock } else { self.begun };
                    (0x82, Vec::new())
                };
                self.answers.extend(Frame { kind, payload, ..frame }.encode());
            }
            Ok(())
        }

        fn receive(&mut self, wait: Duration) -> Result<Vec<u8>, Error> {
            if self.answers.is_empty() {
                self.clock += wait;
            }
            Ok(std::mem::take(&mut self.answers))
        }

        fn now(&self) -> Duration {
            self.clock
        }
    }

    /// Ten cycles of a second, stopped by the user after so many heartbeats.
    fn run_with(says: fn(Duration, bool) -> (State, u32, u32), beats: usize) -> Result<Outcome, Error> {
        let (heard, clock, begun) = (Decoder::default(), Duration::ZERO, Duration::ZERO);
        let link = Liar { says, heard, answers: Vec::new(), clock, begun, is_stopped: false };
        let mut session = Session::open_as(link, 7).unwrap();
        session.period = Duration::from_secs(1);
        let mut left = beats;
        run(&mut session, &Plan { cycles: 10, ..Plan::default() }, &mut |_| {
            left = left.saturating_sub(1);
            if left == 0 { Wish::Stop } else { Wish::GoOn }
        })
    }

    /// Where a board stands that has run for so long, `rate` times as fast as it should.
    fn honest(passed: Duration, rate: f64, is_stopped: bool) -> (State, u32, u32) {
        let time = passed.mul_f64(rate);
        let is_over = is_stopped || time >= Duration::from_secs(10);
        let state = if is_over { State::Armed } else { State::Running };
        (state, time.as_secs().min(10) as u32, time.subsec_micros())
    }

    #[test]
    fn a_board_is_not_believed_that_contradicts_itself() {
        let done = run_with(|passed, stopped| honest(passed, 1.0, stopped), 1000).unwrap();
        assert_eq!(done, Outcome::Completed { cycles: 10 });
        let stopped = run_with(|passed, stopped| honest(passed, 1.0, stopped), 20).unwrap();
        assert_eq!(stopped, Outcome::Stopped { cycles: 1 });

        let early = run_with(|_, _| (State::Armed, 3, 0), 1000).unwrap_err();
        assert!(matches!(early, Error::EndedOtherwise { asked: 10, run: 3 }), "{early}");
        let late = run_with(|_, _| (State::Armed, u32::MAX, 0), 1000).unwrap_err();
        assert!(matches!(late, Error::EndedOtherwise { .. }), "{late}");
        let deaf = run_with(|passed, _| honest(passed, 1.0, false), 20).unwrap_err();
        assert!(matches!(deaf, Error::StillRunning), "{deaf}");
        for says in
            [|passed, stopped| honest(passed, 0.5, stopped), |_: Duration, _: bool| (State::Running, 0, 0)]
        {
            let slow = run_with(says, 1000).unwrap_err();
            assert!(matches!(slow, Error::Clock { host, .. } if host < Duration::from_secs(6)), "{slow}");
        }
    }
}
