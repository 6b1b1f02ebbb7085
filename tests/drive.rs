//! `sgc drive`: from a run folder to what a board plays, and to a board that plays it.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::rig::Rig;
use crate::support::{root, said};

fn sgc(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sgc"));
    command.args(arguments).env("NO_COLOR", "1");
    command
}

fn run(arguments: &[&str]) -> Output {
    sgc(arguments).output().unwrap()
}

fn grammar(name: &str) -> String {
    root().join("grammars").join(name).to_string_lossy().into_owned()
}

/// A folder with a short run of each of the two grammars that have a target.
fn runs() -> &'static Path {
    static RUNS: OnceLock<TempDir> = OnceLock::new();
    let folder = RUNS.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        for name in ["pneumatic", "tendon"] {
            let out = folder.path().join(name);
            // A short search finds no gait that holds everywhere.
            let base = grammar(&format!("{name}.sgr"));
            let file = folder.path().join(format!("{name}.sgr"));
            let text = format!(
                "use std.objectives {{ lasting_travel }}\nuse std.search {{ shortly_many_kinds }}\nvariant {name} of \"{base}\" {{\n  \
                 replace maximize lasting_travel in cm\n  replace search shortly_many_kinds\n}}\n"
            );
            std::fs::write(&file, text).unwrap();
            let file = file.to_string_lossy().into_owned();
            let output =
                run(&["run", &file, "--max-evals", "60", "--quiet", "--out", &out.to_string_lossy()]);
            assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        }
        folder
    });
    folder.path()
}

