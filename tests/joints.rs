//! Rows that twist, slide, spin, or that nothing drives, from the text to the motion.

use grammar_lang::ir::RuleSet;
use grammar_lang::source::SourceMap;
use nalgebra::Isometry3;
use sgc::derive::{Candidate, Derivation, Stream};
use sgc::drive::Drive;
use sgc::loader::Files;
use sgc::search::settings;
use sgc::simulate::{Invalid, Motion, Settings, model};

pub(crate) fn compiled(text: &str) -> RuleSet {
    let mut sources = SourceMap::default();
    let entry = sources.add("own.sgr", text);
    let compiled = grammar_lang::compile(&Files, &mut sources, entry, &[], None);
    compiled.ruleset.unwrap_or_else(|| panic!("{:#?}", compiled.diagnostics))
}

/// A cube with a row of a joint at each side, and a lever at its end that shows how it moves.
fn winged(joint: &str, fields: &str, drive: &str) -> String {
    format!(
        "grammar winged
        use std.blocks     {{ cube }}
        use std.models     {{ hinge_model }}
        use std.objectives {{ travel }}
        use std.search     {{ recommended }}
        part lever {{
          shape = box(4 cm, 1 cm, 0.5 cm)  density = 1 g/cm^3  friction = 0.8
          port hub at vector(-1.5 cm, 0.5 cm, 0 cm) facing vector(0, 1, 0)
        }}
        actuator wing {{
          segment = cylinder(6 mm, 12 mm)  density = 1 g/cm^3  friction = 0.8
          joint = {joint}  {fields}
        }}
        actuation beat for a : wing {{
          vary  most : Number in 0.5 .. 1.0 mutate 0.5 by normal(0, 0.1)
          drive {drive}
        }}
        symmetry mirror xy
        begin {{
          place core : cube
          place left : wing to core.left turned 30 deg
          place arm  : lever to left.tip by hub
        }}
        rule grow {{
          match  p : block with free port q
          attach cube to q
        }}
        require few : count(part) <= 12
        actuate wing with beat
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended"
    )
}

const TURNS: &str = "range = -90 deg .. 90 deg  speed = 360 deg/s  effort = 0.06 N*m/rad  \
     stiffness = 0.3 N*m/rad^2  damping = 0.01 N*m*s/rad^2";
const SLIDES: &str =
    "range = -5 mm .. 20 mm  speed = 60 mm/s  effort = 5 N  stiffness = 500 N/m  damping = 10 N*s/m";
const SPINS: &str = "speed = 360 deg/s  effort = 0.03 N*m/rad  damping = 0.01 N*m*s/rad^2";

pub(crate) fn moved(rules: &RuleSet, name: &str, weightless: bool) -> (Motion, Vec<usize>) {
    let candidate = Candidate::new(rules, Derivation::begin(rules).into());
    let task = rules.first_task().unwrap();
    let drive = Drive::new(&candidate, task).unwrap();
    let targets = drive.targets(&drive.draw(&mut Stream::named(3, "wings"))).unwrap();
    let gravity = if weightless { 0.0 } else { task.model.gravity };
    let settings = Settings { gravity, ..settings(&task.model) };
    let assembly = &candidate.body.assembly;
    let mut simulation = model(name).unwrap().prepare(assembly, &settings).unwrap();
    let motion = simulation.run(&[targets]).remove(0).unwrap();
    // The elements of the original and of its image, in the same order.
    let parts = &candidate.design().parts;
    let images = [0, 1].map(|image| {
        let of =
            |(_, id): &(usize, &sgc::design::PartId)| parts[*id].kind != "cube" && parts[*id].image == image;
        let all = candidate.body.parts_of_elements.iter().enumerate();
        all.filter(of).map(|(element, _)| element).collect::<Vec<_>>()
    });
    (motion, images.concat())
}

const HUNG: [(&str, &str); 5] = [
    ("bend about x", "bend = -40 deg .. 60 deg  stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2"),
    (
        "bend about vector(0.2, 1, 0.5)",
        "bend = -40 deg .. 60 deg  stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2",
    ),
    ("slide along vector(1, 2, -1)", "range = -3 mm .. 9 mm  stiffness = 20 N/m  damping = 0.1 N*s/m"),
    ("spin about y", "damping = 1e-6 N*m*s/rad^2"),
    ("socket", "range = -40 deg .. 70 deg  stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2"),
];

/// The same with a lever that hangs on its row with a joint.
fn hung(text: &str, (joint, fields): (&str, &str)) -> String {
    text.replace(
        "friction = 0.8\n          port hub",
        &format!("friction = 0.8\n joint = {joint} passive {fields}\n port hub"),
    )
}

