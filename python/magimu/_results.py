# SPDX-License-Identifier: BSD-3-Clause
"""Results as dataclasses, under the names of the program's files (docs/formats.md).

Lists of numbers are NumPy arrays. What a file has beyond these fields is in ``to_dict()``.
"""
from __future__ import annotations

import dataclasses
import json
import os
import typing
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, Optional, Sequence, Union

import numpy as np

from . import _core
from ._errors import refused
from ._recording import Recording, native, numbers

PathLike = Union[str, "os.PathLike[str]"]


@lru_cache(maxsize=None)
def _types(cls: type) -> dict[str, Any]:
    hints = typing.get_type_hints(cls)
    return {f.name: hints[f.name] for f in fields(cls) if f.init}


def _convert(hint: Any, value: Any) -> Any:
    """`value`, as JSON has it, as what `hint` says."""
    if value is None:
        return float("nan") if hint is float else None
    origin = typing.get_origin(hint)
    if hint is np.ndarray:
        array = np.array(value, dtype=float)
        array.flags.writeable = False  # save(), apply() and export() would not see a change
        return array
    if origin is Union:
        return _convert(next(a for a in typing.get_args(hint) if a is not type(None)), value)
    if origin is list:
        (item,) = typing.get_args(hint)
        return [_convert(item, v) for v in value]
    if origin is dict:
        item = typing.get_args(hint)[1]
        return {k: _convert(item, v) for k, v in value.items()}
    if isinstance(hint, type) and hasattr(hint, "__dataclass_fields__"):
        return _build(hint, value)
    if hint is float:
        return float(value)
    return value


def _build(cls: Any, values: dict[str, Any], **more: Any) -> Any:
    """An instance of the dataclass `cls` of a JSON object; absent fields keep their defaults."""
    known = {k: _convert(hint, values[k]) for k, hint in _types(cls).items() if k in values}
    return cls(**known, **more)


def _same(a: Any, b: Any) -> bool:
    """Equal, arrays element by element; nan is nan."""
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return bool(np.array_equal(a, b, equal_nan=True))
    if isinstance(a, (list, tuple)) and isinstance(b, (list, tuple)):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(_same(a[k], b[k]) for k in a)
    return bool(a == b) or (isinstance(a, float) and a != a and b != b)


class _Values:
    """Results compare by their fields, arrays among them."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(_same(getattr(self, f.name), getattr(other, f.name))
                   for f in fields(self) if f.compare)  # type: ignore[arg-type]

    __hash__ = None  # type: ignore[assignment]


@dataclass(eq=False)
class Trust(_Values):
    """May one believe it? ``verdict`` is "yes", "limited" or "no"; reasons, the gravest first."""

    verdict: str
    reasons: list[str]

    def __bool__(self) -> bool:
        return self.verdict != "no"


@dataclass(eq=False)
class Bias(_Values):
    """A bias (3,) with its standard deviations: robust (to be used), and the model's own."""

    bias: np.ndarray
    bias_sigma: np.ndarray
    bias_sigma_model: np.ndarray


@dataclass(eq=False)
class Magnetometer(_Values):
    """mag = distortion @ R.T @ m + bias: distortion (3, 3) and bias (3,) in uT."""

    name: str
    distortion: np.ndarray
    distortion_sigma: np.ndarray
    distortion_sigma_model: np.ndarray
    bias: np.ndarray
    bias_sigma: np.ndarray
    bias_sigma_model: np.ndarray

    def unit_field(self, mag: np.ndarray) -> np.ndarray:
        """Readings (..., 3) in uT as the unit field in the IMU's frame: D^-1 (mag - o_m)."""
        readings = numbers(mag, "mag")
        if readings.ndim == 0 or readings.shape[-1] != 3:
            raise refused("mag", f"its shape is {readings.shape}",
                          "give x, y, z in the last dimension: shape (3,) or (n, 3)")
        difference = readings - self.bias
        return np.linalg.solve(self.distortion, difference[..., None])[..., 0]


@dataclass(eq=False)
class Field(_Values):
    """Dip in degrees, positive downward; strength in uT (cube root of det D)."""

    dip_deg: float
    dip_deg_sigma: float
    dip_deg_sigma_model: float
    strength_uT: float = float("nan")
    strength_uT_sigma: float = float("nan")
    strength_uT_sigma_model: float = float("nan")
    recording: str = ""


