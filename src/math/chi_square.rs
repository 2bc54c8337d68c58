//! For tests: do samples follow the density that they claim? Pearson's χ² over cells that pool those expecting few.

/// Independent uniform numbers in [0, 1), as the statistic wants them: two, and one more.
pub fn random(i: u32) -> ([f32; 2], f32) {
    let hash = |x: u32| {
        let mut x = x.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        for _ in 0..3 {
            x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
            x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
        }
        (x >> 8) as f32 / 16_777_216.0
    };
    ([hash(3 * i), hash(3 * i + 1)], hash(3 * i + 2))
}

/// χ² of counts against masses, normalised to a standard normal deviate (Wilson and Hilferty 1931); cells
/// expecting fewer than 5 are pooled.
pub fn deviate(counts: &[u32], masses: &[f64], samples: f64) -> f64 {
    let (mut chi2, mut cells, mut pool) = (0.0, 0.0, (0.0, 0.0));
    for (&count, mass) in counts.iter().zip(masses) {
        let expected = mass * samples;
        if expected < 5.0 {
            pool = (pool.0 + f64::from(count), pool.1 + expected);
        } else {
            chi2 += (f64::from(count) - expected).powi(2) / expected;
            cells += 1.0;
        }
    }
    if pool.1 >= 5.0 {
        chi2 += (pool.0 - pool.1).powi(2) / pool.1;
        cells += 1.0;
    }
    let k: f64 = f64::max(cells - 1.0, 1.0);
    ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

/// Judges `counts` of `samples` against the masses of a density in the same cells: no more mass than 1, no sample where
/// there is none, χ² within 6 standard deviations, and the same judge refuses a density `power` times as high.
pub fn judge(counts: &[u32], masses: &[f64], samples: u32, power: f64) -> Result<(), String> {
    accept(counts, masses, samples)?;
    let wrong: Vec<f64> = masses.iter().map(|m| m * power).collect();
    match accept(counts, &wrong, samples) {
        Err(_) => Ok(()),
        Ok(()) => Err(format!("a density {power} times as high would pass")),
    }
}

fn accept(counts: &[u32], masses: &[f64], samples: u32) -> Result<(), String> {
    let total: f64 = masses.iter().sum();
    if total > 1.003 {
        return Err(format!("the density integrates to {total}"));
    }
    if let Some(cell) = counts.iter().zip(masses).position(|(count, mass)| *count > 0 && *mass <= 0.0) {
        return Err(format!("{} samples in cell {cell} where the density is zero", counts[cell]));
    }
    let z = deviate(counts, masses, f64::from(samples));
    if z >= 6.0 { Err(format!("χ² deviates by {z} σ")) } else { Ok(()) }
}
