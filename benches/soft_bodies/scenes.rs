//! The three experiments: a cantilever, a block on the ground and a walker.

use crate::voxels::{Block, Body, Material};
use cpu_time::ProcessTime;
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::fmt;

/// A soft silicone.
const SILICONE: Material = Material { density: 1080.0, young: 0.6e6 };
/// Gravity, m/s^2.
pub(crate) const GRAVITY: f64 = 9.81;
/// A body flies off when one of its particles is faster than this, m/s. A soft beam that falls whips at up to 11 m/s.
const FLYING: f64 = 20.0;
/// A body gets away when its centre is this far from where it began, m.
const AWAY: f64 = 1.0;

/// What surrounds a body.
pub(crate) struct World {
    /// Gravity, m/s^2.
    pub(crate) gravity: Vector3<f64>,
    /// Every velocity falls at this rate, 1/s.
    pub(crate) drag: f64,
    /// The friction coefficient of ground at z = 0, if there is ground.
    pub(crate) ground: Option<f64>,
}

/// A method that moves a body by steps.
pub(crate) trait Solver {
    /// The step, s.
    fn step(&self) -> f64;
    /// Moves the body by one step.
    fn advance(&mut self, body: &mut Body, world: &World);
}

/// How a run fails.
#[derive(Clone, Copy)]
pub(crate) enum Lost {
    /// A particle is too fast, or its velocity is not a number.
    FliesOff,
    /// The body is too far from where it began, without such a speed.
    GetsAway,
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Lost::FliesOff => "flies off",
            Lost::GetsAway => "gets away",
        })
    }
}

/// Runs a body for a time (s), and gives the time it ran.
/// `watch` sees the body and the time after each step, and ends the run when it returns true.
fn run(
    solver: &mut dyn Solver,
    body: &mut Body,
    world: &World,
    time: f64,
    mut watch: impl FnMut(&mut Body, f64) -> bool,
) -> Result<f64, Lost> {
    let (steps, start) = ((time / solver.step()).round() as usize, body.centre());
    for count in 1..=steps {
        solver.advance(body, world);
        let (t, speed) = (count as f64 * solver.step(), body.top_speed());
        if speed > FLYING || speed.is_nan() {
            return Err(Lost::FliesOff);
        }
        if (body.centre() - start).norm() > AWAY {
            return Err(Lost::GetsAway);
        }
        if watch(body, t) {
            return Ok(t);
        }
    }
    Ok(time)
}

/// Size of the cantilever, m.
const BEAM: [f64; 3] = [0.1, 0.016, 0.016];

/// How far a cantilever's tip hangs.
#[derive(Clone, Copy)]
pub(crate) struct Sag {
    /// Sag of the middle of the end face, mm.
    pub(crate) millimetres: f64,
    /// Whether every particle came to rest.
    pub(crate) rests: bool,
    /// CPU time for one second of simulation, s.
    pub(crate) cpu: f64,
}

/// The sag (mm) of the cantilever's tip by linear beam theory with shear, for a Poisson's ratio of 1/4.
pub(crate) fn beam_theory() -> f64 {
    let [length, width, height] = BEAM;
    let (area, inertia) = (width * height, width * height * height * height / 12.0);
    let load = SILICONE.density * GRAVITY * area;
    let bending = load * length * length * length * length / (8.0 * SILICONE.young * inertia);
    let shear = load * length * length / (2.0 * 5.0 / 6.0 * SILICONE.young / 2.5 * area);
    1e3 * (bending + shear)
}

/// Numbers of voxels in the cantilever with sizes near `h` (m) that fill it exactly.
pub(crate) fn cantilever_voxels(h: f64) -> [usize; 3] {
    BEAM.map(|side| (side / h).round() as usize)
}

