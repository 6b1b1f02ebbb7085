//! What cannot be simulated is refused, and what goes wrong ends.

use crate::design::assembly::{Assembly, Joint, JointKind, Shape};
use crate::simulate::run::alone;
use crate::simulate::tests::lattices::{cells, lattice, lattice_settings, quadruped, trot};
use crate::simulate::{Invalid, Settings, model};

/// The sentence with which a body is refused.
fn refusal(name: &str, change: impl FnOnce(&mut Assembly, &mut Settings)) -> String {
    let (mut body, mut settings) = (quadruped(), lattice_settings(1.0));
    change(&mut body, &mut settings);
    match model(name).unwrap().prepare(&body, &settings) {
        Ok(_) => "was not refused".to_owned(),
        Err(unfit) => unfit.reason,
    }
}

#[test]
fn nonsense_is_refused_with_advice() {
    for name in ["balls", "rapier"] {
        let cases: Vec<(String, &str)> = vec![
            (refusal(name, |_, s| s.step = 0.0), "step is 0 s"),
            (refusal(name, |b, _| b.elements[3].mass = 0.0), "element 3 has a mass of 0 kg"),
            (refusal(name, |b, _| b.springs[4].stiffness = -1.0), "spring 4 has a stiffness of -1 N/m"),
            (refusal(name, |b, _| b.springs[4].damping = f64::NAN), "spring 4 has a damping of NaN"),
            (refusal(name, |b, _| b.springs[4].to = 999), "names an element that does not exist"),
            (refusal(name, |b, _| b.springs[4].to = b.springs[4].from), "are in one place"),
            (refusal(name, |b, _| b.swellings[0].element = 999), "names an element that does not exist"),
            (refusal(name, |b, _| b.swellings[0].actuator = 9), "number them from zero"),
            (refusal(name, |b, _| b.swellings[0].gain = f64::INFINITY), "give a finite number"),
            (
                refusal(name, |b, _| b.elements[2].shape = Shape::Cylinder { radius: 0.1, half_length: 0.1 }),
                "element 2 is not a ball",
            ),
        ];
        for (reason, part) in cases {
            assert!(reason.contains(part), "{name}: {reason:?} does not say {part:?}");
        }
    }
}

#[test]
fn each_solver_says_who_would_take_it() {
    assert!(refusal("articulated", |_, _| ()).contains("use `balls`"));
    let join = |body: &mut Assembly| body.joints.push(Joint { parent: 0, child: 1, kind: JointKind::Rigid });
    for name in ["balls", "rapier"] {
        assert!(refusal(name, |b, _| join(b)).contains("use `articulated`"));
    }
}

/// The step that is advised is taken, and one that is longer by what is kept in reserve blows up.
#[test]
fn a_step_that_is_too_long_is_refused() {
    let reason = refusal("balls", |b, s| {
        b.springs.iter_mut().for_each(|spring| spring.stiffness = 2000.0);
        s.step = 1.0 / 1200.0;
    });
    let rate: f64 = reason.split("(1/").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(reason.contains("are too long for the springs of ball") && rate > 2000.0, "{reason}");
    let mut body = lattice(&cells([0, 0, 0], [7, 7, 7]));
    body.springs.iter_mut().for_each(|spring| spring.stiffness = 2000.0);
    let mut settings = Settings { gravity: 0.0, ..lattice_settings(0.5) };
    let lowered = super::lifted(&body, &settings, 0.1);
    let (longest, _) = crate::simulate::balls::stable::longest(&lowered);
    for (times, sound) in [(1.0, true), (1.35, false)] {
        settings.step = longest * times;
        let mut kicked = lowered.clone();
        for (n, ball) in kicked.balls.iter_mut().enumerate() {
            ball.velocity.x = if n % 2 == 0 { 0.1 } else { -0.1 };
        }
        let motion =
            alone(crate::simulate::balls::widest(&kicked, &settings).unwrap().as_mut(), &super::idle());
        assert_eq!(motion.is_ok(), sound, "{times} times the longest step");
    }
}

#[test]
fn a_run_that_goes_wrong_says_so() {
    for name in ["balls", "rapier"] {
        let body = lattice(&cells([0, 0, 0], [2, 4, 2]));
        let settings = Settings { speed_limit: 1e-4, ..lattice_settings(0.2) };
        let motion = model(name).unwrap().prepare(&body, &settings).unwrap().run(&[super::idle()]).remove(0);
        assert_eq!(motion.unwrap_err(), Invalid::TooFast, "{name}");
    }
    let limit = Some(0.001);
    let settings = Settings { pace_limit: limit, ..lattice_settings(3.0) };
    let mut simulation = model("balls").unwrap().prepare(&quadruped(), &settings).unwrap();
    assert_eq!(simulation.run(&[trot(4, 0.3, true)]).remove(0).unwrap_err(), Invalid::TooFar);
}
