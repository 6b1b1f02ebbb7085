//! The same bits, however it is run.

use fearless_simd::{Level, dispatch};

use super::lifted;
use crate::simulate::balls::make;
use crate::simulate::run::{Row, alone};
use crate::simulate::tests::lattices::{lattice_settings, quadruped, trot};
use crate::simulate::{Invalid, Motion, Settings, model};

fn bits(motion: &Motion) -> Vec<u64> {
    let places = motion.poses.iter().flat_map(|pose| pose.translation.vector.iter().copied());
    places.chain(motion.bends.clone()).chain(motion.work.clone()).map(f64::to_bits).collect()
}

#[test]
fn a_batch_gives_what_each_gives_alone() {
    let body = quadruped();
    let settings = lattice_settings(1.0);
    let mut drives: Vec<_> = [0.1, 0.3, 0.2].map(|strain| trot(4, strain, false)).into();
    drives[1].angles[100] = f64::NAN;
    let prepare = || model("balls").unwrap().prepare(&body, &settings).unwrap();
    let together = prepare().run(&drives);
    assert_eq!(together[1].as_ref().unwrap_err(), &Invalid::NotFinite);
    for which in [0, 2] {
        let alone = prepare().run(&drives[which..=which]).remove(0).unwrap();
        assert!(bits(&alone) == bits(together[which].as_ref().unwrap()), "drive {which}");
    }
}

#[test]
fn every_processor_gives_the_same() {
    let body = quadruped();
    let settings = lattice_settings(0.5);
    let lowered = lifted(&body, &settings, 0.0);
    let run = |mut row: Box<dyn Row>| bits(&alone(row.as_mut(), &trot(4, 0.2, false)).unwrap());
    let base = run(dispatch!(Level::baseline(), kit => make(kit, &lowered, &settings)).unwrap());
    let best = run(dispatch!(Level::new(), kit => make(kit, &lowered, &settings)).unwrap());
    let used = run(crate::simulate::balls::widest(&lowered, &settings).unwrap());
    assert!(base == best && base == used);
}

#[test]
fn far_from_the_origin_it_moves_alike() {
    let body = quadruped();
    let settings = Settings { ground_friction: 0.0, ..lattice_settings(5.0) };
    let drive = trot(4, 0.0, false);
    let mut lattice = lifted(&body, &settings, 0.0);
    lattice.balls.iter_mut().for_each(|ball| ball.velocity.x = 0.5);
    let motion = super::run(&lattice, &settings, &drive);
    let way = super::middle(&motion, 5.0).x - super::middle(&motion, 0.0).x;
    assert!((way - 2.5).abs() < 1e-4, "{way} m");
}
