//! The `sgc` program.

fn main() -> std::process::ExitCode {
    sgc::cli::main()
}
