use super::args::SurfaceArgs;
use super::console::print;
use super::error::{CliError, Outcome};
use crate::output::write_atomically;
use crate::scene::water;

/// Writes the water surface.
pub fn run(args: &SurfaceArgs) -> Result<Outcome, CliError> {
    write_atomically(&args.output, |mut out| water::write_obj(&mut out, args.cells as usize))?;
    print(format_args!("wrote {}: {n} x {n} cells\n", args.output.display(), n = args.cells))?;
    Ok(Outcome::Done)
}
