//! The BVH on meshes and rays of random bits. Answers are in range whatever the numbers are; where no product of them
//! overflows or loses all of its digits, the f64 judge finds nothing wrong.

use drt::accel::brute::Brute;
use drt::accel::judge::{Judge, Tally};
use drt::accel::{Backend, BuildOptions, Coherence, Hits, Intersector, LANES, MISS, Mask, Quality, Rays};
use drt::math::isa::Isa;
use drt::shape::Mesh;
use std::sync::Arc;

/// Takes its decisions from bytes; zeros follow the last.
struct Bytes<'d>(&'d [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// Any bits at all, or, when `tame`, a coordinate of a grid with few places, on which coincidences are common.
    fn number(&mut self, tame: bool) -> f32 {
        match tame {
            true => f32::from(self.next() as i8) / 4.0,
            false => f32::from_bits(u32::from_le_bytes(std::array::from_fn(|_| self.next()))),
        }
    }

    fn point(&mut self, tame: bool) -> [f32; 3] {
        std::array::from_fn(|_| self.number(tame))
    }
}

/// The bytes are, in turn: options, vertices, triangles, rays.
pub fn run(data: &[u8]) {
    let bytes = &mut Bytes(data);
    let choice = bytes.next();
    let tame = choice & 1 == 0;
    let isas: Vec<Isa> = Isa::ALL.into_iter().filter(|isa| *isa <= Isa::best()).collect();
    let options = BuildOptions {
        quality: [Quality::Low, Quality::Medium, Quality::High][usize::from(choice >> 1) % 3],
        compact: choice & 8 != 0,
        isa: isas.get(usize::from(choice >> 4) % isas.len()).copied(),
        threads: 1,
        ..BuildOptions::default()
    };
    let positions: Vec<[f32; 3]> = (0..bytes.next() % 32).map(|_| bytes.point(tame)).collect();
    let count = if positions.is_empty() { 0 } else { bytes.next() % 64 };
    let corner = |bytes: &mut Bytes<'_>| u32::from(bytes.next()) % positions.len() as u32;
    let indices = (0..count).map(|_| std::array::from_fn(|_| corner(bytes))).collect();
    let meshes = [Arc::new(Mesh::new(positions, indices))];
    let mut rays = Rays::default();
    for lane in 0..LANES {
        let (o, d) = (bytes.point(tame), bytes.point(tame));
        let tmin = if tame { 0.0 } else { bytes.number(false) };
        let tmax = if tame { f32::INFINITY } else { bytes.number(false) };
        rays.set(lane, o.into(), d.into(), tmin, tmax);
    }
    let built = Backend::Bvh.build(&meshes, &options).expect("a hierarchy");
    judge(&meshes, &*built, &rays, tame);
}

fn judge(meshes: &[Arc<Mesh>], built: &dyn Intersector, rays: &Rays, tame: bool) {
    let checked = rays.check(Mask::MAX);
    let mut hits = Hits::default();
    built.closest(checked, Coherence::Incoherent, &mut hits);
    let blocked = built.occluded(checked, Coherence::Incoherent);
    for lane in (0..LANES).filter(|lane| checked.active() >> lane & 1 == 1 && hits.mesh[*lane] != MISS) {
        let mesh = meshes.get(hits.mesh[lane] as usize).expect("a mesh");
        assert!((hits.triangle[lane] as usize) < mesh.indices.len(), "no such triangle");
        assert!(!hits.t[lane].is_nan(), "no distance");
    }
    if !tame {
        return;
    }
    let hit = (0..LANES).fold(0, |mask, lane| mask | ((hits.mesh[lane] != MISS) as Mask) << lane);
    assert_eq!(blocked & checked.active(), hit & checked.active(), "occluded against closest");
    let mut truth = Hits::default();
    Brute::new(meshes).closest(checked, Coherence::Incoherent, &mut truth);
    let mut tally = Tally::default();
    Judge::thorough(meshes).compare(checked, &truth, &hits, &mut tally);
    assert_eq!(tally.real, 0, "{:#?}", tally.kept.first());
}