/// The period of a cycle of valves is what it says, whether a variable is called `period` or not.
#[test]
fn a_cycle_whose_period_is_a_number_is_played() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("fixed.sgr");
    let text = format!(
        "use std.objectives {{ travel }}
        use std.search {{ shortly_many_kinds }}
        actuation beat for a : actuator {{
          vary  open : Number in 0.3 .. 0.7 mutate 0.5 by normal(0, 0.1)
          drive valves = cycle(2 s, [open, 1 - open], [inflate, vent], 0)
        }}
        variant fixed of \"{}\" {{
          replace actuate bender with beat
          replace maximize travel in cm
          replace search shortly_many_kinds
        }}\n",
        grammar("pneumatic.sgr")
    );
    std::fs::write(&file, text).unwrap();
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let output =
        run(&["run", &file.to_string_lossy(), "--max-evals", "20", "--seed", "2", "--quiet", "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let output = run(&["drive", &out, "--dry-run"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("period 2 s"), "{}", said(&output));
}

fn design(name: &str) -> String {
    runs().join(name).to_string_lossy().into_owned()
}

#[test]
fn what_a_board_would_play_is_printed_and_drawn() {
    for (name, kind, row) in [("pneumatic", "valves", "inflate"), ("tendon", "servos", "1000 to 2000 us")] {
        let output = run(&["drive", &design(name), "--dry-run"]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(0), "{text}");
        assert!(text.contains(&format!("channels of {kind}, period")) && text.contains(row), "{text}");
        let pin = if name == "pneumatic" { "bender-1 (in D3, out D4)" } else { "(D3)" };
        assert!(text.contains(pin), "{text}");
        let drawn = std::fs::read_to_string(runs().join(name).join("schedule.svg")).unwrap();
        roxmltree::Document::parse(&drawn).unwrap();
    }
}

#[test]
fn eval_says_what_to_expect_of_the_robot_when_it_is_built() {
    let text = said(&run(&["eval", &design("tendon")]));
    for words in [
        "speed on `threads`",
        "simulated (`settled_speed`)",
        "(from the measured and simulated speeds of E, F and G on tendon)",
        "of 3 lie in the interval that the others give",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// The value of a design when another grammar judges it.
fn value(design: &str, grammar: &str) -> String {
    let output = run(&["eval", design, "--grammar", grammar]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    said(&output).lines().find(|line| line.starts_with("value")).unwrap().to_owned()
}

/// Slow servos, little air, slow valves: the same commands make another motion. Without the target they make none of it.
#[test]
fn what_the_target_can_do_holds_in_the_simulation() {
    let folder = tempfile::tempdir().unwrap();
    // Only actuators that let air in at the same time share it.
    let together = "
        add actuation together for a : actuator {
          shared period        : Time   in 1 s .. 7 s mutate 0.3 by normal(0 s, 1 s)
          vary   share[4]      : Number in 0.0 .. 1.0 mutate 0.5 by normal(0, 1)
          vary   counter_phase : Bool                 flip 0.1
          drive  valves = cycle(period, [0, 1, 0, 1], [closed, inflate, closed, vent], 0)
        }
        replace actuate bender with together";
    for (name, also, edit) in [
        ("tendon", "", "set threads.servo_speed = 10 deg/s"),
        ("tendon", "", "set threads.turn = -5 deg .. 5 deg"),
        ("pneumatic", together, "set valves.supply.line = 1 cm^3/s/bar"),
        ("pneumatic", "", "set valves.shortest = 2 s"),
    ] {
        let value = |edits: &[&str]| {
            let grammar =
                variant(folder.path(), &format!("{name}.sgr"), &[&[also], edits].concat().join("\n"));
            value(&design(name), &grammar)
        };
        // Off the target no supply has a pressure that a world could change: one world it is.
        let off = "replace simulate hinge_model for 20 s\nreplace maximize lasting_travel in cm";
        let off = if name == "pneumatic" { format!("{off}\ndrop workshop.pressure") } else { off.to_owned() };
        let off = &*off;
        assert_ne!(value(&[edit]), value(&[]), "{edit}");
        assert_eq!(value(&[edit, off]), value(&[off]), "{edit}");
    }
}

/// A variant of a grammar in a file of its own.
fn variant(folder: &Path, base: &str, edits: &str) -> String {
    let path = folder.join("variant.sgr");
    std::fs::write(&path, format!("variant other of \"{}\" {{\n{edits}\n}}\n", grammar(base))).unwrap();
    path.to_string_lossy().into_owned()
}

#[test]
fn what_does_not_fit_is_refused_before_anything_moves() {
    let folder = tempfile::tempdir().unwrap();
    let (air, threads) = (design("pneumatic"), design("tendon"));
    let few = variant(folder.path(), "pneumatic.sgr", "set valves.inflate = [D3]\nset valves.vent = [D4]");
    let cases: [(&[&str], &str); 6] = [
        (&["drive", &air, "--dry-run", "--grammar", &few], "the target has 1 channels: name more pins"),
        (&["drive", &air, "--dry-run", "--target", "threads"], "has no target `threads`; it has: valves"),
        (&["drive", &air, "--port", "/dev/nowhere"], "there is no port /dev/nowhere"),
        (&["drive", &threads], "--port <PATH>"),
        (&["drive", &threads, "--port", "x", "--cycles", "-1"], "unexpected argument '-1'"),
        (&["drive", "/nowhere", "--dry-run"], "cannot read /nowhere"),
    ];
    for (arguments, message) in cases {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", said(&output));
        assert!(said(&output).contains(message), "{arguments:?}: {}", said(&output));
    }
}

/// Targets that make another motion of the gait are refused, each with its reason; with the flag they are shown.
#[test]
fn a_target_that_changes_the_motion_is_refused_or_shown() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [
        (
            "pneumatic",
            "set valves.shortest = 2200 ms",
            "`shortest` is 2200 ms (before: 40 ms)",
            "are left out",
        ),
        ("pneumatic", "set bender.bending_speed = 5 deg/s", "`bending_speed` is 5 deg/s", ""),
        (
            "tendon",
            "set threads.turn = -3 deg .. 3 deg",
            "`turn` is -3 deg .. 3 deg",
            "it is asked to bend by",
        ),
        ("tendon", "set threads.wheel = 2 mm", "`wheel` is 2 mm", "it is asked to bend by"),
        (
            "tendon",
            "set threads.servo_speed = 4 deg/s",
            "`servo_speed` is 4 deg/s",
            "it is too slow for its curve",
        ),
    ];
    for (name, edit, contents, cut) in cases {
        let copy = folder.path().join("best.design.json");
        std::fs::copy(Path::new(&design(name)).join("best.design.json"), &copy).unwrap();
        let copy = copy.to_string_lossy();
        let other = variant(folder.path(), &format!("{name}.sgr"), edit);
        let refused = run(&["drive", &copy, "--dry-run", "--grammar", &other]);
        let text = said(&refused);
        assert_eq!(refused.status.code(), Some(2), "{edit}: {text}");
        for words in
            ["would not move as in the simulation", "bender-1: bent by", contents, cut, "--accept-changes"]
        {
            assert!(text.contains(words), "{edit}: {words}: {text}");
        }
        assert!(!folder.path().join("difference.svg").exists() && refused.stdout.is_empty(), "{text}");
        let shown = run(&["drive", &copy, "--dry-run", "--grammar", &other, "--accept-changes"]);
        let text = said(&shown);
        assert_eq!(shown.status.code(), Some(0), "{edit}: {text}");
        assert!(text.contains(contents) && text.contains("drawn in") && text.contains("period"), "{text}");
        let drawn = std::fs::read_to_string(folder.path().join("difference.svg")).unwrap();
        roxmltree::Document::parse(&drawn).unwrap();
        std::fs::remove_file(folder.path().join("difference.svg")).unwrap();
    }
}

/// Speeds that read parameters which rules may set are those of the other grammar, unless the steps of the design set them.
#[test]
fn what_rules_may_set_is_compared_too() {
    let folder = tempfile::tempdir().unwrap();
    let text = |default: f64, follows: f64| {
        format!(
            "param leak : Number in 0.1 .. 1.0 = {default}
            param own : Number in 0.1 .. 1.0 = 0.5
            variant leaky of \"{}\" {{
              set bender.bending_speed  = 95 deg/s * own
              set bender.relaxing_speed = 95 deg/s * leak
              add rule leaks {{ choose v in 0.1 .. 1.0 set leak = v }}
              add rule follows {{ always set own = {follows} }}
              add rule legs {{
                match p : cube with free port q where p is core and q is left
                attach cube to core.left as a
                attach bender(segments = 4) to a.left
              }}
              add example legged {{ step a = legs(p = core, q = core.left) }}
            }}",
            grammar("pneumatic.sgr")
        )
    };
    let write = |name: &str, text: String| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    let own = write("own.sgr", text(0.4, 0.5));
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let made = run(&["run", &own, "--from", "legged", "--max-evals", "4", "--quiet", "--out", &out]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made));
    let drive = |file: &str| run(&["drive", &out, "--dry-run", "--force", "--grammar", file]);
    let same = drive(&own);
    assert_eq!(same.status.code(), Some(0), "{}", said(&same));
    for (other, says) in [
        (text(0.1, 0.5), "`relaxing_speed` is 9.5 deg/s (before: 38 deg/s)"),
        (text(0.4, 0.2), "`bending_speed` is 19 deg/s (before: 47.5 deg/s)"),
    ] {
        let other = write("other.sgr", other);
        let refused = drive(&other);
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(said(&refused).contains(says), "{}", said(&refused));
    }
}

