//! Parts that look different in a mirror, joints whose axis is apart from the port, and where expressions see parts.

use grammar_lang::eval::{Reference, Value};
use grammar_lang::ir::RuleSet;
use nalgebra::{Isometry3, Vector3};
use sgc::derive::{Candidate, Derivation, Stream, check_start};
use sgc::results::beginning::beginning;
use sgc::results::names::Names;
use sgc::search::settings;
use sgc::simulate::Settings;

use crate::joints::{compiled, end_of_last, hanging, moved};

/// A cube with a driven row at each side, an arm at the tip of each, and a lever on the arm.
fn armed(arm: &str, held_by: &str, lever_on: &str, lever: &str) -> String {
    format!(
        "grammar armed
        use std.blocks     {{ cube }}
        use std.actuators  {{ twister }}
        use std.models     {{ hinge_model }}
        use std.objectives {{ travel }}
        use std.search     {{ recommended }}
        part arm {{
          shape = box(3 cm, 1 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8
          {arm}
        }}
        part lever {{
          shape = box(4 cm, 1 cm, 0.5 cm)  density = 1 g/cm^3  friction = 0.8
          {lever}
        }}
        actuation beat for a : actuator {{
          vary  most : Number in 0.5 .. 1.0 mutate 0.5 by normal(0, 0.1)
          drive angle = most * 40 deg * sin(t / 1 s * 360 deg)
        }}
        symmetry mirror xy
        begin {{
          place core : cube
          place row  : twister to core.left turned 30 deg
          place held : arm to row.tip turned 20 deg {held_by}
          place last : lever to held.{lever_on} turned 50 deg
        }}
        rule grow {{
          match  p : block with free port q
          attach lever to q
        }}
        require few : count(part) <= 12
        actuate twister with beat
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended"
    )
}

/// A design as the `begin` of its grammar is the same body.
fn begins_again(text: &str, rules: &RuleSet, derivation: &Derivation) {
    let names = Names::through(rules, derivation);
    let begin = beginning(rules, &names, &derivation.design);
    let (from, to) = (text.find("begin {").unwrap(), text.find("rule grow").unwrap());
    let again = compiled(&format!("{}{begin}{}", &text[..from], &text[to..]));
    assert_eq!(check_start(&again), None, "{begin}");
    let begun = Derivation::begin(&again).design;
    assert_eq!(begun.canonical_hash(), derivation.design.canonical_hash(), "{begin}");
}

/// Ports that a mirror would lead to where the kind has none.
const HANDED: &str = "port root at vector(-1 cm, 0.2 cm, -1 cm) facing vector(0, 0, -1)
                      port axle at vector(1 cm, 0.1 cm, 1 cm) facing vector(0.3, 0.2, 1)";
const SPRING: &str = "stiffness = 0.002 N*m/rad^2  damping = 0.00005 N*m*s/rad^2";

/// The image of a part whose ports are on one side has them on the other: it is held there, and what it holds hangs there. A
/// part with ports on both sides is held by that of the other side.
#[test]
fn parts_on_one_side_have_mirror_images() {
    let hinge = format!("joint = bend about vector(0.2, 1, 0.5) passive  bend = -40 deg .. 60 deg  {SPRING}");
    let pivot = format!("{hinge}  pivot = vector(-1 cm, 2 mm, 3 mm)");
    let one_sided = "port hub at vector(-1 cm, 0 cm, 0.25 cm) facing vector(0, 0, 1)";
    let cases = [
        (HANDED, "", "axle", ""),
        (HANDED, "by axle", "root", ""),
        (HANDED, "", "axle", one_sided),
        (HANDED, "", "axle", &format!("{one_sided}  {hinge}")),
        (HANDED, "", "axle", &format!("{one_sided}  {pivot}")),
        ("", "by right", "front", ""),
        ("", "by right", "left", &pivot),
        ("", "by left", "top", one_sided),
    ];
    for (arm, held_by, lever_on, lever) in cases {
        let text = armed(arm, held_by, lever_on, lever);
        let rules = compiled(&text);
        assert_eq!(check_start(&rules), None, "{text}");
        let (motion, elements) = moved(&rules, "articulated", true);
        let (originals, images) = elements.split_at(elements.len() / 2);
        assert!(originals.len() == images.len() && originals.len() >= 4, "{elements:?}");
        let mut way = 0.0_f64;
        // Later, contacts make much of little differences.
        for frame in (0..motion.frames()).filter(|frame| motion.time(*frame) <= 0.15) {
            let pose = |element| -> Isometry3<f64> { motion.pose(element, motion.time(frame)).unwrap() };
            for (&original, &image) in originals.iter().zip(images) {
                let (a, b) = (pose(original), pose(image));
                // A mirror keeps x and y of a frame, and turns z round.
                for along in [Vector3::zeros(), Vector3::x(), Vector3::y()] {
                    let place =
                        |pose: Isometry3<f64>| pose.translation.vector + pose.rotation * (0.01 * along);
                    let (a, b): (Vector3<f64>, Vector3<f64>) = (place(a), place(b));
                    let off = (a.x - b.x).abs().max((a.y - b.y).abs()).max((a.z + b.z).abs());
                    let limit = if frame == 0 { 1e-9 } else { 3e-4 };
                    assert!(off < limit, "{arm} {held_by} {lever_on} {lever}, frame {frame}: {a} and {b}");
                }
                let begun = motion.pose(original, 0.0).unwrap();
                way = way.max(begun.rotation.angle_to(&a.rotation));
            }
        }
        assert!(way > 0.1, "turns by {way} rad only");
    }
}

const GROWS: &str = "choose  turn in { 0 deg, 90 deg, 200 deg }
                     choose  what in { lever, arm, cube }
                     attach  what to q turned turn";

/// Whatever a rule attaches there, and to the images of it: all parts have their image in the mirror, and its ports are those
/// of the part in the mirror.
#[test]
fn random_growth_of_one_sided_parts_stays_symmetric() {
    let text = armed(HANDED, "", "axle", HANDED)
        .replace("shape = box(4 cm, 1 cm, 0.5 cm)", "shape = box(2 cm, 0.4 cm, 2 cm)")
        .replace("attach lever to q", GROWS);
    let rules = compiled(&text);
    let mut random = Stream::named(5, "one-sided");
    let mut parts = 0;
    for _ in 0..20 {
        let mut derivation = Derivation::begin(&rules);
        for _ in 0..4 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        let design = &derivation.design;
        for (id, part) in &design.parts {
            let twin = &design.parts[&design.twin(*id)];
            let own = sgc::design::ports(part);
            for (port, image) in own.iter().zip(sgc::design::ports(twin)) {
                if part.kind == "cube" {
                    continue;
                }
                let (a, b) = (part.pose * port.frame, twin.pose * image.frame);
                let [a, b] = [a, b].map(|at| (at.translation.vector, at.rotation * Vector3::x()));
                for (a, b) in [(a.0, b.0), (a.1, b.1)] {
                    let off = (a.x - b.x).abs().max((a.y - b.y).abs()).max((a.z + b.z).abs());
                    assert!(off < 1e-9, "{}.{}: {a} and {b}", part.kind, port.name);
                }
            }
            parts += usize::from(part.image > 0);
        }
        begins_again(&text, &rules, &derivation);
    }
    assert!(parts > 60, "{parts} images");
}

/// A plate that hangs on its rim, and turns about the middle of itself: nothing pulls it down. About the rim it falls.
#[test]
fn a_part_turns_about_its_pivot() {
    let text = |pivot: &str| {
        format!(
            "grammar signpost
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ gait_annealing }}
            part stand {{ shape = box(10 cm, 60 cm, 10 cm)  mass = 20 kg  friction = 0.8 }}
            part plate {{
              shape = box(6 cm, 1 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8
              port rim at vector(-3 cm, 0 cm, 0 cm) facing vector(-1, 0, 0)
              joint = bend about z passive  bend = -80 deg .. 80 deg  {pivot}
              stiffness = 0 N*m/rad^2  damping = 0 N*m*s/rad^2
            }}
            begin {{
              place core : stand
              place sign : plate to core.front
            }}
            simulate hinge_model for 0.5 s
            maximize travel in cm
            search gait_annealing"
        )
    };
    // A free end falls, at first, by 3/2 g: the middle of the bar by 3/4 g.
    for (pivot, lever) in
        [("", 0.03), ("pivot = vector(0 cm, 0 cm, 0 cm)", 0.0), ("pivot = vector(1 cm, 0 cm, 0 cm)", -0.01)]
    {
        let rules = compiled(&text(pivot));
        let own = Settings { step: 1.0 / 4800.0, ..settings(&rules.first_task().unwrap().model) };
        let motion = hanging(&rules, "articulated", &own).unwrap();
        let element = motion.placements.len() - 1;
        let rest = motion.pose(element, 0.0).unwrap();
        let t = motion.time(2);
        // Small angles: the angle grows as half of m g r / (I + m r^2) times the square of the time.
        let moment = (0.06_f64.powi(2) + 0.01_f64.powi(2)) / 12.0 + lever * lever;
        let angle = -0.5 * own.gravity * lever / moment * t * t;
        let now = motion.pose(element, t).unwrap();
        let forward = now.rotation * Vector3::x();
        let turned = libm::atan2(forward.y, forward.x);
        assert!(
            (turned - angle).abs() < 0.02 * angle.abs() + 1e-6,
            "{pivot}: {turned} rad, {angle} expected"
        );
        let fallen = now.translation.vector.y - rest.translation.vector.y;
        assert!((fallen - lever * libm::sin(turned)).abs() < 1e-5, "{pivot}: fallen by {fallen} m");
    }
    // The motion of the free plate about its middle never begins.
    let rules = compiled(&text("pivot = vector(0 cm, 0 cm, 0 cm)"));
    let own = settings(&rules.first_task().unwrap().model);
    let motion = hanging(&rules, "rapier", &own).unwrap();
    assert!(end_of_last(&motion).rotation.angle() < 1e-3);
}

