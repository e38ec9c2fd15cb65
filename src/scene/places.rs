use super::{Scene, SceneDesc};

/// Something that a scene file describes; numbers count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    /// Of [`SceneDesc::materials`].
    Material(u32),
    /// Of [`SceneDesc::spheres`].
    Sphere(u32),
    /// Of [`SceneDesc::meshes`].
    Mesh(u32),
    /// Of [`SceneDesc::point_lights`].
    PointLight(u32),
    /// Of [`SceneDesc::further_lights`].
    FurtherLight(u32),
    /// The camera.
    Camera,
    /// The film.
    Film,
}

/// In which lines of its file a scene describes what: four bytes each, whatever the size of a mesh.
///
/// What was added to a description later has no line; whoever takes something out of its lists takes its line out, too.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Places {
    /// The scene file, as it was asked for.
    pub file: String,
    /// The lines of the scene file's own materials, from 1.
    pub materials: Vec<u32>,
    /// Those of the spheres.
    pub spheres: Vec<u32>,
    /// Those of the quads, then of the meshes.
    pub meshes: Vec<u32>,
    /// Those of the point lights.
    pub point_lights: Vec<u32>,
    /// Those of the lights of other kinds.
    pub further_lights: Vec<u32>,
    /// That of the camera.
    pub camera: Option<u32>,
    /// That of the film, where the file has one.
    pub film: Option<u32>,
}

impl Places {
    /// The line of `item`, where it has one.
    pub fn line(&self, item: Item) -> Option<u32> {
        let of = |lines: &[u32], number: u32| lines.get(number as usize).copied();
        match item {
            Item::Material(number) => of(&self.materials, number),
            Item::Sphere(number) => of(&self.spheres, number),
            Item::Mesh(number) => of(&self.meshes, number),
            Item::PointLight(number) => of(&self.point_lights, number),
            Item::FurtherLight(number) => of(&self.further_lights, number),
            Item::Camera => self.camera,
            Item::Film => self.film,
        }
    }
}

impl Scene {
    /// What people call `item`, which the scene has, and where it stands: `sphere 2 (data/cornell_b.toml:44)`, or
    /// `sphere 2` alone where no file describes it.
    pub fn describe(&self, item: Item) -> String {
        let name = self.name_of(item);
        match self.places.line(item) {
            Some(line) => format!("{name} ({}:{line})", self.places.file),
            None => name,
        }
    }

    fn name_of(&self, item: Item) -> String {
        match item {
            Item::Material(number) => format!("material `{}`", self.materials[number as usize].name),
            Item::Mesh(number) => {
                self.surfaces[number as usize].mesh().map_or_else(String::new, |mesh| mesh.name.clone())
            }
            Item::Sphere(number) => format!("sphere {}", u64::from(number) + 1),
            Item::PointLight(number) => format!("point_light {}", u64::from(number) + 1),
            Item::FurtherLight(number) => self.name_of_light(number as usize),
            Item::Camera => String::from("camera"),
            Item::Film => String::from("film"),
        }
    }

    /// Lights of each kind are numbered from 1.
    fn name_of_light(&self, number: usize) -> String {
        let kind = self.further_lights[number].kind();
        let before = self.further_lights[..number].iter().filter(|light| light.kind() == kind);
        match kind {
            "environment" => kind.into(),
            _ => format!("{kind} {}", before.count() + 1),
        }
    }
}

impl SceneDesc {
    /// The same without a line of any item: for a description that is no file's any more.
    #[must_use]
    pub fn without_places(self) -> SceneDesc {
        SceneDesc { places: Places::default(), ..self }
    }
}
