//! Actuations that react: what sensors read, how late and how noisily, what states remember, and that all of it is repeatable.

use grammar_lang::ir::RuleSet;
use sgc::derive::{Candidate, Derivation};
use sgc::drive::{Conditions, Drive};
use sgc::search::settings;
use sgc::simulate::{Motion, Stop, World, model};

use crate::joints::compiled;

/// Two feet on bending legs, with an actuation and what it reads.
pub(crate) fn walker(sensors: &str, actuation: &str) -> String {
    format!(
        "grammar feeling
        use std.blocks     {{ cube, ball }}
        use std.models     {{ hinge_model }}
        use std.actuators  {{ bender }}
        use std.objectives {{ travel }}
        use std.search     {{ recommended }}
        symmetry mirror xy
        begin {{
          place core : cube
          place leg  : bender(segments = 3) to core.left
          place foot : ball to leg.tip
        }}
        rule grow {{ match p : block with free port q  attach cube to q }}
        {sensors}
        actuation act for a : bender {{ {actuation} }}
        actuate bender with act
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended"
    )
}

pub(crate) fn moved_in(rules: &RuleSet, conditions: &Conditions) -> Motion {
    let candidate = Candidate::new(rules, Derivation::begin(rules).into());
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let law = drive.control_law_under(&[], conditions).unwrap();
    assert!(law.is_closed_loop());
    let mut simulation =
        model("articulated").unwrap().prepare(&candidate.body.assembly, &settings(&task.model)).unwrap();
    simulation.run_cases(Stop::NEVER, &[law.case(&World::NOMINAL)]).unwrap().remove(0).unwrap()
}

pub(crate) fn world(name: &str) -> Conditions {
    Conditions { world: name.to_owned(), ..Conditions::NOMINAL }
}

/// What the first actuator was asked for at each control moment, in degrees.
pub(crate) fn commands(text: &str, conditions: &Conditions) -> Vec<f64> {
    let motion = moved_in(&compiled(text), conditions);
    let told = motion.commands.unwrap();
    told.angles.chunks(told.actuators).map(|row| row[0].to_degrees()).collect()
}

/// A state begins where it says, and then is what its `next` said a moment before.
#[test]
fn states_remember() {
    let text = walker(
        "",
        "state count : Count from 3 next count + 1
         state sum   : Angle from 0 deg next sum + count * 0.1 deg
         drive angle = sum",
    );
    let asked = commands(&text, &world("nominal"));
    let mut sum = 0.0;
    for (moment, angle) in asked.iter().enumerate().take(20) {
        assert!((angle - sum).abs() < 1e-9, "{moment}: {angle}");
        sum += 0.1 * (3.0 + moment as f64);
    }
    let interval = moved_in(&compiled(&text), &world("nominal")).commands.unwrap().interval;
    assert_eq!(asked.len(), (2.0 / interval).round() as usize);
}

/// What a sensor reads late is what it read before.
#[test]
fn a_late_sensor_reads_what_was() {
    // Three control moments of a sixtieth of a second. One actuator shows the difference, while the other swings.
    let text = walker(
        "sense prompt(a : bender) : Angle = a.angle at now
         sense late(a : bender)   : Angle = a.angle at now delay 50 ms",
        "state one   : Angle  from 0 deg next prompt(a.twin)
         state two   : Angle  from 0 deg next one
         state three : Angle  from 0 deg next two
         state phase : Number from 0 next phase + control_interval / 1 s
         drive angle = if a.image == 0 then late(a.twin) - three else 40 deg * sin(phase * 360 deg)",
    );
    assert!(commands(&text, &world("nominal")).iter().all(|x| x.abs() < 1e-9));
    let prompt = commands(&text.replace(" delay 50 ms", ""), &world("nominal"));
    assert!(prompt.iter().any(|x| x.abs() > 3.0));
}

