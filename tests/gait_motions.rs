//! Gait classes of motions that searches found, beside what somebody saw in pictures of them.
//!
//! `tests/gait_motions/motions.bin` holds the motions, `strips/` a strip of pictures of each, `labels.toml` what was seen in
//! them. All three were made by [`gather`] and by eye; a motion is kept as it was, whatever becomes of the solvers.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Read, Write as _};
use std::path::PathBuf;

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use sgc::design::assembly::Shape;
use sgc::results::replay::{self, Precision};
use sgc::results::saved::SavedDesign;
use sgc::score::Observed;
use sgc::simulate::Motion;
use sgc::simulate::motion::Placement;

use crate::gaits::{class_of, rules};
use crate::support::root;

/// Steps of a place, m, and of a part of a quaternion.
const PLACE: f64 = 2e-4;
const TURN: f64 = 5e-4;
/// Motions whose class is not what was seen, and what it is instead. What carries the body all the time and what taps the
/// ground beside it count alike in `alternation`, so that these crawlers count as walkers.
const KNOWN: [(&str, &str); 3] = [("codesign-25", "walker"), ("leap-4", "walker"), ("study2-2", "walker")];
/// Pictures of a strip.
const PICTURES: usize = 12;

/// A motion in whole numbers, each frame as its difference from the one before.
#[derive(Serialize, Deserialize)]
struct Kept {
    name: String,
    interval: f64,
    duration: f64,
    /// How long the strip's pictures are apart, s.
    apart: f64,
    bodies: usize,
    placements: Vec<(usize, [f64; 7], Form)>,
    frames: Vec<Vec<i32>>,
}

#[derive(Serialize, Deserialize)]
enum Form {
    Box([f64; 3]),
    Ball(f64),
    Cylinder(f64, f64),
}

fn seven(pose: &Isometry3<f64>) -> [f64; 7] {
    let (p, q) = (pose.translation.vector, pose.rotation.coords);
    [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
}

fn pose([x, y, z, w, i, j, k]: [f64; 7]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, i, j, k));
    Isometry3::from_parts(Translation3::new(x, y, z), rotation)
}

impl Kept {
    fn of(name: String, motion: &Motion, apart: f64) -> Self {
        let whole = |pose: &Isometry3<f64>| -> Vec<i32> {
            let step = |i: usize| if i < 3 { PLACE } else { TURN };
            seven(pose).iter().enumerate().map(|(i, x)| (x / step(i)).round() as i32).collect()
        };
        let mut before = vec![0; 7 * motion.bodies];
        let frames = motion.poses.chunks_exact(motion.bodies).map(|frame| {
            let now: Vec<i32> = frame.iter().flat_map(whole).collect();
            let moved = now.iter().zip(&before).map(|(a, b)| a - b).collect();
            before = now;
            moved
        });
        let frames = frames.collect();
        let form = |shape: &Shape| match *shape {
            Shape::Box { half } => Form::Box([half.x, half.y, half.z]),
            Shape::Ball { radius } => Form::Ball(radius),
            Shape::Cylinder { radius, half_length } => Form::Cylinder(radius, half_length),
            Shape::Capsule { .. } => panic!("none of the kept bodies has a capsule"),
        };
        let placements =
            motion.placements.iter().map(|p| (p.body, seven(&p.local), form(&p.shape))).collect();
        let (interval, duration, bodies) = (motion.interval, motion.duration, motion.bodies);
        Self { name, interval, duration, apart, bodies, placements, frames }
    }

    fn motion(&self) -> Motion {
        let mut now = vec![0; 7 * self.bodies];
        let mut poses = Vec::new();
        for frame in &self.frames {
            now.iter_mut().zip(frame).for_each(|(x, moved)| *x += moved);
            poses.extend(now.chunks_exact(7).map(|x| {
                let at = |i: usize| f64::from(x[i]) * if i < 3 { PLACE } else { TURN };
                pose([at(0), at(1), at(2), at(3), at(4), at(5), at(6)])
            }));
        }
        let placement = |(body, local, form): &(usize, [f64; 7], Form)| {
            let shape = match *form {
                Form::Box(half) => Shape::Box { half: Vector3::from(half) },
                Form::Ball(radius) => Shape::Ball { radius },
                Form::Cylinder(radius, half_length) => Shape::Cylinder { radius, half_length },
            };
            Placement::new(*body, pose(*local), shape)
        };
        Motion {
            interval: self.interval,
            duration: self.duration,
            bodies: self.bodies,
            poses,
            bends: Vec::new(),
            work: Vec::new(),
            commands: None,
            placements: self.placements.iter().map(placement).collect(),
        }
    }
}

