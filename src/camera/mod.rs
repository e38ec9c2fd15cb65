//! The camera: a pinhole or a thin lens, and how its pixels weigh the light on the film.

mod pixel_filter;

pub use pixel_filter::{GAUSSIAN_CUT, GAUSSIAN_SIGMA, PixelFilter};

use crate::math::{Ray, Vec2, Vec3, warp};

/// A camera with square pixels; pixel (0, 0) is the top left one. A pinhole, unless it is given a lens.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    position: Vec3,
    forward: Vec3,
    /// From the middle of the picture to its right edge, at unit distance.
    right: Vec3,
    /// From the middle of the picture to its top edge, at unit distance.
    up: Vec3,
    resolution: Vec2,
    lens: Option<Lens>,
}

/// A thin lens of ideal glass: it gathers in one point of the film whatever comes from one point of the plane of sharpness.
#[derive(Clone, Copy, Debug)]
struct Lens {
    /// To the right edge of the picture.
    right: Vec3,
    /// To the top edge.
    up: Vec3,
    /// From the lens to the plane of sharpness, along the axis of view.
    focus_distance: f32,
}

/// A point as the camera sees it where nothing hides it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where it appears, in pixels from the top left corner.
    pub raster: Vec2,
    /// The point of the lens that it is seen through: the pinhole where there is no lens.
    pub through: Vec3,
    /// Direction to there, unit.
    pub to_camera: Vec3,
    /// How many pixels a unit of area covers that lies at the point and faces [`Projection::through`].
    pub pixels_per_area: f32,
}

impl Camera {
    /// A camera at `position` that looks at `look_at`, with the horizontal field of view `fov_degrees` (full angle).
    ///
    /// `up` must not be parallel to the line of sight; it need be neither unit nor perpendicular.
    pub fn new(position: Vec3, look_at: Vec3, up: Vec3, fov_degrees: f32, resolution: (u32, u32)) -> Camera {
        let resolution = Vec2::new(resolution.0 as f32, resolution.1 as f32);
        let forward = (look_at - position).normalize();
        let right = forward.cross(up).normalize();
        let half_width = (0.5 * fov_degrees.to_radians()).tan();
        Camera {
            position,
            forward,
            right: half_width * right,
            up: half_width * resolution.y / resolution.x * right.cross(forward),
            resolution,
            lens: None,
        }
    }

    /// The same camera with a lens of that radius, which is sharp at `focus_distance` along the axis of view; both are in scene
    /// units, and a radius of 0 is the pinhole. The picture's frame stays that of the pinhole.
    ///
    /// A point at depth `z` is spread over a disc of the film whose diameter is `2 r |1 / z - 1 / f|` at unit distance: the circle
    /// of confusion.
    ///
    /// # Source
    /// Cook, Porter and Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984, section 4.3.
    pub fn with_lens(self, radius: f32, focus_distance: f32) -> Camera {
        let (right, up) = (radius * self.right.normalize(), radius * self.up.normalize());
        Camera { lens: (radius > 0.0).then_some(Lens { right, up, focus_distance }), ..self }
    }

    /// Whether it has a lens, rather than a pinhole.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// The ray through the picture position `raster` (pixels from the top left corner) and the middle of the lens, of unit
    /// direction. It alone is what a pinhole sees.
    pub fn ray(&self, raster: Vec2) -> Ray {
        Ray::new(self.position, self.towards(raster).normalize())
    }

    /// The ray through the picture position `raster` and a point of the lens, uniform in area for `u` uniform in the unit square;
    /// all of them meet [`Camera::ray`] in the plane of sharpness. A pinhole looks at no `u`.
    pub fn ray_through_lens(&self, raster: Vec2, u: Vec2) -> Ray {
        let Some(lens) = &self.lens else { return self.ray(raster) };
        let offset = lens.offset(u);
        let dir = self.towards(raster) - offset / lens.focus_distance;
        Ray::new(self.position + offset, dir.normalize())
    }

    /// From the middle of the lens, as far as depth 1.
    fn towards(&self, raster: Vec2) -> Vec3 {
        let ndc = 2.0 * raster / self.resolution - 1.0;
        self.forward + ndc.x * self.right - ndc.y * self.up
    }

