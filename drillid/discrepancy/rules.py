"""The engine's statistical thresholds in one table: value, meaning, source, and what pins it.

A value that follows from the stated error rate or from another rule is computed here. The others are choices: the
proof on sealed cases (`make blind`) measures their effect, and its scores, such as `false_alarm`, would change.
"""

from __future__ import annotations

from typing import Self

from scipy.special import ndtri


class Rule(float):
    """A number with its reasons; in use it behaves as the plain number.

    Parameters
    ----------
    value : the number, in units of log-likelihood for evidence
    meaning : what it decides
    source : derivation, reference or the consideration behind a choice
    pinned_by : the test that fails without it (file::name), or the scores of `make blind` that measure it
    """

    meaning: str
    source: str
    pinned_by: str

    def __new__(cls, value: float, meaning: str, source: str, pinned_by: str) -> Self:
        """The number with its reasons."""
        rule = super().__new__(cls, value)
        rule.meaning, rule.source, rule.pinned_by = meaning, source, pinned_by
        return rule


_DETECTORS = "tests/truth/discrepancy/test_detectors.py::"
_DRIVE = "tests/truth/discrepancy/test_drive_detectors.py::"
_ENGINE = "tests/truth/blind/test_engine.py::"
_PRODUCTS = "tests/truth/discrepancy/test_products.py::"
_POOLING = "tests/unit/discrepancy/test_pooling.py::"

# how the stated error rate is divided

CHANGES_SHARE = Rule(
    0.2,
    "share of a well's error rate given to interval changes; its sets of windows share the rest",
    "a fifth: a change is sought in two parameters, and the sets look for every cause",
    "tests/truth/discrepancy/test_intervals.py::test_a_well_spends_its_error_rate_once",
)
RESPONSES_SHARE = Rule(
    0.5,
    "share of the error rate given to the linear responses",
    "half: most causes show in them",
    "make blind: false_alarm, power_ratio",
)
DETECTIONS_SHARE = Rule(
    0.25,
    "share of the error rate that the detections share among them (Bonferroni)",
    "a quarter, so that a quarter is reserved: p-values come from draws and estimates",
    "make blind: false_alarm",
)
DATA_SHEET_SHARE = Rule(
    0.15,
    "share of the error rate given to causes beside which data sheets are believed that the base model rejects",
    "of the quarter that is reserved, as much as a law leaves",
    _ENGINE + "test_gains_are_named_though_one_of_them_is_stated_wrong",
)
LAW_SHARE = Rule(
    0.1,
    "share of the error rate given to the harmonics of the sweep's period, by which a law shows that is not linear",
    "a tenth, of the quarter that is reserved",
    "tests/truth/discrepancy/test_law_kinds.py::test_linear_rigs_seldom_show_a_law",
)
CLOSURE_RATE = Rule(
    0.01,
    "p-value below which an extended model fails the tests that the base model failed, and below which a detected "
    "cause leaves too much of the record unexplained",
    "a fifth of the usual error rate of 5 %: every name must pass, so that few right ones may fail",
    "make blind: second_pass_none; " + _ENGINE + "test_a_drift_that_the_catalogue_lacks_is_no_jump",
)

# causes over a fleet

WELL_DEVIATION = Rule(
    0.1,
    "standard deviation of a well from its rig's coordinates, relative to the tolerances of the data sheet",
    "a tenth: top drive, control and pipe go from well to well; what differs more shows as scatter",
    "tests/truth/common_causes/test_hierarchy.py::test_sizes_that_differ_between_wells_are_told_from_a_common_one",
)
LENGTH_DEVIATION = Rule(
    1.0,
    "standard deviation of a well's pipe from its rig's, by the waves' travel time, relative to the tolerance",
    "as its tolerance: one short window fits a pipe of another length as well now and then, far outside its error",
    "tests/truth/common_causes/test_fleets.py::test_a_well_that_took_another_length_does_not_accuse_the_rig",
)
SISTERS_SEE = Rule(
    3.0,
    "standard errors from which a size that a verdict names counts as denied by the data of the other wells",
    "as for the smallest size that a set detects",
    "tests/truth/common_causes/test_hierarchy.py::test_sisters_that_cannot_see_a_cause_contradict_nothing",
)

