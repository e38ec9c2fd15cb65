use super::aim_cone::Cone;
use super::choice::{choice, place};
use super::emitter::{Emitter, Kind};
use super::selection::Lights;
use crate::math::{BoundingSphere, Rgb, Rng, Vec3};

/// Photons aimed at balls: another way of drawing what leaves the lights, to be mixed with [`Lights::sample_emission`].
///
/// With the natural density `p` of light `j`, point `x` and direction `ω`, which is the flux over its total:
///
/// ```text
/// p     = P_j · 1/A_j · p_j(ω)                     P_j: the light's share of all flux
/// p_aim = Σ_k w_jk · 1/A_j · c_k(x, ω)             c_k: uniform in the cone from x to ball k; p_j(ω) inside of it
/// r     = p_aim / p
/// ```
/// `w_jk` is in proportion to the natural flux from the light into the cone, judged by the middle and the corners of the
/// light, and positive wherever the light reaches the ball. So `r` is about constant over balls that are small or far.
///
/// A cone is exact however small its ball is, where a map of directions would need a cell of the ball's size. Memory is that
/// of a number for each pair of a light and a ball; a sample takes the logarithm of it, a ratio a look at every ball.
///
/// # Source
/// Projection maps: Jensen, "Realistic Image Synthesis Using Photon Mapping", 2001, section 5.3. Mixing by the balance
/// heuristic: Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering", SIGGRAPH 1995.
#[derive(Clone, Debug)]
pub struct Aim {
    balls: Vec<BoundingSphere>,
    sources: Vec<Source>,
    /// `w_jk / P_j`, ball after ball of a light.
    shares: Vec<f64>,
    /// Running sums of `w_jk`, up to 1.
    cumulative: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Source {
    emitter: Emitter,
    /// `P_j`.
    probability: f64,
}

/// The start of an aimed photon.
#[derive(Clone, Copy, Debug)]
pub struct AimedSample {
    /// The number of its light, as [`Lights::sample_numbered_emission`] counts.
    pub light: usize,
    /// Where it starts, already off the light's surface.
    pub origin: Vec3,
    /// Where it goes, unit.
    pub dir: Vec3,
    /// What a natural photon of the same start carries: the flux over `p` (W). To be divided by `N_g + N_a r`, where `N_g`
    /// natural photons and `N_a` aimed ones are mixed. 0 where the light does not shine along `dir`.
    pub power: Rgb,
    /// `r`.
    pub ratio: f64,
}

impl Aim {
    /// `None` where there is no light or no ball, or no light that reaches a ball.
    pub fn new(lights: &Lights, balls: &[BoundingSphere]) -> Option<Aim> {
        let sources: Vec<Source> = lights
            .emitters()
            .map(|(emitter, probability)| Source { emitter: emitter.clone(), probability })
            .collect();
        let mut shares: Vec<f64> =
            sources.iter().flat_map(|source| balls.iter().map(|ball| source.share_into(ball))).collect();
        let total = running_sums(&sources, &shares).last().copied().filter(|&total| total > 0.0)?;
        shares.iter_mut().for_each(|share| *share /= total);
        let cumulative = running_sums(&sources, &shares);
        Some(Aim { balls: balls.to_vec(), sources, shares, cumulative })
    }

    /// Whether all emissions are as likely as natural ones, `r = 1`, since every light lies in every ball: then aiming
    /// changes nothing.
    pub fn is_natural(&self) -> bool {
        let inside = |source: &Source| self.balls.iter().all(|ball| source.lies_in(ball));
        self.sources.iter().all(inside)
    }

    /// An emission drawn by `p_aim`.
    pub fn sample(&self, rng: &mut Rng) -> AimedSample {
        let u = choice(rng.next_f32(), rng.next_f32());
        let chosen = place(&self.cumulative, u);
        let (light, ball) = (chosen / self.balls.len(), chosen % self.balls.len());
        let Source { emitter, probability } = &self.sources[light];
        let origin = emitter.origin(rng.next_vec2());
        let u = rng.next_vec2();
        let dir = match Cone::of(&self.balls[ball], origin) {
            Some(cone) => cone.sample(u),
            None => emitter.direction(origin, u),
        };
        let ratio = self.ratio(light, origin, dir);
        // Rounding may take a direction out of all cones; then it lies beside the ball.
        let power =
            if ratio > 0.0 && ratio < f64::INFINITY { emitter.flux / *probability as f32 } else { Rgb::ZERO };
        AimedSample { light, origin, dir, power, ratio }
    }

