//! Frames that are broken, cut, doubled or out of place change nothing.

use std::time::Duration;

use sgc::hardware::frame::{Decoder, Frame};
use sgc::hardware::message::{ChannelSetting, Config, Reply, Request};
use sgc::hardware::{Channel, Link, Plan, Safe, State};

use super::{Rig, session, valves};
use crate::fuzz::mutate::Random;
use crate::support::is_long;

/// What the board says within a time.
pub(crate) fn answers(rig: &mut Rig, time: Duration) -> Vec<Reply> {
    let until = rig.now() + time;
    let mut decoder = Decoder::default();
    let mut out = Vec::new();
    while rig.now() < until {
        let bytes = rig.receive(until - rig.now()).unwrap();
        let replies = decoder.feed(&bytes).into_iter().filter_map(|f| Reply::decode(f.kind, &f.payload));
        out.extend(replies.filter(|reply| !matches!(reply, Reply::Event { .. })));
    }
    out
}

/// Requests that would all do harm if they were heard.
fn requests() -> Vec<Request> {
    vec![
        Request::Start { cycles: 0, timeout: 5000 },
        Request::Stop,
        Request::Estop,
        Request::Clear,
        Request::Hello { nonce: 3 },
        Request::Config(Config { kind: 1, safe: 1, channels: 8, rows: 4, period: 1_000_000 }),
        Request::Channel {
            index: 0,
            setting: ChannelSetting { pin: 3, vent: 4, least: 0, most: 0, rest: 0 },
        },
        Request::Load { offset: 0, bytes: (0..58).collect() },
        Request::Commit { crc: 0x1234 },
    ]
}

/// Breaks a frame.
fn broken(line: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = line.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(out.len());
        match random.below(7) {
            0 | 1 => out[at] ^= 1 << random.below(8),
            2 => out[at] = random.below(256) as u8,
            3 => out.truncate(at.max(1)),
            4 => out.insert(at, random.below(256) as u8),
            5 => drop(out.drain(at..(at + 1 + random.below(4)).min(out.len()))),
            _ => out = (0..1 + random.below(120)).map(|_| random.below(256) as u8).collect(),
        }
        if out.is_empty() {
            out.push(7);
        }
    }
    out
}

/// Whether there is a whole frame in what is on the line after this, or would be if it ended here: what is left of one
/// frame and what is left of the next may be one.
fn is_whole(line: &Decoder, piece: &[u8]) -> bool {
    let mut line = line.clone();
    !line.feed(piece).is_empty() || !line.feed(&[0]).is_empty()
}

#[test]
fn mutilated_frames_change_nothing() {
    let many = if is_long() { 100_000 } else { 2000 };
    let mut random = Random(11);
    let Some(mut session) = session() else { return };
    let schedule = valves::eight(Safe::Hold);
    session.load(&schedule).unwrap();
    let mut sequence = 100_u8;
    let mut whole = 0;
    // What is on the line since the last zero.
    let mut line = Decoder::default();
    for half in [State::Armed, State::Running] {
        if half == State::Running {
            session.start(0, Plan::default().silence).unwrap();
        }
        for i in 0..many / 2 {
            let request = &requests()[random.below(requests().len())];
            // Newer than all that the session has said, so that it would be heard.
            sequence = sequence.wrapping_add(1);
            let frame =
                Frame { kind: request.kind(), session: 0x1234_5678, sequence, payload: request.payload() };
            let piece = broken(&frame.encode(), &mut random);
            if is_whole(&line, &piece) {
                whole += 1;
                continue;
            }
            line.feed(&piece);
            session.link().send(&piece).unwrap();
            session.link().pass(Duration::from_millis(4));
            if i % 20 == 0 {
                line.feed(&[0]);
                session.link().send(&[0]).unwrap();
                let status = session.status().unwrap();
                assert_eq!(status.state, half, "after {i} frames");
                assert_eq!(status.faults.0, 0);
            }
        }
        if half == State::Armed {
            assert_eq!(session.link().trace().changes(), 0, "an output has moved");
        }
    }
    let status = session.status().unwrap();
    println!(
        "{many} frames ({whole} of them still whole, not sent), {} told as broken, {:.0} s",
        status.bad_frames,
        session.link().now().as_secs_f64()
    );
    // The run is the one that was loaded: as many changes as its cycles have.
    session.stop().unwrap();
    assert!(status.bad_frames > 0 && whole * 10 < many);
    let changes = session.link().trace().changes() as u32;
    let many_in = |cycles| -> u32 {
        let pins = |channel: &Channel| channel.output.pins();
        let edges = |channel: &Channel, pin| {
            valves::edges(&channel.output, pin, schedule.period, cycles).len() as u32
        };
        schedule.channels.iter().flat_map(|c| pins(c).into_iter().map(move |pin| edges(c, pin))).sum()
    };
    let in_a_cycle = many_in(2) - many_in(1);
    let expected = in_a_cycle * status.cycle;
    assert!(changes.abs_diff(expected) <= 2 * in_a_cycle, "{changes} changes in {} cycles", status.cycle);
}