/// A flap that hangs in a socket on the ground: between the axes of the socket there is nothing that could sink.
#[test]
fn a_socket_may_be_at_the_ground() {
    for (height, pivot) in [("-5 mm", ""), ("0 mm", ""), ("0 mm", "pivot = vector(-20 mm, -6 mm, 0 mm)")] {
        let rules = compiled(&format!(
            "grammar tile
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ gait_annealing }}
            part slab {{
              shape = box(40 mm, 10 mm, 30 mm)  density = 1 g/cm^3  friction = 0.8
              port front at vector(20 mm, {height}, 0 mm) facing vector(1, 0, 0)
            }}
            part flap {{
              shape = box(40 mm, 10 mm, 30 mm)  density = 1 g/cm^3  friction = 0.8
              port back at vector(-20 mm, {height}, 0 mm) facing vector(-1, 0, 0)
              joint = socket passive  range = -30 deg .. 30 deg  {pivot}
              stiffness = 0.02 N*m/rad^2  damping = 0.0005 N*m*s/rad^2
            }}
            begin {{
              place core : slab
              place f    : flap to core.front
            }}
            simulate hinge_model for 2 s
            maximize travel in cm
            search gait_annealing"
        ));
        let own = settings(&rules.first_task().unwrap().model);
        let motion = hanging(&rules, "articulated", &own).unwrap();
        let last = motion.placements.len() - 1;
        let off = motion.pose(last, 2.0).unwrap().translation.vector
            - motion.pose(last, 0.0).unwrap().translation.vector;
        assert!(off.norm() < 1e-3, "{height} {pivot}: moves by {off}");
    }
}

