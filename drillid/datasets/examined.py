"""Schemas of the stage discrepancy's datasets."""

from drillid.datasets.declaration import DatasetSchema, Variable, each
from drillid.datasets.measured import (
    AT_FREQUENCIES,
    IN_WINDOWS,
    MOBILITY,
    WINDOW_COORDINATES,
    WINDOW_FREQUENCY,
    row_key,
)

DISCREPANCIES = DatasetSchema(
    "What the fitted models leave unexplained",
    {
        **IN_WINDOWS,
        **AT_FREQUENCIES,
        "key": row_key("window"),
        "whitened_residual": Variable(
            WINDOW_FREQUENCY,
            "complex128",
            "1",
            "measured less fitted mobility, in standard deviations of its real or imaginary part",
        ),
        **each(
            ("window",),
            chi2_p_value=("1", "p-value of chi-squared under the fitted model"),
            normality_p_value=("1", "p-value of the residuals' Gaussian distribution (Kolmogorov–Smirnov)"),
            whiteness_p_value=("1", "p-value of the residuals' independence over frequency (Ljung–Box)"),
            damping_pull=("1", "BHA damping less its run's level, in standard deviations"),
            inertia_pull=("1", "BHA inertia less its run's level, in standard deviations"),
        ),
        "flagged": Variable(
            ("window",),
            "bool",
            "",
            "BHA damping or inertia is significantly above the level of its run, in the window or on both sides of it",
        ),
        "verdict": Variable(("window",), "str", "", "what the simulation gets wrong, from the window's set"),
    },
    WINDOW_COORDINATES[1:],
)

