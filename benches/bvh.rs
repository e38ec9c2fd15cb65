//! Build, refit and gather of spheres on the walls of a unit box.

use std::hint::black_box;

use caustica::bench::gather_source::on_walls;
use caustica::bvh::{Sphere, SphereBvh};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rayon::{ThreadPool, ThreadPoolBuilder};

const SIZES: [usize; 2] = [100_000, 1 << 20];
const RADII: [f32; 3] = [0.001, 0.004, 0.01];
const THREADS: [usize; 2] = [1, 2];
const PHOTONS: usize = 100_000;

fn spheres_on_walls(n: usize, radius: f32) -> Vec<Sphere> {
    on_walls(n, 0).into_iter().map(|center| Sphere { center, radius }).collect()
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap_or_else(|error| {
        eprintln!("no pool of {threads} threads: {error}");
        std::process::exit(1)
    })
}

fn build(c: &mut Criterion) {
    let mut group = c.benchmark_group("build");
    group.sample_size(10);
    for n in SIZES {
        let spheres = spheres_on_walls(n, 0.004);
        group.throughput(Throughput::Elements(n as u64));
        for threads in THREADS {
            let pool = pool(threads);
            group.bench_function(BenchmarkId::new(format!("{n}"), threads), |b| {
                b.iter(|| pool.install(|| black_box(SphereBvh::build(&spheres))));
            });
        }
    }
}

fn refit(c: &mut Criterion) {
    let mut group = c.benchmark_group("refit");
    group.sample_size(10);
    for n in SIZES {
        let (mut bvh, _) = SphereBvh::build(&spheres_on_walls(n, 0.004));
        group.throughput(Throughput::Elements(n as u64));
        for threads in THREADS {
            let pool = pool(threads);
            group.bench_function(BenchmarkId::new(format!("{n}"), threads), |b| {
                b.iter(|| pool.install(|| bvh.refit(|_| 0.004)));
            });
        }
    }
}

fn gather(c: &mut Criterion) {
    let photons = on_walls(PHOTONS, 1);
    let mut group = c.benchmark_group("gather");
    group.sample_size(10).throughput(Throughput::Elements(PHOTONS as u64));
    for n in SIZES {
        for radius in RADII {
            let (mut bvh, _) = SphereBvh::build(&spheres_on_walls(n, radius));
            let mut sums = vec![0.0f64; n];
            for threads in THREADS {
                let pool = pool(threads);
                group.bench_function(BenchmarkId::new(format!("{n}/{radius}"), threads), |b| {
                    let add = |sum: &mut f64, _, point: usize| *sum += f64::from(photons[point].x);
                    b.iter(|| pool.install(|| bvh.gather(&photons, &mut sums, add)));
                });
            }
        }
    }
}

criterion_group!(benches, build, refit, gather);
criterion_main!(benches);
