//! The `sgc` program.

fn main() -> std::process::ExitCode {
    sgc::deep::on_deep_stack(sgc::cli::main)
}
