//! What a measurement was made on and with.

use std::fs;

use serde::Serialize;

use crate::embree::{Device, EmbreeError};
use crate::simd::Isa;

/// The machine and the program: numbers without them say nothing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Machine {
    /// The model of the processor; `unknown` where the system does not tell.
    pub cpu: String,
    /// Cores that this process may use.
    pub cores: usize,
    /// Vector instructions that the processor has, of those that matter here.
    pub cpu_features: Vec<&'static str>,
    /// The instructions that its lanes use.
    pub lanes: String,
    /// Instruction sets that the program was compiled for.
    pub compiled_for: Vec<&'static str>,
    /// The compiler.
    pub rustc: &'static str,
    /// Whether the compiler was asked for speed without checks: numbers of other builds mean little.
    pub optimised: bool,
    /// The version of the Embree library.
    pub embree: String,
    /// The version of this program.
    pub version: &'static str,
}

impl Machine {
    /// This machine and this program.
    ///
    /// # Errors
    /// If Embree cannot be started.
    pub fn detect() -> Result<Machine, EmbreeError> {
        Ok(Machine {
            cpu: cpu_model(&fs::read_to_string("/proc/cpuinfo").unwrap_or_default()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            cpu_features: cpu_features(),
            lanes: Isa::best().to_string(),
            compiled_for: env!("BUILT_FOR_FEATURES").split(',').filter(|f| !f.is_empty()).collect(),
            rustc: env!("BUILT_BY_RUSTC"),
            optimised: !cfg!(debug_assertions),
            embree: Device::new()?.version().to_string(),
            version: env!("CARGO_PKG_VERSION"),
        })
    }

    /// The same as names and values for people.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let checks = if self.optimised { "" } else { " with debug assertions: not a build to measure with" };
        vec![
            ("Processor", self.cpu.clone()),
            ("Cores", self.cores.to_string()),
            ("Vector instructions", self.cpu_features.join(" ")),
            ("Lanes", self.lanes.clone()),
            ("Program", format!("caustica {}{checks}", self.version)),
            ("Compiled for", self.compiled_for.join(" ")),
            ("Compiler", self.rustc.into()),
            ("Embree", self.embree.clone()),
        ]
    }
}

fn cpu_model(cpuinfo: &str) -> String {
    let value =
        |line: &str| line.strip_prefix("model name")?.split_once(':').map(|(_, v)| v.trim().to_owned());
    cpuinfo.lines().find_map(value).unwrap_or_else(|| "unknown".into())
}

#[cfg(target_arch = "x86_64")]
fn cpu_features() -> Vec<&'static str> {
    let found = [
        ("sse4.2", is_x86_feature_detected!("sse4.2")),
        ("avx", is_x86_feature_detected!("avx")),
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    found.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
}

#[cfg(not(target_arch = "x86_64"))]
fn cpu_features() -> Vec<&'static str> {
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_processor_is_named() {
        let text = "processor\t: 0\nmodel name\t: Fast(R) CPU @ 3 GHz\nprocessor\t: 1\nmodel name\t: Other\n";
        assert_eq!(cpu_model(text), "Fast(R) CPU @ 3 GHz");
        assert_eq!(cpu_model("processor : 0"), "unknown");
    }

    #[test]
    fn the_machine_is_known() {
        let machine = Machine::detect().unwrap();
        assert!(Isa::available().any(|isa| isa.to_string() == machine.lanes));
        assert!(machine.cores >= 1 && machine.rustc.starts_with("rustc 1."));
        assert!(machine.embree.starts_with("4.") && !machine.compiled_for.is_empty());
        let has_warning = machine.lines().iter().any(|(_, value)| value.contains("not a build to measure"));
        assert_ne!(machine.optimised, has_warning);
    }
}
