use super::{Item, Scene};

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
