"""The verdict of a comparison: whether b is better, worse, the same, or not known."""

from pytest_lpb.run.paired import Figures, Measure

SIGNIFICANCE = 0.05
"""Adjusted p below which a difference is believed."""

EQUIVALENCE = 0.01
"""Half width of the zone of equivalence: share of the larger median; for success, in the rate itself."""

IDENTICAL_PAIRS = 5
"""So many identical pairs, and no other, say that two planners are the same."""

DECIDABLE_PAIRS = 6
"""With fewer pairs no two-sided exact test reaches 0.05: 2 / 2^5 is 0.0625."""

BETTER, WORSE, SAME, INCONCLUSIVE, NONE = "better", "worse", "same", "inconclusive", ""


def verdict(measure: Measure, figures: Figures, p_adjusted: float, contended: bool) -> str:
    """What the figures say about planner b.

    - empty: neither direction is better.
    - inconclusive: timing measured under contention, or fewer than 6 pairs (5 when all are identical).
    - same: every pair is identical; or p_adjusted >= 0.05 and the interval lies in the zone of equivalence.
    - better, worse: p_adjusted < 0.05 and the interval of the difference excludes 0 on that side.
    - inconclusive: anything else.
    """
    if measure.direction == "none":
        return NONE
    if contended and measure.timing:
        return INCONCLUSIVE
    if figures.identical:
        return SAME if figures.pairs >= IDENTICAL_PAIRS else INCONCLUSIVE
    if figures.pairs < DECIDABLE_PAIRS:
        return INCONCLUSIVE
    if p_adjusted < SIGNIFICANCE:
        return _side(measure, figures)
    return SAME if _equivalent(measure, figures) else INCONCLUSIVE


def _side(measure: Measure, figures: Figures) -> str:
    if figures.difference_low > 0:
        return BETTER if measure.direction == "higher" else WORSE
    if figures.difference_high < 0:
        return WORSE if measure.direction == "higher" else BETTER
    return INCONCLUSIVE


def _equivalent(measure: Measure, figures: Figures) -> bool:
    zone = EQUIVALENCE
    if not measure.is_rate:
        zone *= max(abs(figures.median_a), abs(figures.median_b))
    return figures.difference_low >= -zone and figures.difference_high <= zone
