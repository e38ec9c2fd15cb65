//! The pinhole camera.

use crate::math::{Ray, Vec2, Vec3};

/// A pinhole camera with square pixels; pixel (0, 0) is the top left one.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    position: Vec3,
    forward: Vec3,
    /// From the middle of the picture to its right edge, at unit distance.
    right: Vec3,
    /// From the middle of the picture to its top edge, at unit distance.
    up: Vec3,
    resolution: Vec2,
}

/// A point as the camera sees it where nothing hides it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Where it appears, in pixels from the top left corner.
    pub raster: Vec2,
    /// Direction to the pinhole, unit.
    pub to_camera: Vec3,
    /// How many pixels a unit of area covers that lies at the point and faces the pinhole.
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
        }
    }

    /// The ray through the picture position `raster` (pixels from the top left corner), of unit direction.
    pub fn ray(&self, raster: Vec2) -> Ray {
        let ndc = 2.0 * raster / self.resolution - 1.0;
        let dir = self.forward + ndc.x * self.right - ndc.y * self.up;
        Ray::new(self.position, dir.normalize())
    }

    /// The pinhole.
    pub fn position(&self) -> Vec3 {
        self.position
    }

    /// Where in the picture the point `p` appears: the inverse of [`Camera::ray`]. `None` outside the picture, beside
    /// and behind the pinhole.
    ///
    /// On the image plane at distance 1, where a pixel has the area `A`, a solid angle `dω` at the angle `θ` from the
    /// axis covers `dω / cos³ θ`; area that faces the pinhole at distance `d` covers `1 / d²` of solid angle. So
    /// `pixels_per_area = 1 / (A cos³ θ d²)`, which is the importance `W = 1 / (A cos⁴ θ)` of a pinhole times `cos θ / d²`.
    ///
    /// # Source
    /// Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd edition, 2016, section 16.1.1: the importance.
    pub fn project(&self, p: Vec3) -> Option<Projection> {
        let d = p - self.position;
        let (distance, depth) = (d.length(), d.dot(self.forward));
        let on_plane = d / depth;
        let ndc = Vec2::new(
            on_plane.dot(self.right) / self.right.length_squared(),
            -on_plane.dot(self.up) / self.up.length_squared(),
        );
        let raster = 0.5 * (ndc + 1.0) * self.resolution;
        let inside = raster.cmpge(Vec2::ZERO).all() && raster.cmplt(self.resolution).all();
        let cos = depth / distance;
        let pixels_per_area = 1.0 / (self.pixel_area() * cos.powi(3) * distance * distance);
        (depth > 0.0 && inside).then(|| Projection { raster, to_camera: -d / distance, pixels_per_area })
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

    proptest! {
        #[test]
        fn projection_inverts_rays(x in 0.001f32..199.999, y in 0.001f32..119.999, distance in 0.01f32..1e4) {
            let raster = Vec2::new(x, y);
            let ray = askew().ray(raster);
            let seen = askew().project(ray.at(distance)).unwrap();
            prop_assert!((seen.raster - raster).length() < 1e-3 * (1.0 + 1.0 / distance), "{seen:?}");
            prop_assert!((seen.to_camera + ray.dir).length() < 1e-5 * (1.0 + 1.0 / distance));
        }

        /// The determinant of the projection of a small square that faces the pinhole.
        #[test]
        fn pixels_per_area_is_the_measure_of_the_projection(x in 1f32..199.0, y in 1f32..119.0, distance in 0.5f32..50.0) {
            let ray = askew().ray(Vec2::new(x, y));
            let (frame, step) = (Frame::around(ray.dir), 2e-3 * distance);
            let shifted = |by: Vec3| askew().project(ray.at(distance) + step * by).unwrap().raster;
            let along = |axis: Vec3| (shifted(axis) - shifted(-axis)) / (2.0 * step);
            let measure = along(frame.tangent).perp_dot(along(frame.bitangent)).abs();
            let claimed = askew().project(ray.at(distance)).unwrap().pixels_per_area;
            prop_assert!((claimed / measure - 1.0).abs() < 0.01, "{claimed} instead of {measure}");
        }
    }

    #[test]
    fn what_the_picture_does_not_show_has_no_projection() {
        for raster in
            [Vec2::new(-0.01, 50.0), Vec2::new(200.01, 50.0), Vec2::new(9.0, -0.01), Vec2::new(9.0, 100.01)]
        {
            assert_eq!(camera().project(camera().ray(raster).at(3.0)), None, "{raster}");
        }
        let behind = camera().ray(Vec2::new(100.0, 50.0)).at(-3.0);
        assert_eq!(camera().project(behind), None);
        assert_eq!(camera().project(camera().position()), None);
        assert_eq!(camera().project(camera().position() + Vec3::X), None);
    }
}
