//! Which method for which question: what each assumes, when it fails, and how a user notices.
//!
//! A job asks for the probability that a sample is unstable, cell by cell. The verdict on a sample is deterministic; only
//! the inputs are random. What differs between the methods is how much of that they use.
//!
//! # Independent samples: `method = "monte-carlo"`
//!
//! **Assumes** nothing of the verdict. Any number of random inputs, any marginal distribution and correlation.
//!
//! **Costs** `p (1 - p) / error^2` samples in each cell: four times as many for half of the error.
//!
//! **Interval**: up to a confidence of 95 % Wilson's ([`WilsonInterval`](crate::estimate::interval::WilsonInterval)), which is right on average
//! over `p`; beyond, and with `simultaneous = true`, Clopper and Pearson's, which is never short, and wider. `interval =
//! "clopper-pearson"` takes the latter always. How often they contain the true probability where they do worst, for 10,000
//! samples (`make coverage`):
//!
//! | confidence | Wilson, at worst | Clopper-Pearson, at worst |
//! |---|---|---|
//! | 0.80 | 0.714 at P = 2.1e-4 | 0.80 |
//! | 0.90 | 0.801 at P = 2.2e-5 | 0.90 |
//! | 0.95 | 0.838 at P = 1.8e-5 | 0.95 |
//! | 0.99 | not offered (0.889) | 0.99 |
//! | 0.999 | not offered (0.925) | 0.999 |
//!
//! Each holds for one cell: of 780 cells some 39 miss at 95 %. `simultaneous = true` widens them (Bonferroni) until all hold
//! together.
//!
//! **Fails** where the event is rarer than a few in the number of samples: `p_unstable` is then 0. **Notice**: `p_high`
//! stays above 0 and says how rare it has to be. Undecided and failed samples are in no `p_unstable`; they widen `p_low` to
//! `p_high`, so an interval wider than the number of samples explains has `n_undecided` or `n_failed` beside it.
//!
//! # Until precise enough: `until = { half_width }` or `until = { relative }`
//!
//! **Assumes** nothing more. Each cell is looked at first where a stop becomes possible, then after a quarter more samples
//! each time ([`Looks`](crate::estimate::sequential::Looks)), and stops when half of the width of its interval is at most `half_width`, or at most
//! `relative` times the middle of the interval; with both, at the first that is reached.
//!
//! A plain interval that is looked at again and again, until it looks good, misses more often than it says. These intervals
//! share the error among all looks (and with `simultaneous` among all cells), so they hold at whichever look a cell stops;
//! they are about half again as wide as a single one of as many samples. That is the price, and the reason why `samples` is
//! better where the number is known.
//!
//! The share of unstable samples at a stop is biased: with `half_width` too low for rare events, as a cell stops early when
//! few of them have come, with `relative` too high. So `p_unstable` is not that share but the unbiased estimate of this
//! design. It differs from the share where few samples are unstable.
//!
//! With a verdict map the half width is shared: its audit is made so large that half of it remains for the counts, unless
//! `audit` says otherwise. A relative precision cannot be kept beside an audit, and is refused.
//!
//! `at_most` (a million unless told) can be raised later, like `samples`: no look depends on it.
//!
//! **Fails** where `at_most` comes first. **Notice**: `p_high - p_low` is then wider than was asked for. With `relative`
//! alone, every cell without unstable samples takes `at_most`.
//!
//! # Sobol points: `method = "sobol"`
//!
//! **Assumes** that the unstable region is no wild set: a boundary of some length is enough. The points of each of 16
//! randomisations ([`ScrambledSobol`](crate::draw::sobol::ScrambledSobol)) fill the space of inputs evenly, and the error falls about
//! like `samples^-0.75` with two inputs, less fast with more of them.
//!
//! **Interval**: Student's, from the scatter of the randomisations ([`replicates`](crate::estimate::replicates)); where fewer than 30
//! samples (200 above 95 %) are on one side, or all randomisations agree, widened to include that of as many independent
//! samples. With one random input, and wherever the randomisations' counts differ by no more than one, a binomial interval takes the place of
//! Student's. Student's interval takes the randomisations' shares for normally distributed: at the confidence of a band over
//! many cells (`simultaneous`), a miss may be twice as frequent as it says.
//!
//! **Fails** softly: at worst it is about as good as independent samples. Numbers of points that are no power of two lose
//! most of the gain. **Notice**: `p_high - p_low` does not shrink faster than with independent samples. The standard errors
//! of `derivatives` are those of independent samples, and too large here.
//!
//! # Looked up: `evaluate = "boundary"`
//!
//! **Assumes** that only preload and static friction scatter, and that the verdict, over the plane of these two, is constant
//! but for curves which the grid of the map can see ([`crate::verdict_map::map`]: points 1/32 apart in both up to 1, and
//! closer wherever verdicts differ). Samples within the resolution of a curve (about 1e-5 of the coordinate), in boxes that
//! did not resolve, in undecided regions, and beyond six standard deviations are simulated themselves.
//!
//! A map that costs more than the samples, less those of the audit, is given up, and every sample simulated, as a note on
//! standard error says. That is decided by the job alone: a verdict costs 1 and the scaled time that its motion is followed;
//! those of all needed tiles are set against those of the samples, estimated from the first four of up to 64 cells.
//! `stickslip check` says beforehand what to expect, in simulations and in seconds. A motion near a boundary may take more
//! computing than its time suggests, so that a map can still take a second or more where the samples of a small job take
//! less. A run that gave its map up also simulates the samples by which it is extended.
//!
//! With `kind = "eigenvalue"` it changes nothing: the closed form decides as fast as a map would. With `sensitivity` the
//! verdicts on the second set of samples are looked up too, and not audited.
//!
//! **Gives** the counts of `evaluate = "each"` from a thousandth of the simulations, and serves with `--map` any other job
//! of the same model, speed and criterion.
//!
//! **Fails** where a region of another verdict lies between the points of the grid: its samples are looked up wrongly.
//! Horizons so short that many samples are undecided make such regions: slivers beside boundaries. **Notice**: the audit. Of
//! each cell the first looked-up samples, 300 unless told (`audit = 300`, or a share of all of them, `audit = 0.01`), are
//! simulated all the same; an audited sample counts by its simulated verdict. With none of `n` differing, the share of wrong
//! ones is below `3 / n` with 95 % confidence ([`audit`](crate::estimate::audit)). What the audit of a cell does not exclude is in the
//! column `p_audit`, and `p_low` and `p_high` contain it: the error is shared equally between the counts and the audit. A
//! larger audit makes it smaller; `audit = 0` takes the map for right. If a single audited sample differs, the map is wrong
//! somewhere: the command says so and ends with exit code 70, its result written.
//!
//! # Integrated: `method = "exact"`
//!
//! **Assumes** what the map does, and independent normal inputs; for `kind = "eigenvalue"` nothing, as its boundary is known
//! in closed form ([`exact`](crate::integrate::closed_form), error about 1e-14 for scatter above 0.01).
//!
//! **Gives** the probability without samples ([`mapped`](crate::integrate::mapped)), but for those of the audit, which are drawn and
//! simulated as above. `p_low` and `p_high` bound the numerical error (the measure of all that the map does not tell:
//! resolution of the curves, undecided regions, the plane beyond six standard deviations) and, with the job's confidence,
//! what the audit does not exclude. `p_high - p_audit` and `p_low + p_audit` are the numerical bounds alone. `p_undecided`
//! is the measure of the undecided regions.
//!
//! **Fails** as the map does. **Notice**: the audit. For scatter below some 1e-4 the resolution of the curves is no longer
//! small against it, and `p_low` to `p_high` widens.
//!
//! # Derivatives and Sobol indices
//!
//! `derivatives = true`: the slopes of the probability over the expected values (at constant relative standard deviation)
//! and over the relative standard deviations, exact where the probability is integrated, elsewhere by the score function
//! ([`score`](crate::estimate::score)) from the same samples, with their standard errors. They assume independent normal inputs and
//! are null for an input without scatter (whose score does not exist; of the eigenvalue criterion, integrated, the slope
//! over its expected value is still known). A score estimate scatters like `1 / std`: small scatter needs many samples.
//! Undecided and failed samples are left out by the quotient rule: the slope is that of the probability among decided
//! samples. Where fewer than 30 samples are unstable, or stable, slope and error are null.
//!
//! `sensitivity = true`: first-order and total Sobol indices of the verdict (0 or 1), the shares of its variance `p (1 - p)`
//! that an input explains alone, and takes part in. They take `inputs + 1` further verdicts for each sample; where one of
//! them is undecided or failed, the sample is left out of the index, and counted in `n_left_out_INPUT`. They are null where
//! all samples agree, and mean little where nearly all do: an index of a probability of 0.001 needs 10^5 samples. Correlated
//! inputs are refused: their variance has no such parts.
//!
//! # What no interval says
//!
//! How good the model is, with the criterion and the parameters given. The eigenvalue criterion calls a brake quiet that
//! squeals once disturbed; `stickslip compare` shows in how many samples ([`difference`](crate::estimate::difference)). Its intervals
//! hold for all cells together unless told otherwise, share the error among the looks of runs with `until`, and contain what
//! the audits of both runs do not exclude; those of Sobol runs take their points for independent samples, which is on the
//! safe side. Runs with the same seed share their deviates: they are paired, whatever the deviates become, and where that is
//! not possible (another number of random inputs) the interval holds however they depend on each other. Paired differences
//! of runs with `until` are those of the observed shares, which are biased where few samples are unstable.
