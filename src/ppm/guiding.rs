//! Where guided photons start: learned before the first pass from photons that are followed to see whether they arrive.

use std::fmt;

use rayon::prelude::*;
use serde::Serialize;

use super::course::Course;
use super::draws::Draws;
use super::emission::Guided;
use super::flights::FlightPacket;
use super::photon_pass::{CHUNK, paths_of};
use super::photons::{Deposits, PhotonChunk};
use super::trial_points::Points;
use super::wavefront::Wavefront;
use super::{Guiding, Render};
use crate::bvh::{Sphere, SphereBvh};
use crate::light::{Example, Guide, GuideTree, LEVELS, Numbers, Purpose, Start, start};
use crate::math::{Ray, Vec3};
use crate::scene::Receiver;

/// Photons of the first round, which scenes pay for where guiding gains nothing.
const FIRST_ROUND: u64 = 8 * CHUNK;

/// Photons of every further round.
const ROUND: u64 = 2 * FIRST_ROUND;

/// Rounds at most.
const ROUNDS: u32 = 12;

/// So many rounds learn from photons that arrive.
const LAST_ROUNDS: u32 = 3;

/// From so many photons that arrive, or come near, a round is learned.
const ENOUGH: usize = 64;

/// Part of the photons of a round that goes where those before went.
const SHARE: f64 = 0.75;

/// Where as many photons arrived as this, and less gain than [`LEAST_GAIN`] shows, no further round looks for it.
const PLENTY: usize = FIRST_ROUND as usize / 64;

/// Less is not worth it: a trial errs, and the variance that it does not see is that of rare photons.
pub(super) const LEAST_GAIN: f64 = 1.2;

/// The numbers of the rounds' passes count down from this: no pass has them.
const PASS: u32 = u32::MAX - 1;

/// What the set-up decided about guided photons.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GuidePlan {
    /// The part of the photons that goes where photons arrived; the others go wherever light goes. 0 where none are guided.
    pub share: f64,
    /// The part of natural photons that arrives at what is seen.
    pub arriving: f64,
    /// The same of those that go where photons arrived.
    pub guided_arriving: f64,
    /// Cells of starts that are told apart.
    pub cells: usize,
    /// By how much guiding lowers variance times rays, as the trial has it; as far as it was followed where none are guided.
    pub gain: f64,
    /// Rounds of learning.
    pub rounds: u32,
    /// Rays of all of them.
    pub rays: u64,
}

/// Why photons are guided or not.
impl fmt::Display for GuidePlan {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (arriving, gain) = (100.0 * self.arriving, self.gain);
        match self.share > 0.0 {
            true => write!(
                f,
                "{arriving:.3} % of natural photons arrive at what is seen; by a trial {gain:.1} times less variance for the same rays"
            ),
            false => write!(
                f,
                "{arriving:.3} % of photons arrive at what is seen; by a trial no more than {gain:.2} times less variance for the same rays"
            ),
        }
    }
}

/// What was learned.
pub(super) struct Learned {
    pub tree: GuideTree,
    pub plan: GuidePlan,
    /// Of a natural photon, in the mean.
    pub natural_rays: f64,
    /// Of one that goes where photons arrived.
    pub guided_rays: f64,
}

/// A photon that was followed.
#[derive(Clone, Copy, Debug)]
struct Followed {
    start: Start,
    /// By how many photons of all rounds together its start is drawn, in parts of a natural photon's.
    drawn: f64,
    /// 0 where it arrived; how near it came, where it did not.
    level: u8,
    rays: u32,
}

/// Follows photons in rounds, each drawn by what those before told.
///
/// Where too few arrive to learn from, those count that come near: within twice the distance on each level. So rounds close in on
/// what is seen.
///
/// `Err` where it was found that guiding gains nothing.
pub(super) fn learn(render: &Render, points: &Points) -> Result<Learned, GuidePlan> {
    let lights = render.lights.choice_bounds();
    let vicinity = Vicinity::of(points, render.scene.bounds().extent().length());
    let mut school = School { render, points, vicinity, lights, guides: Vec::new(), followed: Vec::new() };
    school.add_round(Guide::new(GuideTree::of_lights(lights), 0.5), FIRST_ROUND);
    let mut left = LAST_ROUNDS;
    loop {
        let (arrived, tree) = (school.arrived(), school.grow(Purpose::Search));
        if render.settings.guiding == Guiding::Auto && arrived >= PLENTY && tree.gain() < LEAST_GAIN {
            return Err(school.plan(&tree));
        }
        if left == 0 || school.guides.len() as u32 == ROUNDS {
            break;
        }
        left -= u32::from(arrived >= ENOUGH);
        school.add_round(Guide::new(tree, SHARE), ROUND);
    }
    let tree = school.grow(Purpose::Render);
    let plan = school.plan(&tree);
    if school.arrived() < ENOUGH {
        return Err(GuidePlan { gain: 1.0, ..plan });
    }
    Ok(school.finish(tree, plan))
}

