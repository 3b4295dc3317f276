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
from pytest_lpb.statistics.profiles import performance_ratios, pointwise_band, shares_within
from pytest_lpb.statistics.stratified import interquartile_interval, interquartile_mean, stratified_weights

__all__ = [
    "bootstrap_means",
    "bootstrap_medians",
    "decided",
    "deciding_pairs",
    "discordant_counts",
    "effective_size",
    "holm",
    "improvement_probability",
    "interquartile_interval",
    "interquartile_mean",
    "loss_of_means",
    "loss_of_rates",
    "mcnemar_p",
    "newcombe_paired_interval",
    "paired_difference",
    "percentile_interval",
    "performance_ratios",
    "pointwise_band",
    "ratio",
    "shares_within",
    "stratified_weights",
    "wilcoxon_p",
    "wilson_interval",
]
