use std::f32::consts::PI;
use std::f64::consts::PI as PI64;

use super::choice::place;
use super::distant::{beyond, cross_section, outside};
use super::{EmissionSample, IlluminationSample};
use crate::film::Image;
use crate::math::{BoundingSphere, DVec3, Rgb, Vec2, Vec3, mean, warp};

/// Light from all around the scene.
///
/// Photons enter through the cross-section of a ball around the scene, so that the flux is `π R² ∫ L dω`.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    sky: Sky,
    /// Around the scene.
    ball: BoundingSphere,
}

/// Radiance by direction.
#[derive(Clone, Debug, PartialEq)]
enum Sky {
    Constant(Rgb),
    Picture(Panorama),
}

impl Environment {
    /// The same radiance (W/m²/sr) from everywhere.
    pub fn constant(radiance: Rgb, ball: BoundingSphere) -> Environment {
        Environment { sky: Sky::Constant(radiance), ball }
    }

    /// Radiance by a picture of all directions: see [`Panorama`].
    pub fn picture(panorama: Panorama, ball: BoundingSphere) -> Environment {
        Environment { sky: Sky::Picture(panorama), ball }
    }

    /// The radiance from where `dir`, unit, points to.
    pub fn radiance(&self, dir: Vec3) -> Rgb {
        match &self.sky {
            Sky::Constant(radiance) => *radiance,
            Sky::Picture(panorama) => panorama.radiance(dir),
        }
    }

    /// What enters the ball (W).
    pub fn flux(&self) -> Rgb {
        let integral = match &self.sky {
            Sky::Constant(radiance) => 4.0 * PI * *radiance,
            Sky::Picture(panorama) => panorama.integral,
        };
        cross_section(&self.ball) * integral
    }

    /// The density by which directions to it are drawn (1/sr).
    pub fn pdf_w(&self, dir: Vec3) -> f32 {
        match &self.sky {
            Sky::Constant(_) => 0.25 / PI,
            Sky::Picture(panorama) => panorama.pdf_w(dir),
        }
    }

    fn sample(&self, u: Vec2) -> Vec3 {
        match &self.sky {
            Sky::Constant(_) => warp::square_to_uniform_sphere(u),
            Sky::Picture(panorama) => panorama.sample(u),
        }
    }

    pub(super) fn emit(&self, place: Vec2, u: Vec2) -> EmissionSample {
        let from = self.sample(u);
        let origin = outside(&self.ball, -from, place);
        let power = self.radiance(from) * (cross_section(&self.ball) / self.pdf_w(from));
        EmissionSample { origin, dir: -from, power }
    }

    pub(super) fn illuminate(&self, p: Vec3, u: Vec2) -> Option<IlluminationSample> {
        let wi = self.sample(u);
        let pdf_w = self.pdf_w(wi);
        let (target, irradiance) = (beyond(&self.ball, p, wi), self.radiance(wi) / pdf_w);
        (pdf_w > 0.0).then_some(IlluminationSample { target, target_error: 0.0, wi, irradiance, pdf_w })
    }
}

/// A picture of all directions in geographic coordinates: longitude from left to right, all around, and latitude from the zenith
/// at the top. The middle of the picture lies along `-z` before it is turned, its right half towards `+x`; `y` is up.
///
/// Its first row is the zenith and its last one the nadir; pixels of a row stand in the middles of equal arcs. Between them
/// radiance is bilinear. Directions are drawn by the fields between pixels, in proportion to their solid angle and the mean of the four
/// around: positive wherever there is light.
///
/// # Source
/// Mitsuba 3.9 places the pixels of its `envmap` so: the same file is the same sky in both.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    picture: Image,
    scale: f32,
    /// About `y`, in radians: by so much is the picture turned, counter-clockwise seen from above.
    turn: f32,
    /// Running sums of the shares of the bands between rows, up to 1, and within each band of its fields'.
    rows: Vec<f64>,
    columns: Vec<f64>,
    integral: Rgb,
}

