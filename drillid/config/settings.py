"""Settings of the workflow: only choices that change results, one model per stage."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from drillid.config.files import read_yaml
from drillid.config.validation import KeyFault, Strict
from drillid.errors import SettingsError

DEFAULT_CONFIGURATION = Path("config/config.yaml")
"""What every run reads first, from the folder that it is started in; another configuration has only what differs."""


class RecordsSettings(Strict):
    """Raw log → regular SI time series with quality flags."""

    interpolate_up_to_s: float = Field(default=0.1, ge=0, le=10)
    """Longest run of missing rows that is filled by interpolation, in s; longer ones are gaps."""
    spike_error_rate: float = Field(default=1e-6, gt=0, lt=1)
    """Share of good samples that may be taken for spikes."""
    stuck_s: float = Field(default=2.0, gt=0, le=3600)
    """A sweep or speed signal that does not change for longer while rotating is stuck, in s."""


class WindowsSettings(Strict):
    """Steady drilling with the sweep on, cut into windows."""

    length_s: float = Field(default=600.0, ge=1, le=86400)
    """Length of a window, in s."""
    shortest_share: float = Field(default=0.6, gt=0, le=1)
    """Shortest window, as a share of the length: what a gap, a stuck sensor or a change of set point leaves may be a
    window. It should contain three periods of the sweep: with two, half of the lines are those of the sweep, and few
    remain to estimate the noise."""
    overlap: float = Field(default=0.0, ge=0, le=0.95)
    """Share of a window that overlaps with the next one."""
    rotating_rpm: float = Field(default=10.0, gt=0, le=300)
    """Below this mean speed the string counts as not rotating, in rpm."""
    on_bottom_m: float = Field(default=0.5, gt=0, le=50)
    """Bit within this distance of the hole's bottom counts as on bottom, in m."""
    steady_rpm: float = Field(default=5.0, gt=0, le=300)
    """Largest change of the speed set point within a window, in rpm."""
    flagged_share: float = Field(default=0.02, ge=0, le=1)
    """Largest share of interpolated or replaced samples in a window."""


class SpectraSettings(Strict):
    """Spectrograms and cross spectra of each window."""

    frequency_minimum_hz: float = Field(default=0.05, gt=0, le=50)
    """Lowest frequency used."""
    frequency_maximum_hz: float = Field(default=5.0, gt=0, le=500)
    """Highest frequency used, where the sweep reaches it."""
    estimator: Literal["local_polynomial", "welch"] = "local_polynomial"
    """Local polynomials of frequency, by line where the sweep repeats, or Welch's averages over segments."""
    segment_s: float = Field(default=120.0, gt=0, le=86400)
    """Length of Welch's segments, in s; where the sweep is not periodic, frequencies are spaced by two of its lines."""
    noise_lines: int = Field(default=80, ge=16, le=10000)
    """Unexcited lines around each excited one from which its noise is estimated; a quarter of these if
    the sweep is not periodic."""
    spectrogram_segment_s: float = Field(default=20.0, gt=0, le=3600)
    """Segment of the spectrograms, in s; at most half of the shortest window."""

    @model_validator(mode="after")
    def _has_a_band(self) -> Self:
        if self.frequency_minimum_hz >= self.frequency_maximum_hz:
            what = f"{self.frequency_minimum_hz} Hz is not below the highest frequency, {self.frequency_maximum_hz} Hz"
            raise KeyFault("frequency_minimum_hz", what, "Lower it, or raise 'frequency_maximum_hz'")
        return self


class MobilitySettings(Strict):
    """Coherence-gated command mobility and its stacks."""

    band_octaves: float = Field(default=0.5, gt=0, le=5)
    """Width of the bands over which coherence is judged, in octaves."""
    error_rate: float = Field(default=0.01, gt=0, lt=1)
    """Share of bands without response that may pass the gate, and of good frequencies rejected as too coherent."""
    stack_windows: int = Field(default=6, ge=2, le=1000)
    """Successive windows in a stack; the paper stacks six."""
    stack_depth_share: float = Field(default=0.025, gt=0, le=1)
    """Largest change of depth within a stack, as a share of the depth; modes move with it."""
    agreement_error_rate: float = Field(default=0.01, gt=0, lt=1)
    """Share of stacks of agreeing windows that may be rejected."""