/// Requirements see where parts and ports are, and where they point, in the frame of the core; on the plane exactly 0.
#[test]
fn expressions_see_places() {
    let text = armed(HANDED, "", "axle", "").replace(
        "require few : count(part) <= 12",
        "require few : count(part) <= 12
        require sides : held.place.z < 0 mm and held.twin.place.z > 0 mm
        require ports : held.axle.place.z == -held.twin.axle.place.z and held.axle.facing.z < 0
        require heads : bearing(row.facing) == 90 deg and bearing(row.twin.facing) == -90 deg
        require same  : last.lowest_point == last.twin.lowest_point
        require whole : core.place.z == 0 mm and core.lowest_point == -12.5 mm and core.front.place.x == 12.5 mm
        require rest  : length(core.top.place) == 12.5 mm and length(row.facing) == 1",
    );
    let rules = compiled(&text);
    assert_eq!(check_start(&rules), None);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    assert!(candidate.body.assembly.elements.len() > 4);
    // A drive sees them, too: the two sides, which the same curve would move alike, go opposite ways.
    let aside = |drive: &str| {
        let rules = compiled(&text.replace("most * 40 deg", drive));
        let (motion, elements) = moved(&rules, "articulated", true);
        let at = |element: usize| motion.pose(element, 0.25).unwrap().translation.vector;
        let (original, image) = (at(elements[elements.len() / 2 - 1]), at(elements[elements.len() - 1]));
        (original.y - image.y).abs()
    };
    let (alike, opposite) = (aside("40 deg"), aside("(if a.place.z > 0 mm then -1 else 1) * 40 deg"));
    assert!(alike < 1e-4 && opposite > 5e-3, "{alike} m and {opposite} m");
}

