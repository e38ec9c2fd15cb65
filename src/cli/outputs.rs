use std::path::PathBuf;

use serde::Serialize;

use super::args::RenderArgs;
use super::circumstances::with_circumstances;
#[cfg(feature = "oidn")]
use super::denoised::Denoised;
use super::error::CliError;
use super::error_watch::ErrorRecord;
use super::json_lines::JsonLines;
use super::memory;
use super::pictures::{PicturePath, default_output};
use crate::effects::{PathClass, Plan};
use crate::film::Image;
use crate::output::{Display, ExrLayer, LayerChannels, Metadata, Value};
use crate::ppm::{Features, Kinds, Layers, PassStatistics, Render, SetupStatistics};
use crate::scene::{SceneDesc, Traversal};

/// Everything that the render writes; all paths are checked before it begins.
pub struct Outputs {
    scene: String,
    threads: usize,
    picture: PicturePath,
    direct: Option<PicturePath>,
    every_pass: Option<PathBuf>,
    json: Option<JsonLines>,
    /// Until the first record of this process.
    tells_setup: bool,
    /// At which confidence, if the picture is to have layers.
    layers: Option<f64>,
    features: bool,
    #[cfg(feature = "oidn")]
    denoised: Option<Denoised>,
    display: Display,
    traversal: Traversal,
    reproducible: bool,
    half: bool,
}

/// A line of the statistics.
#[derive(Serialize)]
struct PassRecord<'a> {
    #[serde(flatten)]
    pass: &'a PassStatistics,
    threads: usize,
    seconds_in_all: f64,
    peak_memory_bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<&'a ErrorRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    setup: Option<&'a SetupStatistics>,
    #[serde(skip_serializing_if = "Option::is_none")]
    plan: Option<&'a Plan>,
}

impl Outputs {
    /// `passes_before` are those of the checkpoint that the render goes on from: what is known of them stays.
    pub fn check(
        args: &RenderArgs,
        desc: &SceneDesc,
        threads: usize,
        passes_before: Option<u32>,
    ) -> Result<Outputs, CliError> {
        let output = args.output.clone().unwrap_or_else(|| default_output(&desc.name, ""));
        if let Some(folder) = &args.every_pass {
            PicturePath::new(&folder.join("pass_0001.exr"))?;
        }
        Ok(Outputs {
            scene: args.scene.display().to_string(),
            threads,
            picture: PicturePath::new(&output)?.with_half(args.run.half),
            direct: args
                .direct
                .as_deref()
                .map(PicturePath::new)
                .transpose()?
                .map(|path| path.with_half(args.run.half)),
            every_pass: args.every_pass.clone(),
            json: args.json.as_deref().map(|path| JsonLines::open(path, passes_before)).transpose()?,
            tells_setup: true,
            layers: args.layers.then_some(args.confidence),
            features: args.features,
            #[cfg(feature = "oidn")]
            denoised: args.denoise.then(|| Denoised::beside(&output, args.run.half)).transpose()?,
            display: Display::from(&args.run.display),
            traversal: args.run.traversal.into(),
            reproducible: args.run.reproducible,
            half: args.run.half,
        })
    }

    pub fn after_pass(
        &mut self,
        render: &Render,
        pass: &PassStatistics,
        error: Option<&ErrorRecord>,
        seconds: f64,
    ) -> Result<(), CliError> {
        if let Some(json) = &mut self.json {
            let first = std::mem::take(&mut self.tells_setup);
            json.write(&PassRecord {
                pass,
                threads: self.threads,
                seconds_in_all: seconds,
                peak_memory_bytes: memory::peak_bytes(),
                error,
                setup: first.then(|| render.setup()),
                plan: first.then(|| render.plan()),
            })?;
        }
        if let Some(folder) = &self.every_pass {
            let path = PicturePath::in_checked_folder(folder, &format!("pass_{:04}.exr", pass.pass))
                .with_half(self.half);
            path.write(&render.picture(), &self.metadata(render, seconds), &self.display)?;
        }
        Ok(())
    }

    /// Has all records of passes reach the disk.
    pub fn flush_statistics(&mut self) -> Result<(), CliError> {
        self.json.as_mut().map_or(Ok(()), JsonLines::sync)
    }

