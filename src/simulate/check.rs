//! Refuses assemblies and settings that no solver could simulate.

use nalgebra::Vector3;

use super::{Settings, Unfit};
use crate::design::assembly::{Assembly, Control, Dof, Element, Shape, Spring, Swelling, Travel};

/// More steps than this in one run is a slip of the pen, not a wish.
const MOST_STEPS: f64 = 1e9;

/// A motion whose frames fill more bytes than this is refused: as many as there are lanes are in memory at once, on each thread.
const MOST_RECORDED: f64 = 512e6;

/// More elements than this would take gigabytes: the solvers of joints remember the contacts of each pair.
const MOST_ELEMENTS: usize = 1000;

fn need(holds: bool, reason: impl FnOnce() -> String) -> Result<(), Unfit> {
    if holds { Ok(()) } else { Err(Unfit { reason: reason() }) }
}

fn positive(value: f64) -> bool {
    value > 0.0 && value.is_finite()
}

fn not_negative(value: f64) -> bool {
    value >= 0.0 && value.is_finite()
}

/// Checks the numbers of the simulation itself.
pub(super) fn settings(settings: &Settings) -> Result<(), Unfit> {
    for (name, value) in
        [("step", settings.step), ("duration", settings.duration), ("record", settings.record)]
    {
        need(positive(value), || format!("the model's {name} is {value} s; give a positive time"))?;
    }
    need(settings.duration / settings.step.min(settings.record) <= MOST_STEPS, || {
        format!(
            "{} s in steps of {} s recorded every {} s is more than a thousand million steps; \
             give a shorter duration or longer steps",
            settings.duration, settings.step, settings.record
        )
    })?;
    need(settings.step <= settings.duration, || {
        format!(
            "the step ({} s) is longer than the duration ({} s); give a shorter step",
            settings.step, settings.duration
        )
    })?;
    need(not_negative(settings.gravity), || {
        format!("gravity is {} m/s2; give zero or a positive number, it points down", settings.gravity)
    })?;
    need(not_negative(settings.ground_friction), || {
        format!("the ground's friction is {}; give zero or a positive number", settings.ground_friction)
    })?;
    need(settings.iterations > 0, || "the contact solver needs at least one iteration".to_owned())?;
    need(settings.tolerance >= 0.0, || "the tolerance of the contact solver cannot be negative".to_owned())?;
    need(settings.speed_limit > 0.0, || {
        format!("the speed limit is {} m/s; give a positive speed", settings.speed_limit)
    })
}

/// Checks that the frames of a motion of so many elements find room.
pub(super) fn recording(settings: &Settings, assembly: &Assembly) -> Result<(), Unfit> {
    let elements = assembly.elements.len();
    // A pose is seven numbers.
    let bytes = |record: f64| settings.duration / record * elements as f64 * 56.0;
    let record = settings.record.max(settings.step);
    let enough = libm::ceil(1e3 * bytes(1.0) / MOST_RECORDED) / 1e3;
    need(bytes(record) <= MOST_RECORDED, || {
        format!(
            "{} s recorded every {record:.4} s are {:.0} frames of {elements} elements, {:.1} GB for each motion; let `record` be \
             at least {enough} s, or the task shorter",
            settings.duration,
            settings.duration / record,
            bytes(record) / 1e9
        )
    })
}

/// Checks the elements and joints one by one; that the joints form a tree is
/// found out when the assembly is lowered.
pub(super) fn assembly(assembly: &Assembly) -> Result<(), Unfit> {
    need(assembly.springs.is_empty() && assembly.swellings.is_empty(), || {
        format!(
            "the assembly has {} springs and {} swellings, but this solver supports only hinges; use `balls`",
            assembly.springs.len(),
            assembly.swellings.len()
        )
    })?;
    let count = some_elements(assembly)?;
    need(assembly.joints.len() + 1 == count, || {
        format!(
            "{count} elements need {} joints to hang together as a tree, but there are {}",
            count - 1,
            assembly.joints.len()
        )
    })?;
    need(count <= MOST_ELEMENTS, || {
        format!(
            "it has {count} elements (blocks, and segments of actuators), and these solvers take at most {MOST_ELEMENTS}: each pair of them needs memory; use fewer parts or segments"
        )
    })?;
    for (index, part) in assembly.elements.iter().enumerate() {
        element(index, part)?;
    }
    for (index, joint) in assembly.joints.iter().enumerate() {
        need(joint.parent < count && joint.child < count, || {
            format!("joint {index} names an element that does not exist; there are {count}")
        })?;
        for part in joint.kind.dofs() {
            dof(index, part, assembly.actuators)?;
        }
    }
    Ok(())
}