/// What is attached alone has no image, nor has what hangs on it; the port in the mirror stays free, and everything else has its image.
#[test]
fn what_is_attached_alone_has_no_image() {
    let text = armed(HANDED, "", "axle", "")
        .replace(
            "place last : lever to held.axle turned 50 deg",
            "place last : lever to held.axle turned 50 deg
             place camera : cube to core.top turned 30 deg alone
             place cab : lever to camera.right",
        )
        .replace("attach lever to q", "attach lever to q alone as a attach cube to a.front")
        .replace(
            "require few : count(part) <= 12",
            "rule pair {
               match  p : cube with free port q where q is left and p is not core
               attach cube to q
             }
             require few : count(part) <= 24
             require one : camera.twin is camera and cab.twin is cab and not camera.own_image and camera.image == 0
             require tilted : camera.upward.y < 0.1 and abs(camera.sideways.x) == 0.5 and cab.place.x != 0 mm",
        );
    let rules = compiled(&text);
    assert_eq!(check_start(&rules), None);
    let begun = Derivation::begin(&rules);
    assert_eq!(begun.design.parts.len(), 1 + 2 * 3 + 2);
    let mut random = Stream::named(7, "alone");
    let (mut alone, mut pairs) = (0, 0);
    for _ in 0..20 {
        let mut derivation = begun.clone();
        for _ in 0..4 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        let design = &derivation.design;
        for (id, part) in &design.parts {
            let holder = part.held_by.and_then(|(holder, _)| design.parts.get(&holder));
            // What hangs on something alone is alone, and has no image.
            assert!(part.alone || !holder.is_some_and(|holder| holder.alone));
            if part.alone {
                assert_eq!((design.orbit(*id).len(), part.image), (1, 0));
                alone += 1;
            }
            pairs += usize::from(part.image > 0);
        }
        // What was made of it is made again.
        let again = Derivation::replay(&rules, &derivation.steps).unwrap();
        assert_eq!(again.design.canonical_hash(), design.canonical_hash());
        begins_again(&text, &rules, &derivation);
    }
    assert!(alone > 100 && pairs >= 60, "{alone} alone, {pairs} images");
}

/// One effect sets all parts of a kind; requirements see only what it comes to in the end.
#[test]
fn one_effect_sets_all_parts_of_a_kind() {
    let rules = compiled(
        "grammar wheels
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { recommended }
        part axle { shape = box(2 cm, 1 cm, 4 cm)  density = 1 g/cm^3  friction = 0.8 }
        part tyre {
          param radius : Length in 5 mm .. 40 mm = 10 mm
          shape = sphere(radius)  density = 1 g/cm^3  friction = 0.8
        }
        symmetry mirror xy
        begin {
          place core : axle
          place u    : tyre to core.left
          place rear : axle to core.back
          place v    : tyre to rear.left
        }
        rule grow {
          choose r in 10 mm .. 30 mm
          match  a : axle
          set    w.radius = r + 2 * a.depth * 1 mm for w in tyre
        }
        require level : forall w in tyre: w.radius == v.radius because \"it stands level\"
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended",
    );
    let begun = Derivation::begin(&rules);
    let grown = begun.advance(&rules, &mut Stream::named(1, "wheels"), 1.0).result.unwrap();
    let radii: Vec<f64> = (grown.design.parts.values())
        .filter(|part| part.kind == "tyre")
        .map(|part| part.params["radius"].as_number().unwrap())
        .collect();
    assert!(radii.len() == 4 && radii[0] != 0.01 && radii.iter().all(|r| *r == radii[0]), "{radii:?}");
}

