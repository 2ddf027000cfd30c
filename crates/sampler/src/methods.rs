//! [choice]: crate#which-door-to-open
//! [limits]: crate::limits
//! [versions]: crate::draw::identity::RESULTS_VERSION
//! [comparison]: crate::estimate::difference
// Links of the page lead to other pages of the site, and here, where the first definition counts, into this crate.
#![doc = include_str!("../METHODS.md")]