class FitsSettings(Strict):
    """Fits of the damped transmission line."""

    use_data_sheets: bool = True
    """Take the rig's data sheets, with their tolerances, as prior knowledge."""
    starts: int = Field(default=16, ge=1, le=10000)
    """Starting points of each fit; the best are followed to their optimum."""
    error_rate: float = Field(default=0.001, gt=0, lt=1)
    """Share of correct models whose fit may be rejected for its residuals."""
    change_error_rate: float = Field(default=0.05, gt=0, lt=1)
    """Share of wells without any change of formation, hole or assembly in which the joint fit may report one."""
    length_factor_error: float = Field(default=0.1, gt=0, le=1)
    """Standard uncertainty of the pipe's effective length for torsional waves relative to its logged length, where no
    tally gives it."""
    length_offset_m: float = Field(default=30.0, gt=0, le=10000)
    """Standard uncertainty of the error of logged bit depth less collars that all windows share, in m."""
    collars_offset_m: float = Field(default=300.0, gt=0, le=10000)
    """The same where no tally lists the collars, so that it includes their length, in m."""


class DiscrepancySettings(Strict):
    """Tests of what the fitted models leave unexplained."""

    error_rate: float = Field(default=0.05, gt=0, lt=1)
    """Share of faultless wells that may get a verdict, a fifth of it for interval changes; and share of those in which
    the residuals of a window may fail a test."""
    base_rate: float = Field(default=0.5, gt=0, lt=1)
    """Share of sets of windows in which something is wrong, before their data are examined. No count over rigs is
    published: even odds favour neither answer; enter the share of your own rigs."""
    second_cause_rate: float = Field(default=0.111, gt=0, lt=1)
    """Share of sets with one cause that have a further one. No count is published: one in nine
    holds where causes come independently of each other and a set in five has any."""
    cause_weights: dict[str, Annotated[float, Field(gt=0, le=1000)]] = Field(default_factory=dict)
    """How much more common a cause, or `unknown`, is than another; 1 where not given. No count is published: equal
    weights are those of indifference (Laplace)."""


class CommonCausesSettings(Strict):
    """Causes that wells of a rig, a hole section or a tool have in common."""

    enabled: bool = False
    """Whether they are judged. Off by default: how often the common size's interval and probability are right has not
    been measured where wells name a cause themselves."""
    error_rate: float = Field(default=0.05, gt=0, lt=1)
    """Share of faultless fleets in which anything may be named; all their rigs, sections and tools share it."""
    base_rate: float = Field(default=0.5, gt=0, lt=1)
    """Share of rigs, sections and tools with a cause that all their wells have, before their data are examined. No
    count is published: even odds favour neither answer."""


class StartUpsSettings(Strict):
    """Measured starts of rotation: a described well is fitted to the first part of its log and judged on the rest."""

    seen_share: float = Field(default=0.6, ge=0.2, le=0.9)
    """Share of a log to which models are fitted; they are judged on the rest."""
    evaluations: int = Field(default=300, ge=1, le=100_000)
    """Largest number of simulations of a fit, each at three levels of friction."""


