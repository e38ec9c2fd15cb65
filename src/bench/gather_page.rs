//! The measurement of the gathering as a table and plots.

use super::gather::{GatherReport, GatherRow};
use super::in_order_of_appearance;
use crate::report::{Cell, Page, Plot, Scale, Table};

const COLUMNS: [&str; 13] = [
    "points",
    "radius (%)",
    "structure",
    "overlaps",
    "build (ms)",
    "min",
    "max",
    "bytes/point",
    "ns/photon",
    "min",
    "max",
    "ns/overlap",
    "x first",
];

const OF_WALLS: &str = "\
Spheres and photons lie uniformly on the six walls of a unit box; the radius is in percent of its side. ";

const OF_RENDER: &str = "\
Spheres lie around an even subset of the hit points that the eye pass of a render leaves, and photons where its first pass \
does; the radius is in percent of the scene's longest side. ";

const NOTE: &str = "\
Every structure adds one to \
the count of every sphere around every photon, and all counts are the same. Times are wall-clock medians over \
interleaved rounds, each with a build of its own. Structures that go photon by photon get them sorted along a Morton \
curve, which is not counted; with more than one thread they count atomically. kiddo knows points alone, and is asked for those \
within the largest radius, which here all spheres have. `x first` is the time of gathering as a \
multiple of the first structure's.";

impl GatherReport {
    /// The numbers, the plots and the machine.
    pub fn page(&self) -> Page {
        let mut facts = self.machine.lines();
        facts.extend(self.scene.iter().map(|scene| ("Scene", scene.clone())));
        facts.push(("Extent", format!("{} scene units", self.extent)));
        facts.push(("Threads", self.threads.to_string()));
        let emitted = self.emitted.map(|emitted| format!(" of {emitted} emitted")).unwrap_or_default();
        facts.push(("Photons", format!("{}{emitted}, sorted in {:.1} ms", self.photons, self.sort_ms)));
        facts.push(("Repetitions", self.repetitions.to_string()));
        let rows = self.rows.iter().map(GatherRow::cells).collect();
        Page {
            title: "Gathering photons".into(),
            facts,
            note: [if self.scene.is_some() { OF_RENDER } else { OF_WALLS }, NOTE].concat(),
            table: Table { columns: COLUMNS.into(), rows },
            plots: self.plots(),
        }
    }

    /// One plot for each number of points, and two over the numbers of points.
    fn plots(&self) -> Vec<Plot> {
        let sizes = in_order_of_appearance(self.rows.iter().map(|row| row.points));
        let of_size = |points| {
            self.plot(
                &format!("Gathering among {points} spheres"),
                ["radius (%)", "ns a photon"],
                move |row| (row.points == points).then_some((row.radius_percent, row.ns_per_photon.median)),
            )
        };
        let build = self.plot("Building", ["spheres", "ms"], |row| {
            let smallest = self.rows.iter().find(|other| other.points == row.points);
            let is_first = smallest.is_some_and(|other| other.radius_percent == row.radius_percent);
            is_first.then_some((row.points as f64, row.build_ms.median))
        });
        let overlap = self.plot("Cost of an overlap", ["overlaps a photon", "ns"], |row| {
            Some((row.overlaps as f64 / self.photons as f64, row.ns_per_overlap?))
        });
        sizes.into_iter().map(of_size).chain([build, overlap]).collect()
    }

    /// A line for each structure through the points of its rows.
    fn plot(
        &self,
        title: &str,
        [x_label, y_label]: [&str; 2],
        point: impl Fn(&GatherRow) -> Option<(f64, f64)>,
    ) -> Plot {
        let names = in_order_of_appearance(self.rows.iter().map(|row| row.structure));
        let line = |name: &'static str| {
            let rows = self.rows.iter().filter(|row| row.structure == name);
            let mut points: Vec<(f64, f64)> = rows.filter_map(&point).collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            (name.to_owned(), points)
        };
        Plot {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            scale: Scale::Logarithmic,
            series: names.into_iter().map(line).collect(),
            guides: vec![],
        }
    }
}

impl GatherRow {
    fn cells(&self) -> Vec<Cell> {
        let GatherRow { build_ms: build, ns_per_photon: gather, .. } = self;
        vec![
            Cell::Count(self.points as u64),
            Cell::Number(self.radius_percent),
            Cell::Text(self.structure.into()),
            Cell::Count(self.overlaps),
            Cell::Number(build.median),
            Cell::Number(build.min),
            Cell::Number(build.max),
            Cell::Number(self.bytes_per_point.unwrap_or(f64::NAN)),
            Cell::Number(gather.median),
            Cell::Number(gather.min),
            Cell::Number(gather.max),
            Cell::Number(self.ns_per_overlap.unwrap_or(f64::NAN)),
            Cell::Number(self.times_first),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::gather::{GatherSettings, RadiusChoice, measure};
    use super::super::gather_source::{Rendered, Source};
    use super::super::ray_scenes::room;
    use super::super::structures::RIVALS;
    use super::*;
    use crate::ppm::Settings;
    use crate::scene::Scene;

    fn report(source: &Source) -> GatherReport {
        let radii = RadiusChoice::Percent(vec![0.5, 5.0]);
        let settings = GatherSettings { points: vec![2000, 300], radii, photons: 500, repetitions: 2 };
        measure(&settings, source, &RIVALS, |_, _| ()).unwrap()
    }

    #[test]
    fn the_page_shows_every_row() {
        let report = report(&Source::Walls);
        let (page, html) = (report.page(), report.page().to_html());
        assert_eq!(page.table.rows.len(), report.rows.len());
        assert!(page.table.rows.iter().all(|row| row.len() == COLUMNS.len()));
        assert_eq!(html.matches("<svg").count(), 4);
        for row in &report.rows {
            let cell = format!("<td>{}</td>", Cell::Number(row.ns_per_photon.median));
            assert!(html.contains(&cell) && html.contains(row.structure));
        }
    }

    #[test]
    fn the_page_tells_where_spheres_and_photons_come_from() {
        let walls = report(&Source::Walls).page().to_html();
        assert!(walls.contains("unit box") && !walls.contains("emitted"));
        let scene = Scene::new(room(36, 100)).unwrap();
        let settings = Settings::of_scene(scene.render());
        let report = report(&Source::Render(Rendered { scene: &scene, name: "a room", settings }));
        let page = report.page().to_html();
        assert!(page.contains("a room") && page.contains("eye pass") && !page.contains("unit box"));
        assert!(page.contains(&format!("{} of 500 emitted", report.photons)), "{page}");
    }
}