/// Lets the cantilever hang until it rests, for 4 s at most.
pub(crate) fn cantilever(h: f64, solver: &mut dyn Solver) -> Result<Sag, Lost> {
    let count = cantilever_voxels(h);
    let size = Vector3::from_fn(|i, _| BEAM[i] / count[i] as f64);
    let mut body = Body::new(&[([0; 3], count)], size, SILICONE);
    body.clamp_start();
    let world = World { gravity: -GRAVITY * Vector3::z(), drag: 40.0, ground: None };
    let tip: Vec<usize> =
        (0..body.positions.len()).filter(|&i| body.positions[i].x > BEAM[0] - 1e-9).collect();
    let height = |body: &Body| tip.iter().map(|&i| body.positions[i].z).sum::<f64>() / tip.len() as f64;
    let (start, clock) = (height(&body), ProcessTime::now());
    let mut rests = false;
    let time = run(solver, &mut body, &world, 4.0, |body, t| {
        rests = t > 0.2 && body.top_speed() < 2e-4;
        rests
    })?;
    let cpu = clock.elapsed().as_secs_f64() / time;
    Ok(Sag { millimetres: 1e3 * (start - height(&body)), rests, cpu })
}

/// A cube of 32 mm with voxels of 8 mm that touches the ground.
fn block() -> Body {
    Body::new(&[([0; 3], [4; 3])], Vector3::repeat(0.008), SILICONE)
}

/// The way (m) the block slides from 1 m/s, with a friction coefficient of 0.5.
pub(crate) fn stopping_distance(solver: &mut dyn Solver) -> Result<f64, Lost> {
    let mut body = block();
    body.velocities.fill(Vector3::x());
    let world = World { gravity: -GRAVITY * Vector3::z(), drag: 0.0, ground: Some(0.5) };
    let start = body.centre().x;
    run(solver, &mut body, &world, 1.0, |_, _| false)?;
    Ok(body.centre().x - start)
}

/// The way (m) the block creeps in 4 s down a slope of 20 degrees, with a friction coefficient of 0.8.
pub(crate) fn creep(solver: &mut dyn Solver) -> Result<f64, Lost> {
    let mut body = block();
    let slope = PI / 9.0;
    let gravity = GRAVITY * Vector3::new(libm::sin(slope), 0.0, -libm::cos(slope));
    let world = World { gravity, drag: 0.0, ground: Some(0.8) };
    let start = body.centre().x;
    run(solver, &mut body, &world, 4.0, |_, _| false)?;
    Ok(body.centre().x - start)
}

/// The highest place (m) of the resting block's lowest particle, and the range (m) of its centre's height, from 1 s to 2 s.
pub(crate) fn hover(solver: &mut dyn Solver) -> Result<[f64; 2], Lost> {
    let mut body = block();
    let world = World { gravity: -GRAVITY * Vector3::z(), drag: 0.0, ground: Some(0.5) };
    let (mut top, mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY);
    run(solver, &mut body, &world, 2.0, |body, t| {
        if t > 1.0 {
            top = top.max(body.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min));
            (low, high) = (low.min(body.centre().z), high.max(body.centre().z));
        }
        false
    })?;
    Ok([top, high - low])
}

/// Lets a walker go for 10 s. Gives the distance of its centre along x (m) and the CPU time (s).
///
/// The trunk has 6 x 3 x 2 voxels of 16 mm. Each leg has 1 x 1 x 2 of them. `finer` splits each voxel's sides.
pub(crate) fn walker(finer: usize, solver: &mut dyn Solver) -> (Result<f64, Lost>, f64) {
    let legs = [(0, 0, 0.0), (5, 2, 0.0), (0, 2, PI), (5, 0, PI)];
    let h = 0.016;
    let mut blocks: Vec<Block> = vec![([0, 0, 2], [6, 3, 2])];
    blocks.extend(legs.map(|(x, y, _)| ([x, y, 0], [1, 1, 2])));
    let split = blocks.iter().map(|(first, count)| (first.map(|i| i * finer), count.map(|i| i * finer)));
    let blocks: Vec<Block> = split.collect();
    let mut body = Body::new(&blocks, Vector3::repeat(h / finer as f64), SILICONE);
    for (x, y, phase) in legs {
        let low = h * Vector3::new(x as f64, y as f64, 0.0);
        body.add_leg_muscles(low, low + h * Vector3::new(1.0, 1.0, 2.0), phase);
    }
    let world = World { gravity: -GRAVITY * Vector3::z(), drag: 0.0, ground: Some(0.8) };
    let (start, clock) = (body.centre().x, ProcessTime::now());
    let reached = run(solver, &mut body, &world, 10.0, |body, t| {
        body.drive(t, 0.15);
        false
    });
    (reached.map(|_| body.centre().x - start), clock.elapsed().as_secs_f64())
}