class DepthSettings(Strict):
    """The depth-indexed dataset, stability against stick-slip and settings of the speed control."""

    step_duration_s: float = Field(default=10.0, gt=0, le=600)
    """Length of the step responses, in s."""
    step_interval_s: float = Field(default=0.05, ge=0.001, le=10)
    """Spacing of the step responses' lags, in s."""
    tuning_interval_m: float = Field(default=50.0, gt=0, le=1000)
    """Settings of the speed control are sought once in every interval of depth, in m."""
    bit_torque_slow_m: float = Field(default=0.06, gt=0, le=1)
    """Torque of the bit per weight on it at standstill, in m, from which the lowest stable speed is estimated."""
    bit_torque_fast_m: float = Field(default=0.03, gt=0, le=1)
    """The same at high speed, in m."""
    bit_torque_rpm: float = Field(default=60.0, gt=0, le=1000)
    """Speed at which most of the difference between the two is gone, in rpm."""

    @model_validator(mode="after")
    def _has_lags(self) -> Self:
        if self.step_interval_s > self.step_duration_s:
            what = f"{self.step_interval_s} s is longer than the step responses, {self.step_duration_s} s"
            raise KeyFault("step_interval_s", what, "Lower it, or raise 'step_duration_s'")
        if self.bit_torque_fast_m > self.bit_torque_slow_m:
            what = f"{self.bit_torque_fast_m} m is above the torque at standstill, {self.bit_torque_slow_m} m"
            raise KeyFault("bit_torque_fast_m", what, "Lower it, or raise 'bit_torque_slow_m'")
        return self


class FiguresSettings(Strict):
    """The paper's figures for every well."""

    dpi: int = Field(default=110, ge=50, le=600)
    """Resolution of PNG files, and of the images in the others."""
    formats: tuple[Literal["png", "svg", "pdf"], ...] = ("png",)
    """Files that are written of each figure: png, svg, pdf. The report links those in PNG."""


class ReportSettings(Strict):
    """The fleet's report."""

    title: str = "Identification while drilling"
    """Heading of the report."""


class SimulateSettings(Strict):
    """The embedded demo fleet: raw logs made by the time-domain rig simulator."""

    drilling_s: float = Field(default=1220.0, gt=0, le=86400)
    """Drilling time of each stand, with the sweep on, in s."""
    connection_s: float = Field(default=240.0, ge=0, le=86400)
    """Connection after each stand, in s."""
    time_step_s: float = Field(default=0.0025, gt=0, le=0.02)
    """Time step of the simulator, in s; a whole number of them makes a log's sample interval of 0.02 s."""
    seed: int = Field(default=2025, ge=0, lt=2**63)
    """Seed of all noise."""


class SlurmWorkers(Strict):
    """Workers that dask submits to Slurm as jobs, for as long as a job of the workflow needs them (dask-jobqueue)."""

    jobs: int = Field(ge=1, le=10000)
    """Largest number of Slurm jobs; no more are submitted than there are wells."""
    processes: int = Field(default=1, ge=1, le=1024)
    """Worker processes of each job, one core each."""
    memory_mb: int = Field(default=4000, ge=100, le=10_000_000)
    """Memory of each job, in MB."""
    runtime: int = Field(default=120, ge=1, le=100_000)
    """Time limit of each job, in minutes."""
    partition: str | None = None
    """Partition; Slurm's default where it is not given."""
    account: str | None = None
    """Account; Slurm's default where it is not given."""
    directives: tuple[str, ...] = ()
    """Further options of sbatch, such as --qos=long."""
    interface: str | None = None
    """Network interface by which scheduler and workers reach each other, such as ib0."""


class KubernetesWorkers(Strict):
    """Workers that dask's operator for Kubernetes starts as pods, for as long as a job needs them (dask-kubernetes)."""

    workers: int = Field(ge=1, le=10000)
    """Largest number of pods, one core each; no more are started than there are wells."""
    image: str = "drillid"
    """Container image, that of the Dockerfile."""
    namespace: str | None = None
    """Namespace; that of the present context where it is not given."""
    memory_mb: int = Field(default=2000, ge=100, le=10_000_000)
    """Memory of each pod, in MB."""
    volumes: dict[str, str] = Field(default_factory=dict)
    """Persistent volume claims with the paths where all pods mount them; logs and results lie there."""


