//! Critical products of preload and friction slope, kept once found.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError, RwLock};

/// Critical products on the lattice, found when they are first needed. Each is a function of the brake alone.
#[derive(Debug, Clone, Default)]
pub(crate) struct CriticalProducts {
    corners: Arc<RwLock<Corners>>,
}

/// By their place on the lattice: along the logarithm of the preload and along the friction coefficient.
type Corners = HashMap<(i64, i64), Option<f64>>;

impl CriticalProducts {
    /// The critical product at a corner, which `find` finds unless it `is_stopped`. What it returns then is not kept.
    pub fn at(
        &self,
        corner: (i64, i64),
        find: impl FnOnce() -> Option<f64>,
        is_stopped: &dyn Fn() -> bool,
    ) -> Option<f64> {
        let known = self.corners.read().unwrap_or_else(PoisonError::into_inner).get(&corner).copied();
        known.unwrap_or_else(|| {
            let found = find().filter(|_| !is_stopped());
            if !is_stopped() {
                self.corners.write().unwrap_or_else(PoisonError::into_inner).insert(corner, found);
            }
            found
        })
    }
}
