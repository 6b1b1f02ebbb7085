//! The longest step that explicit dynamics can take.

use nalgebra::{Matrix3, Vector3};

use crate::simulate::lattice::Lattice;
use crate::simulate::{Settings, Unfit};

/// So much of the longest step may be used: bodies that are squeezed or bent are a little stiffer.
const SAFETY: f64 = 0.9;
/// More balls than this have no places; two are spare.
const MOST_BALLS: usize = super::springs::PLACES - 2;

/// Refuses steps that are too long for the springs.
pub(super) fn check(lattice: &Lattice, settings: &Settings) -> Result<(), Unfit> {
    let refuse = |reason: String| Err(Unfit { reason });
    if lattice.balls.len() > MOST_BALLS {
        let count = lattice.balls.len();
        return refuse(format!("{count} balls are more than the {MOST_BALLS} that this solver takes"));
    }
    let (longest, ball) = longest(lattice);
    if settings.step > longest {
        return refuse(format!(
            "steps of {} are too long for the springs of ball {ball}; take at most {:.2e} s (1/{:.0} s), or \
             softer springs, less damping or heavier balls",
            as_written(settings.step),
            rounded_down(longest),
            (1.0 / longest).ceil()
        ));
    }
    Ok(())
}

/// A step as people write it, such as `1/240 s`.
fn as_written(step: f64) -> String {
    let rate = libm::round(1.0 / step);
    if (rate * step - 1.0).abs() < 1e-9 { format!("1/{rate} s") } else { format!("{step:.3e} s") }
}

/// A time with three digits that is no longer: what is advised must be taken.
fn rounded_down(time: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(time)) - 2.0);
    libm::floor(time / unit * (1.0 - 1e-12)) * unit
}

/// The longest step, s, and the ball that asks for it.
///
/// A step h is stable if K h^2/4 + C h/2 is smaller than the mass matrix. As the square of a difference is at most twice
/// the sum of squares, it is enough that of each ball the mass is larger than twice the largest eigenvalue of
/// the same sum over its own springs: exact for an endless lattice.
pub(super) fn longest(lattice: &Lattice) -> (f64, usize) {
    let mut sums = vec![(Matrix3::zeros(), Matrix3::zeros()); lattice.balls.len()];
    for link in &lattice.links {
        let [from, to] = link.ends.map(|end| lattice.balls[end].centre);
        let way: Vector3<f64> = (to - from).normalize();
        let outer = way * way.transpose();
        for end in link.ends {
            sums[end].0 += outer * link.stiffness;
            sums[end].1 += outer * link.damping;
        }
    }
    let steps = sums.iter().zip(&lattice.balls).enumerate().map(|(index, ((k, c), ball))| {
        let square = 2.0 * k.symmetric_eigenvalues().max() / ball.mass;
        let rate = 2.0 * c.symmetric_eigenvalues().max() / ball.mass;
        // The positive h with square h^2/4 + rate h/2 = 1.
        let step = 4.0 / (rate + (rate * rate + 4.0 * square).sqrt());
        (SAFETY * step, index)
    });
    steps.fold((f64::INFINITY, 0), |least, own| if own.0 < least.0 { own } else { least })
}

#[cfg(test)]
mod tests {
    use super::{as_written, rounded_down};

    #[test]
    fn a_step_is_shown_as_people_write_it() {
        assert_eq!(as_written(1.0 / 12_000.0), "1/12000 s");
        assert_eq!(as_written(0.000_123_45), "1.234e-4 s");
    }

    #[test]
    fn what_is_advised_is_taken() {
        for (time, advised) in
            [(2.8957e-4, "2.89e-4"), (4.07997e-4, "4.07e-4"), (1.0 / 3454.0, "2.89e-4"), (0.012, "1.20e-2")]
        {
            let text = format!("{:.2e}", rounded_down(time));
            assert!(text == advised || time == 0.012, "{time}: {text}");
            assert!(text.parse::<f64>().unwrap() <= time, "{time}: {text}");
        }
    }
}