class SchedulerSettings(Strict):
    """A running dask scheduler, by its address, or a cluster to start workers on: one of these keys."""

    model_config = ConfigDict(json_schema_extra={"type": ["object", "string"]})

    address: str | None = None
    """Address of a running dask scheduler, such as tcp://host:8786."""
    slurm: SlurmWorkers | None = None
    """Workers that are jobs of Slurm."""
    kubernetes: KubernetesWorkers | None = None
    """Workers that are pods of Kubernetes."""

    @model_validator(mode="before")
    @classmethod
    def _is_an_address(cls, value: Any) -> Any:
        return {"address": value} if isinstance(value, str) else value

    @model_validator(mode="after")
    def _is_one_thing(self) -> Self:
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(given) != 1:
            what = f"gives {' and '.join(given) or 'nothing'}"
            raise KeyFault("", what, "Give the address of a scheduler, or one of the keys 'slurm' and 'kubernetes'")
        return self


class FleetSettings(Strict):
    """How wells are spread over processes; set by the workflow's profile, without effect on results."""

    batch_size: int = Field(default=1, ge=1, le=100000)
    """Wells per job; 1 for small fleets, about 25 for a thousand wells."""
    scheduler: SchedulerSettings | None = None
    """Address of a running dask scheduler, such as tcp://host:8786, or a cluster to start workers on; without it,
    processes of the machine are used."""
    processes: int = Field(default=1, ge=1, le=1024)
    """Processes of a job where no scheduler is given."""


class Settings(Strict):
    """The whole configuration: where the sheets are, where results go, and one section per stage."""

    wells: str = "config/wells.tsv"
    """Sheet of wells."""
    logs: str = "config/logs.tsv"
    """Sheet of log files."""
    rigs: str = "config/rigs"
    """Folder of rig descriptions."""
    log_roots: tuple[str, ...] = ()
    """Folders in which logs may lie, such as a mounted share, in addition to the working folder and that of the logs
    sheet."""
    start_up_sheet: str | None = None
    """Sheet of measured starts of rotation; without one there are none."""
    results: str = "results/main"
    """Folder for all results of this configuration, on this machine or a mounted share."""
    mirror: str | None = None
    """Folder or URL, such as s3://bucket/main, with a copy of the results that each run brings up to date; a machine
    without results starts from it."""
    fleet: FleetSettings = FleetSettings()
    records: RecordsSettings = RecordsSettings()
    windows: WindowsSettings = WindowsSettings()
    spectra: SpectraSettings = SpectraSettings()
    mobility: MobilitySettings = MobilitySettings()
    fits: FitsSettings = FitsSettings()
    discrepancy: DiscrepancySettings = DiscrepancySettings()
    common_causes: CommonCausesSettings = CommonCausesSettings()
    start_ups: StartUpsSettings = StartUpsSettings()
    depth: DepthSettings = DepthSettings()
    figures: FiguresSettings = FiguresSettings()
    report: ReportSettings = ReportSettings()
    simulate: SimulateSettings | None = None
    """Only in the demo: the fleet to simulate."""

    @classmethod
    def of_run(cls, configuration: str | Path) -> Self:
        """The settings of a run with a configuration, merged as Snakemake does it: key by key over
        DEFAULT_CONFIGURATION, where that exists.

        Raises
        ------
        SettingsError
            If a file cannot be read or holds no keys with values, or a setting cannot be used.
        """
        first = [DEFAULT_CONFIGURATION] if DEFAULT_CONFIGURATION.is_file() else []
        files, content = list(dict.fromkeys([*first, Path(configuration)])), dict[str, Any]()
        for file in files:
            own = read_yaml(file)
            if not isinstance(own, Mapping | None):
                raise SettingsError(str(file), "holds no keys with values", "Write it as keys with values")
            content = _merged(content, own or {})
        return cls.checked(content, ", ".join(map(str, files)))


def _merged(content: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(content)
    for key, value in changes.items():
        before = merged.get(key)
        merged[key] = _merged(before, value) if isinstance(before, Mapping) and isinstance(value, Mapping) else value
    return merged
