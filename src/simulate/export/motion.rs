//! A motion as a table, and a motion from a table that another program wrote.

use std::sync::Arc;
use thiserror::Error;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::number;
use crate::design::assembly::{Assembly, Element};
use crate::simulate::Settings;
use crate::simulate::motion::{Motion, Placement};

/// What a row tells of each element: its place in m and its rotation as a quaternion.
const COLUMNS: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];

fn header(elements: usize) -> String {
    let mut out = "time".to_owned();
    for element in 0..elements {
        for column in COLUMNS {
            out.push_str(&format!(",element{element}.{column}"));
        }
    }
    out
}

/// The poses of all elements over time, as comma-separated values: a row for
/// each recorded frame. The frame is that of [`Assembly`]: y is up.
#[must_use]
pub fn motion(motion: &Motion) -> String {
    let elements = motion.placements.len();
    let mut out = header(elements);
    out.push('\n');
    for frame in 0..motion.frames() {
        let time = motion.time(frame);
        out.push_str(&number(time));
        for element in 0..elements {
            let Some(pose) = motion.pose(element, time) else { continue };
            let (p, q) = (pose.translation.vector, pose.rotation.coords);
            for value in [p.x, p.y, p.z, q.w, q.x, q.y, q.z] {
                out.push(',');
                out.push_str(&number(value));
            }
        }
        out.push('\n');
    }
    out
}

/// Another program may let a body settle before its first row: by so much, m and rad.
const NEAR: f64 = 5e-3;
const TURNED: f64 = 0.35;

/// Why a table is no motion of a design.
#[derive(Debug, PartialEq, Error)]
pub enum NotMotion {
    /// Its columns are others.
    #[error(
        "the first line does not name the columns of a motion of {elements} elements: \
         time,element0.x,element0.y,element0.z,element0.qw,element0.qx,element0.qy,element0.qz,element1.x and so on"
    )]
    OtherColumns {
        /// How many elements the design has.
        elements: usize,
    },
    /// A row has something that is no finite number.
    #[error("line {0}: not every value is a number")]
    NoNumber(usize),
    /// A row is too short or too long.
    #[error("line {line}: {found} values instead of {wanted}")]
    OtherLength {
        /// Which, from 1.
        line: usize,
        /// How many values it has.
        found: usize,
        /// How many it should have.
        wanted: usize,
    },
    /// A row has a quaternion that does not stand for a rotation.
    #[error("line {0}: a rotation is not a quaternion of length one")]
    NoRotation(usize),
    /// Something goes faster than any motion may that is scored.
    #[error("line {line}: element {element} goes at {speed:.0} m/s; a motion above {limit} m/s has no value")]
    TooFast {
        /// The later of the two rows, from 1.
        line: usize,
        /// What.
        element: usize,
        /// How fast, m/s.
        speed: f64,
        /// How fast it may be, m/s.
        limit: f64,
    },
    /// The centre of something is below the ground.
    #[error("line {line}: element {element} is {:.1} mm below the ground; a motion through the ground has no value", 1e3 * depth)]
    Sunk {
        /// The row, from 1.
        line: usize,
        /// What.
        element: usize,
        /// How deep, m.
        depth: f64,
    },
    /// It has less than two rows.
    #[error("a motion needs two rows at least")]
    TooShort,
    /// Its times are not those of frames.
    #[error("its rows are not at equal intervals from time zero")]
    Uneven,
    /// It is not as long as the task.
    #[error("it ends at {end} s, but the task takes {duration} s")]
    OtherDuration {
        /// Its last time, s.
        end: f64,
        /// The time of the task, s.
        duration: f64,
    },
    /// It is in another unit or frame, or of another design.
    #[error(
        "it does not begin where the design is at rest: element{element} is {:.1} mm and {:.0} deg away. Positions are \
         in metres, y points up, and the first row is at rest, as `sgc export --to motion` writes it",
        1e3 * off, turned.to_degrees()
    )]
    NotAtRest {
        /// The number of the element that is elsewhere.
        element: usize,
        /// How far, m.
        off: f64,
        /// By which angle it is turned, rad.
        turned: f64,
    },
}