/// With the same drive, the image of a row moves as its mirror image does, whatever its joint and its axis.
#[test]
fn images_move_as_mirror_images() {
    let angle = "angle = most * 60 deg * sin(t / 1 s * 360 deg)";
    let distance = "distance = most * 10 mm * (1 + sin(t / 1 s * 360 deg))";
    let speed = "speed = most * a.greatest_speed";
    let bends =
        TURNS.replace("range", "bend").replace(" speed", " bending_speed").replace("effort", "torque")
            + "  relaxing_speed = 360 deg/s";
    let cases = [
        ("bend about z", bends.as_str(), angle),
        ("bend about y", &bends, angle),
        ("bend about vector(0, 1, -0.5)", &bends, angle),
        (
            "bend about vector(0, 1, 0.5)",
            &bends.replace("-90 deg", "10 deg").replace("  bending", "  neutral = 25 deg  bending"),
            angle,
        ),
        ("twist", TURNS, angle),
        ("slide along x", SLIDES, distance),
        ("slide along vector(1, 2, -1)", SLIDES, distance),
        ("spin about x", SPINS, speed),
        ("spin about vector(1, 0.5, 0.2)", SPINS, speed),
    ];
    let rows = cases.map(|(joint, fields, drive)| (joint, winged(joint, fields, drive)));
    let levers = HUNG.map(|lever| (lever.0, hung(&winged("bend about z", &bends, angle), lever)));
    for (joint, text) in rows.into_iter().chain(levers) {
        let rules = compiled(&text);
        let (motion, elements) = moved(&rules, "articulated", true);
        let (originals, images) = elements.split_at(elements.len() / 2);
        assert!(originals.len() == 3 && images.len() == 3, "{joint}: {elements:?}");
        let mut way = 0.0_f64;
        // Later, contacts with the ground make much of little differences.
        for frame in (0..motion.frames()).filter(|frame| motion.time(*frame) <= 0.5) {
            let at = |element| motion.pose(element, motion.time(frame)).unwrap().translation.vector;
            for (&original, &image) in originals.iter().zip(images) {
                let (a, b) = (at(original), at(image));
                let off = (a.x - b.x).abs().max((a.y - b.y).abs()).max((a.z + b.z).abs());
                assert!(off < 3e-4, "{joint}, {} s: {a} and {b}", motion.time(frame));
                way = way.max((a - motion.pose(original, 0.0).unwrap().translation.vector).norm());
            }
        }
        assert!(way > 3e-3, "{joint} moves by {way} m only");
    }
}

/// A range, a speed and a neutral place that read parameters are, for each part, what a text with its numbers says: the same motion,
/// bit for bit.
#[test]
fn ranges_and_speeds_read_parameters() {
    let drive = "distance = most * a.greatest_distance * (1 + sin(t / 1 s * 360 deg))";
    let lever = "stiffness = 20 N/m  damping = 0.1 N*s/m";
    let text = |row: &str, hung_on: &str| {
        let row = format!("{row}  effort = 5 N  stiffness = 500 N/m  damping = 10 N*s/m");
        let hangs = format!("{hung_on}  {lever}");
        hung(&winged("slide along x", &row, drive), ("slide along vector(1, 2, -1)", &hangs))
    };
    let own = text(
        "param reach : Length in 4 mm .. 40 mm = 16 mm  range = -reach / 4 .. reach  speed = reach * 4 / 1 s",
        "param give : Length in 1 mm .. 9 mm = 2 mm  range = -give .. 2 * give  neutral = give / 2",
    );
    let mut ends = Vec::new();
    for (reach, give) in [(16, 2), (32, 4)] {
        let own = own
            .replace("wing to core.left", &format!("wing(reach = {reach} mm) to core.left"))
            .replace("lever to left.tip", &format!("lever(give = {give} mm) to left.tip"));
        let row = format!("range = -{} mm .. {reach} mm  speed = {} mm/s", reach / 4, reach * 4);
        let numbers =
            text(&row, &format!("range = -{give} mm .. {} mm  neutral = {} mm", 2 * give, give / 2));
        let [(own, _), (numbers, _)] =
            [own, numbers].map(|text| moved(&compiled(&text), "articulated", false));
        assert_eq!(own.placements, numbers.placements, "{reach} mm");
        ends.push(end_of_last(&own));
    }
    assert!((ends[0].translation.vector - ends[1].translation.vector).norm() > 1e-3, "{ends:?}");
}

