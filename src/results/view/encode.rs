//! Packs the numbers of a scene for the page, in about a tenth of their size.
//!
//! The numbers form *channels*: one sequence per body and coordinate, one per
//! actuator, one per target curve. Channels of one kind make a [`Group`] and
//! share a scale. Each value becomes 16 bits; each channel is replaced by its
//! second differences (a smooth motion leaves almost nothing), made unsigned by
//! zigzag. The low bytes of everything, then the high bytes, are compressed in
//! the zlib format, which every browser unpacks by itself, and written as
//! base64. Differences wrap around, so unpacking gives the same 16 bits back.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use nalgebra::{Isometry3, UnitQuaternion};
use serde::Serialize;

use super::pieces::{Look, Looks, Piece, finite, pieces};
use super::{Measure, Scene};
use crate::simulate::Motion;

/// The most frames that a page keeps of a recording.
pub const FRAMES: usize = 2400;

/// The shortest time between kept frames in s: no screen shows more.
pub const INTERVAL: f64 = 1.0 / 61.0;

/// What the page's script reads: texts in the clear, numbers in `stream`.
#[derive(Debug, Serialize)]
pub struct Data {
    /// Time between kept frames in s; the last may come earlier, at `duration`.
    pub interval: f64,
    /// Time of the last frame in s.
    pub duration: f64,
    /// Number of kept frames.
    pub frames: usize,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of actuators whose bend was recorded.
    pub actuators: usize,
    /// What elements look like, each look once.
    pub looks: Vec<Look>,
    /// Whether the motion in another world follows in `stream`, as four groups more: x, y, z and rotations.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub elsewhere: bool,
    /// The elements that have a placement.
    pub elements: Vec<Part>,
    /// The elements at rest, as the design grew.
    pub pieces: Vec<Piece>,
    /// The target curves, without their samples.
    pub curves: Vec<Label>,
    /// The groups in `stream`: the bodies' x, y and z in m, their rotations
    /// (channels i, j, k, w of each body in turn), one group per actuator with what it did, then one
    /// per target curve, in SI units.
    pub groups: Vec<Group>,
    /// The packed channels as base64.
    pub stream: String,
}

/// An element as the page's script reads it.
#[derive(Debug, Serialize)]
pub struct Part {
    /// Index of its look.
    pub look: usize,
    /// Index of its actuator.
    pub actuator: Option<usize>,
    /// Index of the body that it is fixed to.
    pub body: usize,
    /// Its pose in the frame of that body: x, y, z in m, quaternion i, j, k, w.
    pub local: [f64; 7],
}

/// Name and sampling interval (s) of a target curve.
#[derive(Debug, Serialize)]
pub struct Label {
    /// Name of the actuator.
    pub name: String,
    /// What its numbers are.
    pub measure: Measure,
    /// Time between samples in s.
    pub interval: f64,
}

/// Channels of one kind: value = `low` + `step` times the 16-bit number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// The least value.
    pub low: f64,
    /// The value of one unit.
    pub step: f64,
    /// Number of channels.
    pub channels: usize,
    /// Samples of each channel.
    pub length: usize,
}

/// Every how many frames one is kept: at most [`FRAMES`] of them, no nearer to
/// each other than [`INTERVAL`]. The last frame is always kept.
#[must_use]
pub fn stride(motion: &Motion) -> usize {
    let by_time = if motion.interval > 0.0 { (INTERVAL / motion.interval).ceil() as usize } else { 1 };
    by_time.max(motion.frames().div_ceil(FRAMES)).max(1)
}

/// The scene's numbers, packed.
#[must_use]
pub fn data(scene: &Scene) -> Data {
    let motion = &scene.motion;
    let mut looks = Looks::default();
    let (elements, pieces) = (elements(scene, &mut looks), pieces(&scene.making, &mut looks));
    let stride = stride(motion);
    let kept = kept(motion.frames(), stride);
    let actuators = motion.bends.len().checked_div(motion.frames()).unwrap_or(0);
    let mut packer = Packer::default();
    packer.poses(motion, &kept);
    // Each by itself: what slides has other numbers than what turns.
    for column in columns(&motion.bends, actuators, &kept) {
        packer.group(vec![column]);
    }
    for curve in &scene.curves {
        packer.group(vec![curve.targets.clone()]);
    }
    let elsewhere = scene.elsewhere.as_ref().map(|elsewhere| &elsewhere.motion);
    let elsewhere =
        elsewhere.filter(|other| other.bodies == motion.bodies && other.frames() == motion.frames());
    if let Some(other) = elsewhere {
        packer.poses(other, &kept);
    }
    Data {
        elsewhere: elsewhere.is_some(),
        interval: finite(motion.interval * stride as f64),
        duration: if kept.is_empty() { 0.0 } else { finite(motion.time(motion.frames() - 1)) },
        frames: kept.len(),
        bodies: motion.bodies,
        actuators,
        looks: looks.list,
        elements,
        pieces,
        curves: scene
            .curves
            .iter()
            .map(|curve| Label {
                name: curve.name.clone(),
                measure: curve.measure,
                interval: finite(curve.interval),
            })
            .collect(),
        stream: packer.stream(),
        groups: packer.groups,
    }
}

