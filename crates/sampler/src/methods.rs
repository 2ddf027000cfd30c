//! Which method for which question: what each assumes, when it fails, and how a user notices.
//!
//! A job asks for the probability that a sample is unstable, cell by cell. The verdict on a sample is deterministic; only the
//! inputs are random. What differs between the methods is how much of that they use.
//!
//! # Independent samples: `method = "monte-carlo"`
//!
//! **Assumes** nothing of the verdict. Any number of random inputs, any marginal distribution and correlation.
//!
//! **Costs** `p (1 - p) / error^2` samples in each cell: four times as many for half of the error.
//!
//! **Interval**: Wilson's ([`WilsonInterval`](crate::WilsonInterval)) is right on average over `p`, and may fall a little short
//! at a given one; `interval = "clopper-pearson"` is never short, and wider. Each holds for one cell: of 780 cells some 39
//! miss at 95 %. `simultaneous = true` widens them (Bonferroni) until all hold together.
//!
//! **Fails** where the event is rarer than a few in the number of samples: `p_unstable` is then 0. **Notice**: `p_high` stays
//! above 0 and says how rare it has to be. Undecided and failed samples are in no `p_unstable`; they widen `p_low` to
//! `p_high`, so an interval wider than the number of samples explains has `n_undecided` or `n_failed` beside it.
//!
//! # Until precise enough: `until = { half_width, confidence, at_most }`
//!
//! **Assumes** nothing more. Each cell is looked at after 1000 samples, then after a quarter more each time
//! ([`Looks`](crate::Looks)), and stops when its interval is narrow enough.
//!
//! A plain interval that is looked at again and again, until it looks good, misses more often than it says. These intervals
//! share the error among all looks (and with `simultaneous` among all cells), so they hold at whichever look a cell stops; they are about half again as wide as a
//! single one of as many samples. That is the price, and the reason why `samples` is better where the number is known.
//!
//! Looks depend on `at_most`: a run cannot be extended to a larger one, only made anew.
//!
//! **Fails** where `at_most` comes first. **Notice**: `p_high - p_low` is then wider than twice the `half_width`.
//!
//! # Sobol points: `method = "sobol"`
//!
//! **Assumes** that the unstable region is no wild set: a boundary of some length is enough. The points of each of 16
//! randomisations ([`ScrambledSobol`](crate::ScrambledSobol)) fill the space of inputs evenly, and the error falls about like
//! `samples^-0.75` with two inputs, less fast with more of them.
//!
//! **Interval**: Student's, from the scatter of the randomisations ([`replicates`](crate::replicates)); where fewer than 30
//! samples are on one side, or all randomisations agree, widened to include that of as many independent samples.
//!
//! **Fails** softly: at worst it is about as good as independent samples. Numbers of points that are no power of two lose most
//! of the gain. **Notice**: `p_high - p_low` does not shrink faster than with independent samples. The standard errors of
//! `derivatives` are those of independent samples, and too large here.
//!
//! # Looked up: `evaluate = "boundary"`
//!
//! **Assumes** that only preload and static friction scatter, and that the verdict, over the plane of these two, is constant
//! but for curves which the grid of the map can see
//! ([`stickslip_core::verdict_map`]: points 1/32 apart in both up to 1, and closer wherever verdicts differ). Samples within
//! the resolution of a curve (about 1e-5 of the coordinate), in boxes that did not resolve, in undecided regions, and beyond
//! six standard deviations are simulated themselves.
//!
//! A map that costs more than the samples is given up, and every sample simulated, as a note on standard error says. That is
//! decided by the job alone: by the verdicts that all needed tiles take together, against those that the samples take; one that
//! ends at the horizon counts for a tenth of that horizon, at least for one. `stickslip check` says beforehand what to expect.
//! Samples are not all alike: those near a boundary, which a map asks for, take longer. So a map may still take more time than
//! the samples of a small job; it pays from some hundred thousand samples on. A run that is extended says of its first samples
//! how they were judged then.
//!
//! With `kind = "eigenvalue"` it changes nothing: the closed form decides as fast as a map would. With `sensitivity` the
//! verdicts on the second set of samples are looked up too, and not audited.
//!
//! **Gives** the counts of `evaluate = "each"` from a thousandth of the simulations, and serves with `--map` any other job of the
//! same model, speed and criterion.
//!
//! **Fails** where a region of another verdict lies between the points of the grid: its samples are looked up wrongly. Horizons
//! so short that many samples are undecided make such regions: slivers beside boundaries.
//! **Notice**: the audit. A seeded share of the looked-up samples (`audit`, 0.0001 unless told) is simulated all the same;
//! `n_audit_differed` above 0 in any cell, and a warning, mean that the map is wrong somewhere. With none of `n` differing, the
//! share of wrong ones is below `3 / n` with 95 % confidence ([`audit`](crate::audit)); a larger `audit` says more. An audited
//! sample counts by its simulated verdict.
//!
//! # Integrated: `method = "exact"`
//!
//! **Assumes** what the map does, and independent normal inputs; for `kind = "eigenvalue"` nothing, as its boundary is known in
//! closed form ([`exact`](crate::exact), error about 1e-14 for scatter above 0.01).
//!
//! **Gives** the probability without samples ([`mapped`](crate::mapped)). `p_low` and `p_high` bound the numerical error: the
//! measure of all that the map does not tell (resolution of the curves, undecided regions, the plane beyond six standard
//! deviations), not a confidence. `p_undecided` is the measure of the undecided regions.
//!
//! **Fails** as the map does. There are no samples to audit: run a job with `evaluate = "boundary"` on the same map. **Notice**,
//! for scatter below some 1e-4: the resolution of the curves is then no longer small against it, and `p_low` to `p_high` widens.
//!
//! # Derivatives and Sobol indices
//!
//! `derivatives = true`: the slopes of the probability over the expected values (at constant relative standard deviation) and
//! over the relative standard deviations, exact where the probability is integrated, elsewhere by the score function
//! ([`score`](crate::score)) from the same samples, with their standard errors. They assume independent normal inputs and are
//! null for an input without scatter (whose score does not exist; of the eigenvalue criterion, integrated, the slope over its
//! expected value is still known). A score estimate scatters like `1 / std`: small scatter needs many samples.
//!
//! `sensitivity = true`: first-order and total Sobol indices of the verdict (0 or 1), the shares of its variance `p (1 - p)` that
//! an input explains alone, and takes part in. They take `inputs + 1` further verdicts for each sample. They are null where
//! all samples agree, and mean little where nearly all do: an index of a probability of 0.001 needs 10^5 samples.
//!
//! # What no interval says
//!
//! How good the model is, with the criterion and the parameters given. The eigenvalue criterion calls a brake quiet that squeals
//! once disturbed; `stickslip compare` shows in how many samples. Its intervals share the error among the looks of runs with
//! `until`; those of Sobol runs take their points for independent samples, which is on the safe side.
