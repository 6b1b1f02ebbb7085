//! What nothing inside a body may change, in every solver: where its centre of mass is on ice.

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
fn on_ice_the_centre_of_mass_stays() {
    let hinged = (slippery(m2()), Settings { ground_friction: 0.0, ..settings() });
    let soft = (slippery(quadruped()), Settings { ground_friction: 0.0, ..lattice_settings(10.0) });
    let drives = [gait(2, 1, false), trot(soft.0.actuators, 0.2, false)];
    for (name, (body, settings), drive, duration, limit) in [
        ("articulated", &hinged, &drives[0], 20.0, 1e-6),
        ("balls", &soft, &drives[1], 10.0, 2e-6),
        ("rapier", &hinged, &drives[0], 4.0, 5e-6),
        ("rapier", &soft, &drives[1], 1.0, 5e-6),
    ] {
        let settings = Settings { duration, ..settings.clone() };
        let motion = run(name, body, &settings, drive);
        let drift = motion.drift(body);
        assert!(drift < limit, "{name}: {drift} m");
    }
}
