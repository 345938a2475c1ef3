"""Properties of one sensor's reads: mean and spread, the distribution of the noise, and dependence on earlier reads.

A correct noise model fails a statistical test with probability `statistics.ALPHA`. `bias_is_right` and `size_is_right` allow for
noise of the standard deviation that was asked for; `is_centred` allows for the spread that the reads have, `mean_bound` for the
larger of both. `Twins` are reads of instances with the same seed and one parameter changed: all else cancels in their difference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from grader.labs.imu import statistics as st
from grader.labs.imu.compare import Array, same

EXACT = 1e-9
"""Largest difference of equal numbers near one. Arithmetic without noise repeats to rounding; two random draws never do."""
TRUTH_ATOL = 1e-5
"""m/s², rad/s. How far the truth itself may be off: bundles recorded with another MuJoCo differ by 1.3e-7."""
_FINEST = 0.99e-4
"""m/s², rad/s. Smallest step of rounded readings that counts as lost precision."""
_SMOOTH = 0.5
"""Largest von Neumann ratio of a drift. White noise has 1 (± 0.04 for 600 values), a random walk of 100 reads less than 0.2."""
_UNLIKE_UNIFORM = 0.9
"""Standard deviations. Smallest bound that counts as clipping: between narrower ones, a truncated normal distribution has the
moments of a uniform one."""
_OFTEN = 0.52
"""Largest share of reads in noise that equal the one before: half of them if it is held for two reads, and a margin for chance."""
_LAGS = 16
"""Earlier reads of which a prediction of the next one is made: enough for a cycle of 16 values, or for a sum of eight sines."""
_PREDICTED = 0.1
"""Largest unpredictable part of a sequence, as a share of its spread, that is no noise: noise of its own has 1, and correlated
noise 0.4 (a share of 0.9 of the read before)."""
_CUT = 2.9
"""Standard deviations. All of 7,500 sound values stay within with a probability of (1 - 0.0037)^7500 = 7e-13."""


@dataclass(frozen=True)
class Reads:
    """Results of `NoisyIMU.read` for one sensor, many in each of several robot states; checks and diagnosis judge the properties.

    Attributes
    ----------
    residual : (states, reads, 3) ndarray, reading minus truth
    truth : (states, 3) ndarray, the readings without noise and bias
    std : the standard deviation of the noise that was asked for
    bias : (3,) ndarray, the bias that was given; if none was, the mean error of the reads in its place
    """

    residual: Array
    truth: Array
    std: float
    bias: Array

    # ---- mean and spread

    @cached_property
    def offset(self) -> Array:
        """Mean error (states, 3) of the reads in each state: the bias that they show."""
        return np.asarray(self.residual.mean(axis=1))

    @cached_property
    def centred(self) -> Array:
        """Errors (states, reads, 3) of the reads minus their mean in each state: the noise alone."""
        return np.asarray(self.residual - self.residual.mean(axis=1, keepdims=True))

    @cached_property
    def spread(self) -> Array:
        """Standard deviation (states, 3) of the reads, by state and axis."""
        return np.asarray(self.residual.std(axis=1))

    @cached_property
    def pooled_spread(self) -> float:
        return float(np.sqrt(np.mean(self.centred**2)))

    @cached_property
    def standardised(self) -> Array:
        """Noise (states × reads, 3) in units of its own standard deviation, to compare axes; zero for an axis without noise."""
        spread = np.where(self.spread > EXACT * self.std, self.spread, np.inf)
        return np.asarray((self.centred / spread[:, None, :]).reshape(-1, 3))

    @cached_property
    def increments(self) -> Array:
        """Differences (states, reads - 1, 3) of successive reads, which show drift and accumulated noise."""
        return np.diff(self.residual, axis=1)

    @cached_property
    def still(self) -> bool:
        """Return whether the reads in each state are all equal, as without noise or with one draw that is repeated."""
        return bool(np.all(self.spread <= EXACT * self.std))

    @cached_property
    def restless(self) -> bool:
        """Return whether reads often differ from the one before: noise that is held for two reads counts, a rare event does not."""
        return bool(np.quantile(np.abs(self.increments).max(axis=2), _OFTEN) > EXACT * self.std)

    @cached_property
    def unpredicted(self) -> float:
        """Random part: RMS error (m/s², rad/s) of predictions by up to 16 reads before; 0 if all are equal, or no fit exists."""
        if not 0 < self.pooled_spread < np.inf:
            return 0.0
        lags = min(_LAGS, self.residual.shape[1] // 4)
        scaled = self.centred / self.pooled_spread
        windows = np.lib.stride_tricks.sliding_window_view(scaled, lags + 1, axis=1).swapaxes(1, 2)
        of_channels = np.split(windows.reshape(-1, lags + 1), scaled.shape[0] * scaled.shape[2])
        try:
            gaps = [
                rows[:, -1] - rows[:, :-1] @ np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
                for rows in of_channels
            ]
        except np.linalg.LinAlgError:
            return 0.0
        return self.pooled_spread * float(np.sqrt(np.mean(np.square(gaps))))

    @cached_property
    def is_noise(self) -> bool:
        """Return whether reads are random: most differ from the one before and, unlike a counter's, cannot be predicted."""
        return self.restless and self.unpredicted > _PREDICTED * self.pooled_spread

    @cached_property
    def mean_bound(self) -> float:
        """Largest distance that chance explains between the mean of the reads in one state and its expected value.

        The diagnosis uses it to find the fault behind a wrong mean; `bias_is_right` decides whether the mean is wrong.
        """
        sigma = max(self.std, self.pooled_spread) if self.is_noise else self.std
        return st.mean_bound(self.residual.shape[1], sigma) + TRUTH_ATOL

    def offset_is(self, wanted: Array) -> bool:
        """Return whether the mean error in each state is the wanted one (3,) or (states, 3), within chance."""
        return bool(np.abs(self.offset - wanted).max() <= self.mean_bound)

    @cached_property
    def keeps_its_offset(self) -> bool:
        """Return whether the readings follow the truth from state to state: the mean error is the same in all, within chance."""
        return bool(np.ptp(self.offset, axis=0).max() <= 2 * self.mean_bound)

    @cached_property
    def bias_is_right(self) -> bool:
        """Return whether the mean error over all states is the given bias, within the chance of noise of the requested size."""
        return self._mean_is_bias(self.std)

    @cached_property
    def is_centred(self) -> bool:
        """Return whether the noise, also of another size than requested, has zero mean about the given bias, within chance."""
        return self._mean_is_bias(self.pooled_spread)

    def _mean_is_bias(self, sigma: float) -> bool:
        states, reads, _ = self.residual.shape
        bound = st.mean_bound(states * reads, sigma) + TRUTH_ATOL
        return bool(np.abs(self.offset.mean(axis=0) - self.bias).max() <= bound)

    @cached_property
    def size_is_right(self) -> bool:
        """Return whether the spread, pooled and on each axis, agrees with the standard deviation that was asked for.

        The variance that rounding adds, a twelfth of the squared step (Sheppard's correction), is subtracted. False without noise,
        and for steps of more than two standard deviations, which leave nothing of the noise to measure.
        """
        states, reads, axes = self.residual.shape
        per_axis = np.sqrt(np.maximum(np.mean(self.centred**2, axis=(0, 1)) - self.step**2 / 12, 0.0))
        for together, spreads in ((axes, np.array([np.sqrt(np.mean(per_axis**2))])), (1, per_axis)):
            low, high = st.spread_bounds(together * states * reads, together * states)
            if not np.all((low <= spreads / self.std) & (spreads / self.std <= high)):
                return False
        return self.is_noise and self.step <= 2 * self.std

    # ---- the law of the noise

    @cached_property
    def grain(self) -> float:
        """Step to which readings or their noise are rounded (for half-precision numbers, their spacing); 0 if neither is."""
        readings, noise = self.residual + self.truth[:, None, :], self.residual - self.residual[:, :1]
        if self.still:
            return 0.0
        with np.errstate(over="ignore"):  # half precision ends at 65504
            half = readings.astype(np.float16)
        spacing = float(np.spacing(np.abs(half).max())) if np.abs(readings - half).max() < EXACT else 0.0
        decimal = _step(noise)
        if decimal and abs(np.log10(decimal) - round(np.log10(decimal))) > EXACT:
            decimal = 0.0  # such as noise of two values only
        return max(spacing, self.step, decimal)

    @cached_property
    def step(self) -> float:
        """Step to which readings, and not their noise alone, are rounded; 0 if they are not, or if all are equal."""
        return 0.0 if self.still else _step(self.residual + self.truth[:, None, :])

    @cached_property
    def proportional(self) -> bool:
        """Return whether the spread grows in proportion to the reading, over axes and states, as by noise that is multiplied."""
        ratio = self.spread / np.abs(self.truth)
        return bool(ratio.std() < 0.1 * ratio.mean() and self.spread.std() > 0.2 * self.spread.mean())

    @cached_property
    def one_signed(self) -> bool:
        """Return whether the noise has one sign, as `abs(normal)` has: reads come close to truth plus bias from one side only."""
        if self.still:
            return False
        beside, edge = self.residual - self.bias, 0.05 * self.pooled_spread
        least, most = beside.min(axis=(0, 1)), beside.max(axis=(0, 1))
        return bool(np.all((least >= -TRUTH_ATOL) & (least < edge)) or np.all((most <= TRUTH_ATOL) & (most > -edge)))

    @cached_property
    def clipped(self) -> bool:
        """Return whether the noise is normal, of the size that was asked for, but cut off at some bound.

        The largest error must be 0.9 to 2.9 standard deviations, or extremes must repeat to the last digit. Spread and mean size of
        the errors must be those of normal noise that is clipped at the largest error, or drawn again beyond it.
        """
        cut = float(np.abs(self.centred).max()) / self.std
        if self.still or not (_UNLIKE_UNIFORM < cut < _CUT or self._repeats_extremes()):
            return False
        spread, mean = self.pooled_spread / self.std, float(np.abs(self.centred).mean()) / self.std
        laws = st.limited_moments(cut)
        return any(abs(spread / s - 1) < 0.04 and abs(mean / spread - m / s) < 0.012 for s, m in laws)

    def _repeats_extremes(self) -> bool:
        """Return whether at least four of the extreme values (largest and smallest of each axis and state) occur twice.

        By chance, one repeats with a probability of 1e-12 in double precision and 2e-4 in single precision; there, four of twelve
        repeat with 1e-12.
        """
        ranked = np.sort(self.residual, axis=1)
        again = np.stack([ranked[:, -1] == ranked[:, -2], ranked[:, 1] == ranked[:, 0]])
        return int(again.sum()) >= 4

    @cached_property
    def geary(self) -> float:
        """Geary's ratio, a test of normality (mean absolute over standard deviation), of the axes with noise; 0 if none has."""
        return st.geary(self._living) if self._living.size else 0.0

    @cached_property
    def _living(self) -> Array:
        return np.asarray(self.standardised[:, self.standardised.any(axis=0)].ravel())

    @cached_property
    def is_normal(self) -> bool:
        """Return whether the noise passes Geary's test of a normal distribution; True if no axis has noise.

        The ratio `geary` must lie within `statistics.geary_bounds`, which allow for chance.
        """
        if not self._living.size:
            return True
        low, high = st.geary_bounds(self._living.size)
        return low <= self.geary <= high

    # ---- what a read keeps of those before it

    @cached_property
    def accumulates(self) -> bool:
        """Return whether each read adds its noise to that of the read before: successive reads differ and correlate strongly."""
        return self.restless and bool(min(st.autocorrelation(state, 1).min() for state in self.centred) > 0.9)

    @cached_property
    def memory(self) -> float:
        """Largest absolute correlation of a read with one of the three before it, 0 if chance explains it; white noise has none."""
        by_lag = [np.abs(st.autocorrelation(state, lag)).max() for state in self.centred for lag in (1, 2, 3)]
        chance = self.still or max(by_lag) <= st.correlation_bound(self.residual.shape[1])
        return 0.0 if chance else float(max(by_lag))

    @cached_property
    def law_is_off(self) -> bool:
        """Return whether the noise is not white and normal: another distribution, one sign, cut off, or tied to earlier reads."""
        return self.memory > 0 or self.one_signed or self.clipped or not self.is_normal

    @cached_property
    def drifts(self) -> bool:
        """Return whether reads taken without noise drift: successive ones differ little beside the spread; False if all equal."""
        if self.still:
            return False
        return float(np.mean(self.increments**2) / (2 * np.mean(self.centred**2))) < _SMOOTH

    @cached_property
    def pairs(self) -> Array:
        """Differences (states, reads // 2, 3) of neighbouring reads, scaled by 1/√2 to the size of one read's noise."""
        even = self.residual.shape[1] // 2 * 2
        return np.asarray((self.residual[:, 1:even:2] - self.residual[:, 0:even:2]) / np.sqrt(2.0))

    @cached_property
    def paired(self) -> Reads:
        """These reads with differences of neighbours (`pairs`) as noise, so that a drifting bias does not spoil tests of noise."""
        return replace(self, residual=self.bias + self.pairs)


