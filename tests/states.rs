//! States outside of actuations: what the robot and its parts remember, and all actuations read.

use grammar_lang::eval::Value;
use sgc::derive::{Candidate, Derivation};
use sgc::drive::{Conditions, Drive, Traced};
use sgc::results::names::Names;
use sgc::results::signals::table;
use sgc::search::settings;
use sgc::simulate::{Stop, World, model};

use crate::joints::compiled;
use crate::sensors::{commands, moved_in, walker, world};

/// The labels of what a search varies, and whether the body has a motion with the least of all values.
fn varied(text: &str) -> Vec<String> {
    let rules = compiled(text);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
    assert!(
        drive.control_law_under(&vec![1.0; drive.length()], &Conditions::NOMINAL).unwrap().is_closed_loop()
    );
    drive.labels(|part| format!("{part:?}"))
}

/// A state of the robot moves on as a state of each actuator does, to the bit, and it does not matter who reads it.
#[test]
fn the_robot_remembers_as_its_actuators_do() {
    let own = walker(
        "",
        "state phase : Number from 0.25 next fraction(phase + control_interval / 1.5 s)
         drive angle = 40 deg * sin(phase * 360 deg)",
    );
    let of_robot = walker(
        "state phase : Number from 0.25 next fraction(phase + control_interval / 1.5 s)",
        "drive angle = 40 deg * sin(phase * 360 deg)",
    );
    let through_a_value = walker(
        "state phase : Number from 0.25 next fraction(phase + control_interval / 1.5 s)
         let swing = 40 deg * sin(phase * 360 deg)",
        "drive angle = swing",
    );
    let of_core = walker(
        "state phase(b : block) : Number from 0.25 next fraction(phase(b) + control_interval / 1.5 s)",
        "drive angle = 40 deg * sin(phase(a.holder) * 360 deg)",
    );
    let motion = |text: &str| {
        let motion = moved_in(&compiled(text), &world("nominal"));
        (motion.commands.unwrap().angles, motion.poses)
    };
    let expected = motion(&own);
    assert!(expected.0.iter().any(|angle| angle.abs() > 0.5));
    for text in [of_robot, through_a_value, of_core] {
        assert_eq!(motion(&text), expected, "{text}");
    }
}

/// All states move on together, from what was so at one moment, in whatever order they stand.
#[test]
fn states_move_on_together() {
    let states = [
        "state one : Angle from 1 deg next two",
        "state two : Angle from 2 deg next three",
        "state three : Angle from 3 deg next one",
    ];
    for order in [[0, 1, 2], [2, 1, 0], [1, 0, 2]] {
        let declared = order.map(|place| states[place]).join("\n");
        let asked = commands(&walker(&declared, "drive angle = one"), &world("nominal"));
        for (moment, angle) in asked.iter().enumerate().take(12) {
            let expected = [1.0, 2.0, 3.0][moment % 3];
            assert!((angle - expected).abs() < 1e-9, "{moment}: {angle}");
        }
    }
}

/// Each part has its own: images too.
#[test]
fn parts_remember_each_for_itself() {
    let text = walker(
        "state mine(a : bender) : Angle from (1 + a.image) * 10 deg next mine(a.twin) + 1 deg",
        "drive angle = mine(a)",
    );
    // Whoever was asked for 10 deg at first now follows the image, which only follows itself.
    let asked = commands(&text, &world("nominal"));
    assert!((asked[0] - 10.0).abs() < 1e-9, "{asked:?}");
    assert!((asked[1] - 21.0).abs() < 1e-9, "{asked:?}");
}

/// A sensor is read at the moment, also through a state: one moment late.
#[test]
fn a_state_keeps_what_a_sensor_read() {
    let text = walker(
        "sense bent(a : bender) : Angle = a.angle at now
         state was(a : bender) : Angle from 0 deg next bent(a)",
        "state kept  : Angle  from 0 deg next bent(a.twin)
         state phase : Number from 0 next phase + control_interval / 1 s
         drive angle = if a.image == 0 then was(a.twin) - kept else 40 deg * sin(phase * 360 deg)",
    );
    assert!(commands(&text, &world("nominal")).iter().all(|x| x.abs() < 1e-9));
}

