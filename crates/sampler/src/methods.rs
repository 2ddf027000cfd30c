//! The methods: which question each answers, what it assumes, how it fails, and how you notice.
//!
//! A job asks for the probability that a sample is unstable, cell by cell. Only the inputs are random; the verdict on a
//! sample is deterministic. The methods differ in how much of the structure of the verdict they use.
//!
//! | method | question | assumptions | failure | how you notice |
//! |---|---|---|---|---|
//! | [independent samples](#independent-samples) | P of each cell, with an interval | none about the verdict | events rarer than a few per run give P = 0 | `p_high` stays well above 0 |
//! | [sequential looks](#sequential-looks) | P to a given precision, with as few samples as that needs | none about the verdict | `at_most` is reached first | `p_high - p_low` is wider than requested |
//! | [Sobol points](#sobol-points) | P with a narrower interval from as many samples | the unstable region has a boundary of finite length | no better than independent samples | `p_high - p_low` does not shrink faster than theirs |
//! | [verdict map](#verdict-map) | the same counts from far fewer simulations | two random inputs; boundaries visible on a grid | an island between grid points is looked up wrongly | the audit finds wrong verdicts |
//! | [integration](#integration) | P without sampling error | as for the map; over a map independent normal inputs | as for the map | the audit; bounds that are far apart |
//! | [bounds](#bounds-over-imprecise-inputs) | the least and the greatest P over intervals of the inputs | a boundary in closed form | a narrow extreme between the points of a search | the evidence is `searched` |
//! | [conditional probabilities](#conditional-probabilities) | P of rare events with many inputs | a boundary in closed form | few samples have most of P | `p_high` stays above 0 |
//! | [rare events](#rare-events) | P down to 1e-12 with many inputs and any criterion | populations of samples find all unstable regions | a small region is missed; weights scatter | P is null, `n_effective` is small |
//! | [derivatives](#derivatives) | slope of P by a parameter of the cell | independent normal inputs | few unstable or stable samples, small scatter | null, or a large standard error |
//! | [Sobol indices](#sobol-indices) | share of an input in the variance of the verdict | independent inputs | nearly all samples agree | null, or a large standard error |
//!
//! # Independent samples
//!
//! `method = "monte-carlo"`.
//!
//! **Assumptions.** None about the verdict. Any number of random inputs, with any marginal distributions and
//! correlations.
//!
//! **Cost.** `p (1 - p) / error^2` samples in each cell for a standard error `error`: four times as many for half the
//! error.
//!
//! **Interval.** By default Wilson's interval up to a confidence of 95 %; its coverage is right on average over `p`.
//! Beyond 95 %, and with `simultaneous = true`, Clopper and Pearson's interval, whose coverage is never below the
//! confidence and which is wider. `interval = "clopper-pearson"` selects the latter always
//! ([`IntervalKind`](crate::estimate::interval::IntervalKind)). The least coverage over all probabilities up to 0.05,
//! for 10,000 samples (`make coverage`):
//!
//! | confidence | Wilson, least coverage | Clopper-Pearson, least coverage |
//! |---|---|---|
//! | 0.80 | 0.714 at P = 2.1e-4 | 0.80 |
//! | 0.90 | 0.801 at P = 2.2e-5 | 0.90 |
//! | 0.95 | 0.838 at P = 1.8e-5 | 0.95 |
//! | 0.99 | not offered (0.889) | 0.99 |
//! | 0.999 | not offered (0.925) | 0.999 |
//!
//! Each interval holds for one cell: of 780 cells, about 39 miss the true probability at 95 %. `simultaneous = true`
//! widens the intervals (Bonferroni) until all hold together.
//!
//! **Failure.** If the event is so rare that the run is expected to contain only a few or none, `p_unstable` may be 0.
//! **How you notice.** `p_high` stays above 0: the probability may be as large as that. Undecided and failed samples
//! are not part of `p_unstable`, but widen `p_low` to `p_high`. An interval wider than the number of samples explains
//! comes with a large `n_undecided` or `n_failed`.
//!
//! # Sequential looks
//!
//! `until = { half_width = ... }` or `until = { relative = ... }`.
//!
//! **Assumptions.** None about the verdict. A cell is first looked at where a stop becomes possible, then after a
//! quarter more samples each time ([`Looks`](crate::estimate::looks::Looks)). It stops when half of the width of its
//! interval is at most `half_width`, or at most `relative` times the middle of the interval; with both, at whichever is
//! reached first.
//!
//! **Interval.** A plain interval that is computed again and again until it is narrow misses more often than it claims.
//! These intervals share the error among all looks (with `simultaneous = true` also among all cells), so that they hold
//! at whichever look a cell stops. They are about half again as wide as a single one from as many samples. If the
//! number of samples is known in advance, `samples` is therefore the better choice.
//!
//! **Estimate.** The share of unstable samples at a stop is biased: too low with `half_width` for rare events, as a
//! cell stops early when few of them have occurred; too high with `relative`. `p_unstable` is the unbiased estimate of
//! this design instead. It differs from the share where few samples are unstable.
//!
//! **With a verdict map** the half width is shared with the audit, which by default is made so large that half of the
//! half width remains for the counts. A relative precision cannot be combined with an audit and is refused.
//!
//! **Failure.** `at_most` (a million by default) is reached first. It can be raised later, like `samples`, as no look
//! depends on it. **How you notice.** `p_high - p_low` is wider than requested. With `relative` alone, every cell
//! without unstable samples uses all of `at_most`.
//!
//! # Sobol points
//!
//! `method = "sobol"`.
//!
//! **Assumptions.** The unstable region has a boundary of finite length. The points of each of 16 randomisations
//! (scrambled Sobol sequences) fill the space of the inputs evenly. With two inputs the error falls about like
//! `samples^-0.75`, with more inputs less fast.
//!
//! **Interval.** Student's interval, from the scatter of the randomisations
//! ([`randomisations`](crate::estimate::randomisations)). It is widened to include that of as many independent samples
//! where fewer than 30 samples (200 above 95 %) are on one side, or all randomisations agree. With one random input,
//! and wherever the counts of the randomisations differ by no more than one, a binomial interval takes its place.
//! Student's interval assumes normally distributed shares: at the confidence that a band over many cells needs
//! (`simultaneous = true`), it may miss twice as often as it claims.
//!
//! **Failure.** In the worst case the error is about that of independent samples. If the number of points is not a
//! power of two, most of the gain is lost. **How you notice.** `p_high - p_low` does not shrink faster than with
//! independent samples. The standard errors of `derivatives` are those of independent samples, which are too large
//! here.
//!
//! # Verdict map
//!
//! `evaluate = "boundary"`.
//!
//! **Assumptions.** Only preload and static friction scatter. Over the plane of these two the verdict is constant
//! except across curves that the grid of the [map](crate::verdict_map) sees: its points are 1/32 apart in both inputs
//! up to 1, and closer wherever verdicts differ. Four groups of samples are simulated: those within the resolution of a
//! curve (about 1e-5 of the coordinate), in unresolved boxes, in undecided regions, and beyond six standard deviations.
//!
//! **Result.** The counts of `evaluate = "each"` from a thousandth of the simulations. With `--map` the map serves any
//! other job of the same model, speed and criterion. With `sensitivity = true` the verdicts on the second set of
//! samples are looked up too, without an audit. With `kind = "eigenvalue"` the setting has no effect: the closed form
//! is as fast as a map.
//!
//! **Cost.** A map that costs more than the samples, less those of the audit, is given up. Every sample is then
//! simulated, also those by which the run is extended later, and a note on standard error says so. The decision depends
//! on the job alone: a verdict costs 1 plus the scaled time over which its motion is simulated, and the cost of all
//! needed tiles is compared with that of the samples, estimated from the first four samples of up to 64 cells.
//! `stickslip check` predicts both, in simulations and in seconds. A motion near a boundary may take more computing
//! than its scaled time suggests, so that a map can still take a second or more where the samples of a small job take
//! less.
//!
//! **Failure.** A region of another verdict lies between the points of the grid, and its samples are looked up wrongly.
//! Horizons so short that many samples are undecided make such regions: slivers beside boundaries.
//!
//! **How you notice.** By the audit. In each cell the first 300 looked-up samples (`audit = 300`, the default), or a
//! share of all of them (`audit = 0.01`), are simulated as a check, and count by their simulated verdict. If none of
//! `n` differs, the share of wrong verdicts is below `3 / n` with 95 % confidence ([`audit`](crate::estimate::audit)).
//! The column `p_audit` holds the share that the audit of a cell does not exclude. `p_low` and `p_high` contain it: the
//! error is divided equally between the counts and the audit. A larger audit makes `p_audit` smaller; `audit = 0`
//! trusts the map. If a single audited sample differs, the map is wrong somewhere: the command reports it and ends with
//! exit code 70 after it has written the result.
//!
//! # Integration
//!
//! `method = "exact"`.
//!
//! **Assumptions.** Those of the verdict map, and independent normal inputs. For `kind = "eigenvalue"` the boundary is
//! known in [closed form](crate::integrate::closed_form), and no map is needed; the error is about 1e-14 for relative
//! standard deviations above 0.01. There the inputs may also have [any distribution and correlation](crate::integrate::pair).
//!
//! **Result.** The probability without samples ([`integrate::verdict_map`](crate::integrate::verdict_map)), except for
//! those of the audit, which are drawn and simulated as above. `p_low` and `p_high` bound the numerical error: the
//! probability of all unknown verdicts (within the resolution of the curves, in undecided regions, beyond six standard
//! deviations) and, with the job's confidence, of what the audit does not exclude. `p_low + p_audit` and `p_high -
//! p_audit` are the numerical bounds alone. `p_undecided` is the probability of the undecided regions.
//!
//! **Failure.** As for the map. **How you notice.** By the audit. For relative standard deviations below about 1e-4 the
//! resolution of the curves is no longer small against the scatter, and `p_low` and `p_high` move apart.
//!
//! # Bounds over imprecise inputs
//!
//! `stickslip bounds`: the least and the greatest probability over quantities that are known as intervals or alternatives.
//!
//! **Assumptions.** The boundary is known in closed form (`kind = "eigenvalue"`, `method = "exact"`). Every combination of
//! values is possible.
//!
//! **Result.** Expected preload and static friction are at their ends ([`bounds`](crate::imprecise::bounds)). Standard
//! deviations of normal, independent inputs are found [with a proof](crate::imprecise::normal_inputs): a polynomial with
//! a bounded remainder on each of some boxes. All else is [searched](crate::imprecise::search) by an interpolation that
//! is refined until it agrees.
//!
//! **Failure.** A searched probability has an extreme that is narrower than the distance of the points. **How you
//! notice.** The evidence is `searched`.
//!
//! # Conditional probabilities
//!
//! `method = "conditional"`.
//!
//! **Assumptions.** The boundary is known in closed form for the brake of every sample (`kind = "eigenvalue"`). Any number
//! of random inputs, with any marginal distributions and correlations.
//!
//! **Result.** The mean of the [probabilities](crate::integrate::pair) over preload and static friction at scrambled Sobol
//! points of the other inputs, with an interval from the scatter of the randomisations
//! ([`conditional`](crate::estimate::conditional)).
//!
//! **Failure.** Where the other inputs decide, few points have most of the probability, and the method is little better
//! than Sobol points. **How you notice.** `p_high` stays near four over the number of points.
//!
//! # Rare events
//!
//! `method = "importance"` and `method = "subset"`.
//!
//! **Assumptions.** None about the verdict. Any marginal distributions and correlations of up to 31 inputs.
//!
//! **Result.** [Populations](crate::rare::population) of samples are led from an enlarged scatter to the unstable samples of
//! the true one. With `subset` the mean of their own estimates is the probability. With `importance` samples are drawn from
//! [densities](crate::rare::proposal) fitted to them, and count by their [weights](crate::estimate::weighted). With
//! `kind = "eigenvalue"`, preload or friction and further inputs, both integrate over preload and static friction at each
//! sample.
//!
//! **Failure.** A region that is small against the scatter may not be found by any population. **How you notice.** If some
//! find it, populations disagree; if a sample meets it, the effective number is small; both make P null. A region that
//! nothing meets is not noticed.
//!
//! # Derivatives
//!
//! `derivatives = true`: the derivatives of the probability by the expected values (at constant relative standard
//! deviation) and by the relative standard deviations. With `method = "exact"` they are integrated. With other methods
//! the score function estimates them from the same samples, with their standard errors
//! ([`score`](crate::estimate::score)).
//!
//! **Assumptions.** Independent normal inputs. A derivative is null for an input without scatter, whose score does not
//! exist; only the integrated eigenvalue criterion gives the derivative by its expected value. Undecided and failed
//! samples are left out: the derivative is that of the probability among decided samples.
//!
//! **Failure.** The standard error is proportional to `1 / std`, so that small scatter needs many samples. **How you
//! notice.** The standard errors. Derivative and error are null where fewer than 30 samples are unstable or fewer than
//! 30 stable.
//!
//! # Sobol indices
//!
//! `sensitivity = true`: first-order and total Sobol indices of the verdict (0 or 1), the shares of its variance `p (1
//! - p)` that are due to an input alone, and to which it contributes
//! ([`sobol_indices`](crate::estimate::sobol_indices)).
//!
//! **Assumptions.** Independent inputs; correlated ones are refused, as their variance has no such decomposition.
//!
//! **Cost.** `inputs + 1` further verdicts for each sample. A sample of which one of these is undecided or failed is
//! left out of the index and counted in `n_left_out_INPUT`.
//!
//! **Failure.** Indices mean little where nearly all samples agree: that of a probability of 0.001 needs 10^5 samples.
//! **How you notice.** The standard errors; the indices are null where all samples agree.
//!
//! # What no interval includes
//!
//! An interval holds for the model with the given criterion and parameters. It does not include how well the model
//! describes the brake. The eigenvalue criterion, for example, calls a brake stable that squeals after a disturbance.
//!
//! `stickslip compare` shows in how many samples two criteria or models differ
//! ([`difference`](crate::estimate::difference)). By default its intervals hold for all cells together. They share the
//! error among the looks of runs with `until`, and include what the audits of both runs do not exclude. For Sobol runs
//! they assume independent points, which makes them wider than necessary. Runs with the same seed share their deviates
//! and are compared sample by sample, even if their inputs have other distributions. Where that is impossible (another
//! number of random inputs), the interval holds for every dependence of the two runs. The paired difference of runs
//! with `until` is that of the observed shares, which are biased where few samples are unstable.