/// Reads what [`motion`] writes. Rows are at equal intervals from time zero to
/// the end of the task; only the last may come early. Nothing may be faster than the speed limit. It tells no bends and no work.
///
/// # Errors
///
/// What does not fit.
pub fn read_motion(text: &str, assembly: &Assembly, settings: &Settings) -> Result<Motion, NotMotion> {
    let duration = settings.duration;
    let elements = assembly.elements.len();
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    if lines.next().map(|(_, line)| line.trim()) != Some(header(elements).as_str()) {
        return Err(NotMotion::OtherColumns { elements });
    }
    let (mut times, mut poses) = (Vec::new(), Vec::new());
    for (line, row) in lines {
        let line = line + 1;
        let values: Option<Vec<f64>> =
            row.split(',').map(|value| value.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let values = values.ok_or(NotMotion::NoNumber(line))?;
        let Some((time, rest)) = values.split_first().filter(|(_, rest)| rest.len() == 7 * elements) else {
            return Err(NotMotion::OtherLength { line, found: values.len(), wanted: 1 + 7 * elements });
        };
        times.push(*time);
        for pose in rest.chunks_exact(7) {
            let &[x, y, z, w, i, j, k] = pose else { continue };
            let rotation = Quaternion::new(w, i, j, k);
            if (rotation.norm() - 1.0).abs() > 1e-3 {
                return Err(NotMotion::NoRotation(line));
            }
            let rotation = if rotation.norm() == 1.0 {
                UnitQuaternion::new_unchecked(rotation)
            } else {
                UnitQuaternion::new_normalize(rotation)
            };
            poses.push(Isometry3::from_parts(Translation3::new(x, y, z), rotation));
        }
    }
    let interval = interval(&times, duration)?;
    within_speed(&times, &poses, settings.speed_limit)?;
    begins_at_rest(&poses, assembly)?;
    stays_above(&poses, elements)?;
    let placement =
        |(body, element): (usize, &Element)| Placement::new(body, Isometry3::identity(), element.shape);
    Ok(Motion {
        interval,
        duration,
        bodies: elements,
        poses,
        bends: Vec::new(),
        work: Vec::new(),
        commands: None,
        placements: assembly.elements.iter().enumerate().map(placement).collect::<Arc<[_]>>(),
    })
}

/// Whether all elements stay within a speed limit, m/s, in the mean from row to row.
fn within_speed(times: &[f64], poses: &[Isometry3<f64>], limit: f64) -> Result<(), NotMotion> {
    let elements = poses.len() / times.len().max(1);
    for row in 1..times.len() {
        let took = times[row] - times[row - 1];
        for element in 0..elements {
            let at = |row: usize| poses[row * elements + element].translation.vector;
            let speed = (at(row) - at(row - 1)).norm() / took;
            if speed > limit {
                // The first line names the columns.
                return Err(NotMotion::TooFast { line: row + 2, element, speed, limit });
            }
        }
    }
    Ok(())
}

/// Whether the centres of all elements stay above the ground.
fn stays_above(poses: &[Isometry3<f64>], elements: usize) -> Result<(), NotMotion> {
    match poses.iter().position(|pose| pose.translation.y < 0.0) {
        Some(place) => Err(NotMotion::Sunk {
            line: place / elements + 2,
            element: place % elements,
            depth: -poses[place].translation.y,
        }),
        None => Ok(()),
    }
}

/// A motion begins where the design is at rest: where it does not, it is in another unit or frame, or of another design.
fn begins_at_rest(poses: &[Isometry3<f64>], assembly: &Assembly) -> Result<(), NotMotion> {
    let most = assembly.elements.iter().map(|element| element.pose.translation.vector.norm());
    let near = NEAR.max(0.05 * most.fold(0.0, f64::max));
    let moved = |(pose, element): (&Isometry3<f64>, &Element)| {
        pose.translation.vector - element.pose.translation.vector
    };
    // A body is put down onto the ground.
    let lifted = poses.iter().zip(&assembly.elements).next().map_or(0.0, |first| moved(first).y);
    for (number, (pose, element)) in poses.iter().zip(&assembly.elements).enumerate() {
        let off = (moved((pose, element)) - Vector3::new(0.0, lifted, 0.0)).norm();
        let turned = pose.rotation.angle_to(&element.pose.rotation);
        if off > near || turned > TURNED {
            return Err(NotMotion::NotAtRest { element: number, off, turned });
        }
    }
    Ok(())
}

/// The time between rows.
fn interval(times: &[f64], duration: f64) -> Result<f64, NotMotion> {
    let [first, second, ..] = times else {
        return Err(NotMotion::TooShort);
    };
    let (interval, last) = (second - first, times.len() - 1);
    let close = 1e-6 * duration;
    // The last row may come sooner after the one before it.
    let end = if times[last] > duration + close { f64::INFINITY } else { duration };
    let even = |(row, time): (usize, &f64)| {
        let wanted = (row as f64 * interval).min(if row == last { end } else { f64::INFINITY });
        (time - wanted).abs() <= close
    };
    if interval <= 0.0 || first.abs() > close || !times.iter().enumerate().all(even) {
        return Err(NotMotion::Uneven);
    }
    if (times[last] - duration).abs() > close {
        return Err(NotMotion::OtherDuration { end: times[last], duration });
    }
    Ok(interval)
}
