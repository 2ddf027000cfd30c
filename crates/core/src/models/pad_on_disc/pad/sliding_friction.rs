//! The friction of a pad as integration steps evaluate it.

use crate::friction::shape::Shape;
use crate::numerics::row::{Number, numbers};

numbers! {
    /// A friction law with its coefficients, or with all of them multiplied by the contact force.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct SlidingFriction<N> {
        pub shape: Shape,
        /// v.
        pub disc_speed: N,
        /// 1 / v_s, or over another speed scale of the law.
        pub inverse_stribeck: N,
        /// Of Stribeck's law.
        pub exponent: N,
        /// f_c, f_s - f_c and e.
        pub kinetic: N,
        pub falling: N,
        pub additional: N,
    }
}

impl<N: Number> SlidingFriction<N> {
    /// mu s at the pad's speed `u`. The `direction` is 1 in slip and -1 where the pad overtakes the disc.
    #[inline(always)]
    pub fn at(&self, u: N, direction: f64) -> N {
        let direction = N::splat(direction);
        let r = direction * (self.disc_speed - u) * self.inverse_stribeck;
        let (a, b) = self.shape.parts(r, self.exponent);
        direction * (self.kinetic + self.falling * a + self.additional * b)
    }
}
