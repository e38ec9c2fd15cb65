//! The count of leaks as a table.

use super::leaks::{LeakReport, LeakRow};
use crate::report::{Cell, Page, Table};

const COLUMNS: [&str; 10] = [
    "mesh",
    "triangles",
    "traversal",
    "to edges",
    "leaks",
    "to vertices",
    "leaks",
    "bounces",
    "leaks",
    "Mrays/s a thread",
];

const NOTE: &str = "\
Rays from inside closed meshes to points on edges and exactly to vertices, and from wherever they arrive a bounce in a \
uniform direction. Nothing is outside: a ray that meets nothing has slipped out between triangles. `embree-fast` \
does not ask Embree to be robust. The speed is that of the aimed rays, asked one by one; `bench --rays` measures it on \
rays of renders.";

impl LeakReport {
    /// The numbers and the machine.
    pub fn page(&self) -> Page {
        let mut facts = self.machine.lines();
        facts.push(("Threads", self.threads.to_string()));
        Page {
            title: "Rays that slip through closed meshes".into(),
            facts,
            note: NOTE.into(),
            table: Table { columns: COLUMNS.into(), rows: self.rows.iter().map(LeakRow::cells).collect() },
            plots: vec![],
        }
    }
}

impl LeakRow {
    fn cells(&self) -> Vec<Cell> {
        let counts = [self.edges, self.vertices, self.bounces].map(|l| [l.rays, l.leaks]);
        let mut cells = vec![
            Cell::Text(self.mesh.into()),
            Cell::Count(self.triangles as u64),
            Cell::Text(self.traversal.clone()),
        ];
        cells.extend(counts.as_flattened().iter().map(|&count| Cell::Count(count)));
        cells.push(Cell::Number(self.rays_per_microsecond));
        cells
    }
}
