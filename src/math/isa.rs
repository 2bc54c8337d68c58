//! Run-time choice of the instruction set for the hot loops.
//!
//! A [`Kernel`] is compiled once per instruction set and run with the best one the machine has. Rust never
//! contracts a multiplication and an addition by itself, so the answers are the same bits on all of them;
//! only the speed differs. What a kernel calls must be `#[inline(always)]` to be compiled with it.

use crate::error::{Error, Result, unknown_word_advice};

/// An instruction set, in ascending order of width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// What every machine of the target has (SSE2 on x86-64).
    Baseline,
    /// AVX2, FMA, BMI (x86-64-v3).
    Avx2,
    /// AVX-512 F, VL, BW, DQ, CD (x86-64-v4).
    Avx512,
}

impl Isa {
    /// Every instruction set.
    pub const ALL: [Isa; 3] = [Isa::Baseline, Isa::Avx2, Isa::Avx512];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Isa::Baseline => "sse2",
            Isa::Avx2 => "avx2",
            Isa::Avx512 => "avx512",
        }
    }

    /// The best one this machine has.
    pub fn best() -> Isa {
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
            {
                if is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512vl")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512cd")
                {
                    return Isa::Avx512;
                }
                return Isa::Avx2;
            }
        }
        Isa::Baseline
    }

    /// The instruction set of that name, if this machine has it.
    pub fn from_name(name: &str) -> Result<Isa> {
        let known = Isa::ALL.map(Isa::name);
        let Some(isa) = Isa::ALL.into_iter().find(|i| i.name() == name) else {
            return Err(Error::usage(format!("unknown instruction set \"{name}\""))
                .advise(unknown_word_advice(name, &known)));
        };
        if isa > Isa::best() {
            return Err(Error::usage(format!("this machine has no {name}"))
                .advise(format!("its best is \"{}\"", Isa::best().name())));
        }
        Ok(isa)
    }
}

/// The instruction set that a kernel is being compiled for. Only [`run`] names one, and only after it has seen
/// that the machine has it: code that asks [`Set::ISA`] may rely on the answer.
pub trait Set: sealed::Sealed {
    /// Which one.
    const ISA: Isa;
}

/// The set that every machine has; anybody may name it.
pub type Everywhere = sealed::Baseline;

mod sealed {
    use super::{Isa, Set};

    pub trait Sealed {}

    macro_rules! sets {
        ($($name:ident)*) => {$(
            // Other machines have the first alone.
            #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code))]
            pub struct $name;
            impl Sealed for $name {}
            impl Set for $name {
                const ISA: Isa = Isa::$name;
            }
        )*};
    }
    sets!(Baseline Avx2 Avx512);
}

/// a·b + c, rounded once where the set has an instruction for it, else twice.
#[inline(always)]
pub fn fused<S: Set>(a: f32, b: f32, c: f32) -> f32 {
    if matches!(S::ISA, Isa::Baseline) { a * b + c } else { a.mul_add(b, c) }
}

/// A piece of hot code that [`run`] compiles per instruction set. Mark `run` `#[inline(always)]`.
pub trait Kernel {
    /// What it computes.
    type Output;
    /// Does the work.
    fn run<S: Set>(self) -> Self::Output;
}

/// Runs `kernel` compiled for `isa`, or for the best this machine has when that is less.
#[inline]
pub fn run<K: Kernel>(isa: Isa, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    #[allow(unsafe_code)]
    match isa.min(Isa::best()) {
        // SAFETY: `Isa::best` has just seen every feature that the function enables.
        Isa::Avx512 => return unsafe { run_avx512(kernel) },
        // SAFETY: as above.
        Isa::Avx2 => return unsafe { run_avx2(kernel) },
        Isa::Baseline => {}
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = isa;
    kernel.run::<sealed::Baseline>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<sealed::Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<sealed::Avx2>()
}