/// A lever, and a row with a ball at its end, whose springs rest elsewhere than where they are attached begin there, without a drive
/// and without weight nothing moves, and a mirror image begins as a mirror image. Springs that rest beyond an end press on it.
#[test]
fn passive_joints_begin_where_their_springs_rest() {
    let text = |lever: &str, row: &str| {
        format!(
            "grammar cocked
            use std.blocks     {{ cube, ball }}
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ gait_annealing }}
            part lever {{
              shape = box(4 cm, 1 cm, 0.5 cm)  density = 1 g/cm^3  friction = 0.8  joint = {lever}
              port back at vector(-2 cm, 0 cm, 0 cm) facing vector(-1, 0, 0)
              port end  at vector(2 cm, 0 cm, 0 cm)  facing vector(1, 0, 0)
            }}
            actuator neck {{
              param segments : Count in 2 .. 6 = 4
              segment = cylinder(4 mm, 1 cm)  density = 1 g/cm^3  friction = 0.8  joint = {row}
            }}
            symmetry mirror xy
            begin {{
              place core : cube
              place fin  : lever to core.left
              place row  : neck to core.front
              place head : ball to row.tip
              place side : neck to fin.end turned 40 deg
              place last : lever to side.tip
            }}
            simulate hinge_model for 2 s
            maximize travel in cm
            search gait_annealing"
        )
    };
    let springs = "stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2";
    let bent = |range: &str, neutral: &str| {
        format!("bend about z passive  bend = {range}  neutral = {neutral}  {springs}")
    };
    let about_y = |range: &str, neutral: &str| bent(range, neutral).replace("about z", "about y");
    for (lever, row, starts) in [
        (about_y("-80 deg .. -20 deg", "-50 deg"), bent("0 deg .. 90 deg", "40 deg"), (-50.0, 40.0)),
        // Pressed against an end, which is where they begin.
        (about_y("-10 deg .. 20 deg", "60 deg"), bent("-30 deg .. 90 deg", "-90 deg"), (20.0, -30.0)),
    ] {
        let rules = compiled(&text(&lever, &row));
        let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
        let elements = &candidate.body.assembly.elements;
        let parts = &candidate.design().parts;
        let of = |kind: &str| {
            let ids = candidate.body.parts_of_elements.iter().enumerate();
            ids.filter(|(_, id)| parts[*id].kind == kind && parts[*id].image == 0)
                .map(|(i, _)| i)
                .next()
                .unwrap()
        };
        // The lever hangs on the left and turns about the vertical, the ball's row bends upwards.
        let angle = |element: usize, along: [f64; 3], rest: [f64; 3]| {
            let along = elements[element].pose.rotation * nalgebra::Vector3::from(along);
            along.angle(&nalgebra::Vector3::from(rest)).to_degrees()
        };
        let fin = angle(of("lever"), [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]);
        assert!((fin - f64::abs(starts.0)).abs() < 1e-6, "{fin} deg for {starts:?}");
        let head = angle(of("ball"), [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        assert!((head - f64::abs(starts.1)).abs() < 1e-6, "{head} deg for {starts:?}");
        let own = Settings { gravity: 0.0, ..settings(&rules.first_task().unwrap().model) };
        // rapier has soft limits, which a preload presses in.
        for (solver, still) in [("articulated", 1e-5), ("rapier", if starts.0 > 0.0 { 3e-3 } else { 1e-4 })] {
            let motion = hanging(&rules, solver, &own).unwrap();
            for (element, begun) in elements.iter().enumerate() {
                let moved = motion.pose(element, 2.0).unwrap();
                let off =
                    (moved.translation.vector - motion.pose(element, 0.0).unwrap().translation.vector).norm();
                assert!(off < still, "{solver}, {starts:?}: element {element} moves by {off} m");
                let turned = moved.rotation.angle_to(&begun.pose.rotation);
                assert!(turned < 100.0 * still, "{solver}: element {element} turns by {turned} rad");
            }
        }
        // Each image begins as the mirror image of its original.
        let places = |image: u8, kind: &str| -> Vec<nalgebra::Vector3<f64>> {
            let all = candidate.body.parts_of_elements.iter().zip(elements);
            let of = all.filter(|(id, _)| parts[*id].kind == kind && parts[*id].image == image);
            of.map(|(_, element)| element.pose.translation.vector).collect()
        };
        let (originals, images) = (places(0, "lever"), places(1, "lever"));
        assert!(originals.len() == 2 && images.len() == 2);
        for (a, b) in originals.iter().zip(&images) {
            let off = (a.x - b.x).abs().max((a.y - b.y).abs()).max((a.z + b.z).abs());
            assert!(off < 1e-9, "{a} and {b}");
        }
    }
    // On the plane of the mirror a row that rests to one side is not its own image.
    // The same of one that presses on where it is attached.
    for row in [about_y("-30 deg .. 90 deg", "20 deg"), about_y("0 deg .. 40 deg", "-20 deg")] {
        let aside = text(&about_y("-10 deg .. 20 deg", "10 deg"), &row);
        let mut sources = SourceMap::default();
        let entry = sources.add("own.sgr", aside.as_str());
        let rules = grammar_lang::compile(&Files, &mut sources, entry, &[], None).ruleset.unwrap();
        assert!(sgc::derive::check_start(&rules).is_some(), "{row}");
    }
}

/// A driven row that is made bent begins so. Driven to where it rests it does not move, driven to 0 it is straight; what is recorded counts
/// from straight.
#[test]
fn a_driven_row_begins_where_it_rests() {
    let row = "segments : Count in 2 .. 6 = 4";
    let text = |drive: &str| {
        winged("bend about z", "neutral = 40 deg  bend = 20 deg .. 90 deg  bending_speed = 90 deg/s  relaxing_speed = 90 deg/s  torque = 0.06 N*m/rad  stiffness = 0.3 N*m/rad^2  damping = 0.01 N*m*s/rad^2", drive)
            .replace("segment = ", &format!("param {row}  segment = "))
    };
    for (drive, end) in [
        ("angle = most * 0 deg + 40 deg", 40.0),
        ("angle = 60 deg + most * 0 deg", 60.0),
        ("angle = most * 0 deg", 20.0),
    ] {
        let rules = compiled(&text(drive));
        for solver in ["articulated", "rapier"] {
            let (motion, elements) = moved(&rules, solver, true);
            let of = |frame: usize| motion.bends[frame * 2].to_degrees();
            assert!((of(0) - 40.0).abs() < 1e-9, "{solver}: {} deg", of(0));
            let last = motion.frames() - 1;
            assert!((of(last) - end).abs() < 0.5, "{solver}, {drive}: {} deg", of(last));
            // The lever at the tip is turned against the cube by as much, and by what the row is turned.
            let lever = *elements.get(elements.len() / 2 - 1).unwrap();
            let turned = |t: f64| {
                let [core, tip] = [0, lever].map(|element| motion.pose(element, t).unwrap().rotation);
                (core.inverse() * tip)
                    .angle_to(
                        &(motion.pose(0, 0.0).unwrap().rotation.inverse()
                            * motion.pose(lever, 0.0).unwrap().rotation),
                    )
                    .to_degrees()
            };
            assert!(
                (turned(2.0) - (end - 40.0_f64).abs()).abs() < 0.5,
                "{solver}, {drive}: {} deg",
                turned(2.0)
            );
            if end == 40.0 {
                let work: f64 = motion.work.iter().sum();
                assert!(work < 1e-6, "{solver}: {work} J to stay where it rests");
            }
        }
    }
}

/// The two solvers agree on where levers go that nothing holds.
#[test]
fn solvers_agree_on_all_joints() {
    let turn = "angle = most * 60 deg * sin(t / 2 s * 360 deg)";
    let rows = [
        ("twist", TURNS, turn),
        ("twist", &TURNS.replace("range", "neutral = 30 deg  range"), turn),
        ("slide along vector(1, 2, -1)", SLIDES, "distance = most * 8 mm * (1 + sin(t / 2 s * 360 deg))"),
        ("spin about vector(1, 0.5, 0.2)", SPINS, "speed = most * a.greatest_speed * sin(t / 2 s * 360 deg)"),
    ];
    let rows = rows.map(|(joint, fields, drive)| (joint, winged(joint, fields, drive)));
    let levers = HUNG.map(|lever| (lever.0, hung(&winged("twist", TURNS, turn), lever)));
    for (joint, text) in rows.into_iter().chain(levers) {
        let rules = compiled(&text);
        let [(ours, elements), (theirs, _)] = ["articulated", "rapier"].map(|name| moved(&rules, name, true));
        for t in [0.5, 1.0, 1.5, 2.0] {
            for &element in &elements {
                let place = |motion: &Motion| motion.pose(element, t).unwrap().translation.vector;
                let off = (place(&ours) - place(&theirs)).norm();
                assert!(off < 4e-3, "{joint}, {t} s: {off} m apart");
            }
        }
    }
}

/// A passive row is none of the actuators, and needs no actuation.
#[test]
fn what_is_passive_is_no_actuator() {
    let text = winged("spin about x", SPINS, "speed = most * a.greatest_speed")
        .replace(
            "symmetry mirror xy",
            "symmetry mirror xy
        actuator axle {
          segment = cylinder(6 mm, 12 mm)  density = 1 g/cm^3  friction = 0.8
          joint = spin about x passive  damping = 1e-5 N*m*s/rad^2
        }",
        )
        .replace(
            "place arm ",
            "place far : axle to core.front
          place arm ",
        )
        .replace(
            "require few : count(part) <= 12",
            "require few : count(part) <= 12
        require two : count(actuator) == 2",
        );
    let rules = compiled(&text);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    assert_eq!(candidate.body.actuators.len(), 2);
    assert_eq!(candidate.body.assembly.actuators, 2);
    let (motion, _) = moved(&rules, "articulated", false);
    assert_eq!(motion.work.len(), 2);
}

/// How the initial design of a grammar moves that nothing drives.
pub(crate) fn hanging(rules: &RuleSet, solver: &str, settings: &Settings) -> Result<Motion, Invalid> {
    let candidate = Candidate::new(rules, Derivation::begin(rules).into());
    let drive = Drive::new(&candidate, rules.first_task().unwrap()).unwrap();
    let targets = drive.targets(&drive.draw(&mut Stream::named(1, "hanging"))).unwrap();
    let mut simulation = model(solver).unwrap().prepare(&candidate.body.assembly, settings).unwrap();
    simulation.run(&[targets]).remove(0)
}

/// Where the last element is at the end.
pub(crate) fn end_of_last(motion: &Motion) -> Isometry3<f64> {
    motion.pose(motion.placements.len() - 1, motion.duration).unwrap()
}

/// A weight hangs on a strip whose joints all come to their limits: where it ends does not depend on the number of sweeps.
#[test]
fn limits_of_a_whole_row_hold() {
    let rules = compiled(
        "grammar hanging
        use std.actuators  { strip }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { gait_annealing }
        part base { shape = box(20 cm, 40 cm, 20 cm)  mass = 20 kg  friction = 1 }
        part lead { shape = box(2 cm, 3 cm, 4 cm)  mass = 200 g  friction = 0.5 }
        begin {
          place core : base
          place hung : strip(segments = 8) to core.front
          place lump : lead to hung.tip
        }
        simulate hinge_model for 2 s
        maximize travel in cm
        search gait_annealing",
    );
    let own = settings(&rules.first_task().unwrap().model);
    let depth = |iterations: usize, step: f64| {
        let settings = Settings { iterations, step, ..own.clone() };
        end_of_last(&hanging(&rules, "articulated", &settings).unwrap()).translation.vector.y
    };
    let many = depth(1000, own.step);
    for step in [1.0 / 240.0, 1.0 / 960.0, 1.0 / 3840.0] {
        let few = depth(own.iterations, step);
        assert!((few - many).abs() < 2e-4, "it hangs at {few} m, and with converged limits at {many} m");
    }
}

/// A weight on a spring that is relaxed above it. It stays where its load balances the spring, if it begins there, and swings about this
/// place, by as much on both sides and in the time of a mass on a spring, if it begins below.
#[test]
fn a_passive_joint_begins_where_it_is_said() {
    let begun = |begins: &str, damping: &str, time: &str| {
        compiled(&format!(
            "grammar hanging
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ gait_annealing }}
            part base {{ shape = box(20 cm, 40 cm, 20 cm)  mass = 2000 kg  friction = 1 }}
            part lump {{
              shape = box(2 cm, 3 cm, 4 cm)  mass = 200 g  friction = 0.5
              joint = slide along y passive  range = -20 mm .. 20 mm
              neutral = mass * hinge_model.gravity / stiffness  begins = {begins}
              stiffness = 300 N/m  damping = {damping}
            }}
            begin {{
              place core : base
              place hung : lump to core.front
            }}
            simulate hinge_model for {time}
            maximize travel in cm
            search gait_annealing"
        ))
    };
    let rose = |rules: &RuleSet, solver: &str, step: f64| {
        let own = settings(&rules.first_task().unwrap().model);
        let motion = hanging(rules, solver, &Settings { step, ..own }).unwrap();
        let of = |element: usize, time: f64| motion.pose(element, time).unwrap().translation.vector.y;
        // The base may settle into the ground.
        let above = |time: f64| of(1, time) - of(0, time);
        (above(motion.duration) - above(0.0)) * 1e3
    };
    for solver in ["articulated", "rapier", "rod"] {
        let stays = rose(&begun("0 mm", "0.5 N*s/m", "2 s"), solver, 1.0 / 240.0);
        assert!(stays.abs() < 0.02, "with {solver} it moves by {stays} mm");
    }
    // Half a swing takes pi * sqrt(m / k): this is seven of them.
    let rules =
        begun("-5 mm", "0 N*s/m", &format!("{} s", 7.0 * std::f64::consts::PI * (0.2_f64 / 300.0).sqrt()));
    let swung = rose(&rules, "articulated", 1.0 / 3840.0);
    assert!((swung - 10.0).abs() < 0.1, "it swings by {swung} mm");
}