struct School<'a> {
    render: &'a Render<'a>,
    points: &'a Points,
    vicinity: Vicinity,
    lights: &'a [f64],
    /// Of every round, with its photons.
    guides: Vec<(Guide, u64)>,
    followed: Vec<Followed>,
}

impl School<'_> {
    fn arrived(&self) -> usize {
        self.followed.iter().filter(|photon| photon.level == 0).count()
    }

    /// A tree by all photons so far.
    fn grow(&self, purpose: Purpose) -> GuideTree {
        let levels = self.telling_levels();
        let level = |photon: &Followed| levels.iter().position(|&level| photon.level <= level);
        let example = |photon: &Followed| Example {
            start: photon.start,
            weight: 1.0 / photon.drawn,
            level: level(photon).unwrap_or(LEVELS) as u8,
            rays: photon.rays,
        };
        let mut examples: Vec<Example> = self.followed.iter().map(example).collect();
        GuideTree::grow(&mut examples, self.lights, purpose)
    }

    /// Levels on which enough photons came near, and not as many as on the one below; the first is 0 once enough arrived.
    fn telling_levels(&self) -> Vec<u8> {
        let mut counts = [0; 256];
        self.followed.iter().for_each(|photon| counts[usize::from(photon.level)] += 1);
        let (mut levels, mut sum, mut least) = (Vec::new(), 0, ENOUGH);
        for level in 0..u8::MAX {
            sum += counts[usize::from(level)];
            if sum >= least && levels.len() < LEVELS {
                levels.push(level);
                least = 3 * sum / 2;
            }
        }
        levels
    }

    /// Follows so many photons by a guide more.
    fn add_round(&mut self, guide: Guide, photons: u64) {
        self.followed
            .par_iter_mut()
            .for_each(|photon| photon.drawn += drawn((&guide, photons), &photon.start));
        let first = self.followed.len();
        let chunks = (0..(photons / CHUNK) as usize).into_par_iter();
        let chunks: Vec<Vec<Followed>> = chunks.map(|chunk| self.follow(&guide, photons, chunk)).collect();
        self.guides.push((guide, photons));
        self.followed.extend(chunks.into_iter().flatten());
        let guides = &self.guides;
        self.followed[first..].par_iter_mut().for_each(|photon| {
            photon.drawn =
                guides.iter().map(|(guide, photons)| drawn((guide, *photons), &photon.start)).sum();
        });
    }

    fn follow(&self, guide: &Guide, photons: u64, chunk: usize) -> Vec<Followed> {
        let Render { settings, .. } = self.render;
        let guided = Guided { guide, photons };
        let pass = PASS - self.guides.len() as u32;
        let course = Course {
            guided: Some(guided),
            names_paths: true,
            ..Course::natural(self.render.stage(), settings, pass)
        };
        let paths = paths_of(chunk, photons);
        let draws = Draws { seed: settings.seed, pass, first: paths.start, segment: 0 };
        let unknown =
            |path| Followed { start: guided.start(draws, path), drawn: 0.0, level: u8::MAX, rays: 0 };
        let mut followed: Vec<Followed> = (0..CHUNK as u32).map(unknown).collect();
        let (mut photons, mut bounces) = (PhotonChunk::default(), Vec::new());
        let see = |FlightPacket { rays, path, .. }: &FlightPacket| {
            for (lane, &path) in path.iter().enumerate().take(rays.len) {
                let rays_before = &mut followed[path as usize].rays;
                if *rays_before > 0 {
                    bounces.push((path, rays.ray(lane)));
                }
                *rays_before += 1;
            }
        };
        Wavefront::default().follow(&course, paths, &mut photons, see);
        for deposits in [&photons.caustic, &photons.indirect] {
            self.note_arrivals(deposits, &mut followed);
        }
        self.note_bounces(&bounces, &mut followed);
        followed
    }

    fn note_arrivals(&self, Deposits { positions, photons, paths }: &Deposits, followed: &mut [Followed]) {
        for ((&position, photon), &path) in positions.iter().zip(photons).zip(paths) {
            let level = &mut followed[path as usize].level;
            if *level > 0 && self.points.receive(position, photon) {
                *level = 0;
            }
        }
    }

    fn note_bounces(&self, bounces: &[(u32, Ray)], followed: &mut [Followed]) {
        for (path, ray) in bounces {
            let level = &mut followed[*path as usize].level;
            if *level > 0 {
                *level = (*level).min(self.vicinity.level(ray));
            }
        }
    }

    /// Sums over all photons that were followed, each for as many natural ones as it stands for.
    fn sum(&self, of: impl Fn(&Followed) -> f64) -> f64 {
        self.followed.iter().map(|photon| of(photon) / photon.drawn).sum()
    }

    fn plan(&self, tree: &GuideTree) -> GuidePlan {
        let arrives = |photon: &Followed| f64::from(u8::from(photon.level == 0));
        let density = |photon: &Followed| tree.densities()[tree.find(&photon.start)];
        GuidePlan {
            share: 0.0,
            arriving: self.sum(arrives) / self.sum(|_| 1.0),
            guided_arriving: self.sum(|p| arrives(p) * density(p)) / self.sum(density),
            cells: tree.densities().len(),
            gain: tree.gain(),
            rounds: self.guides.len() as u32,
            rays: self.followed.iter().map(|photon| u64::from(photon.rays)).sum(),
        }
    }

    fn finish(&self, tree: GuideTree, plan: GuidePlan) -> Learned {
        let rays = |photon: &Followed| f64::from(photon.rays);
        let density = |photon: &Followed| tree.densities()[tree.find(&photon.start)];
        let natural_rays = self.sum(rays) / self.sum(|_| 1.0);
        let guided_rays = self.sum(|p| rays(p) * density(p)) / self.sum(density);
        Learned { tree, plan, natural_rays, guided_rays }
    }
}