/// Who reads a state has the shared variables that it comes from, through other states, values and functions, and through a policy.
#[test]
fn shared_variables_behind_states_are_varied() {
    let behind = "shared beat : Time in 1 s .. 4 s mutate 0.3 by normal(0 s, 1 s)
         let share(x : Number) = x * control_interval / beat
         state phase : Number from 0 next fraction(phase + share(1))
         state late  : Number from 0 next phase";
    assert_eq!(varied(&walker(behind, "drive angle = late * 10 deg")), ["beat"]);
    let policy = format!("{behind}\npolicy brain {{ inputs = [late]  hidden = [] }}");
    let walker_with_a_brain = walker(
        &policy,
        "action push : Number in -1 .. 1 of brain
         drive angle = push * 10 deg",
    );
    let labels = varied(&walker_with_a_brain.replace("recommended", "gait_evolution"));
    assert!(labels.contains(&"beat".to_owned()), "{labels:?}");
    // It begins with the variable, too.
    let begun = "shared beat : Number in 0 .. 4 mutate 0.3 by normal(0, 1)
         state phase : Number from beat next beat / 2";
    assert_eq!(varied(&walker(begun, "drive angle = phase * 10 deg")), ["beat"]);
}

/// States that nobody reads cost nothing: nothing reacts.
#[test]
fn what_nobody_reads_does_not_react() {
    let text =
        walker("state phase : Number from 0 next phase + 1", "drive angle = 20 deg * sin(t / 1 s * 360 deg)");
    let rules = compiled(&text);
    assert!(rules.states.is_empty());
}

/// A trace keeps what was felt, remembered and asked for, and does not change the motion.
#[test]
fn a_trace_keeps_the_signals_of_a_motion() {
    let text = walker(
        "enum Stage { rest, swing }
         sense bent(a : bender) : Angle = a.angle at now delay 50 ms
         state stage(b : block) : Stage from Stage.rest next if t > 0.1 s then Stage.swing else stage(b)",
        "state count : Count from 3 next count + 1
         drive angle = if stage(core) == Stage.swing then 20 deg + bent(a) / 10 else count * 1 deg",
    );
    let rules = compiled(&text);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let traced = Traced::new(&drive, &[], &Conditions::NOMINAL).unwrap();
    let mut simulation =
        model("articulated").unwrap().prepare(&candidate.body.assembly, &settings(&task.model)).unwrap();
    let motion =
        simulation.run_cases(Stop::NEVER, &[traced.case(&World::NOMINAL)]).unwrap().remove(0).unwrap();
    let trace = traced.trace();
    let told = motion.commands.clone().unwrap();
    assert_eq!(told.angles, moved_in(&rules, &Conditions::NOMINAL).commands.unwrap().angles);
    // Two sensors, a state of each of the three blocks, a state and a command of each actuator.
    assert_eq!(trace.signals.len(), 2 + 3 + 2 + 2);
    let names = Names::through(&rules, &candidate.derivation);
    let table = table(&rules, &names, &trace);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 1 + trace.rows.len());
    assert_eq!(
        lines[0],
        "time (s),bent of leg (deg),bent of leg.twin (deg),stage of core,stage of foot,stage of foot.twin,count of leg,\
         count of leg.twin,leg is asked for (deg),leg.twin is asked for (deg)"
    );
    assert!(lines[1].starts_with("0,0,0,rest,rest,rest,3,3,3,"), "{}", lines[1]);
    assert!(lines[20].contains(",swing,swing,swing,22,22,2"), "{}", lines[20]);
    for (row, asked) in trace.rows.iter().zip(told.angles.chunks(told.actuators)) {
        let number = |value: &Option<Value>| value.as_ref().and_then(Value::as_number).unwrap();
        assert!((number(&row[7]) - asked[0]).abs() < 1e-12 && (number(&row[8]) - asked[1]).abs() < 1e-12);
    }
}