/// Noise scatters as it says, is the same in a world whatever else the grammar says, and another in another world.
#[test]
fn noise_is_that_of_the_world() {
    let still = |noise: &str| {
        walker(
            &format!("sense level : Angle = 30 deg{noise}"),
            "state seen : Angle from 0 deg next level  drive angle = if a.image == 0 then level else 0 deg",
        )
    };
    let (one, again) =
        (commands(&still(" noise 2 deg"), &world("a")), commands(&still(" noise 2 deg"), &world("a")));
    assert_eq!(one, again);
    assert_ne!(one, commands(&still(" noise 2 deg"), &world("b")));
    let mean = one.iter().sum::<f64>() / one.len() as f64;
    let deviation = (one.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / one.len() as f64).sqrt();
    assert!((mean - 30.0).abs() < 0.6 && (deviation - 2.0).abs() < 0.4, "{mean}, {deviation}");
    assert!(commands(&still(""), &world("a")).iter().all(|x| (x - 30.0).abs() < 1e-9));
    // Of a Bool the noise is how often it is wrong.
    let wrong = walker(
        "sense on : Bool = true noise 10 %",
        "state seen : Bool from true next on  drive angle = if on then 0 deg else 10 deg",
    );
    let wrong = commands(&wrong, &world("a"));
    let share = wrong.iter().filter(|x| **x > 5.0).count() as f64 / wrong.len() as f64;
    assert!((0.02..0.2).contains(&share), "{share}");
}

/// An actuator that is late does later what it is asked for, and its hardware limits it as one that does not react.
#[test]
fn late_actuators_react_late() {
    let text = walker(
        "",
        "state count : Count from 0 next count + 1
         drive angle = count * 0.5 deg",
    );
    let prompt = commands(&text, &world("nominal"));
    let late = commands(&text, &Conditions { late: vec![0.1, 0.1], ..world("nominal") });
    assert_eq!(late[..6], [0.0; 6]);
    assert_eq!(late[6..], prompt[..prompt.len() - 6]);
}

/// The load of a part is that of all its elements; a whole robot at rest weighs what it weighs.
#[test]
fn loads_add_up() {
    let text = walker(
        "sense carried(p : part) : Force = p.load at now
         sense whole : Force = sum over e in elements of e.load at now",
        "state on : Bool from false next whole > 0 N
         drive angle = (carried(core) + (sum over p in part where p is not core of carried(p)) - whole) / 1 N * 1 deg",
    );
    assert!(commands(&text, &world("nominal")).iter().all(|x| x.abs() < 1e-9));
}

/// A search for a gait that reacts gives the same bits for one thread and for two, and evaluates to what it says.
#[test]
fn reacting_gaits_are_repeatable() {
    let folder = tempfile::tempdir().unwrap();
    let grammar = folder.path().join("own.sgr");
    std::fs::write(
        &grammar,
        walker(
            "sense bent(a : bender) : Angle = a.angle at now noise 1 deg delay 20 ms
             sense landed(a : bender) : Bool = a.load at now > 0.02 N",
            "vary size : Angle in 10 deg .. 60 deg mutate 0.5 by normal(0 deg, 20 deg)
             vary gain : Number in -1 .. 1 mutate 0.5 by normal(0, 0.3)
             state phase : Number from 0.5 * a.image next if landed(a) then fraction(phase + 0.02) else fraction(phase + 0.01)
             drive angle = size * sin(phase * 360 deg) + gain * bent(a)",
        ),
    )
    .unwrap();
    let run = |name: &str, jobs: &str| {
        let out = folder.path().join(name);
        let (file, to) = (grammar.to_string_lossy(), out.to_string_lossy());
        let command = ["run", &file, "--max-evals", "60", "--jobs", jobs, "--quiet", "--out", &to];
        let output = crate::command_line::sgc(&command);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        std::fs::read(out.join("evals.csv")).unwrap()
    };
    assert_eq!(run("one", "1"), run("two", "2"));
    let one = folder.path().join("one");
    let again = crate::command_line::sgc(&["eval", &one.to_string_lossy()]);
    assert!(String::from_utf8_lossy(&again.stderr).contains("exactly the saved value"));
    // Its commands can be exported, but no board plays them.
    let drive = crate::command_line::sgc(&["export", &one.to_string_lossy(), "--to", "drive"]);
    assert_eq!(drive.status.code(), Some(0));
    assert!(String::from_utf8_lossy(&drive.stderr).contains("depends on the motion itself"));
}