/// A heavy lever on a thin row that twists to its limits: it ends there, and rapier, which cannot hold them, gives no motion.
#[test]
fn what_cannot_hold_its_joints_gives_no_motion() {
    let rules = compiled(
        "grammar tubes
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { gait_annealing }
        part stand {
          shape = box(40 cm, 80 cm, 40 cm)  mass = 20 kg  friction = 0.8
          port e at vector(20 cm, 30 cm, 0 cm) facing vector(1, 0, 0)
        }
        actuator tube {
          param segments : Count in 2 .. 12 = 4
          segment = cylinder(5 mm, 2 cm)  joint = twist passive  range = -20 deg .. 25 deg
          density = 1 g/cm^3  friction = 0.5  stiffness = 0.005 N*m/rad^2  damping = 0.001 N*m*s/rad^2
        }
        part plank {
          shape = box(2 cm, 2 cm, 10 cm)  mass = 50 g  friction = 0.5
          port back at vector(-1 cm, 0 cm, -4 cm) facing vector(-1, 0, 0)
        }
        begin {
          place core : stand
          place row  : tube(segments = 6) to core.e
          place last : plank to row.tip
        }
        simulate hinge_model for 3 s
        maximize travel in cm
        search gait_annealing",
    );
    let own = settings(&rules.first_task().unwrap().model);
    let held = hanging(&rules, "articulated", &own).unwrap();
    let turned = end_of_last(&held).rotation.angle().to_degrees();
    assert!((turned - 25.0).abs() < 0.1, "{turned} deg");
    assert_eq!(hanging(&rules, "rapier", &own).err(), Some(Invalid::BeyondLimits));
}

