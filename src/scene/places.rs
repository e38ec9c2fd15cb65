/// Something that a scene file describes; numbers count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    /// Of [`super::SceneDesc::materials`].
    Material(u32),
    /// Of [`super::SceneDesc::spheres`].
    Sphere(u32),
    /// Of [`super::SceneDesc::meshes`].
    Mesh(u32),
    /// Of [`super::SceneDesc::point_lights`].
    PointLight(u32),
    /// Of [`super::SceneDesc::further_lights`].
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