impl Panorama {
    /// `picture` holds radiance (W/m²/sr), which is multiplied by `scale`. `None` where it is all black, or not a number.
    pub fn new(picture: Image, scale: f32, turn: f32) -> Option<Panorama> {
        let width = picture.width();
        let mut panorama =
            Panorama { picture, scale, turn, rows: Vec::new(), columns: Vec::new(), integral: Rgb::ZERO };
        let n_bands = panorama.n_bands();
        let mut sum = 0.0;
        for y in 0..n_bands {
            let solid_angle = band(y, n_bands) / width as f64;
            let mut along = 0.0;
            for x in 0..width {
                along += panorama.around(x, y);
                panorama.columns.push(along);
            }
            let row = width * y..;
            panorama.columns[row].iter_mut().for_each(|c| *c = if along > 0.0 { *c / along } else { 1.0 });
            sum += along * solid_angle;
            panorama.rows.push(sum);
        }
        panorama.rows.iter_mut().for_each(|row| *row /= sum);
        panorama.integral = panorama.integrated();
        (sum > 0.0 && sum.is_finite() && scale > 0.0).then_some(panorama)
    }

    /// The picture, as the file has it.
    pub fn picture(&self) -> &Image {
        &self.picture
    }

    /// The factor on the picture.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// By how much it is turned about `y`, in radians.
    pub fn turn(&self) -> f32 {
        self.turn
    }

    /// Bands between two rows; a single row is the same from pole to pole.
    fn n_bands(&self) -> usize {
        (self.picture.height() - 1).max(1)
    }

    /// The mean of the four pixels around a field.
    fn around(&self, x: usize, y: usize) -> f64 {
        let corners = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        corners.into_iter().map(|(x, y)| f64::from(mean(self.pixel(x, y)))).sum::<f64>() / 4.0
    }

    /// Columns go around, rows end.
    fn pixel(&self, x: usize, y: usize) -> Rgb {
        let (width, height) = (self.picture.width(), self.picture.height());
        self.picture.pixels()[y.min(height - 1) * width + x % width]
    }

    /// The integral of the radiance over all directions.
    fn integrated(&self) -> Rgb {
        let (width, n_bands) = (self.picture.width(), self.n_bands());
        let row = |y: usize| (0..width).map(|x| self.pixel(x, y).as_dvec3()).sum::<DVec3>() / width as f64;
        let between = |y: usize| {
            let lower = lower_share(y, n_bands);
            (1.0 - lower) * row(y) + lower * row(y + 1)
        };
        (0..n_bands).map(|y| band(y, n_bands) * between(y)).sum::<DVec3>().as_vec3() * self.scale
    }

    /// From the left and from the top, in pictures.
    fn place(&self, dir: Vec3) -> (f64, f64) {
        let dir = dir.as_dvec3();
        let longitude = dir.x.atan2(-dir.z) + f64::from(self.turn);
        let colatitude = (dir.x.hypot(dir.z)).atan2(dir.y);
        ((0.5 + longitude / (2.0 * PI64)).rem_euclid(1.0), colatitude / PI64)
    }

    /// The field that lies there, and how far into it, from its left and from its top.
    fn field(&self, dir: Vec3) -> ([usize; 2], [f64; 2]) {
        let ((u, v), width) = (self.place(dir), self.picture.width());
        let (x, y) = ((u * width as f64 - 0.5).rem_euclid(width as f64), v * self.n_bands() as f64);
        let (left, top) = ((x as usize).min(width - 1), (y as usize).min(self.n_bands() - 1));
        ([left, top], [x - left as f64, y - top as f64])
    }

    fn radiance(&self, dir: Vec3) -> Rgb {
        let ([left, top], along) = self.field(dir);
        let [x, y] = along.map(|along| along as f32);
        let [a, b] =
            [top, top + 1].map(|row| self.pixel(left, row) * (1.0 - x) + self.pixel(left + 1, row) * x);
        self.scale * (a * (1.0 - y) + b * y)
    }

