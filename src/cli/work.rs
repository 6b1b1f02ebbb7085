//! How the work of a run is done.

use std::time::Duration;

use clap::Args;

/// How the work is done; the result does not depend on it.
#[derive(Args, Clone, Debug)]
pub(super) struct Work {
    /// Threads to use; the result does not depend on it [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) jobs: Option<u16>,
    /// Save a checkpoint about this often
    #[arg(long, value_name = "TIME", value_parser = duration, default_value = "5s")]
    pub(super) checkpoint: (String, Duration),
    /// Print only the result, and no progress
    #[arg(short, long)]
    pub(super) quiet: bool,
    /// Keep a page of charts, report/index.html in the folder, up to date: open it in a browser, and it
    /// follows the run
    #[arg(long)]
    pub(super) live: bool,
}

impl Work {
    pub(super) fn jobs(&self) -> usize {
        let all = || std::thread::available_parallelism().map_or(1, usize::from);
        self.jobs.map_or_else(all, usize::from)
    }
}

/// Reads a time such as `90s`, `30m`, `1h`.
pub(super) fn duration(text: &str) -> Result<(String, Duration), String> {
    let wrong = || "write a time such as 90s, 30m or 2h".to_owned();
    let text = text.trim();
    let (number, unit) = text.split_at(text.len() - text.chars().last().map_or(0, char::len_utf8));
    let seconds = match unit {
        "s" => 1.0,
        "m" => 60.0,
        "h" => 3600.0,
        _ => return Err(wrong()),
    };
    match number.trim().parse::<f64>() {
        Ok(x) if x > 0.0 && x * seconds < 1e8 => Ok((text.to_owned(), Duration::from_secs_f64(x * seconds))),
        _ => Err(wrong()),
    }
}
