use std::f32::consts::PI;
use std::f64::consts::PI as PI64;

use super::distant::{beyond, cross_section, outside};
use super::{EmissionSample, IlluminationSample};
use crate::film::Image;
use crate::math::{BoundingSphere, Rgb, Vec2, Vec3, mean, warp};

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
/// Radiance is bilinear between the middles of pixels. Directions are drawn by pixels, in proportion to their solid angle and the
/// mean of the nine around: positive wherever there is light.
#[derive(Clone, Debug, PartialEq)]
pub struct Panorama {
    picture: Image,
    scale: f32,
    /// About `y`, in radians: by so much is the picture turned, counter-clockwise seen from above.
    turn: f32,
    /// Running sums of the rows' shares, up to 1, and within each row of its pixels'.
    rows: Vec<f64>,
    columns: Vec<f64>,
    integral: Rgb,
}

impl Panorama {
    /// `picture` holds radiance (W/m²/sr), which is multiplied by `scale`. `None` where it is all black, or not a number.
    pub fn new(picture: Image, scale: f32, turn: f32) -> Option<Panorama> {
        let (width, height) = (picture.width(), picture.height());
        let mut panorama =
            Panorama { picture, scale, turn, rows: Vec::new(), columns: Vec::new(), integral: Rgb::ZERO };
        let mut sum = 0.0;
        for y in 0..height {
            let solid_angle = band(y, height) / width as f64;
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

    /// The mean of the nine pixels around one.
    fn around(&self, x: usize, y: usize) -> f64 {
        let near = |k: usize| (k % 3, k / 3);
        let sum = (0..9).map(near).map(|(i, j)| f64::from(mean(self.pixel(x + i, 1, y + j, 1))));
        sum.sum::<f64>() / 9.0
    }

    /// Pixel `x - left`, `y - up`: columns go around, rows end.
    fn pixel(&self, x: usize, left: usize, y: usize, up: usize) -> Rgb {
        let (width, height) = (self.picture.width(), self.picture.height());
        let (x, y) = ((x + width - left) % width, y.saturating_sub(up).min(height - 1));
        self.picture.pixels()[y * width + x]
    }

    /// The integral of the radiance over all directions, by the middles of pixels.
    fn integrated(&self) -> Rgb {
        let (width, height) = (self.picture.width(), self.picture.height());
        let row = |y: usize| {
            let sum = self.picture.pixels()[y * width..(y + 1) * width].iter().map(|p| p.as_dvec3());
            sum.sum::<crate::math::DVec3>() * (band(y, height) / width as f64)
        };
        (0..height).map(row).sum::<crate::math::DVec3>().as_vec3() * self.scale
    }

    /// From the left and from the top, in pictures.
    fn place(&self, dir: Vec3) -> (f64, f64) {
        let dir = dir.as_dvec3();
        let longitude = dir.x.atan2(-dir.z) + f64::from(self.turn);
        let colatitude = (dir.x.hypot(dir.z)).atan2(dir.y);
        ((0.5 + longitude / (2.0 * PI64)).rem_euclid(1.0), colatitude / PI64)
    }

    fn radiance(&self, dir: Vec3) -> Rgb {
        let (u, v) = self.place(dir);
        let width = self.picture.width();
        let x = u * width as f64 + 0.5;
        let y = v * self.picture.height() as f64 + 0.5;
        let (left, top) = (x as usize, y as usize);
        let (fx, fy) = ((x - left as f64) as f32, (y - top as f64) as f32);
        // Half a pixel to the left and up: the corners are pixels left - 1, top - 1 to left, top.
        let [a, b] =
            [1, 0].map(|up| self.pixel(left, 1, top, up) * (1.0 - fx) + self.pixel(left, 0, top, up) * fx);
        self.scale * (a * (1.0 - fy) + b * fy)
    }

    fn pdf_w(&self, dir: Vec3) -> f32 {
        let (u, v) = self.place(dir);
        let (width, height) = (self.picture.width(), self.picture.height());
        let (x, y) =
            (((u * width as f64) as usize).min(width - 1), ((v * height as f64) as usize).min(height - 1));
        let row = &self.columns[y * width..(y + 1) * width];
        let share = step(&self.rows, y) * step(row, x);
        (share * width as f64 / band(y, height)) as f32
    }

    fn sample(&self, u: Vec2) -> Vec3 {
        let (width, height) = (self.picture.width(), self.picture.height());
        let (y, down) = chosen(&self.rows, f64::from(u.x));
        let (x, along) = chosen(&self.columns[y * width..(y + 1) * width], f64::from(u.y));
        let longitude = ((x as f64 + along) / width as f64 - 0.5) * 2.0 * PI64 - f64::from(self.turn);
        let [top, bottom] = [y, y + 1].map(|y| (y as f64 / height as f64 * PI64).cos());
        let cos = top + down * (bottom - top);
        let sin = (1.0 - cos * cos).max(0.0).sqrt();
        Vec3::new((sin * longitude.sin()) as f32, cos as f32, (-sin * longitude.cos()) as f32)
    }
}

/// The solid angle of a row of pixels (sr).
fn band(y: usize, height: usize) -> f64 {
    let cos = |y: usize| (y as f64 / height as f64 * PI64).cos();
    2.0 * PI64 * (cos(y) - cos(y + 1))
}

/// The share of place `k`.
fn step(cumulative: &[f64], k: usize) -> f64 {
    cumulative[k] - k.checked_sub(1).map_or(0.0, |before| cumulative[before])
}

/// The place that `u` in `[0, 1)` chooses, and how far into it, from 0 to 1.
fn chosen(cumulative: &[f64], u: f64) -> (usize, f64) {
    let k = cumulative.partition_point(|&c| c <= u).min(cumulative.len() - 1);
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
}