    fn pdf_w(&self, dir: Vec3) -> f32 {
        let ([x, y], _) = self.field(dir);
        let width = self.picture.width();
        let row = &self.columns[y * width..(y + 1) * width];
        let share = step(&self.rows, y) * step(row, x);
        (share * width as f64 / band(y, self.n_bands())) as f32
    }

    fn sample(&self, u: Vec2) -> Vec3 {
        let (width, n_bands) = (self.picture.width(), self.n_bands());
        let (y, down) = chosen(&self.rows, f64::from(u.x));
        let (x, along) = chosen(&self.columns[y * width..(y + 1) * width], f64::from(u.y));
        let longitude = ((x as f64 + along + 0.5) / width as f64 - 0.5) * 2.0 * PI64 - f64::from(self.turn);
        let [top, bottom] = [y, y + 1].map(|y| (y as f64 / n_bands as f64 * PI64).cos());
        let cos = top + down * (bottom - top);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Vec3::new((sin * longitude.sin()) as f32, cos as f32, (-sin * longitude.cos()) as f32)
    }
}

/// The solid angle of a band of `n` (sr).
fn band(y: usize, n: usize) -> f64 {
    let cos = |y: usize| (y as f64 / n as f64 * PI64).cos();
    2.0 * PI64 * (cos(y) - cos(y + 1))
}

/// The mean over a band of `n`, by solid angle, of what grows from 0 at its upper edge to 1 at its lower one.
fn lower_share(y: usize, n: usize) -> f64 {
    let (height, [top, bottom]) = (PI64 / n as f64, [y, y + 1].map(|y| y as f64 / n as f64 * PI64));
    2.0 * PI64 * ((bottom.sin() - top.sin()) / height - bottom.cos()) / band(y, n)
}

/// The share of place `k`.
fn step(cumulative: &[f64], k: usize) -> f64 {
    cumulative[k] - k.checked_sub(1).map_or(0.0, |before| cumulative[before])
}

