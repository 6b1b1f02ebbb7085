//! How closely a command simulates a saved design.

use clap::Args;

use crate::results::replay;

/// Another time step, and contacts solved further.
#[derive(Args)]
pub(super) struct Precision {
    /// Another time step in seconds, such as 1/480; at most as long as a grammar allows [default: the grammar's]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    step: Option<f64>,
    /// Solve contacts with this many sweeps in every step [default: as the grammar's model says]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    sweeps: Option<u32>,
}

impl Precision {
    /// What the simulation is asked for.
    pub(super) fn asked(&self) -> replay::Precision {
        match (self.step, self.sweeps) {
            (None, None) => replay::Precision::Model,
            (step, sweeps) => replay::Precision::Own { step, sweeps: sweeps.map(|n| n as usize) },
        }
    }
}

/// Reads `0.002` or `1/480`.
fn seconds(text: &str) -> Result<f64, String> {
    let number = |t: &str| t.trim().parse::<f64>().ok();
    let value = match text.split_once('/') {
        Some((a, b)) => number(a).zip(number(b)).map(|(a, b)| a / b),
        None => number(text),
    };
    match value {
        Some(x) if x.is_finite() && (1e-5..=0.1).contains(&x) => Ok(x),
        _ => Err("write a time in seconds from 0.00001 to 0.1, such as 1/480".to_owned()),
    }
}