@dataclass(eq=False)
class Covariance(_Values):
    """Joint covariance; ``order`` names the rows. Dips in degrees."""

    order: list[str]
    matrix: np.ndarray

    def of(self, *names: str) -> np.ndarray:
        """The block of these parameters, such as ``of("field.dip_deg")``."""
        at = [self.order.index(name) for name in names]
        return self.matrix[np.ix_(at, at)]


@dataclass(eq=False)
class Noise(_Values):
    """Densities per sqrt(Hz): m/s^2, rad/s, uT; ``source`` is "given" or "estimated"."""

    acc: float
    gyro: float
    mag: float
    source: str = "given"


@dataclass(eq=False)
class Parameter(_Values):
    """A named number with its standard deviation."""

    name: str
    value: float
    sigma: float
    unit: str
    sigma_model: float = float("nan")


@dataclass(eq=False)
class Effect(_Values):
    """A model extension that is part of the calibration."""

    name: str
    parameters: list[Parameter]


@dataclass(eq=False)
class Step(_Values):
    """One tried step of the optimizer."""

    iteration: int
    cost: float
    gradient_norm: float
    step_norm: float
    step_sigma: float
    damping: float
    gain_ratio: float
    accepted: bool


@dataclass(eq=False)
class Fit(_Values):
    """How the optimization went."""

    samples: int
    nodes: int
    node_every: int
    iterations: int
    termination: str
    message: str
    cost_initial: float
    cost_final: float
    gradient_norm: float
    step_norm: float
    seconds: float
    trace: list[Step]


@dataclass(eq=False)
class ResidualSummary(_Values):
    """Whitened residuals of a sensor: 1 is what the noise predicts. ``rms_unit`` in its unit."""

    rms: float
    lag1: float
    rms_unit: float


@dataclass(eq=False)
class Check(_Values):
    """One thing looked at: ``status`` is "ok", "caution" or "bad"."""

    name: str
    status: str
    value: float
    sentence: str


@dataclass(eq=False)
class Disturbance(_Values):
    """A stretch of time in which the magnetometer reads something else than the model's field."""

    recording: str
    begin_s: float
    end_s: float
    rms_uT: float


@dataclass(eq=False)
class SetAside(_Values):
    """Samples that no measurement can have given, and that the fit did not see."""

    recording: str
    sensor: str
    kind: str
    count: int
    of: int
    begin_s: float
    end_s: float
    example: str


@dataclass(eq=False)
class Trajectory(_Values):
    """The estimated motion of one recording at n nodes.

    t: (n,) s. quaternion: (n, 4), w x y z, and matrix: (n, 3, 3), of R_k, which turns vectors of
    the IMU's frame into n (X east, Y magnetic north, Z up). velocity, position: (n, 3), m/s and m
    in n; empty where the sensor only turned.
    """

    recording: str
    t: np.ndarray
    quaternion: np.ndarray
    matrix: np.ndarray
    velocity: np.ndarray
    position: np.ndarray


@dataclass(eq=False)
class ResidualSeries(_Values):
    """Measured less predicted at n nodes, in standard deviations: t (n,), whitened (n, 3)."""

    sensor: str
    t: np.ndarray
    whitened: np.ndarray