_AT_SIZES = ("set", "part", "candidate", "held")
_SC, _SP, _SF = ("set", "cause"), ("set", "port"), ("set", "frequency")
EXAMINATIONS = DatasetSchema(
    "What the discovery engine found in each set of windows, and the extended models",
    {
        **IN_WINDOWS,
        **AT_FREQUENCIES,
        "set": Variable(("set",), "int32", "", "number of the set in its well"),
        "key": row_key("set"),
        "cause": Variable(("cause",), "str", "", "cause of the catalogue"),
        "cause_": Variable(("cause_",), "str", "", "second axis of the distinguishability matrix"),
        "port": Variable(("port",), "str", "", "where an unknown disturbance may act: ports, pipe and data sheets"),
        "parameter": Variable(("parameter",), "str", "", "parameter of the transmission-line model"),
        "coordinate": Variable(
            ("coordinate",), "str", "", "coordinate that describes a window before causes are added"
        ),
        "window_set": Variable(("window",), "int32", "", "set of the window; -1 where it has no fit"),
        "verdict": Variable(("set",), "str", "", "verdicts on the set"),
        "advice": Variable(("set",), "str", "", "the one further measurement that would help most"),
        "fingerprint": Variable(
            ("set",),
            "str",
            "",
            "best fit of every element of learnt extensions to the same data, JSON; empty if nothing was learnt",
        ),
        **each(
            ("set",),
            from_m=("m", "hole depth at which the set begins"),
            to_m=("m", "hole depth at which it ends"),
            p_value_before=("1", "p-value of the evidence for any cause, if nothing is wrong"),
            p_value_after=("1", "the same for the extended model"),
            law_memory=("s", "memory of the learnt law of the bit; NaN where no law is offered"),
            coupling_place=("1", "share of the string above the coupling whose law was learnt; NaN without one"),
        ),
        **each(
            _SC,
            log_evidence=("1", "log Bayes factor of the cause by the linear responses"),
            detection_log_evidence=(
                "1",
                "upper bound on the log Bayes factor of the cause, from the p-value of its detections",
            ),
            detection_p_value=("1", "p-value of the detections in the absence of the cause"),
            smallest_detectable=("", "size of three standard deviations, in the cause's unit"),
            typical_size=("", "usual size of the cause, in its unit"),
        ),
        "unknown_evidence": Variable(_SP, "float64", "1", "log Bayes factor of an unknown disturbance that acts there"),
        "candidate": Variable(
            ("candidate",), "str", "", "cause that wells may have in common, with the shape where it has several"
        ),
        "shared_sizes": Variable(("set", "candidate", "held"), "float64", "", "sizes at which the candidate is held"),
        "shared_coordinates": Variable(
            ("set", "candidate", "held", "rig_coordinate"),
            "float64",
            "1",
            "the rig's coordinates fitted there, less those of its data sheets, scaled",
        ),
        "shared_value": Variable(
            _AT_SIZES, "float64", "1", "log-likelihood there, of the mobilities and of the control's responses"
        ),
        "shared_score": Variable((*_AT_SIZES, "rig_coordinate"), "float64", "1", "its score in the rig's coordinates"),
        "shared_information": Variable(
            (*_AT_SIZES, "rig_coordinate", "rig_coordinate_"), "float64", "1", "its information, without any prior"
        ),
        "shared_directions": Variable(
            ("set", "part", "direction", "direction_"),
            "float64",
            "",
            "information of the rig's coordinates and of two changes of the responses by each candidate",
        ),
        "shared_prior_error": Variable(
            ("set", "rig_coordinate"), "float64", "1", "tolerance of the rig's coordinates by data sheets, scaled"
        ),
        **each(
            ("set",),
            shared_control_common=("1", "share of errors common to all windows in the control's responses"),
            shared_windows=("1", "number of windows of the set"),
            shared_temper=("1", "factor on log-likelihoods, for residuals larger than noise"),
        ),
        **each(
            ("set", "law_point"),
            law_speed=("rad s-1", "bit speed at which the learnt law is drawn"),
            law_torque=("N m", "bit torque at that speed less that at the mean speed; NaN where no law is offered"),
            law_error=("N m", "standard error of the non-linear part of that torque"),
            control_speed_error=("rad s-1", "speed error at which the learnt law of the speed control is drawn"),
            control_torque=(
                "N m",
                "torque of the control at that error beyond its gains; NaN where no such law is offered",
            ),
            control_torque_error=("N m", "standard error of that torque"),
            coupling_torque=(
                "N m",
                "torque at which the learnt law of a coupling is drawn; about its mean where no command is logged",
            ),
            coupling_twist=("rad", "twist at that torque less its linear part; NaN where no such law is offered"),
            coupling_error=("rad", "standard error of that twist"),
        ),
        "separation": Variable(
            ("set", "cause", "cause_"),
            "float64",
            "1",
            "distance of a cause of usual size from the best fit by another one, in standard deviations",
        ),
        **each(
            WINDOW_FREQUENCY,
            "complex128",
            residual_before=(
                "1",
                "measured less modelled mobility, in standard deviations of its real or imaginary part",
            ),
            residual_after=("1", "the same for the extended model"),
        ),
        "extended_value": Variable(("window", "parameter"), "float64", "", "parameter in the set's model, SI"),
        "coordinates": Variable(("window", "coordinate"), "float64", "", "coordinate in the set's model, SI"),
        "extension_set": Variable(("extension",), "int32", "", "set whose model the cause extends"),
        "extension_cause": Variable(
            ("extension",), "str", "", "cause, or term of a learnt extension, by which the model is extended"
        ),
        "extension_shape": Variable(("extension",), "float64", "", "shape of the cause, as defined in the catalogue"),
        "extension_fitted_shape": Variable(
            ("extension",), "float64", "1", "standard normal coordinate of what is fitted of its shape"
        ),
        "extension_size": Variable(("extension",), "float64", "", "size of the cause, in its unit"),
        "extension_size_error": Variable(("extension",), "float64", "", "standard error of the size"),
        "extension_present": Variable(("extension", "window"), "bool", "", "the cause is present in the window"),
        "held_out_window": Variable(("set",), "int32", "", "window that was held out"),
        **each(
            _SF,
            "complex128",
            held_out_base=(MOBILITY, "its command mobility predicted by the base model fitted to the other windows"),
            held_out_extended=(
                MOBILITY,
                "its command mobility predicted by the extended model fitted to the other windows",
            ),
            missing_immittance=("", "immittance that an unknown disturbance adds at its port: N m s/rad, or a share"),
            missing_rational=("", "rational fit of the missing immittance"),
        ),
        "missing_deviation": Variable(_SF, "float64", "", "standard deviation of its real or imaginary part"),
        "missing_reading": Variable(("set",), "str", "", "physical interpretation of the missing immittance"),
        **each(
            ("set", "phase"),
            period_time=("s", "time since the sweep's start"),
            period_speed=("rad s-1", "measured speed in the sweep's band, mean over the held-out window's periods"),
            period_base=("rad s-1", "the same speed predicted by the base model"),
            period_extended=("rad s-1", "the same speed predicted by the extended model"),
        ),
        "period_error": Variable(("set",), "float64", "rad s-1", "standard error of the mean over periods"),
        **each(
            ("set", "place"),
            distance=("m", "distance along the string from its top"),
            reflection_before=("1", "measured less modelled reflection"),
            reflection_after=("1", "the same for the extended model"),
            reflection_level=(
                "1",
                "magnitude that noise alone exceeds at any distance only with the probability of the error rate",
            ),
        ),
    },
    WINDOW_COORDINATES[1:],
)
