//! Which instruction set the lanes are compiled for, and how it is chosen.

/// An instruction set that lanes are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// What every processor of the architecture has (SSE2 on x86-64, NEON on aarch64).
    Baseline,
    /// AVX2, four lanes in a register.
    Avx2,
    /// AVX-512, eight lanes in a register.
    Avx512,
}

impl InstructionSet {
    /// Those that this processor has, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        [Self::Baseline, Self::Avx2, Self::Avx512].into_iter().filter(|set| set.is_available()).collect()
    }

    fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Baseline => {}
            Self::Avx2 => return std::arch::is_x86_feature_detected!("avx2"),
            Self::Avx512 => {
                return std::arch::is_x86_feature_detected!("avx512f")
                    && std::arch::is_x86_feature_detected!("avx512dq");
            }
        }
        self == Self::Baseline
    }

    /// The widest that this processor has.
    #[must_use]
    pub fn widest() -> Self {
        Self::available().pop().unwrap_or(Self::Baseline)
    }

    /// The name that manuals of processors give it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Baseline if cfg!(target_arch = "x86_64") => "SSE2",
            Self::Baseline if cfg!(target_arch = "aarch64") => "NEON",
            Self::Baseline => "baseline",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        }
    }
}

/// Compiles a function once for each instruction set and calls the one for `$set`: the same function, or one for each.
macro_rules! dispatch {
    ($set:expr, $body:path, $($argument:ident: $type:ty),*) => {
        dispatch!($set, $body, $body, $body, $($argument: $type),*)
    };
    ($set:expr, $baseline:path, $avx2:path, $avx512:path, $($argument:ident: $type:ty),*) => {{
        #[allow(unsafe_code, reason = "functions compiled for an instruction set, called if the processor has it")]
        #[inline(always)]
        fn choose(set: InstructionSet, $($argument: $type),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn avx2($($argument: $type),*) {
                    $avx2($($argument),*);
                }
                #[target_feature(enable = "avx512f,avx512dq")]
                fn avx512($($argument: $type),*) {
                    $avx512($($argument),*);
                }
                match set {
                    // SAFETY: `InstructionSet::available` lists a set only if the processor has it, and
                    // `TimeDomain::decide_all_with` and `TimeDomain::take_steps` refuse any other.
                    InstructionSet::Avx512 => return unsafe { avx512($($argument),*) },
                    // SAFETY: as above.
                    InstructionSet::Avx2 => return unsafe { avx2($($argument),*) },
                    InstructionSet::Baseline => {}
                }
            }
            #[cfg(not(target_arch = "x86_64"))]
            let _ = set;
            $baseline($($argument),*);
        }
        choose($set, $($argument),*);
    }};
}

pub(super) use dispatch;