    pub fn write(&self, render: &Render, seconds: f64) -> Result<(), CliError> {
        let metadata = self.metadata(render, seconds);
        let light = light_layers(render);
        let errors = self.layers.and_then(|confidence| render.accuracy(confidence)?.layers());
        let mut layers: Vec<ExrLayer> = light.iter().map(|(class, image)| of_class(*class, image)).collect();
        layers.extend(errors.as_ref().map(of_errors).unwrap_or_default());
        let features = self.features.then(|| render.features());
        layers.extend(features.as_ref().map(of_features).into_iter().flatten());
        self.picture.write_layers(&render.picture(), &layers, &metadata, &self.display)?;
        #[cfg(feature = "oidn")]
        if let Some(denoised) = &self.denoised {
            denoised.write(render, &metadata, &self.display)?;
        }
        if let Some(direct) = &self.direct {
            direct.write(&render.direct_picture(), &metadata, &self.display)?;
        }
        note!(
            "{} passes in {seconds:.1} s: {} and {}",
            render.passes(),
            self.picture.exr().display(),
            self.picture.png().display()
        );
        Ok(())
    }

    /// The facts of the picture, for its header.
    fn metadata(&self, render: &Render, seconds: f64) -> Metadata {
        let metadata = described(render, &self.scene, self.traversal);
        let metadata = match self.layers {
            Some(confidence) => metadata.with("caustica:confidence", Value::Double(confidence)),
            None => metadata,
        };
        with_circumstances(metadata, self.reproducible, seconds)
    }
}

/// What of the picture follows from scene, settings and passes.
pub fn described(render: &Render, scene: &str, traversal: Traversal) -> Metadata {
    let settings = render.settings();
    let aimed = render.setup().aim.map_or(0, |aim| aim.budget.aimed);
    let guided = render.setup().guide.map_or(0.0, |guide| guide.share);
    Metadata::new()
        .with_world_to_camera(render.scene().camera().world_to_camera())
        .with("caustica:version", Value::Text(env!("CARGO_PKG_VERSION").into()))
        .with("caustica:method", Value::Text("progressive photon mapping".into()))
        .with("caustica:scene", Value::Text(scene.into()))
        .with("caustica:passes", Value::Integer(render.passes().into()))
        .with("caustica:photons", Value::Integer(settings.photons as i64))
        .with("caustica:aimed_photons", Value::Integer(aimed as i64))
        .with("caustica:guided_share", Value::Double(guided))
        .with("caustica:alpha", Value::Double(settings.alpha))
        .with("caustica:radius", Value::Double(render.setup().radius))
        .with("caustica:samples", Value::Integer(settings.samples.into()))
        .with("caustica:depth", Value::Integer(settings.depth.into()))
        .with("caustica:radius_policy", Value::Text(settings.policy.to_string()))
        .with("caustica:precision", Value::Text(format!("{:?}", settings.precision).to_lowercase()))
        .with("caustica:sampling", Value::Text(format!("{:?}", settings.sampling).to_lowercase()))
        .with("caustica:traversal", Value::Text(traversal.to_string()))
        .with("caustica:transport", Value::Text(render.plan().classes.to_string()))
        .with("caustica:plan", Value::Text(render.plan().to_string()))
        .with("caustica:seed", Value::Text(settings.seed.to_string()))
        .with("caustica:eye_paths", Value::Text(render.eye_paths().to_string()))
        .with("caustica:eye_seed", Value::Text(settings.key_of_eye_paths().to_string()))
}

/// Where kinds are kept apart.
fn light_layers(render: &Render) -> Vec<(PathClass, Image)> {
    match render.settings().kinds {
        Kinds::Together => Vec::new(),
        Kinds::Apart => {
            PathClass::ALL.into_iter().filter_map(|class| Some((class, render.layer(class)?))).collect()
        }
    }
}

fn of_class(class: PathClass, image: &Image) -> ExrLayer<'_> {
    layer(class.name(), LayerChannels::Rgb, image)
}

fn layer<'a>(name: &'a str, channels: LayerChannels, image: &'a Image) -> ExrLayer<'a> {
    ExrLayer { name, channels, image }
}

fn of_errors(layers: &Layers) -> Vec<ExrLayer<'_>> {
    vec![
        layer("stderr", LayerChannels::Rgb, &layers.stderr),
        layer("bias", LayerChannels::Rgb, &layers.bias),
        layer("bound", LayerChannels::Rgb, &layers.bound),
        layer("photons", LayerChannels::Single, &layers.photons),
        layer("radius", LayerChannels::Single, &layers.radius),
    ]
}

fn of_features(features: &Features) -> [ExrLayer<'_>; 3] {
    [
        layer("albedo", LayerChannels::Rgb, &features.albedo),
        layer("N", LayerChannels::Xyz, &features.normal),
        layer("Z", LayerChannels::Single, &features.depth),
    ]
}
