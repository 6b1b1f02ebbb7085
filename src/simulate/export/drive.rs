//! The targets of the servos over time, as a table.

use super::{joint_names, number};
use crate::design::assembly::Assembly;
use crate::simulate::lowering::Lowered;
use crate::simulate::schedule::Schedule;
use crate::simulate::servo::Servo;
use crate::simulate::{Settings, Targets, Unfit};

/// The target of every joint that something drives after rate limiting, in rad, m or rad/s, as
/// comma-separated values: a row for each step, with the time at which that step ends. Columns
/// are the actuators of [`super::mjcf`], in its order; `names` are those of the parts that its elements belong to.
///
/// # Errors
///
/// [`Unfit`] when the assembly or its settings cannot be simulated, or the
/// drive asks for no number.
pub fn drive(
    assembly: &Assembly,
    settings: &Settings,
    targets: &Targets,
    names: &[String],
) -> Result<String, Unfit> {
    let settings = settings.in_whole_steps();
    let lowered = Lowered::new(assembly, &settings)?;
    let dofs = lowered.bodies.iter().filter_map(|body| body.dof.as_ref());
    let driven = dofs.zip(joint_names(&lowered, names)).filter(|(dof, _)| dof.actuator().is_some());
    let (mut servos, columns): (Vec<Servo>, Vec<String>) =
        driven.map(|(dof, name)| (Servo::new(dof), name)).unzip();
    let Schedule { step, steps, .. } = Schedule::new(&settings);
    let mut out = "time".to_owned();
    for column in columns {
        out.push(',');
        out.push_str(&column);
    }
    out.push('\n');
    for now in 1..=steps {
        let time = now as f64 * step;
        out.push_str(&number(time));
        for servo in &mut servos {
            if !servo.follow(|actuator| targets.asked(actuator, time), step) {
                return Err(Unfit { reason: format!("the drive asks for no number at {time} s") });
            }
            out.push(',');
            out.push_str(&number(servo.target));
        }
        out.push('\n');
    }
    Ok(out)
}