@dataclass(eq=False)
class Calibration(_Values):
    """A calibration: what ``magimu calibrate -o`` writes, field by field.

    To use it: ``magnetometers[0].unit_field(mag)``, ``acc - accelerometer.bias``,
    ``gyr - gyroscope.bias``; or :func:`magimu.apply`, which takes out every effect that was found.
    """

    trust: Trust
    accelerometer: Bias  # m/s^2
    gyroscope: Bias  # rad/s
    magnetometers: list[Magnetometer]
    field: Field
    covariance: Covariance
    covariance_model: Covariance
    noise: Noise
    motion: str
    motion_reason: str = ""
    gravity: float = 9.80665
    effects: list[Effect] = dataclasses.field(default_factory=list)
    fit: Optional[Fit] = None
    residuals: dict[str, ResidualSummary] = dataclasses.field(default_factory=dict)
    checks: list[Check] = dataclasses.field(default_factory=list)
    disturbances: list[Disturbance] = dataclasses.field(default_factory=list)
    undetermined: list[str] = dataclasses.field(default_factory=list)
    set_aside: list[SetAside] = dataclasses.field(default_factory=list)
    warnings: list[str] = dataclasses.field(default_factory=list)
    fields: list[Field] = dataclasses.field(default_factory=list)
    method: str = "map"
    _fitted: Any = dataclasses.field(default=None, repr=False, compare=False)

    def to_json(self) -> str:
        """The content of the program's file; of one that was read, that file."""
        return typing.cast(str, self._fitted.file())

    def to_dict(self) -> dict[str, Any]:
        """The same as dictionaries, lists and numbers."""
        return typing.cast("dict[str, Any]", json.loads(self.to_json()))

    def save(self, path: PathLike) -> None:
        """Writes the file, whole or not at all."""
        _core.write_atomically(os.fspath(path), self.to_json())

    @property
    def trajectories(self) -> list[Trajectory]:
        """The estimated motion, one a recording (of a part, where a recording has gaps)."""
        return [Trajectory(*t) for t in self._fitted.trajectories()]

    @property
    def residual_series(self) -> list[ResidualSeries]:
        """Whitened residuals of "acc", "gyr" and each magnetometer."""
        return [ResidualSeries(*r) for r in self._fitted.residuals()]

    def report(self, recordings: Union[Recording, Sequence[Recording]]) -> str:
        """A page (HTML, one file) with pictures; ``recordings`` are those it was made of."""
        return typing.cast(str, self._fitted.report(native(recordings, "report")))

    def __str__(self) -> str:
        m = self.magnetometers[0]
        return (f"Calibration(trust {self.trust.verdict}; strength {self.field.strength_uT:.4g} uT, "
                f"dip {self.field.dip_deg:.4g} deg; {m.name} bias {np.round(m.bias, 3)} uT, "
                f"sigma {np.round(m.bias_sigma, 4)} uT; motion {self.motion})")


def calibration_of(fitted: Any) -> Calibration:
    """The dataclass of what the compiled part holds."""
    return typing.cast(Calibration, _build(Calibration, json.loads(fitted.json()), _fitted=fitted))


@dataclass(eq=False)
class Gain(_Values):
    """What a cause gains, on data the fit has not seen (nats) and in the residuals' size."""

    heldout_nll_before: float
    heldout_nll_after: float
    bic_delta: float
    residual_rms_before: float
    residual_rms_after: float


@dataclass(eq=False)
class Confusable(_Values):
    """Another cause that this motion cannot tell from the one found."""

    effect: str
    why: str
    motion_that_separates: str


@dataclass(eq=False)
class Finding(_Values):
    """A cause that was found, with its size and what it explains."""

    effect: str
    channel: str
    sentence: str
    parameters: list[Parameter]
    p_value: float
    probability: float = float("nan")
    gain: Optional[Gain] = None
    confusable_with: list[Confusable] = dataclasses.field(default_factory=list)


@dataclass(eq=False)
class ScanEntry(_Values):
    """A candidate effect that was tested."""

    effect: str
    channel: str
    parameters: list[str]
    statistic: float
    dof: int
    p_value: float
    significant: bool
    needs: str
    detectable: str = ""


@dataclass(eq=False)
class Departure(_Values):
    """A statistic that lies outside of what the fitted model predicts."""

    channel: str
    statistic: str
    observed: float
    predicted: float
    predicted_band: np.ndarray
    z: float


@dataclass(eq=False)
class Unexplained(_Values):
    """Structure that no candidate explains."""

    detected: bool
    channels: list[str]
    evidence: list[str]


@dataclass(eq=False)
class Change(_Values):
    """One group of parameters against a stored calibration."""

    group: str
    changed: bool
    sentence: str
    p_value: float = float("nan")
    parameters: list[Parameter] = dataclasses.field(default_factory=list)


@dataclass(eq=False)
class Against(_Values):
    """Does a stored calibration still hold?"""

    tested: bool
    groups: list[Change] = dataclasses.field(default_factory=list)
    notes: list[str] = dataclasses.field(default_factory=list)


@dataclass(eq=False)
class Diagnosis(_Values):
    """What the simulation gets wrong, and why: what ``magimu diagnose -o`` writes.

    ``answer``: "predicts", "explained", "partly", "unexplained" or "none".
    """

    recordings: list[str]
    answer: str
    answer_evidence: list[str]
    departures: list[Departure]
    scan: list[ScanEntry]
    findings: list[Finding]
    unexplained: Unexplained
    departures_after: list[Departure] = dataclasses.field(default_factory=list)
    next_step: str = ""
    notes: list[str] = dataclasses.field(default_factory=list)
    against: Optional[Against] = None
    seconds: float = float("nan")
    before: Optional[Calibration] = None
    after: Optional[Calibration] = None
    _json: str = dataclasses.field(default="", repr=False, compare=False)
    _page: str = dataclasses.field(default="", repr=False, compare=False)

    def to_json(self) -> str:
        """The content of the program's file."""
        return self._json + "\n"

    def to_dict(self) -> dict[str, Any]:
        """The same as dictionaries, lists and numbers."""
        return typing.cast("dict[str, Any]", json.loads(self._json))

    def save(self, path: PathLike) -> None:
        """Writes the file, whole or not at all."""
        _core.write_atomically(os.fspath(path), self.to_json())

    def report(self) -> str:
        """A page (HTML, one file) with pictures."""
        return self._page