# detections in one window's record

CLEAR_DETECTION = Rule(
    4.0,
    "score from which a cause is subtracted from the record before the others are scored",
    "standard normal: 15 candidates in 1000 windows pass it by chance once in two",
    _DETECTORS + "test_scores_are_standard_normal_without_causes",
)
CHANGE_FOLLOWED = Rule(
    2.0,
    "score from which the whole course of a change in time is fitted",
    "5 % of windows without a change: the fit costs time and changes no error rate",
    _DETECTORS + "test_a_large_drift_shows_more_along_its_course_than_by_its_derivative",
)
TORQUE_STEP = Rule(
    5.5,
    "standard deviations from which a step of the torque at the bit is subtracted from a record",
    "two-sided p-value 4e-8 at each of some 30 000 samples: noise reaches it once in a thousand windows",
    _DETECTORS + "test_harder_rock_is_no_cause_and_hides_none",
)
LEAST_BLOCKS = Rule(
    6.0,
    "effective number of blocks below which a column has its energy in too little of the record to be scored",
    "Student's t with fewer degrees of freedom has tails that no score corrects for",
    _DETECTORS + "test_scores_are_standard_normal_without_causes",
)
LEAST_MISSING_SHARE = Rule(
    0.5,
    "amplitude that torque missing by a limit must be consistent with, 1 being all of it",
    "a limit withholds all of the missing torque: a smaller share is due to another cause",
    "make blind: detections_named",
)
MOST_MISSING_SHARE = Rule(
    4.0,
    "amplitude from which missing torque is due to another cause, 1 being all of it",
    "limits and plays that are tried lie so close that the nearest has an amplitude from 0.4 to 2.5",
    _DETECTORS + "test_hardly_any_missing_torque_is_no_evidence",
)
AMPLITUDE_REACH = Rule(
    3.0,
    "standard errors within which the amplitude must reach that share",
    "0.1 % of true amplitudes lie farther off",
    "make blind: detections_named",
)
UNEVEN_ROWS = Rule(
    2e-4,
    "standard deviation of the age of a record's samples, s, from which it hides jitter of the drive",
    "lines between samples at 22 ms, or a hold of 1 ms, make as much",
    _DETECTORS + "test_in_rows_of_random_ages_no_jitter_is_sought",
)
STAMPED_TO = Rule(
    1e-3,
    "jitter of the drive, s, below which it is not told from the clock that stamps the rows",
    "loggers stamp their rows to 1 ms",
    "tests/unit/discrepancy/test_pooling.py::test_a_jitter_finer_than_time_stamps_is_no_evidence",
)
STEPPED_ROWS = Rule(
    2e-3,
    "the same, s, from which rows in steps hide a slew of the drive",
    "lines between samples at 50 ms make less, a hold of 7 ms as much",
    _DRIVE + "test_rows_that_a_slower_control_wrote_are_no_slew",
)
LINE_KEPT = Rule(
    2.0,
    "log ratio above which a spectral line is kept for pooling over windows",
    "exponential in noise: one line in e² = 7 exceeds it; enough for pooling, at little storage",
    _DETECTORS + "test_windows_tell_a_faint_tone_together_unless_it_repeats_with_the_sweep",
)
IMAGES_RATE = Rule(
    0.01,
    "chance in noise below which strong lines, or those in one place beside all harmonics, are images of the sweep",
    "one set in a hundred without images needs a tone to stand out of its strongest lines of noise",
    "tests/unit/discrepancy/test_pooling.py::test_one_of_many_lines_of_all_heights_is_no_tone",
)
TONE_WITH_SIZE = Rule(
    2.0,
    "score from which a tone has a size, and is tested for motion of the rig",
    "2 % of windows without a tone: the strongest line of noise differs from window to window",
    _DETECTORS + "test_a_tone_is_a_line",
)
RESPONSE_MISSING = Rule(
    0.5,
    "share of the control's response that may be missing for a line to be motion of the rig",
    "half way between a tone of the recording alone, which has no response, and motion, which has all",
    _DETECTORS + "test_a_bit_that_sticks_and_slips",
)
ROUNDING_MATERIAL = Rule(
    1.0,
    "rounding noise relative to all other noise from which coarse quantisation is named",
    "rounding that doubles the noise; less of it costs less than half a window",
    _DETECTORS + "test_what_the_recorder_does",
)