    /// The pinhole, or the middle of the lens.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// How far `p` lies before the pinhole or the lens, along the axis of view, in scene units: not the distance, which is larger
    /// towards the edges of the picture. Negative behind it.
    pub fn depth(&self, p: Vec3) -> f32 {
        (p - self.position).dot(self.forward)
    }

    /// The row-major matrix that takes row vectors `(x, y, z, 1)` of the world to the camera's own axes: x to the right of the
    /// picture, y to its top, and it looks along -z.
    pub fn world_to_camera(&self) -> [f32; 16] {
        let (x, y, z) = (self.right.normalize(), self.up.normalize(), -self.forward);
        let row = |axis: Vec3| [axis.dot(x), axis.dot(y), axis.dot(z)];
        let [a, b, c, d] = [row(Vec3::X), row(Vec3::Y), row(Vec3::Z), row(-self.position)];
        [a[0], a[1], a[2], 0.0, b[0], b[1], b[2], 0.0, c[0], c[1], c[2], 0.0, d[0], d[1], d[2], 1.0]
    }

    /// The point of the lens that `u` of the unit square stands for.
    pub fn point_of_lens(&self, u: Vec2) -> Vec3 {
        self.lens.map_or(self.position, |lens| self.position + lens.offset(u))
    }

    /// Where the point `p` appears that is seen through the point of the lens that `u` stands for: the inverse of
    /// [`Camera::ray_through_lens`]. `None` further than `margin` pixels outside the picture, beside and behind the lens.
    ///
    /// On the image plane at distance 1, where a pixel has the area `A`, a solid angle `dω` at the angle `θ` from the
    /// axis covers `dω / cos³ θ`; area that faces the pinhole at distance `d` covers `1 / d²` of solid angle. So
    /// `pixels_per_area = 1 / (A cos³ θ d²)`, which is the importance `W = 1 / (A cos⁴ θ)` of a pinhole times `cos θ / d²`.
    /// A point of the lens is a pinhole whose image plane lies in the plane of sharpness, shifted but of the same scale.
    ///
    /// # Source
    /// Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd edition, 2016, section 16.1.1: the importance.
    pub fn project(&self, p: Vec3, u: Vec2, margin: f32) -> Option<Projection> {
        let through = self.point_of_lens(u);
        let d = p - through;
        let (distance, depth) = (d.length(), d.dot(self.forward));
        let shift = self.lens.map_or(Vec3::ZERO, |lens| lens.offset(u) / lens.focus_distance);
        let on_plane = d / depth + shift;
        let ndc = Vec2::new(
            on_plane.dot(self.right) / self.right.length_squared(),
            -on_plane.dot(self.up) / self.up.length_squared(),
        );
        let raster = 0.5 * (ndc + 1.0) * self.resolution;
        let inside = raster.cmpge(Vec2::splat(-margin)).all() && raster.cmplt(self.resolution + margin).all();
        let cos = depth / distance;
        let pixels_per_area = 1.0 / (self.pixel_area() * cos.powi(3) * distance * distance);
        (depth > 0.0 && inside).then(|| Projection {
            raster,
            through,
            to_camera: -d / distance,
            pixels_per_area,
        })
    }

    /// The area of a pixel at distance 1.
    fn pixel_area(&self) -> f32 {
        4.0 * self.right.length() * self.up.length() / (self.resolution.x * self.resolution.y)
    }

    /// The width of a pixel at distance 1 in the middle of the picture.
    pub fn pixel_width(&self) -> f32 {
        2.0 * self.right.length() / self.resolution.x
    }
}

