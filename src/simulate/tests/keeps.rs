//! What nothing inside a body may change, in every solver: where its centre of mass is on ice, and its angular momentum about the
//! vertical.

use super::bodies::{gait, m2};
use super::lattices::{lattice_settings, quadruped, trot};
use super::settings;
use super::truth::run;
use crate::design::assembly::Assembly;
use crate::simulate::Settings;

/// The same body on a floor without friction, and without friction between its parts.
fn slippery(mut body: Assembly) -> Assembly {
    body.elements.iter_mut().for_each(|element| element.friction = 0.0);
    body
}

#[test]
fn on_ice_nothing_carries_a_body_away_or_turns_it() {
    let hinged = (slippery(m2()), Settings { ground_friction: 0.0, ..settings() });
    // Frames that are further apart miss how balls tremble.
    let often = 1.0 / 480.0;
    let soft =
        (slippery(quadruped()), Settings { ground_friction: 0.0, record: often, ..lattice_settings(10.0) });
    let drives = [gait(2, 1, false), trot(soft.0.actuators, 0.2, false)];
    for (name, (body, settings), drive, duration, limit, turns) in [
        ("articulated", &hinged, &drives[0], 20.0, 1e-6, 1e-3),
        ("balls", &soft, &drives[1], 10.0, 2e-6, 1e-3),
        ("rapier", &hinged, &drives[0], 4.0, 5e-6, 1e-2),
        ("rapier", &soft, &drives[1], 1.0, 5e-6, 1e-2),
    ] {
        let settings = Settings { duration, ..settings.clone() };
        let motion = run(name, body, &settings, drive);
        let drift = motion.drift(body);
        assert!(drift < limit, "{name}: {drift} m");
        let spin = motion.spin(body);
        assert!(spin < turns, "{name}: {spin} rad");
    }
}