SET_POINT_ERROR = Rule(
    5e-3,
    "standard uncertainty of the ratio of mean speed and set point in all windows of a set, beside their scatter",
    "a set point shown in whole rpm is rounded by up to 0.5 rpm: by 0.5 % at 100 rpm, the same in all windows",
    "tests/unit/discrepancy/test_set_point.py::test_rounding_that_all_windows_share_is_no_scale",
)

# pooling over windows

SCATTER_RATE = Rule(
    0.01,
    "p-value of the scatter between windows down to which their stated errors are accepted",
    "a higher threshold would enlarge errors, and cost power, in more than one set in a hundred",
    "make blind: coverage95",
)
LARGEST_COUNTEREVIDENCE = Rule(
    30.0,
    "largest evidence that a detection can give against a cause",
    "sizes from detections are rough: beyond e³⁰ only their errors would be tested",
    "make blind: accuracy_at_2x",
)
STUDENT_TAIL = Rule(
    3.0,
    "degrees of freedom of the windows' deviations from their set (Student's t)",
    "the heaviest tail with a variance (Lange, Little and Taylor 1989)",
    _PRODUCTS + "test_an_outlier_window_is_brought_back",
)
UNDERSTATED = Rule(
    0.1,
    "share of the tolerances of length and clock that are understated",
    "as much contamination as in Tukey's (1960) survey of sampling from contaminated normal distributions",
    _ENGINE + "test_a_length_or_clock_within_four_tolerances_is_no_cause",
)
UNDERSTATED_BY = Rule(
    2.0,
    "factor by which such a tolerance is too small",
    "tolerances are stated as one deviation or as two, and the one is mistaken for the other",
    _ENGINE + "test_a_length_or_clock_within_four_tolerances_is_no_cause",
)
NEIGHBOURS_SHARE_VARIANCE = Rule(
    1.15,
    "variance of sums of whitened errors relative to that of independent ones",
    "neighbouring lines share estimated variances; measured on simulated noise",
    "tests/unit/discrepancy/test_predictive_gain.py::test_the_lower_end_of_a_gain_holds_in_95_percent_of_sets",
)

# screen and search