impl Lens {
    /// From the middle to the point that `u` of the unit square stands for.
    fn offset(&self, u: Vec2) -> Vec3 {
        let p = warp::square_to_disk(u);
        p.x * self.right + p.y * self.up
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Frame;
    use proptest::prelude::*;

    fn camera() -> Camera {
        Camera::new(Vec3::new(0.0, 60.0, 180.0), Vec3::new(0.0, 60.0, 0.0), Vec3::Y, 90.0, (200, 100))
    }

    #[test]
    fn middle_looks_forward_and_edges_span_the_field_of_view() {
        let middle = camera().ray(Vec2::new(100.0, 50.0)).dir;
        assert!((middle - Vec3::NEG_Z).length() < 1e-6);
        let right = camera().ray(Vec2::new(200.0, 50.0)).dir;
        assert!((right - Vec3::new(1.0, 0.0, -1.0).normalize()).length() < 1e-6);
        let top = camera().ray(Vec2::new(100.0, 0.0)).dir;
        assert!((top - Vec3::new(0.0, 0.5, -1.0).normalize()).length() < 1e-6);
    }

    #[test]
    fn pixel_width_is_the_step_between_neighbours() {
        let step = camera().ray(Vec2::new(101.0, 50.0)).dir.x / -camera().ray(Vec2::new(101.0, 50.0)).dir.z;
        assert!((step - camera().pixel_width()).abs() < 1e-6);
    }

    /// Askew, so that no coordinate stands for another, and of pixels that number differently along each side.
    fn askew() -> Camera {
        Camera::new(
            Vec3::new(3.0, -2.0, 7.0),
            Vec3::new(-1.0, 4.0, 2.0),
            Vec3::new(0.2, 1.0, 0.1),
            70.0,
            (200, 120),
        )
    }

    /// A point two units to the right, three up and five ahead, by the camera's own rays.
    #[test]
    fn the_matrix_takes_the_world_to_the_axes_of_the_camera() {
        let camera = askew();
        let [forward, right, up] = [Vec2::new(100.0, 60.0), Vec2::new(200.0, 60.0), Vec2::new(100.0, 0.0)]
            .map(|raster| camera.towards(raster));
        let (right, up) = ((right - forward).normalize(), (up - forward).normalize());
        let p = camera.position() + 2.0 * right + 3.0 * up + 5.0 * forward;
        let m = camera.world_to_camera();
        let seen: [f32; 4] =
            std::array::from_fn(|k| p.x * m[k] + p.y * m[4 + k] + p.z * m[8 + k] + m[12 + k]);
        for (seen, expected) in seen.into_iter().zip([2.0, 3.0, -5.0, 1.0]) {
            assert!((seen - expected).abs() < 1e-5, "{seen} instead of {expected}");
        }
        assert!((camera.depth(p) - 5.0).abs() < 1e-5);
    }

    /// Of a pinhole and of a lens.
    fn cameras() -> [Camera; 2] {
        [askew(), askew().with_lens(0.3, 6.0)]
    }

    proptest! {
        #[test]
        fn projection_inverts_rays(x in 0.001f32..199.999, y in 0.001f32..119.999, distance in 0.01f32..1e4, u in 0f32..1.0, v in 0f32..1.0) {
            let (raster, u) = (Vec2::new(x, y), Vec2::new(u, v));
            for camera in cameras() {
                let ray = camera.ray_through_lens(raster, u);
                let seen = camera.project(ray.at(distance), u, 0.1).unwrap();
                prop_assert!((seen.raster - raster).length() < 1e-3 * (1.0 + 1.0 / distance), "{seen:?}");
                prop_assert!((seen.to_camera + ray.dir).length() < 1e-5 * (1.0 + 1.0 / distance));
                prop_assert_eq!(seen.through, ray.origin);
            }
        }

        /// The determinant of the projection of a small square that faces the point of the lens.
        #[test]
        fn pixels_per_area_is_the_measure_of_the_projection(x in 1f32..199.0, y in 1f32..119.0, distance in 0.5f32..50.0, u in 0f32..1.0, v in 0f32..1.0) {
            let u = Vec2::new(u, v);
            for camera in cameras() {
                let ray = camera.ray_through_lens(Vec2::new(x, y), u);
                let (frame, step) = (Frame::around(ray.dir), 2e-3 * distance);
                let shifted = |by: Vec3| camera.project(ray.at(distance) + step * by, u, 1.0).unwrap().raster;
                let along = |axis: Vec3| (shifted(axis) - shifted(-axis)) / (2.0 * step);
                let measure = along(frame.tangent).perp_dot(along(frame.bitangent)).abs();
                let claimed = camera.project(ray.at(distance), u, 0.1).unwrap().pixels_per_area;
                prop_assert!((claimed / measure - 1.0).abs() < 0.01, "{claimed} instead of {measure}");
            }
        }

        /// Whatever point of the lens a ray comes from.
        #[test]
        fn the_plane_of_sharpness_is_sharp(x in 0f32..200.0, y in 0f32..120.0, u in 0f32..1.0, v in 0f32..1.0) {
            let camera = askew().with_lens(0.7, 6.0);
            let (chief, ray) = (camera.ray(Vec2::new(x, y)), camera.ray_through_lens(Vec2::new(x, y), Vec2::new(u, v)));
            let in_focus = |ray: &Ray| ray.at((6.0 - (ray.origin - camera.position).dot(camera.forward)) / ray.dir.dot(camera.forward));
            prop_assert!(in_focus(&chief).distance(in_focus(&ray)) < 1e-5);
            prop_assert!((ray.origin - camera.position).dot(camera.forward).abs() < 1e-5, "the lens faces the view");
            prop_assert!(ray.origin.distance(camera.position) <= 0.7 + 1e-5);
        }
    }

    /// A point at depth `z`, seen through all of the lens, covers a disc of diameter `2 r |1 / z - 1 / f|` at unit distance.
    #[test]
    fn the_circle_of_confusion_is_that_of_the_thin_lens() {
        let (radius, focus) = (0.4, 5.0);
        let camera = camera().with_lens(radius, focus);
        for z in [2.0, 4.0, 5.0, 9.0, 1e4] {
            let p = camera.ray(Vec2::new(130.0, 20.0)).dir;
            let p = camera.position() + p * (z / p.dot(camera.forward));
            let seen = |u| camera.project(p, u, 1e4).unwrap().raster;
            let edge = |k: f32| Vec2::new(k / 64.0, 0.0);
            let rim: Vec<Vec2> = (0..64)
                .map(|k| seen(edge(k as f32)))
                .chain((0..64).map(|k| seen(Vec2::ONE - edge(k as f32))))
                .collect();
            let widest = rim.iter().flat_map(|a| rim.iter().map(move |b| a.distance(*b))).fold(0.0, f32::max);
            let expected = 2.0 * radius * (1.0 / z - 1.0 / focus).abs() / camera.pixel_width();
            assert!(
                (widest - expected).abs() < 1e-3 * expected + 1e-3,
                "depth {z}: {widest} for {expected} pixels"
            );
        }
    }

    /// In the plane of sharpness, by symmetry.
    #[test]
    fn the_lens_is_sampled_evenly() {
        let camera = camera().with_lens(2.0, 5.0);
        let n = 64;
        let offset = |k: u32| {
            let u = (Vec2::new((k % n) as f32, (k / n) as f32) + 0.5) / n as f32;
            camera.point_of_lens(u) - camera.position()
        };
        let offsets: Vec<Vec3> = (0..n * n).map(offset).collect();
        let mean = offsets.iter().sum::<Vec3>() / (n * n) as f32;
        assert!(mean.length() < 1e-3, "{mean}");
        // Of a disc: r² / 4 along each axis.
        let squares = offsets.iter().map(|o| *o * *o).sum::<Vec3>() / (n * n) as f32;
        assert!((squares - Vec3::new(1.0, 1.0, 0.0)).length() < 2e-3, "{squares}");
    }

    #[test]
    fn a_pinhole_is_a_lens_without_extent() {
        let (raster, u) = (Vec2::new(3.0, 70.5), Vec2::new(0.9, 0.1));
        for camera in [askew(), askew().with_lens(0.0, 3.0)] {
            assert!(!camera.has_lens());
            assert_eq!(camera.ray_through_lens(raster, u), askew().ray(raster));
            assert_eq!(camera.point_of_lens(u), askew().position());
        }
    }

    #[test]
    fn what_the_picture_does_not_show_has_no_projection() {
        let project = |p| camera().project(p, Vec2::ZERO, 0.0);
        for raster in
            [Vec2::new(-0.01, 50.0), Vec2::new(200.01, 50.0), Vec2::new(9.0, -0.01), Vec2::new(9.0, 100.01)]
        {
            let p = camera().ray(raster).at(3.0);
            assert_eq!(project(p), None, "{raster}");
            assert!(camera().project(p, Vec2::ZERO, 0.02).is_some(), "{raster}");
        }
        let behind = camera().ray(Vec2::new(100.0, 50.0)).at(-3.0);
        assert_eq!(project(behind), None);
        assert_eq!(project(camera().position()), None);
        assert_eq!(project(camera().position() + Vec3::X), None);
    }
}
