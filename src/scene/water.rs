//! The course's water surface: a height field made of directional waves, for `surface.obj`.
//!
//! An open, single sheet over the unit square in x and z, centred at the origin, of amplitude about ±0.0125.
//! Four main waves (4 to 5 crests across) bend the light; five choppy ripples with sharpened crests refine its
//! pattern. Each is `a (sin φ - b cos 2φ)` with `φ = k (d · (x, z)) + phase`: at `b = 1/4`, the second harmonic
//! of a Stokes wave doubles the curvature of the crests and flattens the troughs.
//!
//! The amplitudes are chosen for a floor 50 units below after scaling by 120, that is `D = 0.417` here. Light
//! that comes straight down is bent by `(1 - 1/n) h'`, so a crest focuses on the floor where
//! `-h'' = 1 / (D (1 - 1/n)) = 9.7` (n = 1.33), and where a lamp `H` above the water lights it, where
//! `-h'' = (1 + D / (n H)) / (D (1 - 1/n)) = 15.9` (H = 0.483: the course's lamp at y = 108). The strongest crest
//! has 15.3: a connected net of thin bright lines from the lamp, and from the sun one whose lines have just
//! begun to cross (2 % of the surface lies beyond its focus).

use std::f64::consts::TAU;
use std::io::{self, Write};

use super::Mesh;
use crate::math::Vec3;

/// Cells along each side that leave no visible facet after scaling by 120: the chords stay within 0.004 units.
pub const DEFAULT_CELLS: usize = 256;

struct Wave {
    /// Direction of travel, from +x towards +z.
    degrees: f64,
    /// Wavelengths along the unit square's side.
    count: f64,
    amplitude: f64,
    phase: f64,
    /// Share of the second harmonic.
    sharpness: f64,
}

const fn wave(degrees: f64, count: f64, amplitude: f64, phase: f64, sharpness: f64) -> Wave {
    Wave { degrees, count, amplitude, phase, sharpness }
}

const WAVES: [Wave; 9] = [
    wave(12.0, 4.3, 0.0038, 0.6, 0.0),
    wave(-31.0, 4.7, 0.0031, 2.1, 0.0),
    wave(64.0, 4.1, 0.0028, 4.4, 0.0),
    wave(101.0, 5.0, 0.0022, 1.3, 0.0),
    wave(38.0, 7.3, 0.0009, 5.2, 0.25),
    wave(-17.0, 8.9, 0.0007, 0.9, 0.25),
    wave(83.0, 10.6, 0.0005, 3.3, 0.25),
    wave(-58.0, 12.2, 0.00036, 2.6, 0.25),
    wave(152.0, 14.1, 0.00024, 1.7, 0.25),
];

impl Wave {
    fn vector(&self) -> (f64, f64) {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        (TAU * self.count * cos, TAU * self.count * sin)
    }

    fn angle(&self, x: f64, z: f64) -> f64 {
        let (kx, kz) = self.vector();
        kx * x + kz * z + self.phase
    }

    fn height(&self, x: f64, z: f64) -> f64 {
        let phi = self.angle(x, z);
        self.amplitude * (phi.sin() - self.sharpness * (2.0 * phi).cos())
    }

    /// The derivatives of the height by x and by z.
    fn slope(&self, x: f64, z: f64) -> (f64, f64) {
        let phi = self.angle(x, z);
        let d = self.amplitude * (phi.cos() + 2.0 * self.sharpness * (2.0 * phi).sin());
        let (kx, kz) = self.vector();
        (d * kx, d * kz)
    }
}

/// The height of the water above the point `(x, z)`, in mesh units; the square is `[-1/2, 1/2]²`.
pub fn height(x: f64, z: f64) -> f64 {
    WAVES.iter().map(|w| w.height(x, z)).sum()
}

/// The upward unit normal `(-∂h/∂x, 1, -∂h/∂z) / |…|`.
fn normal(x: f64, z: f64) -> [f64; 3] {
    let (dx, dz) = WAVES.iter().map(|w| w.slope(x, z)).fold((0.0, 0.0), |s, d| (s.0 + d.0, s.1 + d.1));
    let length = (1.0 + dx * dx + dz * dz).sqrt();
    [-dx / length, 1.0 / length, -dz / length]
}

/// The grid's points `(x, z)`, x running fastest.
fn grid_points(n: usize) -> impl Iterator<Item = (f64, f64)> {
    let at = move |i: usize| i as f64 / n as f64 - 0.5;
    (0..=n).flat_map(move |row| (0..=n).map(move |column| (at(column), at(row))))
}

/// Two triangles a cell, wound so that their geometric normals point up.
fn grid_triangles(n: usize) -> impl Iterator<Item = [usize; 3]> {
    (0..n * n).flat_map(move |cell| {
        let near = cell / n * (n + 1) + cell % n;
        let far = near + n + 1;
        [[near, far, far + 1], [near, far + 1, near + 1]]
    })
}

/// The surface as a smooth mesh of `n x n` cells (at least one), all of material 0.
///
/// ```
/// use caustica::scene::water::surface_mesh;
/// let mesh = surface_mesh(8);
/// assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (81, 128));
/// ```
pub fn surface_mesh(n: usize) -> Mesh {
    let n = n.max(1);
    let vertex = |(x, z)| Vec3::new(x as f32, height(x, z) as f32, z as f32);
    let vertex_normal = |(x, z)| Vec3::from(normal(x, z).map(|c| c as f32)).normalize();
    Mesh {
        name: String::from("surface"),
        vertices: grid_points(n).map(vertex).collect(),
        normals: Some(grid_points(n).map(vertex_normal).collect()),
        uvs: None,
        triangles: grid_triangles(n).map(|t| t.map(|i| i as u32)).collect(),
        materials: vec![0; 2 * n * n],
    }
}