TAIL = Rule(
    0.02,
    "share of draws beyond which the tail of a simulated null distribution is extrapolated as an exponential",
    "80 of 4000 draws: they determine the tail's scale to 11 %",
    "make blind: false_alarm",
)
LINEARITY = Rule(
    0.95,
    "correlation from which a cause's response at a size is as good as linear",
    "above it a second direction adds less than a tenth of the information",
    _ENGINE + "test_a_filter_whose_first_order_a_delay_hides_is_seen",
)
WIDE_PRIOR = Rule(
    5.0,
    "factor by which sizes may exceed the typical size: half of the prior is wider by it",
    "physical bounds lie at about five times the typical size",
    "make blind: accuracy_at_2x",
)
BOUND_REACHED = Rule(
    0.99,
    "share of a physical bound that counts as reaching it",
    "the fit converges to a size more closely",
    "make blind: wrong_family_confident",
)
FOLLOWED_WITHIN = Rule(
    8.0,
    "evidence behind the best within which causes are fitted non-linearly",
    "e⁻⁸ of the posterior is neglected",
    "make blind: accuracy_at_2x",
)
OBVIOUS_MISFIT = Rule(
    15.0,
    "linear evidence from which its ranking of the causes is not relied on and all are fitted",
    "the responses' second order is no longer negligible",
    _ENGINE + "test_an_obvious_cause_is_named_as_itself_or_its_exact_class",
)
CONTENDER = Rule(
    0.5,
    "share of the best evidence from which a cause is tried from other sizes too, where the misfit is obvious",
    "half of it: a local optimum seldom costs more",
    "make blind: accuracy_at_2x",
)
OUT_OF_REACH = Rule(
    20.0,
    "cost above the least known from which a fit is stopped, and cost of an extended model's pulls off the data sheet "
    "from which it explains nothing",
    "e⁻²⁰ of the posterior is neglected",
    "make blind: accuracy_at_2x; " + _ENGINE + "test_what_the_catalogue_lacks_has_no_name_of_another",
)
SHAPES_WITHIN = Rule(
    2.0,
    "evidence behind the best shape of a cause within which other shapes are fitted",
    "the accuracy of the linear evidence of shapes",
    _ENGINE + "test_where_a_string_changes_its_size_is_told_between_the_shapes_that_are_tried",
)
SHAPE_RESOLVED = Rule(
    1.0,
    "change of evidence by a step of a continuous shape below which the step is not halved further",
    "a step of one unit of log-likelihood is within the shape's own error",
    _ENGINE + "test_where_a_string_changes_its_size_is_told_between_the_shapes_that_are_tried",
)
OUTLIER_IMPROVEMENT = Rule(
    0.1,
    "fall of the cost from which outlier windows are searched for once more",
    "a tenth of a unit of log-likelihood changes no decision",
    _PRODUCTS + "test_an_outlier_window_is_brought_back",
)

# from evidence to names

EVEN_ODDS = Rule(
    0.5,
    "probability below which a verdict is likelier wrong than right",
    "by definition",
    "make blind: calibration_error",
)
CLASS_MASS = Rule(
    0.9,
    "posterior mass of the members of a class",
    "the class is right in nine of ten sets where its causes are indistinguishable",
    "make blind: accuracy_at_2x",
)
DISTINGUISHED_SHARE = Rule(
    0.95,
    "share of sets in which a test between two causes must be right for them to be distinguishable",
    "one less the usual error rate",
    "tests/unit/discrepancy/test_gather.py::test_two_courses_of_a_change_are_a_class_where_they_predict_nearly_the_same",
)
DISTINCT = Rule(
    2 * ndtri(DISTINGUISHED_SHARE),
    "standard deviations between two causes below which they count as indistinguishable",
    "at a distance d the test between them is right in a share Φ(d/2) of sets",
    "tests/unit/discrepancy/test_rules.py::test_derived_rules_follow_from_what_they_are_derived_from",
)
PAIR_FIRST_WITHIN = Rule(
    12.0,
    "evidence behind the best within which a cause is tried as the first of two",
    "farther behind, the second would have to make up for e¹²",
    _ENGINE + "test_what_one_of_two_causes_explains_is_no_rival_of_the_other",
)
LEFT_UNEXPLAINED = Rule(
    4.0,
    "evidence that may remain beside a cause before its name is withdrawn",
    "e⁴ = 55 to 1, less than the penalty of a second cause",
    _ENGINE + "test_what_the_catalogue_lacks_has_no_name_of_another",
)
LEFT_CHI2 = Rule(
    1.4,
    "χ² per residual that an extended model may leave, whatever it explained: else the cause is only the nearest known",
    "the most that an error of the noise estimate makes where the model is right",
    "tests/truth/discrepancy/test_closure.py::test_a_ripple_of_the_wall_is_unknown_however_much_a_cause_explains",
)
SHADOW_OF_EVIDENCE = Rule(
    0.02,
    "share of the evidence for a cause from the responses below which a detection beside it is a side effect",
    "models of causes are accurate to about 2 % of their effect",
    "make blind: second_pass_none",
)
SHADOW_OF_DETECTION = Rule(
    0.1,
    "evidence for a second detection, relative to the strongest, below which it counts as a side effect of that",
    "columns of detectors are first-order: accurate to about a third, so to a tenth in evidence",
    "make blind: detections_named",
)
NAMELESS_EVIDENCE = Rule(
    10.0,
    "evidence from which a detection without a name keeps the verdict that something is wrong",
    "e¹⁰ = 22 000 to 1, whatever its predictive gain on held-out data",
    _PRODUCTS + "test_a_misfit_without_a_sure_gain_is_unknown",
)
REJECTED_PULLS = Rule(
    8.0,
    "cost of the data sheet's pulls from which a model, extended or not, is rejected whatever its residuals",
    "13 tolerances of a value that no one measures, 6 of a length or clock: linear theory sees no pull so far out; "
    "fits judge the causes",
    _ENGINE + "test_a_length_that_fits_far_off_the_data_sheet_is_wrong_though_all_residuals_are_noise",
)
WRONG_VALUES = Rule(
    0.01,
    "share of the values that no one measures that are plainly wrong, by any factor",
    "one data sheet of twenty with five such values has one that belongs to another rig",
    _ENGINE + "test_values_off_together_are_wrong_though_no_cause_explains_them",
)
REJECTED_CHI2 = Rule(
    2.0,
    "χ² per residual from which a model, extended or not, is rejected, however rough the residuals are",
    "beyond any error of the noise estimate, which is within 0.74 to 1.4 even where it is wrong",
    _ENGINE + "test_residuals_far_above_the_noise_are_unknown_however_rough_they_are",
)
LARGEST_LOG_ODDS = Rule(
    12.0,
    "largest log odds of a stated probability",
    "sealed cases are far fewer than e¹²",
    "tests/unit/discrepancy/test_verdict.py::test_more_sure_stays_more_sure_and_a_probability_one",
)

