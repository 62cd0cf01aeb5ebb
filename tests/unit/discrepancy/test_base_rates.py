"""Base rates turn evidence into probabilities, and do not enter the evidence."""

import numpy as np
import pytest

from drillid.config.settings import Settings
from drillid.discrepancy.base_rates import BaseRates, stated_base_rates
from drillid.discrepancy.catalogue import CATALOGUE
from drillid.errors import SettingsError


def test_even_base_rates_share_the_prior_among_all_causes() -> None:
    rates = BaseRates()
    assert rates.probability(["drive_lag"], float(np.log(len(CATALOGUE)))) == pytest.approx(0.5)
    assert rates.probability(CATALOGUE, 0.0) == pytest.approx(0.5)
    assert np.exp(rates.pair_penalty) == pytest.approx(8 * (len(CATALOGUE) - 1))


def test_where_only_some_causes_may_be_wrong_these_share_the_prior() -> None:
    rates = BaseRates(weights={"drive_lag": 3.0}).among(["drive_lag", "clock_offset"])
    assert rates.probability(["drive_lag", "clock_offset"], 0.0) == pytest.approx(0.5)
    assert rates.probability(["drive_lag"], 0.0) == pytest.approx(3 / 7)


def test_posterior_odds_are_those_of_the_evidence_times_the_base_rates() -> None:
    stated = {"discrepancy": {"base_rate": 0.1, "cause_weights": {"drive_lag": 5.0}}}
    rates = stated_base_rates(Settings.checked(stated, "test").discrepancy)
    prior = 0.1 / 0.9 * 5 / (5 + len(CATALOGUE) - 1)
    for log_evidence in (-2.0, 0.0, 3.0):
        probability = rates.probability(["drive_lag"], log_evidence)
        assert probability / (1 - probability) == pytest.approx(prior * np.exp(log_evidence))


def test_a_weight_of_no_cause_is_refused_with_the_likely_name() -> None:
    stated = Settings.checked({"discrepancy": {"cause_weights": {"drive_lags": 2.0}}}, "test")
    with pytest.raises(SettingsError, match="Did you mean 'drive_lag'"):
        stated_base_rates(stated.discrepancy)
