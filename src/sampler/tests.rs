use super::*;

fn all() -> impl Iterator<Item = (&'static str, SamplerKind)> {
    SamplerKind::TABLE.iter().map(|row| (row.0, row.2))
}

/// Root mean square error of the mean of `f` over `n` samples, over 200 pixels, in the given dimensions.
fn rms(kind: SamplerKind, n: u32, dimension: u32, exact: f64, f: impl Fn([f32; 2]) -> f64) -> f64 {
    let sampler = Sampler::new(kind, 7, n);
    let error = |pixel: u32| {
        let mean =
            (0..n).map(|i| f(sampler.d2(sampler.key(pixel, i), dimension))).sum::<f64>() / f64::from(n);
        (mean - exact).powi(2)
    };
    ((0..200).map(error).sum::<f64>() / 200.0).sqrt()
}

/// Least-squares slope of log₂ error against log₂ N for N = 16 … 1024.
fn slope(kind: SamplerKind, dimension: u32, exact: f64, f: impl Fn([f32; 2]) -> f64 + Copy) -> f64 {
    let points: Vec<(f64, f64)> =
        (4..=10).map(|k| (f64::from(k), rms(kind, 1 << k, dimension, exact, f).log2())).collect();
    let n = points.len() as f64;
    let (mx, my) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    sxy / points.iter().map(|p| (p.0 - mx).powi(2)).sum::<f64>()
}

fn smooth(u: [f32; 2]) -> f64 {
    (f64::from(u[0]) * f64::from(u[1])).exp()
}
/// ∫∫ e^{xy} = Σ 1/(k!·(k+1)²).
const SMOOTH: f64 = 1.317_902_151_454_404;

fn edge(u: [f32; 2]) -> f64 {
    f64::from(u8::from(f64::from(u[0]) + 0.7 * f64::from(u[1]) < 0.9))
}
/// Area below x + 0.7·y = 0.9 in the unit square: ∫ min(1, 0.9 − 0.7y) dy.
const EDGE: f64 = 0.55;

/// The convergence gates: random −.5, stratified −1 and −.75, scrambled Sobol beyond −1.25 and −.67; in
/// the first dimensions and in padded ones.
#[test]
fn errors_fall_as_theory_says() {
    for dimension in [0, 2, 200] {
        let of = |kind, f: fn([f32; 2]) -> f64, exact| slope(kind, dimension, exact, f);
        assert!(of(SamplerKind::Random, smooth, SMOOTH) < -0.42);
        assert!(of(SamplerKind::Random, smooth, SMOOTH) > -0.60);
        assert!(of(SamplerKind::Stratified, smooth, SMOOTH) < -0.92);
        assert!(of(SamplerKind::Stratified, edge, EDGE) < -0.67);
        let sobol = of(SamplerKind::Sobol, smooth, SMOOTH);
        assert!(sobol < -1.25, "dimension {dimension}: {sobol}");
        assert!(of(SamplerKind::Sobol, edge, EDGE) < -0.67);
    }
}

/// Halton points at numbers of samples that are no powers of their bases: (2, 3), (5, 7); beyond the table they are Sobol's.
#[test]
fn halton_points_are_better_than_random_ones() {
    for (dimension, least) in [(0, -0.9), (2, -0.8), (200, -1.25)] {
        let smooth = slope(SamplerKind::Halton, dimension, SMOOTH, smooth);
        assert!(smooth < least, "dimension {dimension}: {smooth}");
        let edge = slope(SamplerKind::Halton, dimension, EDGE, edge);
        assert!(edge < -0.62, "dimension {dimension}: {edge}");
    }
}

/// Any b^k consecutive points from a multiple of b^k put one into each of b^k equal intervals.
#[test]
fn halton_points_are_stratified_in_their_bases() {
    let sampler = Sampler::new(SamplerKind::Halton, 11, 64);
    for (dimension, cells) in [(0, 64u32), (1, 81), (2, 125), (3, 49), (30, 127)] {
        for block in [0, cells, 77 * cells] {
            let mut seen = vec![false; cells as usize];
            for i in 0..cells {
                let bits = u64::from(sampler.bits(sampler.key(5, block + i), dimension));
                seen[((bits * u64::from(cells)) >> 32) as usize] = true;
            }
            assert!(seen.iter().all(|s| *s), "dimension {dimension}, block {block}");
        }
    }
}