/// So are the parameters of a part, which the same steps may set otherwise by the rules of the other grammar.
#[test]
fn what_rules_give_to_a_part_is_compared_too() {
    let folder = tempfile::tempdir().unwrap();
    let text = crate::support::read("tests/many_sizes.sgr");
    let write = |from: &str, to: &str| {
        let path = folder.path().join("other.sgr");
        let other = text.replace(from, to);
        assert!(from.is_empty() || other != text, "{from}");
        std::fs::write(&path, other).unwrap();
        path.to_string_lossy().into_owned()
    };
    let out = folder.path().join("run").to_string_lossy().into_owned();
    let own = write("", "");
    let made = run(&["run", &own, "--from", "legged", "--max-evals", "4", "--quiet", "--out", &out]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made));
    let drive = |file: &str| run(&["drive", &out, "--dry-run", "--force", "--grammar", file]);
    let same = drive(&own);
    assert_eq!(same.status.code(), Some(0), "{}", said(&same));
    let short = drive(&write("reach = r", "reach = 1"));
    assert_eq!(short.status.code(), Some(2), "{}", said(&short));
    let says = "`bend` is -30 deg .. 30 deg (before: -90 deg .. 90 deg)";
    assert!(said(&short).contains(says), "{}", said(&short));
    // A rule that cannot make the design leaves open what its legs are.
    let without = |text: &str| {
        let (before, example) = text.split_once("example legged").unwrap();
        format!("{before}{}", example.split_once("\n}\n").unwrap().1)
    };
    let path = folder.path().join("fewer.sgr");
    std::fs::write(&path, without(&text).replace("choose  k in 2 .. 4", "choose  k in 1 .. 2")).unwrap();
    let unknown = drive(&path.to_string_lossy());
    assert_eq!(unknown.status.code(), Some(2), "{}", said(&unknown));
    assert!(said(&unknown).contains("the other grammar cannot make this design"), "{}", said(&unknown));
}

