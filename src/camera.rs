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

    /// The width of a pixel at distance 1 in the middle of the picture.
    pub fn pixel_width(&self) -> f32 {
        2.0 * self.right.length() / self.resolution.x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