    /// `r` of a photon that leaves the light of this number (as [`Lights::sample_numbered_emission`] counts) from `origin`,
    /// off its surface, along `dir`; infinite where the light does not shine along `dir`.
    pub fn ratio(&self, light: usize, origin: Vec3, dir: Vec3) -> f64 {
        let natural = self.sources[light].emitter.pdf_w(origin, dir);
        if natural <= 0.0 {
            return f64::INFINITY;
        }
        let shares = &self.shares[light * self.balls.len()..];
        let part = |(share, ball): (&f64, &BoundingSphere)| match Cone::of(ball, origin) {
            None => *share,
            Some(cone) if cone.contains(dir) => share / (cone.solid_angle() * natural),
            Some(_) => 0.0,
        };
        shares.iter().zip(&self.balls).filter(|(share, _)| **share > 0.0).map(part).sum()
    }

    /// How many balls there are.
    pub fn balls(&self) -> usize {
        self.balls.len()
    }

    /// Heap memory, in bytes.
    pub fn memory_bytes(&self) -> usize {
        size_of_val(&*self.balls)
            + size_of_val(&*self.sources)
            + size_of_val(&*self.shares)
            + size_of_val(&*self.cumulative)
    }
}

/// The sums of `P_j` times the shares of `j`, one after the other.
fn running_sums(sources: &[Source], shares: &[f64]) -> Vec<f64> {
    let balls = shares.len() / sources.len().max(1);
    let mut sum = 0.0;
    let mut add = |(place, share): (usize, &f64)| {
        sum += sources[place / balls].probability * share;
        sum
    };
    shares.iter().enumerate().map(&mut add).collect()
}

impl Source {
    /// The share of the light's flux that goes into the cones to `ball`, about.
    fn share_into(&self, ball: &BoundingSphere) -> f64 {
        let Emitter { kind, corners, frame, .. } = &self.emitter;
        if self.emitter.is_far() {
            return 0.0;
        }
        let is_point = !matches!(kind, Kind::Triangle);
        let share = |from: Vec3| match Cone::of(ball, from) {
            None => 1.0,
            Some(cone) if is_point => cone.uniform_share(),
            Some(cone) => cone.lambertian_share(frame.normal),
        };
        if is_point {
            return share(corners[0]);
        }
        let middle = corners.iter().sum::<Vec3>() / 3.0;
        0.25 * (share(middle) + corners.map(share).iter().sum::<f64>())
    }

    fn lies_in(&self, ball: &BoundingSphere) -> bool {
        if matches!(self.emitter.kind, Kind::Other(_)) {
            return false;
        }
        let nearer = BoundingSphere { radius: ball.radius - 2.0 * self.emitter.p_error, ..*ball };
        nearer.radius >= 0.0 && self.emitter.corners.iter().all(|&corner| nearer.contains(corner))
    }
}

#[cfg(test)]
mod tests {
    use super::super::Light;
    use super::*;
    use crate::math::{DVec3, Stream, mean};
    use std::f64::consts::TAU;

    const N: u32 = 100_000;

    fn ball(x: f32, y: f32, z: f32, radius: f32) -> BoundingSphere {
        BoundingSphere { center: Vec3::new(x, y, z), radius }
    }

    fn point(position: Vec3, watts_a_steradian: f32) -> Light {
        Light::Point { position, intensity: Rgb::splat(watts_a_steradian) }
    }

    /// Shines downwards.
    fn lamp(y: f32, size: f32) -> Light {
        let corners = [Vec3::new(-size, y, -size), Vec3::new(size, y, -size), Vec3::new(-size, y, size)];
        Light::Triangle { corners, radiance: Rgb::new(3.0, 2.0, 1.0) }
    }

    /// Lamps and points outside of balls, inside, under them; balls that overlap, touch the horizon, lie behind.
    fn scenes() -> Vec<(Lights, Vec<BoundingSphere>)> {
        let far = vec![ball(0.3, 0.1, 0.2, 0.05)];
        let overlapping = vec![ball(0.0, 0.0, 0.0, 0.4), ball(0.3, 0.0, 0.0, 0.5), ball(0.9, 1.0, 0.0, 0.3)];
        let around = vec![ball(0.0, 1.0, 0.0, 0.5), ball(0.0, 0.0, 0.0, 0.3), ball(0.2, 3.0, 0.0, 0.4)];
        let one = || Lights::new([point(Vec3::Y, 2.0)]);
        let mixed = || Lights::new([point(Vec3::new(0.5, 0.9, 0.1), 1.0), lamp(1.0, 0.2), lamp(0.7, 0.02)]);
        vec![
            (one(), far.clone()),
            (Lights::new([lamp(1.0, 0.3)]), far),
            (one(), overlapping.clone()),
            (mixed(), overlapping),
            (mixed(), around.clone()),
            (one(), around),
        ]
    }