/// Other pins and tables that wind up the same bends are another target, and the same motion.
/// Where two boards play one gait, each is compared for what it drives.
#[test]
fn each_board_is_compared_for_its_own_actuators() {
    let folder = tempfile::tempdir().unwrap();
    let (walker, out) = (grammar("walker.sgr"), folder.path().join("walker"));
    let out = out.to_string_lossy();
    let made = run(&["run", &walker, "--from", "hexapod", "--max-evals", "40", "--quiet", "--out", &out]);
    assert_eq!(made.status.code(), Some(0), "{}", said(&made));
    let slow = variant(folder.path(), "walker.sgr", "set threads.servo_speed = 4 deg/s");
    let drive =
        |target: &str| run(&["drive", &out, "--dry-run", "--target", target, "--grammar", &slow, "--force"]);
    let fingers = drive("air");
    assert_eq!(fingers.status.code(), Some(0), "{}", said(&fingers));
    let legs = drive("threads");
    let text = said(&legs);
    assert!(legs.status.code() == Some(2) && text.contains("`servo_speed` is 4 deg/s"), "{text}");
    assert!(text.contains("leg-1") && !text.contains("finger-1: bent"), "{text}");
}

#[test]
fn a_target_that_keeps_the_motion_is_played() {
    let folder = tempfile::tempdir().unwrap();
    for (name, edit, says) in [
        ("pneumatic", "set valves.safe = hold", "`safe` is hold (before: vent)"),
        ("tendon", "set threads.safe = rest", "`safe` is rest"),
        // A servo that has less to turn comes into the gait sooner.
        ("tendon", "set threads.wheel = 21 mm", "only the first period, which begins at rest, is different"),
    ] {
        let other = variant(folder.path(), &format!("{name}.sgr"), edit);
        let out = folder.path().join("drawn.svg");
        let output =
            run(&["drive", &design(name), "--dry-run", "--grammar", &other, "--out", &out.to_string_lossy()]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(0), "{edit}: {text}");
        assert!(text.contains(says) && text.contains("move in the same way"), "{edit}: {text}");
    }
    // Nothing is said of the target that was simulated.
    let out = folder.path().join("drawn.svg");
    let output = run(&["drive", &design("tendon"), "--dry-run", "--out", &out.to_string_lossy(), "--force"]);
    assert!(!said(&output).contains("target differs"), "{}", said(&output));
}