# places and intervals

PLACE_CONFIDENCE = Rule(
    0.95,
    "probability that a stated place must have to lie within 5 % of the pipe of the true one",
    "the confidence of all stated intervals",
    "make blind: location_within_5pct; " + _PRODUCTS + "test_a_place_is_stated_where_the_noise_permits",
)
PLACE_TOLERANCE = Rule(
    0.05,
    "share of the pipe's length about its true place within which a stated one is to lie",
    "the length of a zone of local damping in the catalogue",
    "make blind: location_within_5pct",
)
PLACE_NEGLIGIBLE = Rule(
    12.0,
    "cost above the best place's from which another place is neglected",
    "e⁻¹² of the posterior over places is neglected",
    _PRODUCTS + "test_a_place_is_stated_where_the_noise_permits",
)
INTERVAL_EVIDENCE = Rule(
    3.0,
    "evidence that a beginning and an end in depth must add, beside the logarithm of the number of places tried",
    "the penalty of one more parameter (Akaike 1974), and e² = 7 to 1",
    "make blind: second_pass_none",
)
DETECTABLE = Rule(
    3.0,
    "standard deviations at which a cause counts as detectable in advance",
    "half of all sets pass an ideal test at 0.1 % there",
    _PRODUCTS + "test_every_measurement_helps_or_changes_nothing",
)
PART_READ = Rule(
    3.0,
    "standard errors from which a component of a missing immittance is reported",
    "0.1 % of components that are absent",
    _PRODUCTS + "test_nothing_is_read_where_nothing_is_missing",
)

RULES: dict[str, Rule] = {name: value for name, value in globals().items() if isinstance(value, Rule)}
"""Every rule by its name."""


def page() -> str:
    """The table as a page in Markdown."""
    lines = [
        "# Rules of the discovery engine",
        "",
        "Statistical thresholds, as `drillid/discrepancy/rules.py` has them. Evidence is in units of log-likelihood.",
        "A rule is pinned by a test, or by the scores of the sealed proof (`make blind`) that depend on it.",
        "",
        "| rule | value | decides | source | pinned by |",
        "|---|---|---|---|---|",
    ]
    for name, rule in RULES.items():
        lines.append(f"| {name} | {float(rule):.4g} | {rule.meaning} | {rule.source} | {rule.pinned_by} |")
    return "\n".join(lines) + "\n"