    /// Anything that depends on where photons start, where they go and what they carry.
    fn observed(origin: Vec3, dir: Vec3, power: Rgb) -> DVec3 {
        let p = f64::from(mean(power));
        p * DVec3::new(
            1.0,
            f64::from(dir.dot(Vec3::new(0.3, -0.9, 0.2))),
            f64::from((origin.x + dir.z).powi(2)),
        )
    }

    fn meets(ball: &BoundingSphere, origin: Vec3, dir: Vec3) -> bool {
        Cone::of(ball, origin).is_none_or(|cone| cone.contains(dir))
    }

    /// `Φ Ω / 4π` of a point, by photons all of which hit: exactly, not on average.
    #[test]
    fn a_point_aimed_at_a_ball_sends_it_its_flux() {
        for radius in [0.5, 1e-2, 1e-4] {
            let lights = Lights::new([point(Vec3::new(3.0, 1e4, 1.0), 5.0)]);
            let balls = [ball(3.0, 2.0, -1.0, radius * 1e4)];
            let aim = Aim::new(&lights, &balls).unwrap();
            let mut rng = Rng::new(1, Stream::Test, 0, 0);
            let dark = (0..N).map(|_| aim.sample(&mut rng)).filter(|photon| {
                let flux = f64::from(photon.power.x) / photon.ratio;
                let omega = Cone::of(&balls[0], photon.origin).unwrap().solid_angle();
                photon.power != Rgb::ZERO && (flux / (5.0 * omega) - 1.0).abs() > 1e-6
            });
            assert_eq!(dark.count(), 0, "{radius}");
            let sharp = f64::from(radius).asin();
            let narrow = TAU * (1.0 - sharp.cos());
            let omega = Cone::of(&balls[0], Vec3::new(3.0, 1e4, 1.0)).unwrap().solid_angle();
            assert!((omega / narrow - 1.0).abs() < 0.03, "{radius}: {omega} for {narrow}");
        }
    }

    /// Two ways of drawing have the same expectations, weighted by the ratio of their densities.
    #[test]
    fn samples_follow_the_density_that_the_ratio_tells() {
        // Towards horizons the ratio has no variance: there both are left out.
        const LARGEST: f64 = 3e4;
        for (number, (lights, balls)) in scenes().into_iter().enumerate() {
            let aim = Aim::new(&lights, &balls).unwrap();
            let (mut natural, mut aimed) = ([Sum::default(); 3], [Sum::default(); 3]);
            let mut rng = Rng::new(2, Stream::Test, 0, number as u64);
            for _ in 0..4 * N {
                let (light, e) = lights.sample_numbered_emission(&mut rng).unwrap();
                let r = aim.ratio(light, e.origin, e.dir);
                if r < LARGEST {
                    add(&mut natural, r * observed(e.origin, e.dir, e.power));
                } else {
                    add(&mut natural, DVec3::ZERO);
                }
                let a = aim.sample(&mut rng);
                add(
                    &mut aimed,
                    if a.ratio < LARGEST { observed(a.origin, a.dir, a.power) } else { DVec3::ZERO },
                );
            }
            for k in 0..3 {
                let (difference, sigma) = natural[k].against(&aimed[k]);
                assert!(
                    difference.abs() < 5.0 * sigma,
                    "scene {number}, moment {k}: {difference} of ±{sigma}"
                );
            }
        }
    }

    /// Flux into every ball, by natural photons and by both kinds weighted by the balance heuristic.
    #[test]
    fn the_balance_heuristic_is_unbiased() {
        for (number, (lights, balls)) in scenes().into_iter().enumerate() {
            let aim = Aim::new(&lights, &balls).unwrap();
            for (rho, ball) in balls.iter().enumerate().map(|(k, ball)| ([0.5, 3.0, 20.0][k % 3], ball)) {
                let (mut alone, mut mixed) = ([Sum::default(); 3], [Sum::default(); 3]);
                let mut rng = Rng::new(3, Stream::Test, 0, number as u64);
                let seen = |origin, dir, power| {
                    if meets(ball, origin, dir) { observed(origin, dir, power) } else { DVec3::ZERO }
                };
                for _ in 0..N {
                    let (light, e) = lights.sample_numbered_emission(&mut rng).unwrap();
                    let flux = seen(e.origin, e.dir, e.power);
                    add(&mut alone, flux);
                    let mut both = flux / (1.0 + rho * aim.ratio(light, e.origin, e.dir));
                    // As many aimed photons as `rho` asks for, or one of their weight.
                    let a = aim.sample(&mut rng);
                    if a.power != Rgb::ZERO {
                        both += seen(a.origin, a.dir, a.power) * rho / (1.0 + rho * a.ratio);
                    }
                    add(&mut mixed, both);
                }
                for k in 0..3 {
                    let (difference, sigma) = alone[k].against(&mixed[k]);
                    assert!(difference.abs() < 5.0 * sigma, "scene {number}: {difference} of ±{sigma}");
                }
            }
        }
    }

