"""Statistics of planner comparisons: pure functions on arrays, with sources; randomness is an argument."""

from pytest_lpb.statistics.bootstrap import bootstrap_means, bootstrap_medians, percentile_interval
from pytest_lpb.statistics.intervals import effective_size, newcombe_paired_interval, wilson_interval
from pytest_lpb.statistics.loss import decided, deciding_pairs, loss_of_means, loss_of_rates
from pytest_lpb.statistics.multiple import holm
from pytest_lpb.statistics.paired import (
    discordant_counts,
    improvement_probability,
    mcnemar_p,
    paired_difference,
    ratio,
    wilcoxon_p,
)

__all__ = [
    "bootstrap_means",
    "bootstrap_medians",
    "decided",
    "deciding_pairs",
    "discordant_counts",
    "effective_size",
    "holm",
    "improvement_probability",
    "loss_of_means",
    "loss_of_rates",
    "mcnemar_p",
    "newcombe_paired_interval",
    "paired_difference",
    "percentile_interval",
    "ratio",
    "wilcoxon_p",
    "wilson_interval",
]