#[test]
fn repeated_frames_are_done_once() {
    let Some(mut session) = session() else { return };
    session.load(&valves::eight(Safe::Hold)).unwrap();
    let line = |request: &Request, sequence: u8| {
        let (kind, payload) = (request.kind(), request.payload());
        Frame { kind, session: 0x1234_5678, sequence, payload }.encode()
    };
    let mut say = |line: &[u8]| {
        let rig = session.link();
        rig.send(line).unwrap();
        answers(rig, Duration::from_millis(30))
    };
    // Started, stopped, and the start is said again: by then it is old.
    let start = line(&Request::Start { cycles: 0, timeout: 500 }, 100);
    assert_eq!(say(&start), [Reply::Ack]);
    assert_eq!(say(&start), [Reply::Ack]);
    let stop = line(&Request::Stop, 101);
    assert_eq!(say(&stop), [Reply::Ack]);
    for _ in 0..10 {
        assert!(matches!(say(&start)[..], [Reply::Error { .. }]));
        assert_eq!(say(&stop), [Reply::Ack]);
    }
    // A greeting that comes again does not make old requests new.
    let hello = line(&Request::Hello { nonce: 1 }, 0);
    assert!(matches!(say(&hello)[..], [Reply::Welcome(_)]));
    assert!(matches!(say(&start)[..], [Reply::Error { .. }]));
    let changes = session.link().trace().changes();
    session.link().pass(Duration::from_secs(2));
    assert_eq!(session.link().trace().changes(), changes);
    // A heartbeat that is said again is answered as before, and is no new one.
    let beat = line(&Request::Heartbeat, 102);
    let mut say = |line: &[u8]| {
        let rig = session.link();
        rig.send(line).unwrap();
        answers(rig, Duration::from_millis(30))
    };
    let first = say(&beat);
    assert!(matches!(first[..], [Reply::Status(_)]));
    assert_eq!(say(&beat), first);
}

#[test]
fn tables_that_are_not_sound_are_refused_by_the_board() {
    let Some(mut session) = session() else { return };
    let mut sequence = 0;
    let mut say = |request: &Request| {
        sequence += 1;
        let (kind, payload) = (request.kind(), request.payload());
        let frame = Frame { kind, session: 0x1234_5678, sequence, payload };
        session.link().send(&frame.encode()).unwrap();
        let answers = answers(session.link(), Duration::from_millis(40));
        format!("{answers:?}")
    };
    let setting = |pin, vent| ChannelSetting { pin, vent, least: 0, most: 0, rest: 0 };
    let config = |kind, safe, rows| Config { kind, safe, channels: 1, rows, period: 1_000_000 };
    // Rows of a table of valves, and what the board says to it.
    for (rows, refusal) in [
        (vec![(0_u32, 1_u8, 0_u8), (500_000, 0, 1)], "Ack"),
        (vec![(0, 1, 1)], "BadTable"),
        (vec![(0, 2, 0)], "BadTable"),
        (vec![(5, 1, 0)], "BadTable"),
        (vec![(0, 1, 0), (0, 0, 1)], "BadTable"),
        (vec![(0, 1, 0), (1_000_000, 0, 1)], "BadTable"),
    ] {
        let config = config(1, 0, rows.len() as u16);
        let table: Vec<u8> = rows
            .iter()
            .flat_map(|(at, inflate, vent)| [&at.to_le_bytes()[..], &[*inflate, *vent]].concat())
            .collect();
        let all = [config.to_bytes(), setting(3, 4).to_bytes(), table.clone()].concat();
        assert!(say(&Request::Config(config)).contains("Ack"));
        assert!(say(&Request::Channel { index: 0, setting: setting(3, 4) }).contains("Ack"));
        assert!(say(&Request::Load { offset: 0, bytes: table }).contains("Ack"));
        assert!(say(&Request::Commit { crc: !sgc::hardware::frame::crc(&all) }).contains("OtherTable"));
        let answer = say(&Request::Commit { crc: sgc::hardware::frame::crc(&all) });
        assert!(answer.contains(refusal), "{rows:?}: {answer}");
        let answer = say(&Request::Start { cycles: 1, timeout: 500 });
        assert!(answer.contains(if refusal == "Ack" { "Ack" } else { "WrongState" }), "{answer}");
        say(&Request::Stop);
    }
    for (wrong, refusal) in [
        (Request::Config(config(3, 0, 1)), "OutOfLimits"),
        (Request::Config(config(1, 2, 1)), "OutOfLimits"),
        (Request::Config(config(1, 0, 171)), "OutOfLimits"),
        (Request::Config(config(1, 0, 0xFFFF)), "OutOfLimits"),
        (Request::Config(config(1, 0, 0)), "OutOfLimits"),
        (Request::Load { offset: 0, bytes: vec![0] }, "NothingLoaded"),
        (Request::Commit { crc: 0 }, "NothingLoaded"),
    ] {
        let answer = say(&wrong);
        assert!(answer.contains(refusal), "{wrong:?}: {answer}");
    }
    assert!(say(&Request::Config(config(1, 0, 1))).contains("Ack"));
    for (setting, refusal) in
        [(setting(2, 4), "BadPin"), (setting(3, 3), "BadPin"), (setting(0, 13), "BadPin")]
    {
        let answer = say(&Request::Channel { index: 0, setting });
        assert!(answer.contains(refusal), "{answer}");
    }
    assert!(say(&Request::Load { offset: 3, bytes: vec![0; 4] }).contains("OutOfLimits"));
}
