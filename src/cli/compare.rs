use super::args::CompareArgs;
use super::error::{CliError, Outcome};
use crate::compare::Metrics;
use crate::output::read_exr;

/// Prints how two pictures differ; the bounds decide the exit code.
pub fn run(args: &CompareArgs) -> Result<Outcome, CliError> {
    let image = read_exr(&args.image).map_err(CliError::BadImage)?;
    let reference = read_exr(&args.reference).map_err(CliError::BadImage)?;
    let metrics = Metrics::between(&image, &reference)?;
    if args.json {
        println!("{}", serde_json::json!(metrics));
    } else {
        println!("{metrics}");
    }
    let exceeded: Vec<_> = args.fail_above.iter().filter(|bound| metrics.exceeds(bound)).collect();
    for bound in &exceeded {
        eprintln!("beyond the bound: {bound}");
    }
    Ok(if exceeded.is_empty() { Outcome::Done } else { Outcome::BoundExceeded })
}
