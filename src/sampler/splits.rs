//! Into how many paths the samples of a pixel split at their first hit.
//!
//! By itself a picture's first [`PREVIEW`] samples take one path each: a preview costs no more than that. When more samples
//! are wanted they get the paths that they lack, in a wave of their own that traces their camera rays once more, so that
//! in the end all samples have as many, and the picture of 256 samples does not depend on whether there was one of 16.

/// Samples of a preview.
pub const PREVIEW: u32 = 16;

/// How many paths each sample of a pixel becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Splits {
    /// Every sample into so many.
    Each(u32),
    /// Those of a preview into one, as long as it is one; in larger pictures all into so many.
    Later(u32),
}

/// What a wave traces of its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Paths of each sample.
    pub paths: u32,
    /// The first one's branch; branch 0 goes on with the numbers of the sample itself.
    pub first: u32,
    /// What these paths count in the mean of the pixel.
    pub weight: f32,
    /// Whether the samples are there already, and get further paths.
    pub again: bool,
}

impl Splits {
    /// What is traced of samples when they are begun, of which the first is `index`. Waves never go across a preview's end.
    #[inline]
    pub fn begun(self, index: u32) -> Part {
        match self {
            Splits::Later(_) if index < PREVIEW => Part { paths: 1, first: 0, weight: 1.0, again: false },
            Splits::Later(n) => Part { paths: n, first: 1, weight: n as f32, again: false },
            Splits::Each(n) => Part { paths: n, first: u32::from(n > 1), weight: 1.0, again: false },
        }
    }

    /// What the samples of a preview lack when sample `index` is begun, if anything.
    pub fn lacking(self, index: u32) -> Option<Part> {
        match self {
            Splits::Later(n) if index == PREVIEW && n > 1 => {
                Some(Part { paths: n - 1, first: n + 1, weight: (n - 1) as f32, again: true })
            }
            _ => None,
        }
    }

    /// The number of a branch of sample `index`, from 1, among all paths of the pixel. Without gap: 16 paths of a preview,
    /// then those that its samples get later (branches from `n + 1`), then those of the other samples.
    #[inline(always)]
    pub fn number(self, index: u32, branch: u32) -> u64 {
        let (n, index, branch) = (u64::from(self.most()), u64::from(index), u64::from(branch));
        match self {
            Splits::Later(_) if branch > n => u64::from(PREVIEW) + (n - 1) * index + (branch - n - 1),
            _ => n * index + branch - 1,
        }
    }

    /// The most paths of a sample.
    pub fn most(self) -> u32 {
        let (Splits::Each(n) | Splits::Later(n)) = self;
        n
    }

    /// Paths of the first `samples`, when there are no more.
    pub fn before(self, samples: u32) -> u64 {
        match self {
            Splits::Later(_) if samples <= PREVIEW => u64::from(samples),
            Splits::Each(n) | Splits::Later(n) => u64::from(n) * u64::from(samples),
        }
    }

    /// What the first `samples` count together, when there are no more.
    pub fn total_weight(self, samples: u32) -> f64 {
        match self {
            Splits::Each(_) => f64::from(samples),
            Splits::Later(_) => self.before(samples) as f64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As waves ask: every path has a number of its own, and there is no gap, neither of a preview nor of more.
    #[test]
    fn paths_are_numbered_without_gap_and_weigh_alike() {
        for splits in [Splits::Each(2), Splits::Each(3), Splits::Later(1), Splits::Later(4), Splits::Later(7)]
        {
            let (mut numbers, mut weight) = (Vec::new(), 0.0);
            let mut trace = |samples: std::ops::Range<u32>, part: Part| {
                for index in samples {
                    let branches = part.first..part.first + part.paths;
                    let number = |b| if b == 0 { u64::from(index) } else { splits.number(index, b) };
                    numbers.extend(branches.map(number));
                    weight += f64::from(part.weight);
                }
                (numbers.len() as u64, weight)
            };
            for sample in 0..100 {
                if let Some(part) = splits.lacking(sample) {
                    trace(0..PREVIEW, part);
                }
                let done = trace(sample..sample + 1, splits.begun(sample));
                assert_eq!(done, (splits.before(sample + 1), splits.total_weight(sample + 1)), "{splits:?}");
            }
            numbers.sort_unstable();
            assert!(numbers.iter().copied().eq(0..splits.before(100)), "{splits:?} {numbers:?}");
        }
    }
}