def _step(values: Array) -> float:
    """Return the largest step of which all values are multiples; 0 without one, or if it is finer than a rounding that counts."""
    apart = np.diff(np.unique(values))
    step = round(float(apart[apart > EXACT].min()), 15) if (apart > EXACT).any() else 1.0
    multiples = np.abs(values - (values / step).round() * step).max() < EXACT
    return step if step > _FINEST and multiples else 0.0


@dataclass(frozen=True)
class Twins:
    """Reads (reads, 3) of one sensor by instances with the same seed, so that only the effect of a changed argument differs.

    Attributes
    ----------
    base, again : two series with the same arguments
    other : a series with `change` (3,) added to the given bias
    scaled : a series with `factor` times the standard deviation
    """

    base: Array
    again: Array
    other: Array
    scaled: Array
    change: Array
    factor: float

    @cached_property
    def seeded(self) -> bool:
        """Return whether the same seed gives the same reads; if not, differences between the series mean nothing."""
        return same(self.base, self.again, EXACT)

    @cached_property
    def response(self) -> Array:
        """Difference (reads, 3) that the change of the bias makes in each read."""
        return np.asarray(self.other - self.base)

    def adds_bias(self) -> bool:
        """Return whether `change`, added to the given bias, changes every read by as much; False if not `seeded`."""
        return self.seeded and same(self.response, np.tile(self.change, (len(self.base), 1)), TRUTH_ATOL)

    def begins_with_bias(self) -> bool:
        """Return whether `change` adds as much to the first read (to 5 %): the test for a drifting bias; False if not `seeded`."""
        return self.seeded and same(self.response[0], self.change, 0.05 * float(np.abs(self.change).max()))

    def ignores_bias(self) -> bool:
        return self.seeded and not np.abs(self.response).max() > TRUTH_ATOL

    def noise_size(self) -> float:
        """Return the standard deviation of the noise of `base`, estimated from what larger noise adds; 0 if not `seeded`.

        A bias that moves is equal in `base` and `scaled` and cancels. From 40 reads on three axes the estimate is good to 10 %.
        """
        if not self.seeded:
            return 0.0
        added = np.diff(self.scaled - self.base, axis=0) / (self.factor - 1)
        return float(np.sqrt(np.mean(added**2) / 2))

    def scales(self) -> bool:
        """Return whether asking for `factor` times the noise multiplies most changes between reads by it; False if not `seeded`."""
        if not self.seeded:
            return False
        wanted, came = self.factor * np.diff(self.base, axis=0), np.diff(self.scaled, axis=0)
        differ = np.abs(wanted).max(axis=1) > TRUTH_ATOL
        return bool(differ.any() and np.median(np.abs(came - wanted).max(axis=1)[differ]) <= TRUTH_ATOL)


_NOTHING = np.full((1, 3), np.nan)
UNSEEDED = Twins(_NOTHING, _NOTHING, _NOTHING, _NOTHING, _NOTHING[0], 1.0)
"""Twins without reads, for a sensor that needs none: `seeded` is False."""