def diagnosis_of(text: str, page: str, before: Any, after: Any) -> Diagnosis:
    """The dataclass of what the compiled part returns."""
    values = json.loads(text)
    out = _build(Diagnosis, values, _json=text, _page=page)
    if values["answer"] != "none":
        out.before, out.after = calibration_of(before), calibration_of(after)
    return typing.cast(Diagnosis, out)


@dataclass(eq=False)
class Issue(_Values):
    """A fault of the samples, with the remedy."""

    kind: str
    sensor: str
    severity: str
    problem: str
    remedy: str
    axis: Optional[str] = None


@dataclass(eq=False)
class Sensor(_Values):
    """What a recording holds of one sensor; ``noise_density`` per sqrt(Hz) at rest."""

    name: str
    samples: int
    rate_hz: float
    longest_interval_s: float
    largest: float
    unit: str
    noise_density: float = float("nan")


@dataclass(eq=False)
class Expected(_Values):
    """How well each parameter would be known: standard deviations by the parameters' names."""

    motion: str
    sigma: dict[str, float]
    undetermined: list[str]


@dataclass(eq=False)
class Info(_Values):
    """What a recording holds and lacks, before a fit: what ``magimu info --json`` prints."""

    recording: str
    duration_s: float
    sensors: list[Sensor]
    issues: list[Issue]
    rests: np.ndarray
    not_looked_further: str = ""
    motion: dict[str, Any] = dataclasses.field(default_factory=dict)
    field: dict[str, Any] = dataclasses.field(default_factory=dict)
    axes: dict[str, Any] = dataclasses.field(default_factory=dict)
    expected: Optional[Expected] = None
    notes: list[str] = dataclasses.field(default_factory=list)
    _json: str = dataclasses.field(default="", repr=False, compare=False)

    def to_dict(self) -> dict[str, Any]:
        """All of it as dictionaries, lists and numbers."""
        return typing.cast("dict[str, Any]", json.loads(self._json))


def info_of(text: str) -> Info:
    """The dataclass of what the compiled part returns."""
    return typing.cast(Info, _build(Info, json.loads(text), _json=text))


@dataclass(eq=False)
class Window(_Values):
    """How well one window of a stream fits all others."""

    nis: float
    dof: int
    p_value: float
    used: bool


@dataclass(eq=False)
class Target(_Values):
    """A standard deviation of a stream's estimate, and the limit that is good enough."""

    name: str
    sigma: float
    limit: float
    unit: str


@dataclass(eq=False)
class Estimate(_Values):
    """The parameters so far."""

    accelerometer: Bias
    gyroscope: Bias
    magnetometers: list[Magnetometer]
    field: Field
    undetermined: list[str]
    trust: Trust


@dataclass(eq=False)
class SensorChange(_Values):
    """A sensor that reads otherwise than before: which, since when, by how much.

    ``also_likely``: others whose odds are hardly less. ``stays``: a step or a drift of its bias,
    which by now is ``size``; else something that changes with the motion, of that root mean
    square.
    """

    sensor: str
    also_likely: list[str]
    since_s: float
    between_s: list[float]
    stays: bool
    size: list[float]
    log_odds: float
    advice: str


@dataclass(eq=False)
class Update(_Values):
    """What a stream says at the end of a window (a second): the program's JSON line.

    ``phase``: "collecting", "calibrating" or "converged". ``headline`` and ``guidance`` are for
    the person who holds the sensor. ``theta`` is None while collecting.
    """

    t: float
    samples: int
    phase: str
    theta: Optional[Estimate]
    window: Window
    guidance: str
    headline: str
    missing: list[str]
    target: list[Target]
    events: list[str]
    issues: list[Issue]
    checks: list[Check]
    flagged_windows: list[int]
    sensor_change: Optional[SensorChange]


def update_of(text: str) -> Update:
    """The dataclass of a line."""
    return typing.cast(Update, _build(Update, json.loads(text)))
