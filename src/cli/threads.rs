use super::error::CliError;

/// Gives rayon the number of threads asked for; all of the machine's without one.
pub fn use_threads(threads: Option<usize>) -> Result<usize, CliError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build_global()
        .map_err(|error| CliError::Threads { reason: error.to_string() })?;
    Ok(rayon::current_num_threads())
}