/// By how many photons a guide draws a start, in parts of one natural photon's.
fn drawn((guide, photons): (&Guide, u64), start: &Start) -> f64 {
    photons as f64 * guide.density(start)
}

/// Balls around what is seen, fewer and larger ones on each level, with the normals there.
struct Vicinity(Vec<(SphereBvh, Vec<Vec3>)>);

impl Vicinity {
    /// Up to balls of the size of the scene.
    fn of(points: &Points, size: f32) -> Vicinity {
        let receivers: Vec<Receiver> = points.receivers().collect();
        let (mut levels, mut radius, mut step) = (Vec::new(), points.radius, 1);
        while radius < size && levels.len() < usize::from(u8::MAX) - 1 {
            (radius, step) = (2.0 * radius, (4 * step).min(receivers.len()));
            let some: Vec<&Receiver> = receivers.iter().step_by(step).collect();
            let spheres: Vec<Sphere> = some.iter().map(|r| Sphere { center: r.p, radius }).collect();
            let (tree, order) = SphereBvh::build(&spheres);
            levels.push((tree, order.iter().map(|&k| some[k as usize].ng).collect()));
        }
        Vicinity(levels)
    }

    /// The lowest level, from 1, on which a photon flies on from near what is seen, and to the side from which it is seen; the highest number where it does on none.
    fn level(&self, onward: &Ray) -> u8 {
        let near = |(tree, normals): &(SphereBvh, Vec<Vec3>)| {
            let mut any = false;
            tree.for_each_containing(onward.origin, |place| any |= normals[place].dot(onward.dir) > 0.0);
            any
        };
        self.0.iter().position(near).map_or(u8::MAX, |level| level as u8 + 1)
    }
}

impl Guided<'_> {
    /// How a photon of a chunk starts.
    fn start(&self, draws: Draws, path: u32) -> Start {
        let mut rng = draws.of(path);
        let numbers: Numbers = std::array::from_fn(|_| rng.next_f32());
        let cell = self.cell(draws.first + u64::from(path), rng.next_f32());
        start(self.guide.warp(cell, numbers))
    }

    /// The number of the cell that a photon of a chunk starts from.
    pub fn cell_of(&self, draws: Draws, path: u32) -> usize {
        let mut rng = draws.of(path);
        let place = (0..7).fold(0.0, |_, _| rng.next_f32());
        self.cell(draws.first + u64::from(path), place)
    }
}
