//! What drt adds to Embree, and which way of asking it is the fastest.
//!
//! `cargo bench --bench embree -- INPUT [ISA] [low]` records the rays of a render of INPUT and traces them again, by a
//! loop in C over `rtcIntersect1`/`rtcOccluded1` ("bare"), by each way on its own ("single", "packet", "coherent"), and
//! through the backend with its gate, choice of way, names and settled edges ("drt"). Nanoseconds of CPU time a
//! ray: medians of rounds in which all of them take turns. The last column is drt's time over the bare loop's,
//! the median of the rounds' ratios.

use drt::accel::embree::Embree;
use drt::accel::embree::bare::Way;
use drt::accel::{BuildOptions, Coherence, Hits, Intersector, Mask, Quality, Rays};
use drt::diff::Kind;
use drt::diff::rays::record;
use drt::math::isa::Isa;
use rustix::time::{ClockId, clock_gettime};

const RAYS: u64 = 1 << 19;
const ROUNDS: usize = 9;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let Some(input) = words.first() else {
        return println!("usage: cargo bench --bench embree -- INPUT [ISA] [low]");
    };
    let isa = words.iter().find_map(|w| Isa::from_name(w).ok()).unwrap_or(Isa::best());
    let quality = if words.iter().any(|w| w == "low") { Quality::Low } else { Quality::Medium };
    let loaded = drt::load::scene(input.as_ref(), drt::load::Options::default()).expect("a readable input");
    let options = BuildOptions { quality, isa: Some(isa), ..BuildOptions::default() };
    let built = Embree::build(&loaded.scene.meshes, &options).expect("builds");
    let sets = record(&loaded.scene, &loaded.settings, &built, RAYS, &|| false).expect("renders");
    println!("{input}: {} triangles, {}, {}; ns a ray", loaded.scene.triangles(), isa.name(), quality.name());
    println!(
        "{:8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "", "rays", "bare", "single", "packet", "coherent", "drt", "drt/bare"
    );
    for set in sets.expect("nobody stops it") {
        let chunks: Vec<(Rays, Mask)> = set.chunks.iter().map(|c| (c.rays.clone(), c.mask)).collect();
        measure(&built, set.kind, set.coherence(), &chunks);
    }
}

fn measure(built: &Embree, kind: Kind, coherence: Coherence, chunks: &[(Rays, Mask)]) {
    let rays = built.bare(chunks).len();
    let mut times = vec![[0.0; 5]; ROUNDS];
    let mut hits = vec![Hits::default(); chunks.len()];
    for times in &mut times {
        let mut bare = built.bare(chunks);
        if kind == Kind::Shadow {
            times[0] = seconds(|| bare.occluded());
            for (way, time) in Way::ALL.into_iter().zip(&mut times[1..]) {
                *time = seconds(|| {
                    for (rays, mask) in chunks {
                        std::hint::black_box(built.occluded_by(way, rays.check(*mask)));
                    }
                });
            }
            times[4] = seconds(|| {
                for (rays, mask) in chunks {
                    std::hint::black_box(built.occluded(rays.check(*mask), coherence));
                }
            });
        } else {
            times[0] = seconds(|| bare.closest());
            for (way, time) in Way::ALL.into_iter().zip(&mut times[1..]) {
                *time = seconds(|| {
                    for ((rays, mask), hits) in chunks.iter().zip(&mut hits) {
                        built.closest_by(way, rays.check(*mask), hits);
                    }
                });
            }
            times[4] = seconds(|| {
                for ((rays, mask), hits) in chunks.iter().zip(&mut hits) {
                    built.closest(rays.check(*mask), coherence, hits);
                }
            });
        }
    }
    print!("{:8} {rays:8}", kind.name());
    for way in 0..5 {
        print!(" {:8.1}", median(times.iter().map(|t| t[way])) * 1e9 / rays as f64);
    }
    println!(" {:8.3}", median(times.iter().map(|t| t[4] / t[0])));
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn seconds(work: impl FnOnce()) -> f64 {
    let now = || {
        let t = clock_gettime(ClockId::ThreadCPUTime);
        t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
    };
    let start = now();
    work();
    now() - start
}