/// A wheel that turns against a paddle which stands at its limit: where they touch, hardly any joint can give way. An
/// impulse that grows without bound there lets rounding errors throw the body about, and its motion is refused.
#[test]
fn what_jams_throws_nothing_about() {
    let jammed = |radius: &str, width: &str, reach: &str, turned: &str| {
        compiled(&format!(
            "grammar jammed
            use std.blocks     {{ cube }}
            use std.actuators  {{ motor }}
            use std.limbs      {{ wheel, paddle }}
            use std.actuation  {{ steady_spin }}
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ recommended }}
            symmetry mirror xy
            begin {{
              place core : cube
              place m    : motor to core.left
              place roll : wheel(radius = {radius}, width = {width}) to m.tip by hub
              place rear : cube to core.back
              place pad  : paddle(reach = {reach}) to rear.left turned {turned} by root
            }}
            rule grow {{
              match  p : block with free port q
              attach cube to q
            }}
            require few : count(part) <= 12
            actuate motor with steady_spin
            simulate hinge_model for 10 s
            maximize travel in cm
            search recommended"
        ))
    };
    for (radius, width, reach, turned) in [
        ("6.4 cm", "38 mm", "8.4 cm", "0 deg"),
        ("8.0 cm", "41 mm", "5.9 cm", "180 deg"),
        ("3.6 cm", "9 mm", "7.2 cm", "0 deg"),
        ("7.0 cm", "6 mm", "6.9 cm", "0 deg"),
        ("4.1 cm", "13 mm", "3.3 cm", "270 deg"),
        ("5.7 cm", "8 mm", "4.2 cm", "270 deg"),
        ("8.0 cm", "3 mm", "8.7 cm", "180 deg"),
    ] {
        let rules = jammed(radius, width, reach, turned);
        let own = settings(&rules.first_task().unwrap().model);
        let refused = hanging(&rules, "articulated", &own).err();
        assert_eq!(refused, None, "a wheel of {radius} by {width} and a paddle of {reach} at {turned}");
    }
}

