use super::args::DoctorArgs;
use super::console::{print, print_json};
use super::error::{CliError, Outcome};
use crate::doctor::{Diagnosis, Severity, examine, not_loaded, stability};
use crate::ppm::Settings;
use crate::scene::load_with;

/// Says what is odd about a scene or, without one, about the program.
pub fn run(args: &DoctorArgs) -> Result<Outcome, CliError> {
    let Some(path) = &args.scene else {
        let diagnosis = stability()?;
        tell(&diagnosis, args.json)?;
        return Ok(outcome(&diagnosis, args.strict));
    };
    let mut desc = match load_with(path, &(&args.access).into()) {
        Ok(desc) => desc,
        Err(error) => {
            tell(&not_loaded(path, &error), args.json)?;
            return Ok(Outcome::NotLoaded);
        }
    };
    desc.film = args.size.map_or(desc.film, |size| desc.film.resized(size));
    let settings = Settings::of_scene(&desc.render);
    let settings = Settings { radius: args.radius.or(settings.radius), ..settings };
    let diagnosis = examine(&desc, settings, args.traversal.into())?;
    tell(&diagnosis, args.json)?;
    Ok(outcome(&diagnosis, args.strict))
}

fn outcome(diagnosis: &Diagnosis, strict: bool) -> Outcome {
    let least = if strict { Severity::Warning } else { Severity::Fault };
    if diagnosis.severity() >= least { Outcome::Unsound } else { Outcome::Done }
}

fn tell(diagnosis: &Diagnosis, as_json: bool) -> Result<(), CliError> {
    if !as_json {
        return print(format_args!("{}\n{}\n", diagnosis.table().to_text(), diagnosis.verdict()));
    }
    let Diagnosis { subject, findings } = diagnosis;
    let (severity, verdict) = (diagnosis.severity(), diagnosis.verdict());
    print_json(&serde_json::json!({
        "subject": subject, "severity": severity, "verdict": verdict, "findings": findings
    }))
}