#[test]
fn a_board_plays_so_many_cycles() {
    let Some((mut rig, port)) = Rig::at_port("--uno") else { return };
    let output = run(&["drive", &design("pneumatic"), "--port", &port, "--cycles", "1"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(said(&output).contains("one cycle was run"), "{}", said(&output));
    let trace = rig.trace();
    assert!(trace.changes() > 2, "valves have moved");
    // A target that vents leaves the vents open.
    assert!(!trace.high().is_empty());
}

/// A line at whose other end nobody answers.
#[cfg(unix)]
#[test]
fn ctrl_c_is_heard_before_the_board_has_greeted() {
    use std::io::Read;

    use serialport::{SerialPort, TTYPort};
    let (mut board, line) = TTYPort::pair().unwrap();
    let port = line.name().unwrap();
    // The program opens it by itself.
    drop(line);
    let mut host = sgc(&["drive", &design("tendon"), "--port", &port]);
    let host = host.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // It says hello, and waits.
    let begun = Instant::now();
    while board.read(&mut [0]).is_err() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it says nothing");
        std::thread::sleep(Duration::from_millis(20));
    }
    let asked = Instant::now();
    assert!(Command::new("kill").args(["-INT", &host.id().to_string()]).status().unwrap().success());
    let output = host.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
}

#[test]
fn ctrl_c_and_the_stop_button_bring_the_board_to_its_safe_state() {
    for (button, code, message) in [(false, 130, "stopped after"), (true, 3, "stop circuit")] {
        let Some((mut rig, port)) = Rig::at_port("--pty") else { return };
        let mut host = sgc(&["drive", &design("tendon"), "--port", &port]);
        let host = host.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        while rig.trace().changes() < 20 {
            assert!(begun.elapsed() < Duration::from_secs(60), "nothing moves");
            std::thread::sleep(Duration::from_millis(50));
        }
        if button {
            rig.command("stop 1");
        } else {
            let pid = host.id().to_string();
            assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
        }
        let output = host.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        assert!(said(&output).contains(message), "{}", said(&output));
        // Servos are let go: no pulse is under way, and none comes.
        let at = rig.cycles();
        while rig.cycles() < at + 100_000 * crate::rig::MHZ {
            std::thread::sleep(Duration::from_millis(20));
        }
        let trace = rig.trace();
        assert!(trace.high().is_empty() && trace.last_rise() < at, "pulses go on");
    }
}

/// A board goes straight between the points of a period: curves that change faster are not what was simulated.
#[test]
fn a_curve_that_is_finer_than_the_points_of_a_board_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let searched = |name: &str, beats: &str| {
        let grammar = folder.path().join(format!("{name}.sgr"));
        std::fs::write(&grammar, FAST.replace("BEATS", beats)).unwrap();
        let run =
            run(&["run", &grammar.to_string_lossy(), "--max-evals", "1", "--quiet", "--out", &out(name)]);
        assert_eq!(run.status.code(), Some(0), "{}", said(&run));
        run_drive(&out(name))
    };
    let slow = searched("slow", "2");
    assert_eq!(slow.status.code(), Some(0), "{}", said(&slow));
    // With 32 beats every point is a zero; with 30 there are two points a beat.
    for beats in ["30", "32"] {
        let fast = searched(&format!("fast{beats}"), beats);
        let text = said(&fast);
        assert_eq!(fast.status.code(), Some(2), "{text}");
        assert!(text.contains("interpolates linearly between 64 points"), "{text}");
    }
}

fn run_drive(folder: &str) -> Output {
    run(&["drive", folder, "--dry-run"])
}

const FAST: &str = "grammar fast
use std.blocks { cube }
use std.actuators { bender }
use std.models { hinge_model }
use std.search { gait_annealing }
use std.objectives { travel }
table lengths : Angle -> Length { -90 deg -> -21 mm, 0 deg -> 0 mm, 90 deg -> 21 mm }
begin {
  place core : cube
  place one : bender(segments = 4) to core.left
}
require few : count(part) <= 5
actuation beats for a : bender {
  let   period = 16 s
  drive angle  = 20 deg * sin(t / period * 360 deg * BEATS)
}
actuate bender with beats
target threads on tendon for bender {
  servo       = [D3]
  thread      = lengths
  wheel       = 14 mm
  turn        = -90 deg .. 90 deg
  servo_speed = 3000 deg/s
  pulse       = 1000 us .. 2000 us
  safe        = release
}
simulate hinge_model for 2 s on threads
maximize travel in cm
search gait_annealing
";