/// What is exported as the drive of a gait that reacts holds each command from its moment on, as the simulation did.
#[test]
fn held_commands_begin_at_their_moment() {
    let commands = sgc::simulate::Targets { interval: 0.1, actuators: 1, angles: vec![1.0, 2.0, 3.0] };
    let held = commands.held(0.04, 0.3);
    // The steps begin at 0, 0.04, 0.08, 0.12, 0.16, 0.2, 0.24 and 0.28 s; the first row is the state at rest.
    assert_eq!(held.angles, [1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
}

/// A spring leg measures how far it is compressed: what it carries divided by its stiffness, counted as its range counts it. A hinge on
/// which nothing pulls stays at its `neutral`.
#[test]
fn passive_joints_are_measured() {
    let text = |reads: &str| {
        format!(
            "grammar sprung
            use std.blocks     {{ cube }}
            use std.models     {{ hinge_model }}
            use std.actuators  {{ bender }}
            use std.objectives {{ travel }}
            use std.search     {{ recommended }}
            part sole {{
              shape = box(10 cm, 1 cm, 10 cm)  mass = 20 g  friction = 1
              port top at vector(0 cm, 5 mm, 0 cm) facing vector(0, 1, 0)
              port mast at vector(4 cm, 5 mm, 0 cm) facing vector(0, 1, 0)
              joint = slide along y passive  range = -1 cm .. 2 cm  neutral = 4 mm
              stiffness = 600 N/m  damping = 8 N*s/m
            }}
            part flag {{
              shape = box(2 cm, 4 mm, 4 mm)  mass = 1 g  friction = 1
              port root at vector(-1 cm, 0 cm, 0 cm) facing vector(-1, 0, 0)
              joint = bend about y passive  bend = -30 deg .. 90 deg  neutral = 40 deg
              stiffness = 0.01 N*m/rad^2  damping = 0.001 N*m*s/rad^2
            }}
            begin {{
              place core : cube
              place foot : sole to core.bottom
              place mark : flag to core.left
              place arm  : bender(segments = 3) to core.top
            }}
            rule grow {{ match p : block with free port q  attach cube to q }}
            sense pressed(s : sole) : Length = s.distance at now
            sense pressing(s : sole) : Velocity = s.distance_rate at now
            sense waved(f : flag) : Angle = f.angle at now
            actuation act for a : bender {{ drive angle = 1 deg * ({reads}) }}
            actuate bender with act
            simulate hinge_model for 2 s
            maximize travel in cm
            search recommended"
        )
    };
    let of_sole = "sum over s in sole of pressed(s) / 1 mm";
    let pressed = commands(&text(of_sole), &Conditions::NOMINAL);
    assert!((pressed[0] - 4.0).abs() < 1e-5, "it begins at neutral: {}", pressed[0]);
    let rules = compiled(&text(of_sole));
    let body = Candidate::new(&rules, Derivation::begin(&rules).into()).body;
    let carried: f64 = body.assembly.elements.iter().map(|element| element.mass).sum::<f64>() - 0.020;
    let (last, wanted) = (pressed[pressed.len() - 1], 4.0 + carried * 9.81 / 600.0 * 1e3);
    assert!((last - wanted).abs() < 0.02 * (wanted - 4.0), "{last} mm, and it carries {wanted} mm");
    // A rate is what the position does from moment to moment; the spring swings about five times as slowly.
    let rates = commands(&text("sum over s in sole of pressing(s) / 1 mm * 1 s"), &Conditions::NOMINAL);
    let summed: f64 = rates.windows(2).take(40).map(|two| (two[0] + two[1]) / 120.0).sum();
    assert!((summed / (pressed[40] - 4.0) - 1.0).abs() < 0.25, "{summed} of {}", pressed[40] - 4.0);
    let turned = commands(&text("sum over f in flag of waved(f) / 1 deg"), &Conditions::NOMINAL);
    assert!(turned.iter().all(|angle| (angle - 40.0).abs() < 0.5), "{turned:?}");
}