/// Two fingers squeeze a flap with many times the weight of the body. Its feet are solved as well as if they did not: the servos
/// hold, and do not tremble, which is work for nothing.
#[test]
fn what_squeezes_itself_stands_still() {
    let rules = compiled(
        "grammar gripper
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { gait_annealing }
        part bar {
          shape = box(4 cm, 3 cm, 20 cm)  mass = 1 kg  friction = 0.5
          port fl at vector(2 cm, 0 cm, -5 cm) facing vector(1, 0, 0)
          port fr at vector(2 cm, 0 cm, 5 cm)  facing vector(1, 0, 0)
          port md at vector(2 cm, 0 cm, 0 cm)  facing vector(1, 0, 0)
        }
        part jaw { shape = box(8 cm, 3 cm, 1 cm)  mass = 20 g  friction = 0.5 }
        part flap {
          shape = box(14 cm, 3 cm, 6 cm)  mass = 2.6 g  friction = 0.5
          joint = bend about y passive  bend = -30 deg .. 30 deg
          stiffness = 0.001 N*m/rad^2  damping = 0.0001 N*m*s/rad^2
          port back at vector(-7 cm, 0 cm, 0 cm) facing vector(-1, 0, 0)
        }
        actuator finger {
          param segments : Count in 2 .. 4 = 3
          param side     : Number in -1.0 .. 1.0 = 1.0
          segment = cylinder(5 mm, 2 cm)  joint = bend about y  bend = -60 deg .. 60 deg
          bending_speed = 90 deg/s  relaxing_speed = 90 deg/s  density = 1 g/cm^3  friction = 0.4
          torque = 5 N*m/rad  stiffness = 50 N*m/rad^2  damping = 0.02 N*m*s/rad^2
        }
        actuation squeeze for a : actuator { drive angle = a.side * 40 deg }
        begin {
          place core : bar
          place f1 : finger(segments = 3, side = -1.0) to core.fl
          place j1 : jaw to f1.tip
          place f2 : finger(segments = 3, side = 1.0) to core.fr
          place j2 : jaw to f2.tip
          place mm : flap to core.md by back
        }
        actuate finger with squeeze
        simulate hinge_model for 4 s
        maximize travel in cm
        search gait_annealing",
    );
    let own = settings(&rules.first_task().unwrap().model);
    let worked = |iterations: usize, tolerance: f64| {
        let settings = Settings { iterations, tolerance, ..own.clone() };
        hanging(&rules, "articulated", &settings).unwrap().work.iter().sum::<f64>()
    };
    let (few, many) = (worked(own.iterations, own.tolerance), worked(1000, 1e-6));
    assert!(few < 1.5 * many, "{few} J, and {many} J with a thousand sweeps");
}