fn folder() -> PathBuf {
    root().join("tests/gait_motions")
}

fn kept() -> Vec<Kept> {
    let file = std::fs::File::open(folder().join("motions.bin")).unwrap();
    let mut text = String::new();
    flate2::read::DeflateDecoder::new(file).read_to_string(&mut text).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The corners of what is drawn of an element.
fn corners(shape: &Shape) -> Vec<Point3<f64>> {
    let half = shape.half_extents();
    let signs = [-1.0, 1.0];
    let each = signs.iter().flat_map(|x| signs.iter().flat_map(move |y| signs.map(move |z| (*x, *y, z))));
    each.map(|(x, y, z)| Point3::new(x * half.x, y * half.y, z * half.z)).collect()
}

/// The outline of points in a plane (monotone chain).
fn outline(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let half = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut out: Vec<(f64, f64)> = Vec::new();
        for p in points {
            while let [.., a, b] = out.as_slice()
                && (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut all = half(&mut points.iter().copied());
    all.extend(half(&mut points.iter().rev().copied()));
    all
}

/// A strip of pictures, seen from the side of where it goes: each keeps the middle of the body in its own middle, and the
/// marks on the ground are 5 cm apart. What touches the ground is red.
fn strip(kept: &Kept, motion: &Motion) -> String {
    let from = 0.5 * motion.duration;
    let elements = motion.placements.len();
    let middle = |time: f64| {
        let sum: Vector3<f64> = (0..elements).map(|e| motion.pose(e, time).unwrap().translation.vector).sum();
        sum / elements as f64
    };
    let went = middle(motion.duration) - middle(0.25 * motion.duration);
    let way = Vector3::new(went.x, 0.0, went.z);
    let came = 100.0 * way.norm();
    let way = if way.norm() > 1e-3 { way.normalize() } else { Vector3::x() };
    let reach = (0..elements)
        .map(|e| (motion.pose(e, from).unwrap().translation.vector - middle(from)).norm())
        .fold(0.05, f64::max);
    let (wide, high) = (150.0, 130.0);
    let scale = 0.5 * wide / (1.3 * reach);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<style>text {{ font: 11px sans-serif }} \
         polygon {{ fill: #8ab; fill-opacity: .55; stroke: #246 }} .on {{ fill: #e33; stroke: #900 }} \
         path {{ stroke: #555; fill: none }}</style>\n<text x=\"4\" y=\"12\">{}, {:.2} s apart, from {from:.1} s; marks 5 cm; \
         in the last three quarters it comes {came:.1} cm</text>\n",
        kept.name,
        kept.apart,
        w = wide * PICTURES as f64,
        h = high + 20.0
    );
    for picture in 0..PICTURES {
        let time = from + picture as f64 * kept.apart;
        let centre = middle(time);
        let left = wide * picture as f64;
        let ground = high + 4.0;
        let x = |along: f64| left + 0.5 * wide + scale * along;
        let _ = write!(out, "<path d=\"M{left:.0} {ground:.0}h{:.0}", wide - 6.0);
        let here = centre.dot(&way);
        let first = ((here - 1.2 * reach) / 0.05).ceil() as i64;
        let marks = (first..).map(|mark| mark as f64 * 0.05 - here).take_while(|mark| *mark < 1.2 * reach);
        for mark in marks {
            let _ = write!(out, "M{:.0} {ground:.0}v6", x(mark));
        }
        out.push_str("\"/>\n");
        for element in 0..elements {
            let at = motion.pose(element, time).unwrap();
            let shape = &motion.placements[element].shape;
            let points: Vec<(f64, f64)> = corners(shape)
                .iter()
                .map(|corner| {
                    let p = at * corner;
                    (x((p.coords - centre).dot(&way)), ground - scale * p.y)
                })
                .collect();
            let touches = points.iter().any(|(_, y)| *y > ground - scale * 0.002);
            let text: Vec<String> = outline(points).iter().map(|(x, y)| format!("{x:.0},{y:.0}")).collect();
            let class = if touches { " class=\"on\"" } else { "" };
            let _ = writeln!(out, "<polygon{class} points=\"{}\"/>", text.join(" "));
        }
    }
    out + "</svg>\n"
}

/// Makes the motions and the strips from run folders below the folder that `GAIT_RUNS` names; what is seen in them is
/// written into `labels.toml` by hand.
#[test]
#[ignore = "makes what the other test reads"]
fn gather() {
    let runs = PathBuf::from(std::env::var("GAIT_RUNS").expect("GAIT_RUNS: a folder of run folders"));
    let mut names: Vec<String> = std::fs::read_dir(&runs)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .filter(|name| runs.join(name).join("best.design.json").exists())
        .collect();
    names.sort();
    std::fs::create_dir_all(folder().join("strips")).unwrap();
    let mut text = String::new();
    for name in names {
        let design = SavedDesign::read(&runs.join(&name).join("best.design.json")).unwrap();
        let rules = design.grammar.compile(&design.sgc).unwrap();
        let setup = replay::setup(&rules, &design, None, Precision::Model).unwrap();
        let motion = setup.motion(&design.solver).unwrap();
        let drive = &design.tasks[0].drive;
        let period = drive.iter().find(|(name, _)| name == "period").map_or(1.0, |(_, period)| *period);
        let kept = Kept::of(name.clone(), &motion, (1.5 * period / PICTURES as f64).clamp(0.04, 0.6));
        let _ = writeln!(text, "{}", serde_json::to_string(&kept).unwrap());
        std::fs::write(folder().join(format!("strips/{name}.svg")), strip(&kept, &kept.motion())).unwrap();
    }
    let file = std::fs::File::create(folder().join("motions.bin")).unwrap();
    let mut deflated = flate2::write::DeflateEncoder::new(file, flate2::Compression::best());
    deflated.write_all(text.as_bytes()).unwrap();
    deflated.finish().unwrap();
}

/// A class that is sure is the one that was seen; few are not sure.
#[test]
fn gaits_are_of_the_class_that_is_seen_in_their_pictures() {
    let labels = std::fs::read_to_string(folder().join("labels.toml")).unwrap();
    let labels: BTreeMap<String, String> = toml::from_str(&labels).unwrap();
    let rules = rules("");
    let all = kept();
    assert!(all.len() >= 30 && all.len() == labels.len(), "{} motions, {} labels", all.len(), labels.len());
    let (mut unsure, mut wrong, mut sure) = (Vec::new(), Vec::new(), Vec::new());
    for kept in &all {
        let motion = kept.motion();
        let picture = folder().join(format!("strips/{}.svg", kept.name));
        // Pictures are snapshots: look at what is drawn anew.
        if std::env::var("INSTA_UPDATE").is_ok_and(|update| update == "always") {
            std::fs::write(&picture, strip(kept, &motion)).unwrap();
        }
        let drawn = std::fs::read_to_string(&picture).unwrap();
        assert_eq!(drawn, strip(kept, &motion), "{}: the strip is not of this motion", kept.name);
        let (seen, label) = (class_of(&rules, &motion), &labels[&kept.name]);
        let (name, told): (&str, Vec<String>) = (&kept.name, seen.iter().map(Observed::to_string).collect());
        match &seen[0] {
            Observed::Word(class) if class == "unsure" => unsure.push(format!("{name} ({label}): {told:?}")),
            Observed::Word(class) if KNOWN.contains(&(name, class)) => assert_ne!(class, label),
            Observed::Word(class) if class == label && KNOWN.iter().all(|(known, _)| *known != name) => {
                sure.push(format!("{name} {told:?}"))
            }
            _ => wrong.push(format!("{name} looks like a {label}: {told:?}")),
        }
    }
    println!("{} as seen, {} unsure, {} known to be wrong", sure.len(), unsure.len(), KNOWN.len());
    assert!(wrong.is_empty(), "{wrong:#?}\nunsure: {unsure:#?}\nsure: {sure:#?}");
    assert!(3 * unsure.len() <= all.len(), "{unsure:#?}");
}