/// Checks balls, springs and swellings one by one.
pub(super) fn lattice(assembly: &Assembly) -> Result<(), Unfit> {
    some_elements(assembly)?;
    need(assembly.joints.is_empty(), || {
        format!(
            "the assembly has {} joints, but this solver supports only springs; use `articulated`",
            assembly.joints.len()
        )
    })?;
    for (index, part) in assembly.elements.iter().enumerate() {
        element(index, part)?;
        need(matches!(part.shape, Shape::Ball { .. }), || {
            format!("element {index} is not a ball; springs hold balls only, give it a radius")
        })?;
    }
    for (index, part) in assembly.springs.iter().enumerate() {
        spring(index, part, assembly)?;
    }
    for (index, part) in assembly.swellings.iter().enumerate() {
        swelling(index, part, assembly)?;
    }
    Ok(())
}

/// How many elements there are.
fn some_elements(assembly: &Assembly) -> Result<usize, Unfit> {
    let count = assembly.elements.len();
    need(count > 0, || "the assembly has no elements; give it at least a core".to_owned())?;
    Ok(count)
}

fn spring(index: usize, spring: &Spring, assembly: &Assembly) -> Result<(), Unfit> {
    let count = assembly.elements.len();
    need(spring.from < count && spring.to < count, || {
        format!("spring {index} names an element that does not exist; there are {count}")
    })?;
    let place = |element: usize| assembly.elements[element].pose.translation.vector;
    need(spring.from != spring.to && positive((place(spring.to) - place(spring.from)).norm()), || {
        format!("the ends of spring {index} are in one place; give it two balls that are apart")
    })?;
    need(positive(spring.stiffness), || {
        format!("spring {index} has a stiffness of {} N/m; give a positive number", spring.stiffness)
    })?;
    need(not_negative(spring.damping), || {
        format!("spring {index} has a damping of {} N s/m; give zero or a positive number", spring.damping)
    })
}

fn swelling(index: usize, swelling: &Swelling, assembly: &Assembly) -> Result<(), Unfit> {
    let (elements, actuators) = (assembly.elements.len(), assembly.actuators);
    need(swelling.element < elements, || {
        format!("swelling {index} names an element that does not exist; there are {elements}")
    })?;
    need(swelling.actuator < actuators, || {
        format!(
            "swelling {index} belongs to actuator {}, but there are {actuators}; number them from zero",
            swelling.actuator
        )
    })?;
    need(swelling.gain.is_finite(), || {
        format!("swelling {index} has a gain of {}; give a finite number", swelling.gain)
    })
}

fn element(index: usize, element: &Element) -> Result<(), Unfit> {
    need(positive(element.mass), || {
        format!("element {index} has a mass of {} kg; give it a positive mass", element.mass)
    })?;
    need(not_negative(element.friction), || {
        format!("element {index} has a friction of {}; give zero or a positive number", element.friction)
    })?;
    let finite = |vector: &Vector3<f64>| vector.iter().all(|value| value.is_finite());
    let pose = &element.pose;
    need(finite(&pose.translation.vector) && pose.rotation.coords.iter().all(|v| v.is_finite()), || {
        format!("element {index} has a pose that is not finite; give it a place")
    })?;
    let (name, sizes) = (element.shape.name(), element.shape.half_extents());
    need(sizes.iter().copied().all(positive), || {
        format!(
            "element {index} is a {name} with half sizes {} x {} x {} m; give it positive sizes",
            sizes.x, sizes.y, sizes.z
        )
    })
}

fn dof(index: usize, dof: &Dof, actuators: usize) -> Result<(), Unfit> {
    need(dof.anchor.iter().chain(dof.axis.iter()).all(|value| value.is_finite()), || {
        format!("joint {index} has an anchor or axis that is not finite; give it a place")
    })?;
    need(dof.actuator().is_none_or(|actuator| actuator < actuators), || {
        format!(
            "joint {index} belongs to actuator {}, but there are {actuators}; number them from zero",
            dof.actuator().unwrap_or_default()
        )
    })?;
    need(dof.share.is_finite(), || {
        format!("joint {index} has a share of {}; give a finite number", dof.share)
    })?;
    let (low, high) = dof.limits;
    let unit = match dof.travel {
        Travel::Turn => "rad",
        Travel::Slide => "m",
    };
    need(low <= 0.0 && 0.0 <= high && low < high, || {
        format!(
            "joint {index} is limited to {low} to {high} {unit}, which excludes its place at rest, zero, \
             or leaves no room; give a lower limit below and an upper limit above zero"
        )
    })?;
    for (name, value) in [("stiffness", dof.stiffness), ("damping", dof.damping)] {
        need(not_negative(value), || {
            format!("joint {index} has a {name} of {value}; give zero or a positive number")
        })?;
    }
    let moving = match dof.control {
        Control::Position { rate, relaxing_rate, .. } => {
            vec![("rate", rate), ("relaxing rate", relaxing_rate)]
        }
        Control::Speed { times, .. } => vec![("gain", times)],
        Control::Passive { neutral } => {
            need(neutral.is_finite(), || {
                format!("the spring of joint {index} is slack at {neutral} {unit}; give a place")
            })?;
            Vec::new()
        }
    };
    for (name, value) in [("largest torque", dof.effort)].into_iter().chain(moving) {
        need(value >= 0.0, || {
            format!("the servo of joint {index} has a {name} of {value}; give zero or a positive number")
        })?;
    }
    Ok(())
}
