//! The measurement of rays as a table and plots.

use super::in_order_of_appearance;
use super::ray_engines::{BUILDS, Build, Query};
use super::ray_scenes::RayKind;
use super::rays::{RayReport, RayRow};
use crate::report::{Cell, Page, Plot, Scale, Table};

const COLUMNS: [&str; 15] = [
    "triangles",
    "rays",
    "count",
    "structure",
    "query",
    "build (ms)",
    "bytes/triangle",
    "1 thread (Mrays/s)",
    "min",
    "max",
    "x first",
    "all threads (Mrays/s)",
    "different/M",
    "distance/M",
    "ties/M",
];

const NOTE: &str = "\
Rays of a real render through an open room with two blocks, in which water stands as finely as the triangles ask for: eye \
rays with what mirror and water send on, shadow rays from all hit points to the lamp, photon rays from the lamp until \
they are absorbed. Every round builds every structure and lets every engine answer every ray; the numbers are wall-clock \
medians. Packets of rays as traced are asked as incoherent; coherent packets get the rays sorted by the octant of their \
direction in blocks of 4096, and the sorting is not counted. `x first` is the speed on one thread as a multiple of the \
first engine's, which the program renders with. Of a million rays, `different` hit \
another triangle at another distance than the first engine has it, or hit where that misses or the other way round; \
`distance` hit the same triangle more than 1e-5 of the way nearer or farther; `ties` hit another triangle at the same \
distance: an edge. Memory includes the copy of the triangles.";

impl RayReport {
    /// The numbers, the plots and the machine.
    pub fn page(&self) -> Page {
        let mut facts = self.machine.lines();
        facts.push(("Threads", self.threads.to_string()));
        facts.push(("Photons", format!("{}, and about as many eye paths", self.photons)));
        facts.push(("Repetitions", self.repetitions.to_string()));
        let rows = self.rows.iter().map(RayRow::cells).collect();
        Page {
            title: "Tracing rays".into(),
            facts,
            note: NOTE.into(),
            table: Table { columns: COLUMNS.into(), rows },
            plots: self.plots(),
        }
    }

    /// Two for each kind of rays, one over all builds' times and one over their memory.
    fn plots(&self) -> Vec<Plot> {
        let kinds = in_order_of_appearance(self.rows.iter().map(|row| row.kind));
        let first = kinds.first().copied();
        let of_kind = |kind| {
            let speed = |row: &RayRow| (row.kind == kind).then_some(row.one_thread.median);
            let title = |question| format!("One thread, {kind} rays: {question}");
            [("ways to ask", way as Name), ("ways to build", structure)]
                .map(|(question, name)| self.plot(title(question), "million rays a second", name, speed))
        };
        // The rows of every kind repeat what the structures took.
        let once =
            |value: fn(&RayRow) -> f64| move |row: &RayRow| (Some(row.kind) == first).then(|| value(row));
        let structures = [
            self.plot("Building".into(), "ms", structure, once(|row| row.build_ms.median)),
            self.plot("Memory".into(), "bytes a triangle", structure, once(|row| row.bytes_per_triangle)),
        ];
        kinds.into_iter().flat_map(of_kind).chain(structures).collect()
    }

    /// A line for each name through its rows; rows without a name are left out.
    fn plot(&self, title: String, y_label: &str, name: Name, value: impl Fn(&RayRow) -> Option<f64>) -> Plot {
        let mut series: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
        for row in &self.rows {
            let (Some(name), Some(value)) = (name(row), value(row)) else { continue };
            let point = (row.triangles as f64, value);
            match series.iter_mut().find(|(other, _)| *other == name) {
                Some((_, points)) => points.push(point),
                None => series.push((name, vec![point])),
            }
        }
        Plot {
            title,
            x_label: "triangles".into(),
            y_label: y_label.into(),
            scale: Scale::Logarithmic,
            series,
            guides: vec![],
        }
    }
}

/// The line in a plot that a row belongs to, if any.
type Name = fn(&RayRow) -> Option<String>;

/// The way of asking, where the structure is the program's own or Embree's as the program builds it.
fn way(row: &RayRow) -> Option<String> {
    match row.engine.build {
        Build::Custom => Some(format!("{}, {}", row.structure, row.query)),
        build => (build == BUILDS[0]).then(|| row.query.into()),
    }
}

/// The structure, where it is asked as the program does.
fn structure(row: &RayRow) -> Option<String> {
    let query = if row.kind == RayKind::Shadow.name() { Query::Any } else { Query::Nearest };
    (row.engine.query == query).then(|| row.structure.into())
}

impl RayRow {
    fn cells(&self) -> Vec<Cell> {
        let one = self.one_thread;
        vec![
            Cell::Count(self.triangles as u64),
            Cell::Text(self.kind.into()),
            Cell::Count(self.rays as u64),
            Cell::Text(self.structure.into()),
            Cell::Text(self.query.into()),
            Cell::Number(self.build_ms.median),
            Cell::Number(self.bytes_per_triangle),
            Cell::Number(one.median),
            Cell::Number(one.min),
            Cell::Number(one.max),
            Cell::Number(self.times_first),
            Cell::Number(self.all_threads.median),
            Cell::Number(self.different_per_million),
            Cell::Number(self.distances_per_million),
            Cell::Number(self.ties_per_million),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::super::rays::tests::small;
    use super::*;

    #[test]
    fn the_page_shows_every_row() {
        let report = small();
        let (page, html) = (report.page(), report.page().to_html());
        assert_eq!(page.table.rows.len(), report.rows.len());
        assert!(page.table.rows.iter().all(|row| row.len() == COLUMNS.len()));
        for row in &report.rows {
            for number in [row.one_thread.median, row.all_threads.median, row.build_ms.median] {
                assert!(html.contains(&format!("<td>{}</td>", Cell::Number(number))));
            }
            assert!(html.contains(row.structure) && html.contains(row.query));
        }
        assert_eq!(html.matches("<svg").count(), 8);
    }

    #[test]
    fn builds_are_compared_as_the_program_asks() {
        for row in small().rows {
            let query = if row.kind == "shadow" { Query::Any } else { Query::Nearest };
            assert_eq!(structure(&row).is_some(), row.engine.query == query, "{row:?}");
        }
    }

    #[test]
    fn plots_have_a_line_for_each_way_and_each_build() {
        let lines: Vec<usize> = small().plots().iter().map(|plot| plot.series.len()).collect();
        assert_eq!(lines, [6, 7, 8, 7, 6, 7, 7, 7]);
        for plot in small().plots() {
            assert!(
                plot.series.iter().all(|(_, points)| points.len() == 2),
                "{}: a point a scene",
                plot.title
            );
        }
    }
}