/// A variant gives a row another joint, whichever way either is written: the same as the text with that joint.
#[test]
fn a_variant_sets_a_joint() {
    let text = |joint: &str, rest: &str| {
        format!(
            "grammar base
            use std.blocks     {{ cube }}
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ gait_annealing }}
            actuator finger {{
              param segments : Count in 2 .. 12 = 5
              segment = cylinder(9 mm, 2 cm)  density = 1 g/cm^3  friction = 0.8
              bend = -40 deg .. 40 deg  {joint}
              stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2
            }}
            begin {{
              place core : cube
              place arm  : finger to core.front
            }}
            simulate hinge_model for 2 s
            maximize travel in cm
            search   gait_annealing
            {rest}"
        )
    };
    let written = ["joint = bend about y passive", "joint = bend about vector(0, 1, 1) passive"];
    for from in written {
        for to in written {
            let text = text(from, &format!("variant other of base {{ set finger.{to} }}"));
            let mut sources = SourceMap::default();
            let entry = sources.add("set.sgr", text.as_str());
            let found = grammar_lang::compile(&Files, &mut sources, entry, &[], Some("other"));
            let other = found.ruleset.unwrap_or_else(|| panic!("{:?}", found.diagnostics));
            let want = compiled(&text_with(&text, from, to));
            assert_eq!(other.actuators["finger"].joint.kind, want.actuators["finger"].joint.kind);
            let axis = |rules: &grammar_lang::ir::RuleSet| {
                let candidate = Candidate::new(rules, Derivation::begin(rules).into());
                candidate
                    .body
                    .assembly
                    .joints
                    .iter()
                    .flat_map(|j| j.kind.dofs())
                    .map(|dof| dof.axis)
                    .collect::<Vec<_>>()
            };
            assert_eq!(axis(&other), axis(&want), "{from}, {to}");
            assert_ne!(axis(&want).len(), 0);
        }
    }
}

/// The base of a text with a variant, with another joint in place of its own.
fn text_with(text: &str, from: &str, to: &str) -> String {
    let base = text.split("variant").next().unwrap_or("");
    base.replacen(from, to, 1)
}