/// The indices of the kept frames.
fn kept(frames: usize, stride: usize) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..frames).step_by(stride).collect();
    if let Some(last) = frames.checked_sub(1).filter(|last| kept.last() != Some(last)) {
        kept.push(last);
    }
    kept
}

/// One coordinate of every body over the kept frames.
fn positions(motion: &Motion, kept: &[usize], axis: usize) -> Vec<Vec<f64>> {
    (0..motion.bodies)
        .map(|body| {
            let along = |frame: &usize| pose(motion, *frame, body).translation.vector.as_slice()[axis];
            kept.iter().map(along).collect()
        })
        .collect()
}

/// The rotation of every body over the kept frames. A quaternion and its
/// negative are the same rotation: each takes the sign nearer to the one
/// before, which keeps the channels smooth.
fn rotations(motion: &Motion, kept: &[usize]) -> Vec<Vec<f64>> {
    let mut channels = Vec::with_capacity(4 * motion.bodies);
    for body in 0..motion.bodies {
        let mut of_body: [Vec<f64>; 4] = std::array::from_fn(|_| Vec::with_capacity(kept.len()));
        let mut before = UnitQuaternion::identity().coords;
        for frame in kept {
            let mut now = pose(motion, *frame, body).rotation.coords;
            if now.dot(&before) < 0.0 {
                now = -now;
            }
            for (channel, value) in of_body.iter_mut().zip(now.iter()) {
                channel.push(*value);
            }
            before = now;
        }
        channels.extend(of_body);
    }
    channels
}

/// The pose of a body in a frame.
fn pose(motion: &Motion, frame: usize, body: usize) -> Isometry3<f64> {
    motion.poses.get(frame * motion.bodies + body).copied().unwrap_or_else(Isometry3::identity)
}

/// The columns of a table of `width` columns, at the kept rows.
fn columns(table: &[f64], width: usize, kept: &[usize]) -> Vec<Vec<f64>> {
    let cell = |row: usize, column: usize| table.get(row * width + column).copied().unwrap_or(0.0);
    (0..width).map(|column| kept.iter().map(|row| cell(*row, column)).collect()).collect()
}

/// The elements that have a placement on a body.
fn elements(scene: &Scene, looks: &mut Looks) -> Vec<Part> {
    let placements = scene.motion.placements.iter();
    scene
        .elements
        .iter()
        .zip(placements)
        .filter(|(_, placement)| placement.body < scene.motion.bodies)
        .map(|(element, placement)| Part {
            look: looks.index(&element.look),
            actuator: element.actuator.filter(|actuator| *actuator < scene.curves.len()),
            body: placement.body,
            local: coordinates(&placement.local),
        })
        .collect()
}

/// A pose as seven numbers.
fn coordinates(pose: &Isometry3<f64>) -> [f64; 7] {
    let (at, turn) = (pose.translation.vector, pose.rotation.coords);
    [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w].map(finite)
}

/// Collects groups and their 16-bit differences.
#[derive(Debug, Default)]
struct Packer {
    groups: Vec<Group>,
    words: Vec<u16>,
}

impl Packer {
    /// Adds where all bodies are: three groups of places, one of rotations.
    fn poses(&mut self, motion: &Motion, kept: &[usize]) {
        for axis in 0..3 {
            self.group(positions(motion, kept, axis));
        }
        self.scaled(rotations(motion, kept), (-1.0, 1.0));
    }

    /// Adds channels of equal length, on the scale of their least and greatest value.
    fn group(&mut self, channels: Vec<Vec<f64>>) {
        let values = || channels.iter().flatten().copied().map(finite);
        let range = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        self.scaled(channels, if range.0 <= range.1 { range } else { (0.0, 0.0) });
    }

    /// Adds channels of equal length on a given scale.
    fn scaled(&mut self, channels: Vec<Vec<f64>>, (low, high): (f64, f64)) {
        let step = (high - low) / f64::from(u16::MAX);
        let length = channels.first().map_or(0, Vec::len);
        for channel in &channels {
            let mut before = [0_u16; 2];
            for value in channel {
                let word = word(finite(*value), low, step);
                let expected = before[1].wrapping_mul(2).wrapping_sub(before[0]);
                self.words.push(zigzag(word.wrapping_sub(expected)));
                before = [before[1], word];
            }
        }
        self.groups.push(Group { low, step, channels: channels.len(), length });
    }

    /// Everything so far as compressed text.
    fn stream(&self) -> String {
        let low = self.words.iter().map(|word| word.to_le_bytes()[0]);
        let high = self.words.iter().map(|word| word.to_le_bytes()[1]);
        let bytes: Vec<u8> = low.chain(high).collect();
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
        // Writing to memory does not fail; if it did, the page would say that
        // its recording is damaged.
        let packed = encoder.write_all(&bytes).and_then(|()| encoder.finish()).unwrap_or_default();
        STANDARD.encode(packed)
    }
}