/// Every sampler is uniform: chi-square over 64 cells of each dimension and over an 8×8 grid of pairs.
#[test]
fn numbers_are_uniform_in_every_dimension() {
    for (name, kind) in all() {
        let sampler = Sampler::new(kind, 3, 1);
        for dimension in [0, 1, 5, 63, 64, 1000] {
            let (mut line, mut grid) = ([0u32; 64], [0u32; 64]);
            for pixel in 0..64_000 {
                let key = sampler.key(pixel, 0);
                line[(sampler.d1(key, dimension) * 64.0) as usize] += 1;
                let [x, y] = sampler.d2(key, dimension);
                grid[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
            }
            for cells in [line, grid] {
                let chi2: f64 = cells.iter().map(|&c| (f64::from(c) - 1000.0).powi(2) / 1000.0).sum();
                // 63 degrees of freedom; 140 is beyond the 1 − 1e-7 quantile.
                assert!(chi2 < 140.0, "{name}, dimension {dimension}: {chi2}");
            }
        }
    }
}

/// Any block of 2^k Sobol samples puts one point in each of 2^k equal intervals, whatever the scramble.
#[test]
fn sobol_points_are_stratified() {
    let sampler = Sampler::new(SamplerKind::Sobol, 11, 64);
    for dimension in [0, 1, 7, 63, 70] {
        for block in [0u32, 64, 1024] {
            let mut seen = [false; 64];
            for i in 0..64 {
                seen[(sampler.d1(sampler.key(5, block + i), dimension) * 64.0) as usize] = true;
            }
            assert!(seen.iter().all(|s| *s), "dimension {dimension}, block {block}");
        }
    }
}

#[test]
fn strata_are_all_used_once() {
    for spp in [1u32, 2, 7, 16, 30, 64, 97] {
        let sampler = Sampler::new(SamplerKind::Stratified, 1, spp);
        let mut seen = vec![false; spp as usize];
        for i in 0..spp {
            seen[(f64::from(sampler.bits(sampler.key(9, i), 4)) / 4_294_967_296.0 * f64::from(spp))
                as usize] = true;
        }
        assert!(seen.iter().all(|s| *s), "spp {spp}");
    }
}

#[test]
fn seeds_pixels_indices_and_dimensions_all_matter() {
    for (name, kind) in all() {
        let draw = |seed, pixel, index, dimension| {
            let s = Sampler::new(kind, seed, 16);
            s.bits(s.key(pixel, index), dimension)
        };
        let base = draw(1, 2, 3, 4);
        for other in [
            draw(2, 2, 3, 4),
            draw(1 << 32 | 1, 2, 3, 4),
            draw(1, 3, 3, 4),
            draw(1, 2, 4, 4),
            draw(1, 2, 3, 5),
        ] {
            assert_ne!(base, other, "{name}");
        }
        assert_eq!(base, draw(1, 2, 3, 4), "{name}");
    }
}

/// What batches draw is what each sample draws by itself, within one block of indices and across blocks.
#[test]
fn numbers_of_batches_are_those_of_their_samples() {
    for (name, kind) in all() {
        let sampler = Sampler::new(kind, 5, 4096);
        for start in [0, 250, 4000] {
            let mut keys = Keys::<16>::ZERO;
            for lane in 0..16 {
                keys.set(lane, sampler.key(3 + lane as u32 / 5, start + lane as u32));
            }
            for dimension in [0, 3, 31, 62, 63, 64, 1 << 20] {
                let (bits, pairs) = (sampler.bits_of(&keys, dimension), sampler.d2_of(&keys, dimension));
                let singles = sampler.d1_of(&keys, dimension);
                for lane in 0..16 {
                    let key = keys.get(lane);
                    assert_eq!(bits[lane], sampler.bits(key, dimension), "{name}");
                    assert_eq!(singles[lane], sampler.d1(key, dimension), "{name}");
                    assert_eq!([pairs[0][lane], pairs[1][lane]], sampler.d2(key, dimension), "{name}");
                }
            }
        }
    }
}