/// Writes the surface as an OBJ file of `n x n` cells (at least one): seven decimals, always the same bytes.
///
/// # Errors
/// Those of `out`.
pub fn write_obj(out: &mut impl Write, n: usize) -> io::Result<()> {
    let n = n.max(1);
    writeln!(
        out,
        "# Water surface, written by `caustica surface`: an open height field of {n} x {n} cells,"
    )?;
    writeln!(out, "# {} directional waves over the unit square in x and z, y up.", WAVES.len())?;
    for (x, z) in grid_points(n) {
        writeln!(out, "v {x:.7} {:.7} {z:.7}", height(x, z))?;
    }
    for (x, z) in grid_points(n) {
        let [nx, ny, nz] = normal(x, z);
        writeln!(out, "vn {nx:.7} {ny:.7} {nz:.7}")?;
    }
    for [a, b, c] in grid_triangles(n).map(|t| t.map(|i| i + 1)) {
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::mesh::geometric_normal;
    use super::*;

    fn heights() -> impl Iterator<Item = f64> {
        grid_points(400).map(|(x, z)| height(x, z))
    }

    /// `-h''` along the direction of strongest focusing, by central differences.
    fn focusing(x: f64, z: f64) -> f64 {
        let e = 1e-4;
        let h = |i: f64, j: f64| height(x + i * e, z + j * e);
        let xx = (h(1., 0.) - 2. * h(0., 0.) + h(-1., 0.)) / (e * e);
        let zz = (h(0., 1.) - 2. * h(0., 0.) + h(0., -1.)) / (e * e);
        let xz = (h(1., 1.) - h(1., -1.) - h(-1., 1.) + h(-1., -1.)) / (4. * e * e);
        let (mean, half) = (0.5 * (xx + zz), 0.5 * (xx - zz));
        half.hypot(xz) - mean
    }

    #[test]
    fn amplitude_is_the_courses() {
        let largest = heights().map(f64::abs).fold(0.0, f64::max);
        assert!((0.010..=0.0135).contains(&largest), "{largest}");
        let mean = heights().sum::<f64>() / 401f64.powi(2);
        assert!(mean.abs() < 1e-4, "{mean}");
    }

    #[test]
    fn crests_focus_at_about_the_depth_of_the_floor() {
        let (depth, lamp, bend): (f64, f64, f64) = (50.0 / 120.0, 58.0 / 120.0, 1.0 - 1.0 / 1.33);
        let (sun_focus, lamp_focus) = (1.0 / (depth * bend), (1.0 + depth / (1.33 * lamp)) / (depth * bend));
        assert!((sun_focus - 9.67).abs() < 0.01 && (lamp_focus - 15.94).abs() < 0.01);
        let curvatures: Vec<f64> = grid_points(200).map(|(x, z)| focusing(x, z)).collect();
        let strongest = curvatures.iter().fold(0.0, |a: f64, &b| a.max(b));
        assert!((14.0..16.0).contains(&strongest), "{strongest}");
        let beyond = curvatures.iter().filter(|&&c| c > sun_focus).count() as f64 / curvatures.len() as f64;
        assert!((0.01..0.06).contains(&beyond), "{beyond}");
    }

    #[test]
    fn ripples_have_sharp_crests_and_flat_troughs() {
        let ripple = wave(0.0, 1.0, 1.0, 0.0, 0.25);
        let bend = |x: f64| {
            ripple.height(x - 1e-3, 0.0) + ripple.height(x + 1e-3, 0.0) - 2.0 * ripple.height(x, 0.0)
        };
        assert!(bend(0.25) < -1e-5 && bend(0.75).abs() < 1e-8);
    }

    #[test]
    fn normals_are_the_derivatives() {
        let e = 1e-6;
        for (x, z) in grid_points(7) {
            let dx = (height(x + e, z) - height(x - e, z)) / (2.0 * e);
            let dz = (height(x, z + e) - height(x, z - e)) / (2.0 * e);
            let [nx, ny, nz] = normal(x, z);
            assert!((nx / ny + dx).abs() < 1e-7 && (nz / ny + dz).abs() < 1e-7);
        }
    }

    #[test]
    fn the_mesh_is_an_upward_sheet_on_the_unit_square() {
        let mesh = surface_mesh(16);
        assert_eq!((mesh.vertices.len(), mesh.triangles.len(), mesh.materials.len()), (289, 512, 512));
        assert!((0..512).all(|t| geometric_normal(mesh.corners(t)).unwrap().y > 0.9));
        let area: f32 = (0..512).map(|t| mesh.corners(t)).map(|[a, b, c]| (b - a).cross(c - a).y / 2.0).sum();
        assert!((area - 1.0).abs() < 1e-5, "{area}");
        assert_eq!(mesh.vertices[0].with_y(0.0), Vec3::new(-0.5, 0.0, -0.5));
        assert_eq!(surface_mesh(0).triangles.len(), 2);
    }

    #[test]
    fn the_file_holds_seven_decimals_and_does_not_change() {
        let write = || {
            let mut bytes = Vec::new();
            write_obj(&mut bytes, 2).unwrap();
            String::from_utf8(bytes).unwrap()
        };
        let text = write();
        assert_eq!(text, write());
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2 + 9 + 9 + 8);
        assert!(lines[0].contains("caustica surface") && lines[0].contains("2 x 2"));
        assert_eq!(lines[6], format!("v 0.0000000 {:.7} 0.0000000", height(0.0, 0.0)));
        assert_eq!(lines[20], "f 1//1 4//4 5//5");
    }
}