/// The place that `u` in `[0, 1)` chooses, and how far into it, from 0 to 1.
fn chosen(cumulative: &[f64], u: f64) -> (usize, f64) {
    let k = place(cumulative, u);
    let share = step(cumulative, k);
    let before = cumulative[k] - share;
    (k, if share > 0.0 { ((u - before) / share).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Rng, Stream};

    const BALL: BoundingSphere = BoundingSphere { center: Vec3::ZERO, radius: 2.0 };

    /// A dim sky with a bright pixel and a black half.
    fn sky() -> Panorama {
        let mut pixels = vec![Rgb::splat(0.1); 16 * 8];
        pixels[2 * 16 + 5] = Rgb::new(50.0, 40.0, 30.0);
        pixels[4 * 16..].fill(Rgb::ZERO);
        Panorama::new(Image::from_pixels(16, 8, pixels).unwrap(), 2.0, 0.7).unwrap()
    }

    fn skies() -> [Environment; 2] {
        [Environment::constant(Rgb::new(1.0, 2.0, 3.0), BALL), Environment::picture(sky(), BALL)]
    }

    /// `∫ pdf = 1`, no light without density, and the mean of `L / pdf` over samples is `∫ L`, by directions drawn uniformly.
    #[test]
    fn directions_are_drawn_by_their_density() {
        const N: usize = 200_000;
        for environment in skies() {
            let mut rng = Rng::new(1, Stream::Test, 0, 0);
            let (mut density, mut integral, mut drawn) = (0.0, 0.0, 0.0);
            for _ in 0..N {
                let dir = warp::square_to_uniform_sphere(rng.next_vec2());
                let (pdf_w, radiance) = (environment.pdf_w(dir), mean(environment.radiance(dir)));
                assert!(pdf_w > 0.0 || radiance == 0.0, "{dir}: {radiance}");
                density += 4.0 * PI64 * f64::from(pdf_w) / N as f64;
                integral += 4.0 * PI64 * f64::from(radiance) / N as f64;
                let sample = environment.illuminate(Vec3::ZERO, rng.next_vec2()).unwrap();
                drawn += f64::from(mean(sample.irradiance)) / N as f64;
            }
            assert!((density - 1.0).abs() < 0.05, "{density}");
            assert!((drawn / integral - 1.0).abs() < 0.05, "{drawn} {integral}");
        }
    }

    /// Samples fall where the density says: the share of those in a half space is its integral there.
    #[test]
    fn samples_lie_where_their_density_is() {
        const N: usize = 100_000;
        for environment in skies() {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(0.6, 0.64, -0.48)] {
                let mut rng = Rng::new(2, Stream::Test, 0, 0);
                let (mut drawn, mut integral) = (0.0, 0.0);
                for _ in 0..N {
                    drawn +=
                        f64::from(u8::from(environment.sample(rng.next_vec2()).dot(axis) > 0.5)) / N as f64;
                    let dir = warp::square_to_uniform_sphere(rng.next_vec2());
                    let pdf_w = if dir.dot(axis) > 0.5 { environment.pdf_w(dir) } else { 0.0 };
                    integral += 4.0 * PI64 * f64::from(pdf_w) / N as f64;
                }
                assert!((drawn - integral).abs() < 0.03, "{axis}: {drawn} {integral}");
            }
        }
    }

    /// The photons of a ball bring its flux, whatever way they are drawn.
    #[test]
    fn photons_bring_the_flux() {
        const N: usize = 100_000;
        for environment in skies() {
            let mut rng = Rng::new(3, Stream::Test, 0, 0);
            let emit = |rng: &mut Rng| environment.emit(rng.next_vec2(), rng.next_vec2());
            let sum: f64 = (0..N).map(|_| f64::from(mean(emit(&mut rng).power)) / N as f64).sum();
            let flux = f64::from(mean(environment.flux()));
            assert!((sum / flux - 1.0).abs() < 0.03, "{sum} {flux}");
        }
    }

    /// Rows stand at equal steps from pole to pole, and pixels in the middles of equal arcs. Catches a shift by half a pixel.
    #[test]
    fn pixels_stand_where_they_do_for_mitsuba() {
        let pixels = (0..8 * 5).map(|k| Rgb::new(k as f32, 1.0, 0.0)).collect();
        let sky = Panorama::new(Image::from_pixels(8, 5, pixels).unwrap(), 1.0, 0.0).unwrap();
        for (x, y) in (0..8).flat_map(|x| (1..4).map(move |y| (x, y))) {
            let (longitude, latitude) = ((x as f32 + 0.5) / 8.0 * 2.0 * PI, y as f32 / 4.0 * PI);
            let across = Vec3::new(-longitude.sin(), 0.0, longitude.cos());
            let dir = latitude.sin() * across + latitude.cos() * Vec3::Y;
            assert!(
                (sky.radiance(dir).x - (8 * y + x) as f32).abs() < 1e-3,
                "{x} {y}: {}",
                sky.radiance(dir)
            );
        }
        assert!((sky.radiance(Vec3::NEG_Y).x - 35.5).abs() < 4.0);
    }

    /// `∫ L dω` of a sky that falls from 1 at the zenith to 0 at the horizon is `2 π ∫ (1 - 2 θ / π) sin θ dθ = 2 π - 4`.
    #[test]
    fn the_flux_of_a_slope_is_exact() {
        let slope = vec![Rgb::ONE, Rgb::ZERO, Rgb::ZERO];
        let sky = Panorama::new(Image::from_pixels(1, 3, slope).unwrap(), 1.0, 0.0).unwrap();
        assert!((sky.integral.x - (2.0 * PI - 4.0)).abs() < 1e-6, "{}", sky.integral.x);
        let row = Image::from_pixels(2, 1, vec![Rgb::ONE, Rgb::ZERO]).unwrap();
        assert!((Panorama::new(row, 1.0, 0.0).unwrap().integral.x / (2.0 * PI) - 1.0).abs() < 1e-6);
    }

    /// The middle of the picture lies along -z, its right half along +x, its top along +y; it turns counter-clockwise.
    #[test]
    fn the_picture_lies_as_it_says() {
        let mut pixels = vec![Rgb::ZERO; 64 * 32];
        pixels[16 * 64 + 48] = Rgb::ONE;
        let at =
            |turn| Panorama::new(Image::from_pixels(64, 32, pixels.clone()).unwrap(), 1.0, turn).unwrap();
        assert!(at(0.0).radiance(Vec3::new(1.0, -0.05, 0.05).normalize()).x > 0.3);
        assert!(at(std::f32::consts::FRAC_PI_2).radiance(Vec3::new(0.05, -0.05, -1.0).normalize()).x > 0.3);
        let black = Image::from_pixels(2, 1, vec![Rgb::ZERO; 2]).unwrap();
        assert_eq!(Panorama::new(black, 1.0, 0.0), None);
    }

    /// `wi` from longitude and colatitude, in pictures, of a sky that is not turned.
    fn direction(u: f64, v: f64) -> Vec3 {
        let (longitude, colatitude) = ((u - 0.5) * 2.0 * PI64, v * PI64);
        let across = DVec3::new(longitude.sin(), 0.0, -longitude.cos());
        (colatitude.sin() * across + colatitude.cos() * DVec3::Y).as_vec3()
    }

    /// Pixel centres stand at `(x + 1/2) / width` and rows at `y / (height - 1)`; what is between them is a share of the way.
    /// The last column is followed by the first.
    #[test]
    fn between_two_pixels_radiance_is_bilinear() {
        let value = |x: usize, y: usize| (3 * (x % 8) + 7 * y + 2 * (x % 8) * y) as f32;
        let pixels = (0..8 * 5).map(|k| Rgb::splat(value(k % 8, k / 8))).collect();
        let sky = Panorama::new(Image::from_pixels(8, 5, pixels).unwrap(), 2.0, 0.0).unwrap();
        for (x, y) in [(0, 0), (2, 1), (5, 2), (7, 3)] {
            for (right, down) in [(0.3, 0.6), (0.75, 0.2)] {
                let dir = direction((x as f64 + right + 0.5) / 8.0, (y as f64 + down) / 4.0);
                let (field, along) = sky.field(dir);
                assert_eq!(field, [x, y], "{dir}");
                assert!((along[0] - right).abs() < 1e-4 && (along[1] - down).abs() < 1e-4, "{along:?}");
                let (right, down) = (right as f32, down as f32);
                let row = |y| value(x, y) + right * (value(x + 1, y) - value(x, y));
                let expected = 2.0 * (row(y) + down * (row(y + 1) - row(y)));
                let found = sky.radiance(dir).x;
                assert!((found - expected).abs() < 0.01, "{x} {y}: {found}, not {expected}");
            }
        }
    }

    /// Photons start on the far side of the ball from where they go, on the disc before it, and come from where their light is.
    #[test]
    fn photons_enter_from_the_side_of_their_light() {
        let ball = BoundingSphere { center: Vec3::new(3.0, -1.0, 2.0), radius: 2.0 };
        let environment = Environment::picture(sky(), ball);
        let mut rng = Rng::new(4, Stream::Test, 0, 0);
        for _ in 0..1000 {
            let photon = environment.emit(rng.next_vec2(), rng.next_vec2());
            let to_center = ball.center - photon.origin;
            assert!((to_center.dot(photon.dir) - 2.0).abs() < 1e-5, "{photon:?}");
            assert!(to_center.cross(photon.dir).length() < 2.0 + 1e-5, "{photon:?}");
            let weight = 4.0 * PI / environment.pdf_w(-photon.dir);
            let expected = environment.radiance(-photon.dir) * weight;
            assert!((photon.power - expected).length() <= 1e-4 * expected.length(), "{photon:?}");
        }
    }
}
