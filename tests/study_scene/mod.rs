//! A small scene to study, and the program run on it.
#![allow(dead_code, reason = "every test program uses another part")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const SCENE: &str = "\
[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]
fov = 40
[render]
photons = 2000
samples = 1
radius = 0.5
[material.white]
diffuse = { albedo = [0.5, 0.6, 0.7] }
[material.glass]
dielectric = { ior = 1.5 }
[[point_light]]
position = [0, 3, 0]
intensity = [9, 9, 9]
[[sphere]]
center = [0, 0.6, 0]
radius = 0.5
material = \"glass\"
[[quad]]
corners = [[-2, 0, -2], [-2, 0, 2], [2, 0, 2], [2, 0, -2]]
material = \"white\"
[[quad]]
corners = [[-2, 0, -2], [2, 0, -2], [2, 4, -2], [-2, 4, -2]]
material = \"white\"
";

pub fn caustica(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_caustica")).args(arguments).output().unwrap()
}

/// A folder with a scene, for a study in `study`.
pub struct Studio {
    folder: TempDir,
}

impl Studio {
    pub fn new() -> Studio {
        let studio = Studio { folder: tempfile::tempdir().unwrap() };
        fs::write(studio.path("scene.toml"), SCENE).unwrap();
        studio
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn name(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }

    pub fn scene(&self) -> String {
        self.name("scene.toml")
    }

    /// A study of the scene without further arguments.
    pub fn bare(&self, arguments: &[&str]) -> Output {
        let (scene, folder) = (self.scene(), self.name("study"));
        caustica(&[&["study", &scene, "-o", &folder], arguments].concat())
    }

    /// A study of 64 x 64 pixels.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_caustica"));
        command.args([
            "study",
            &self.scene(),
            "-o",
            &self.name("study"),
            "--make-reference",
            "--size",
            "64x64",
        ]);
        command.args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    pub fn study(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// On a busy machine a budget may be over before all is measured: then the same command goes on.
    pub fn study_to_the_end(&self, arguments: &[&str]) {
        for _ in 0..20 {
            let output = self.study(arguments);
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            let json: serde_json::Value =
                serde_json::from_slice(&fs::read(self.path("study/study.json")).unwrap()).unwrap();
            if json["complete"] == true {
                return;
            }
        }
        panic!("the study never ends");
    }
}
