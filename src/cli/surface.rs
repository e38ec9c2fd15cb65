use super::args::SurfaceArgs;
use super::error::{CliError, Outcome};
use crate::output::write_atomically;
use crate::scene::water;

/// Writes the water surface.
pub fn run(args: &SurfaceArgs) -> Result<Outcome, CliError> {
    write_atomically(&args.output, |mut out| water::write_obj(&mut out, args.cells as usize))?;
    println!("wrote {}: {n} x {n} cells", args.output.display(), n = args.cells);
    Ok(Outcome::Done)
}