    /// `E_p[r] = 1`: cones hold the whole of `p_aim`, but what they have below a horizon.
    #[test]
    fn the_ratio_has_the_mean_one() {
        for (lights, balls) in [
            (Lights::new([point(Vec3::Y, 2.0)]), vec![ball(0.0, 0.0, 0.0, 0.7), ball(1.5, 1.0, 0.0, 0.8)]),
            (Lights::new([lamp(1.0, 0.1)]), vec![ball(0.0, 0.0, 0.0, 0.5), ball(0.1, 0.2, 0.0, 0.4)]),
            (Lights::new([lamp(1.0, 0.1), point(Vec3::ZERO, 1.0)]), vec![ball(0.0, 0.0, 0.0, 0.5)]),
        ] {
            let aim = Aim::new(&lights, &balls).unwrap();
            let (mut rng, mut sum) = (Rng::new(4, Stream::Test, 0, 0), Sum::default());
            for _ in 0..N {
                let (light, e) = lights.sample_numbered_emission(&mut rng).unwrap();
                sum.add(aim.ratio(light, e.origin, e.dir));
            }
            let (mean, sigma) = sum.mean();
            assert!((mean - 1.0).abs() < 5.0 * sigma && sigma < 0.05, "{mean} ± {sigma}");
        }
    }

    #[test]
    fn lights_inside_of_all_balls_shine_naturally() {
        let lights = Lights::new([lamp(1.0, 0.3), point(Vec3::new(0.1, 0.9, 0.0), 1.0)]);
        let aim = Aim::new(&lights, &[ball(0.0, 1.0, 0.0, 0.6), ball(0.2, 1.0, 0.0, 0.9)]).unwrap();
        assert!(aim.is_natural());
        let mut rng = Rng::new(5, Stream::Test, 0, 0);
        assert!((0..1000).all(|_| (aim.sample(&mut rng).ratio - 1.0).abs() < 1e-9));
        assert!(!Aim::new(&lights, &[ball(0.0, 1.0, 0.0, 0.35)]).unwrap().is_natural());
    }

    #[test]
    fn there_is_nothing_to_aim_at_behind_a_lamp() {
        let lights = Lights::new([lamp(1.0, 0.3)]);
        assert!(Aim::new(&lights, &[ball(0.0, 2.0, 0.0, 0.5)]).is_none());
        assert!(Aim::new(&lights, &[ball(0.0, 1.1, 0.0, 0.5)]).is_some());
        assert!(
            Aim::new(&lights, &[]).is_none()
                && Aim::new(&Lights::new([]), &[ball(0.0, 0.0, 0.0, 1.0)]).is_none()
        );
    }

    /// A million pairs: the table is searched, not walked.
    #[test]
    fn many_lights_are_aimed_by_a_search() {
        let light = |k: u32| point(Vec3::new(k as f32, 5.0, (k % 7) as f32), 1.0 + (k % 3) as f32);
        let lights = Lights::new((0..60_000).map(light));
        let balls: Vec<BoundingSphere> = (0..16).map(|k| ball(3000.0 * k as f32, 0.0, 0.0, 1.0)).collect();
        let aim = Aim::new(&lights, &balls).unwrap();
        let mut rng = Rng::new(6, Stream::Test, 0, 0);
        let lit = (0..1000).filter(|_| aim.sample(&mut rng).power != Rgb::ZERO).count();
        assert!(lit > 990 && aim.memory_bytes() < 32 << 20, "{lit}, {}", aim.memory_bytes());
    }

    #[derive(Clone, Copy, Default)]
    struct Sum {
        count: f64,
        sum: f64,
        squares: f64,
    }

    impl Sum {
        fn add(&mut self, x: f64) {
            (self.count, self.sum, self.squares) = (self.count + 1.0, self.sum + x, self.squares + x * x);
        }

        fn mean(&self) -> (f64, f64) {
            let mean = self.sum / self.count;
            (mean, ((self.squares / self.count - mean * mean).max(0.0) / self.count).sqrt())
        }

        /// The difference of two means, and how large chance makes it.
        fn against(&self, other: &Sum) -> (f64, f64) {
            let ((a, sigma_a), (b, sigma_b)) = (self.mean(), other.mean());
            (a - b, sigma_a.hypot(sigma_b) + 1e-9 * a.abs())
        }
    }

    fn add(sums: &mut [Sum; 3], x: DVec3) {
        sums.iter_mut().zip(x.to_array()).for_each(|(sum, x)| sum.add(x));
    }
}