/// The 16-bit number nearest to a value.
fn word(value: f64, low: f64, step: f64) -> u16 {
    if step > 0.0 { ((value - low) / step).round().clamp(0.0, f64::from(u16::MAX)) as u16 } else { 0 }
}

/// Small numbers of either sign become small unsigned numbers.
fn zigzag(difference: u16) -> u16 {
    if difference & 0x8000 == 0 { difference << 1 } else { !(difference << 1) }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use flate2::read::ZlibDecoder;

    use super::*;
    use crate::results::view::tests::walker;

    /// Does in Rust what the page's script does.
    fn unpack(groups: &[Group], stream: &str) -> Vec<Vec<Vec<f64>>> {
        let packed = STANDARD.decode(stream).unwrap();
        let mut bytes = Vec::new();
        ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
        let (low, high) = bytes.split_at(bytes.len() / 2);
        let mut words = low.iter().zip(high).map(|(low, high)| u16::from_le_bytes([*low, *high]));
        let mut channel = |group: &Group| {
            let mut before = [0_u16; 2];
            let mut next = || {
                let zigzag = words.next().unwrap();
                let difference = (zigzag >> 1) ^ (zigzag & 1).wrapping_neg();
                let now = difference.wrapping_add(before[1].wrapping_mul(2)).wrapping_sub(before[0]);
                before = [before[1], now];
                group.low + group.step * f64::from(now)
            };
            (0..group.length).map(|_| next()).collect()
        };
        groups.iter().map(|group| (0..group.channels).map(|_| channel(group)).collect()).collect()
    }

    #[test]
    fn zigzag_is_small_for_small_differences() {
        let of = |difference: i16| zigzag(difference.cast_unsigned());
        assert_eq!([0, -1, 1, -2, 2].map(of), [0, 1, 2, 3, 4]);
        assert_eq!((of(i16::MIN), of(i16::MAX)), (0xffff, 0xfffe));
    }

    #[test]
    fn wild_numbers_survive_packing() {
        let wild: Vec<f64> = (0..500_i32).map(|i| f64::from((i * i * 7919) % 1000) - 300.0).collect();
        let mut packer = Packer::default();
        packer.group(vec![wild.clone(), wild.iter().rev().copied().collect()]);
        let back = unpack(&packer.groups, &packer.stream());
        let half = packer.groups[0].step / 2.0;
        for (value, got) in wild.iter().zip(&back[0][0]) {
            assert!((value - got).abs() <= half * 1.0001, "{value} came back as {got}");
        }
        assert_eq!(back[0][1].len(), wild.len());
    }

    #[test]
    fn constant_empty_and_not_finite_channels_are_harmless() {
        let mut packer = Packer::default();
        packer.group(vec![vec![3.5; 4]]);
        packer.group(Vec::new());
        packer.group(vec![vec![f64::NAN, 1.0, f64::INFINITY]]);
        let back = unpack(&packer.groups, &packer.stream());
        assert_eq!(back[0], vec![vec![3.5; 4]]);
        assert!(back[1].is_empty());
        assert_eq!(back[2], vec![vec![0.0, 1.0, 0.0]]);
    }

    #[test]
    fn poses_bends_and_targets_come_back() {
        let scene = walker();
        let data = data(&scene);
        let back = unpack(&data.groups, &data.stream);
        assert_eq!(data.groups.len(), 4 + data.actuators + scene.curves.len());
        assert_eq!(data.frames, scene.motion.frames());
        let got = |group: usize, channel: usize, frame: usize| back[group][channel][frame];
        for frame in 0..data.frames {
            for body in 0..data.bodies {
                let pose = pose(&scene.motion, frame, body);
                for axis in 0..3 {
                    let error = got(axis, body, frame) - pose.translation.vector[axis];
                    assert!(error.abs() < 1e-5, "{error} m");
                }
                let turn: Vec<f64> = (0..4).map(|i| got(3, 4 * body + i, frame)).collect();
                let same: f64 = turn.iter().zip(pose.rotation.coords.iter()).map(|(a, b)| a * b).sum();
                assert!((same.abs() - 1.0).abs() < 1e-4, "{turn:?}");
            }
            for actuator in 0..data.actuators {
                let error =
                    got(4 + actuator, 0, frame) - scene.motion.bends[frame * data.actuators + actuator];
                assert!(error.abs() < 1e-4);
            }
        }
        for (curve, got) in scene.curves.iter().zip(&back[4 + data.actuators..]) {
            assert_eq!(curve.targets.len(), got[0].len());
            assert!(curve.targets.iter().zip(&got[0]).all(|(want, got)| (want - got).abs() < 1e-4));
        }
    }

    #[test]
    fn fine_recordings_are_thinned_and_end_with_their_last_frame() {
        assert_eq!(kept(0, 4), Vec::<usize>::new());
        assert_eq!(kept(8, 3), [0, 3, 6, 7]);
        assert_eq!(kept(7, 3), [0, 3, 6]);
        let mut motion = walker().motion;
        assert_eq!(stride(&motion), 1);
        motion.interval = 0.001;
        assert_eq!(stride(&motion), 17);
        motion.interval = 1.0 / 60.0;
        assert_eq!(stride(&motion), 1);
    }
}