/// A flat strip is a row of boxes: as heavy as its segments, cut where a row of cylinders is, and both solvers move it alike.
#[test]
fn segments_may_be_boxes() {
    let text = |segment: &str| {
        format!(
            "grammar flat
            use std.blocks     {{ cube }}
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ recommended }}
            actuator strip {{
              param segments : Count in 2 .. 8 = 4
              segment = {segment}  density = 1 g/cm^3  friction = 0.8
              bend = -60 deg .. 60 deg  bending_speed = 90 deg/s  relaxing_speed = 90 deg/s
              torque = 0.06 N*m/rad  stiffness = 0.3 N*m/rad^2  damping = 0.01 N*m*s/rad^2
            }}
            actuation beat for a : strip {{
              vary  most : Number in 0.5 .. 1.0 mutate 0.5 by normal(0, 0.1)
              drive angle = most * 50 deg * sin(t / 1 s * 360 deg)
            }}
            symmetry mirror xy
            begin {{
              place core : cube
              place left : strip to core.left turned 30 deg
            }}
            actuate strip with beat
            simulate hinge_model for 2 s
            maximize travel in cm
            search recommended"
        )
    };
    let flat = compiled(&text("box(20 mm, 4 mm, 24 mm)"));
    let round = compiled(&text("cylinder(6 mm, 20 mm)"));
    let elements = |rules: &RuleSet| {
        let candidate = Candidate::new(rules, Derivation::begin(rules).into());
        candidate.body.assembly.elements.clone()
    };
    let (boxes, cylinders) = (elements(&flat), elements(&round));
    assert_eq!(boxes.len(), cylinders.len());
    let mut mass = 0.0;
    for (one, other) in boxes.iter().zip(&cylinders).skip(1) {
        assert!((one.pose.translation.vector - other.pose.translation.vector).norm() < 1e-12);
        let half = one.shape.half_extents();
        assert!((half.x - other.shape.half_extents().x).abs() < 1e-12);
        assert!((half.y - 2e-3).abs() < 1e-12 && (half.z - 12e-3).abs() < 1e-12);
        mass += one.mass;
    }
    // Two rows of four segments of 1.92 g.
    assert!((mass - 8.0 * 1.92e-3).abs() < 1e-9, "{mass} kg");
    let (own, all) = moved(&flat, "articulated", true);
    let (other, _) = moved(&flat, "rapier", true);
    for element in all {
        for t in [0.25, 0.5, 1.0] {
            let apart = own.pose(element, t).unwrap().translation.vector
                - other.pose(element, t).unwrap().translation.vector;
            assert!(apart.norm() < 3e-3, "element {element} is {} m away at {t} s", apart.norm());
        }
    }
}

/// Without an actuator nothing gives a body energy, so on level ground it comes to rest. Of these two, each found by a search, the one crept
/// by 2 mm/s while faces touched in a single point, which jumped from end to end; the other glided by 0.8 mm/s on a loose limb whose
/// friction pushed it off the ground: the sweeps over the contacts went to and fro.
#[test]
fn bodies_without_actuators_come_to_rest() {
    for grammar in ["tests/creeps.sgr", "tests/glides.sgr"] {
        let rules = crate::support::grammar(grammar);
        let base = settings(&rules.first_task().unwrap().model);
        for step in [1.0 / 240.0, 1.0 / 480.0] {
            let own = Settings { duration: 30.0, step, ..base.clone() };
            let motion = hanging(&rules, "articulated", &own).unwrap();
            let place = |t: f64| motion.pose(0, t).unwrap().translation.vector;
            let way = (place(30.0) - place(20.0)).norm();
            assert!(way < 1e-4, "{grammar}: {way} m in 10 s with a step of {step} s");
        }
    }
}

/// A row of blocks that swings sideways is its own mirror image half a period later, so it goes nowhere. What its blocks carry does not slosh from
/// one to the other with each stroke: this carried the row by 27 mm/s, and further the better its contacts were solved.
#[test]
fn a_row_that_swings_sideways_goes_nowhere() {
    let rules = compiled(
        "grammar swaying
        use std.actuators  { bender }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { gait_annealing }
        part slab { shape = box(4 cm, 3 cm, 4 cm)  mass = 50 g  friction = 0.8 }
        actuation sway for a : actuator { drive angle = 30 deg * sin(t / 2 s * 360 deg) }
        begin {
          place core : slab
          place fore : bender(segments = 3, direction = 90 deg) to core.front
          place mid  : slab to fore.tip
          place hind : bender(segments = 3, direction = 90 deg) to mid.front
          place last : slab to hind.tip
        }
        actuate bender with sway
        simulate hinge_model for 12 s
        maximize travel in cm
        search gait_annealing",
    );
    let own = settings(&rules.first_task().unwrap().model);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let blocks: Vec<usize> = candidate
        .body
        .assembly
        .elements
        .iter()
        .enumerate()
        .filter(|(_, e)| e.mass > 0.04)
        .map(|(n, _)| n)
        .collect();
    assert_eq!(blocks.len(), 3);
    for (name, settings) in [("articulated", own.clone()), ("articulated", own.finer()), ("rod", own)] {
        let motion = hanging(&rules, name, &settings).unwrap();
        let aside = |t: f64| {
            blocks.iter().map(|block| motion.pose(*block, t).unwrap().translation.z).sum::<f64>() / 3.0
        };
        let way = aside(12.0) - aside(4.0);
        assert!(way.abs() < 8e-3, "{name} with a step of {} s: {way} m in four periods", settings.step);
    }
}