/// What a rule says by `let` follows from the design: where an earlier step is taken back, it is worked out again.
#[test]
fn a_let_follows_what_is_taken_back() {
    let rules = compiled(
        "grammar rods
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { recommended }
        part hub { shape = box(2 cm, 2 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8 }
        part rod {
          param size : Length in 1 cm .. 4 cm = 2 cm
          shape = box(size, 1 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8
          port back at vector(-size / 2, 0 cm, 0 cm) facing vector(-1, 0, 0)
        }
        begin { place core : hub }
        rule add {
          match  h : hub with free port q
          choose fresh in { 1 cm, 2 cm, 3 cm, 4 cm }
          let    r = min over x in rod of x.size otherwise fresh
          attach rod(size = r) to q
        }
        rule undo { match s : step where s adds part  revert s }
        require few : count(part) <= 7
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended",
    );
    let mut random = Stream::named(3, "rods");
    let mut derivation = Derivation::begin(&rules);
    let mut reverted = 0;
    for _ in 0..200 {
        let before = derivation.steps.len();
        let Some(next) = derivation.advance(&rules, &mut random, 1.0).result else { continue };
        reverted += usize::from(next.steps.len() < before);
        derivation = next;
        // The steps that are listed make this body, as a rule would make them now.
        let followed = Derivation::follow_all(&rules, &derivation.steps).unwrap();
        assert_eq!(followed.design.canonical_hash(), derivation.design.canonical_hash());
    }
    assert!(reverted > 20, "{reverted}");
}

/// At a tilted port the end of a part reaches into the face that holds it, and does not overlap; one that goes through its holder does.
#[test]
fn a_tilted_part_does_not_overlap_its_holder() {
    let overlaps = |tilt: &str, own: &str, at: &str, back: &str| {
        let rules = compiled(&format!(
            "grammar leaning
            use std.models     {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search     {{ recommended }}
            part base {{
              shape = box(6 cm, 2 cm, 6 cm)  density = 1 g/cm^3  friction = 0.8
              port slope at vector({at}, 1 cm, 0 cm) facing vector(sin({tilt}), cos({tilt}), 0)
            }}
            part mast {{
              shape = box(8 cm, 1 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8
              port foot at vector({back}, 0 cm, 0 cm) facing vector(-cos({own}), sin({own}), 0)
            }}
            begin {{
              place core : base
              place up   : mast to core.slope
            }}
            rule grow {{
              match  p : base
              set    p.turn = 90 deg
            }}
            simulate hinge_model for 2 s
            maximize travel in cm
            search recommended"
        ));
        let design = Derivation::begin(&rules).design;
        assert_eq!(design.parts.len(), 2);
        !design.no_overlap(&rules)
    };
    for tilt in ["0 deg", "20 deg", "45 deg", "59 deg"] {
        assert!(!overlaps(tilt, "0 deg", "0 cm", "-4 cm"), "{tilt}");
        // The same where the tilt is that of its own port, or each has half of it.
        assert!(!overlaps("0 deg", tilt, "0 cm", "-4 cm"), "{tilt}");
        assert!(!overlaps(&format!("0.5 * {tilt}"), &format!("0.5 * {tilt}"), "0 cm", "-4 cm"), "{tilt}");
        // Held in its middle.
        assert!(overlaps(tilt, "0 deg", "0 cm", "0 cm"), "{tilt}");
    }
    assert!(overlaps("80 deg", "0 deg", "0 cm", "-4 cm"));
    assert!(overlaps("0 deg", "80 deg", "0 cm", "-4 cm"));
    // At the edge it leans away from the base.
    assert!(!overlaps("70 deg", "0 deg", "3 cm", "-4 cm"));
}

/// What hangs on the plane of a mirror is its own image only if its joint is, too: about an axis in the plane or across it, through the plane.
#[test]
fn joints_on_the_mirror_are_their_own_images() {
    let text = |lever: &str, row: &str| {
        format!(
            "grammar own
            use std.blocks {{ cube }}
            use std.models {{ hinge_model }}
            use std.objectives {{ travel }}
            use std.search {{ recommended }}
            part lever {{ shape = box(4 cm, 1 cm, 1 cm)  density = 1 g/cm^3  friction = 0.8 {lever} }}
            actuator neck {{
              segment = cylinder(1 cm, 3 cm)  density = 0.4 g/cm^3  friction = 0.9
              param segments : Count in 2 .. 4 = 3
              {row}
            }}
            symmetry mirror xy
            begin {{ place core : cube
                     place row : neck to core.front
                     place last : lever to row.tip }}
            simulate hinge_model for 2 s
            maximize travel in cm
            search recommended"
        )
    };
    let bend = |axis: &str| format!("joint = bend about {axis} passive  bend = -40 deg .. 40 deg  {SPRING}");
    let slide = |axis: &str| {
        format!(
            "joint = slide along {axis} passive  range = -5 mm .. 5 mm  stiffness = 50 N/m  damping = 0.5 N*s/m"
        )
    };
    let pivot = |at: &str| format!("{}  pivot = vector({at})", bend("y"));
    let across = "bend about z passive  bend = -40 deg .. 40 deg";
    let row = |joint: &str| format!("joint = {joint}  {SPRING}");
    for (lever, joint, is_own) in [
        (String::new(), across, true),
        (bend("y"), across, true),
        (bend("z"), across, true),
        (bend("vector(1, 2, 0)"), across, true),
        (bend("vector(0, 1, 1)"), across, false),
        (pivot("1 cm, 2 mm, 0 mm"), across, true),
        (pivot("1 cm, 2 mm, 3 mm"), across, false),
        (bend("z") + "  pivot = vector(1 cm, 2 mm, 3 mm)", across, true),
        (slide("x"), across, true),
        (slide("z"), across, true),
        (slide("vector(1, 0, 1)"), across, false),
        (String::new(), "bend about y passive  bend = -40 deg .. 40 deg", true),
        (String::new(), "bend about vector(0, 1, 1) passive  bend = -40 deg .. 40 deg", false),
    ] {
        let rules = compiled(&text(&lever, &row(joint)));
        assert_eq!(check_start(&rules).is_none(), is_own, "{lever} {joint}");
    }
}

/// What hangs on a part, and where its centre of mass is: those of its elements, with every joint at 0.
#[test]
fn bodies_know_what_hangs_on_a_part_and_where_its_mass_is() {
    let text = armed("", "", "front", "");
    let text = text.replace("require few", "require sums : abs((sum over p in hanging_on(core) of p.mass) + core.mass - (sum over p in part of p.mass)) < 1e-6 g
            require none : forall p in part: forall c in hanging_on(p): not (exists h in hanging_on(c): h is twister)
            require mine : forall a in twister: count(hanging_on(a)) == 2 and count(hanging_on(first(hanging_on(a)))) == 1
            require few");
    let rules = compiled(&text);
    assert_eq!(check_start(&rules), None);
    let candidate = Candidate::new(&rules, Derivation::begin(&rules).into());
    let design = candidate.design();
    let elements = &candidate.body.assembly.elements;
    for id in design.parts.keys() {
        let own = candidate.body.elements_of(*id).map(|i| &elements[i]);
        let (mut sum, mut mass) = (Vector3::zeros(), 0.0);
        for element in own {
            sum += element.pose.translation.vector * element.mass;
            mass += element.mass;
        }
        let [least, greatest] = design.corners(&rules, *id).unwrap().map(Vector3::from);
        assert!((greatest - least).min() > 5e-3);
        for element in candidate.body.elements_of(*id).map(|i| &elements[i]) {
            let below = element.shape.lowest(&element.pose);
            assert!(below > least.y - 2e-9 && element.pose.translation.vector.y < greatest.y);
        }
        let lowest = design.lowest_point(&rules, *id).unwrap();
        assert!((lowest - least.y).abs() < 2e-9);
        let centre = Vector3::from(design.attached().centre(*id).unwrap());
        assert!((centre - least).min() > 0.0 && (greatest - centre).min() > 0.0);
        assert!((sum / mass - centre).norm() < 2e-9, "{centre}");
        assert!((design.mass(*id).unwrap() - mass).abs() < 1e-12);
    }
}

/// A part that moves otherwise in a mirror is another body where it is an image than where it is an original; a text that places it
/// again makes the same one. What moves alike is the same body.
#[test]
fn parts_that_move_otherwise_in_a_mirror_are_other_bodies() {
    let bend = |axis: &str, rest: &str| format!("joint = bend about {axis} passive  {rest}  {SPRING}");
    let even = "bend = -40 deg .. 40 deg";
    let slide = |axis: &str, range: &str| {
        format!(
            "joint = slide along {axis} passive  range = {range}  stiffness = 50 N/m  damping = 0.5 N*s/m"
        )
    };
    for (joint, is_other) in [
        (String::new(), false),
        (bend("z", even), false),
        (bend("z", "bend = -10 deg .. 40 deg  neutral = 20 deg"), false),
        (bend("y", even), false),
        (bend("vector(1, 2, 0)", even), false),
        (bend("y", "bend = -40 deg .. 40 deg  neutral = -20 deg"), true),
        (bend("y", "bend = -10 deg .. 40 deg"), true),
        (bend("vector(0, 1, 1)", even), true),
        (bend("y", even) + "  pivot = vector(-1 cm, 0 cm, 2 mm)", true),
        (bend("z", even) + "  pivot = vector(-1 cm, 0 cm, 2 mm)", false),
        (slide("x", "-5 mm .. 5 mm"), false),
        (slide("x", "0 mm .. 5 mm"), false),
        (slide("z", "-5 mm .. 5 mm"), false),
        (slide("z", "0 mm .. 5 mm"), true),
    ] {
        let text = armed("", "", "front", &joint);
        let text = text.replace("          place last : lever to held.front turned 50 deg\n", "");
        let rules = compiled(&text);
        let grown = |image: u8| {
            let derivation = Derivation::begin(&rules);
            let arm =
                derivation.design.parts.iter().find(|(_, part)| part.kind == "arm" && part.image == image);
            let arm = *arm.unwrap().0;
            let rule = rules.rules.iter().find(|rule| rule.name == "grow").unwrap();
            let all = derivation.matches(&rules, rule).unwrap();
            let is_it = |locals: &&Vec<Value>| {
                locals[0] == Value::Reference(Reference::Part(arm))
                    && matches!(locals[1], Value::Reference(Reference::Port(_, port)) if port_name(&derivation, arm, port) == "front")
            };
            derivation.apply(&rules, rule, all.iter().find(is_it).unwrap()).ok().unwrap()
        };
        let both = [grown(0), grown(1)];
        let hash = |derivation: &Derivation| derivation.design.canonical_hash();
        assert_eq!(hash(&both[0]) != hash(&both[1]), is_other, "{joint}");
        for derivation in &both {
            begins_again(&text, &rules, derivation);
        }
    }
}

fn port_name(derivation: &Derivation, part: sgc::design::PartId, port: u8) -> String {
    sgc::results::describe::port_name(&derivation.design.parts[&part], port).unwrap_or_default()
}

/// What hangs alone on any image of a radial symmetry is placed there again.
#[test]
fn what_hangs_alone_on_any_image_is_placed_again() {
    let text = "grammar radial
        use std.blocks     { cube, ball }
        use std.models     { hinge_model }
        use std.objectives { travel }
        use std.search     { recommended }
        part hub {
          shape = disk(3 cm, 2 cm)  density = 1 g/cm^3  friction = 0.8
          port rim[i in 0 .. 3] at vector(3 cm * cos(i * 90 deg), 0 cm, 3 cm * sin(i * 90 deg)) facing vector(cos(i * 90 deg), 0, sin(i * 90 deg))
        }
        symmetry radial 4 about y
        begin {
          place core : hub
          place leg  : cube to core.rim[0]
        }
        rule grow {
          match  p : cube with free port q
          attach ball to q alone
        }
        rule limb {
          match  p : cube with free port q
          attach cube to q
        }
        require few : count(part) <= 60
        simulate hinge_model for 2 s
        maximize travel in cm
        search recommended";
    let rules = compiled(text);
    let mut named = 0;
    for seed in 0..30 {
        let mut derivation = Derivation::begin(&rules);
        let mut random = Stream::named(seed, "alone");
        for _ in 0..6 {
            if let Some(next) = derivation.advance(&rules, &mut random, 1.0).result {
                derivation = next;
            }
        }
        begins_again(text, &rules, &derivation);
        let names = Names::through(&rules, &derivation);
        named += beginning(&rules, &names, &derivation.design).matches("images(").count();
    }
    assert!(named > 10, "further images were met");
}

/// A value that is set for all parts of a kind is worked out for originals; images follow.
#[test]
fn what_is_set_for_a_kind_is_set_for_originals() {
    let text = armed("", "", "front", "param long : Length in 1 cm .. 4 cm = 2 cm")
        .replace("shape = box(4 cm, 1 cm, 0.5 cm)", "shape = box(long, 1 cm, 0.5 cm)");
    let text = text.replace(
        "require few",
        "            rule resize { set w.long = (if w.image > 0 then 4 cm else 1 cm) for w in lever }
            example sized {
              step one = resize()
              expect forall w in lever: w.long == 1 cm
            }
            require few",
    );
    let rules = compiled(&text);
    let (name, example) = rules.examples.first().unwrap();
    assert!(sgc::derive::run_example(&rules, name, example).is_ok());
}

/// Where no curves are tuned, a body whose drive tells original from image is another one where the other side is the original: a
/// population does not take one for the other.
#[test]
fn a_population_knows_originals_from_images() {
    let text = "grammar sides
        use std.blocks     { cube }
        use std.actuators  { bender }
        use std.objectives { turning }
        use std.models     { hinge_model }
        symmetry mirror xy
        begin { place core : cube }
        rule leg {
          match  p : part with free port q where p is core and (q is left or q is right)
          attach bender(segments = 4) to q turned 180 deg
        }
        rule swap { match s : step where s.rule == \"leg\"  revert s }
        actuation wave for a : actuator {
          let period  = 3 s
          drive angle = (if a.image > 0 then 1 else 0.3) * 60 deg * sin(t / period * 360 deg)
        }
        actuate  bender with wave
        simulate hinge_model for 10 s
        maximize 90 deg - turning in deg
        search plain
        search plain {
          keep = 80 %
          bodies population { iterations = 30  moves = 3  size = 8  tournament = 2  further = 0 %  stop = false }
        }
        example lefty { step a = leg(p = core, q = core.left) }
        example righty { step a = leg(p = core, q = core.right) }";
    let rules = crate::joints::compiled(text);
    let [left, right] = ["lefty", "righty"].map(|name| Derivation::start(&rules, Some(name)).unwrap().design);
    assert_eq!(left.canonical_hash(), right.canonical_hash());
    assert_ne!(left.driven_hash(), right.driven_hash());
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sides.sgr");
    std::fs::write(&file, text).unwrap();
    let best = |seed: &str| {
        let out = folder.path().join(seed);
        let (file, to) = (file.to_string_lossy(), out.to_string_lossy());
        let output = crate::command_line::sgc(&["run", &file, "--seed", seed, "--quiet", "--out", &to]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        let text = std::fs::read_to_string(out.join("best.design.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["value"].as_f64().unwrap()
    };
    let all: Vec<f64> = ["1", "2", "3"].map(best).to_vec();
    assert!(all.windows(2).all(|pair| pair[0] == pair[1]), "{all:?}");
}
