# SPDX-License-Identifier: BSD-3-Clause
"""The functions of magimu, as the program's commands have them."""
from __future__ import annotations

import json
import os
import tempfile
import time
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._errors import InputError, NotTrustedError, refused
from ._recording import Motion, Recording, axes_of, native, numbers, one, several
from ._results import (Calibration, Diagnosis, Info, Noise, PathLike, Update, _build,
                       calibration_of, diagnosis_of, info_of, update_of)

Recordings = Union[Recording, Iterable[Recording]]
NoiseLike = Union[Noise, Sequence[float]]
_NUMBER = (int, float, np.integer, np.floating)
_WHOLE = (int, np.integer)
_FLAG = (bool, np.bool_, type(None))


def _typed(kinds: Any, what: str, **given: Any) -> None:
    """InputError where one of these arguments is of another type."""
    for name, value in given.items():
        if isinstance(value, kinds) and not (isinstance(value, bool) and kinds in (_NUMBER, _WHOLE)):
            continue
        raise refused(name, f"{value!r} is not {what}", f"give {what}")


def _calibration(calibration: Any, function: str) -> Any:
    """The compiled part's calibration."""
    if isinstance(calibration, Calibration):
        return calibration._fitted
    raise refused(function, f"{type(calibration).__name__} is no Calibration",
                  "make one: magimu.calibrate(recording), or magimu.read_calibration(path)")


def _densities(noise: Optional[NoiseLike]) -> Optional[list[float]]:
    if noise is None:
        return None
    values = numbers([noise.acc, noise.gyro, noise.mag] if isinstance(noise, Noise) else noise,
                     "noise")
    if values.shape != (3,) or not np.all((values > 0.0) & np.isfinite(values)):
        raise refused("noise", "it is not three positive numbers",
                      "give densities per sqrt(Hz): m/s^2, rad/s, uT")
    return [float(v) for v in values]


def _model(noise: Optional[NoiseLike], gravity: Optional[float], motion: str,
           location: str = "", hemisphere: str = "", field_prior: bool = False) -> Any:
    if isinstance(location, (tuple, list)):
        location = ",".join(str(part) for part in location)
    _typed(str, "a text", motion=motion, location=location, hemisphere=hemisphere)
    if gravity is not None:
        _typed(_NUMBER, "a number", gravity=gravity)
        if not 0.0 < gravity < np.inf:
            raise refused("gravity", f"it is {gravity}", "give a positive number, m/s^2")
    out = _core.ModelOptions()
    out.noise = _densities(noise)
    out.gravity = gravity
    out.motion = motion
    out.location = location
    out.hemisphere = hemisphere
    out.field_prior = field_prior
    return out


def _pairs(given: Optional[Mapping[str, Any]], name: str) -> list[str]:
    if given is not None and not isinstance(given, Mapping):
        raise refused(name, f"{given!r} is no dictionary", f"give one, such as {_PAIRS[name]}")
    return [f"{k}={v}" for k, v in (given or {}).items()]


_PAIRS = {"map": "{'acc_x': 'ax'}", "unit": "{'gyr': 'deg/s'}", "axes": "{'mag': 'y,-x,z'}"}


def _path(path: Any, function: str) -> str:
    if isinstance(path, (str, os.PathLike)):
        return os.fspath(path)
    raise refused(function, f"{type(path).__name__} is no path", "give the path of a file")


def read(path: PathLike, *, map: Optional[Mapping[str, str]] = None,
         unit: Optional[Mapping[str, Union[str, float]]] = None,
         axes: Optional[Mapping[str, str]] = None, rate: Optional[float] = None,
         gyro_interval: str = "forward", columns: Union[str, Sequence[str]] = (),
         sensors: Sequence[str] = ()) -> Recording:
    """Reads a recording: every file that the program reads.

    Args:
        map: our columns by the file's: ``{"acc_x": "ax"}``.
        unit: the file's units: ``{"gyr": "deg/s", "mag": "gauss", "t": "ms"}``.
        axes: where the device's x, y, z are among a sensor's axes: ``{"mag": "y,-x,z"}``.
        rate: Hz, for a file without times.
        gyro_interval: a gyroscope sample is the mean rate over the interval that begins at its
            time ("forward"), has it in the middle ("centred") or ends there ("backward").
        columns: the names that a file without a header lacks, a list or "t,acc_x,..."; "-" ignores
            a column.
        sensors: of a log with several of a kind those to read, as `info` lists them:
            ``["mag=sensor_mag[1]"]``.
    """
    turns = _pairs(axes, "axes")
    return Recording._of(_core.read(_path(path, "read"), _pairs(map, "map"), _pairs(unit, "unit"),
                                    turns, rate or 0.0, gyro_interval,
                                    columns if isinstance(columns, str) else ",".join(columns),
                                    list(sensors)), turns)


def _prior(prior: Any, age_days: Optional[float], drift: Optional[float],
           axes: Optional[list[str]], folder: str) -> Any:
    """What the compiled part is told of it; an older calibration goes through a file in `folder`."""
    out = _core.Prior()
    for name, value in (("prior_age", age_days), ("prior_drift", drift)):
        if value is not None:
            _typed(_NUMBER, "a number", **{name: value})
    out.age_days, out.drift = age_days, drift
    if isinstance(prior, str) and prior in ("default", "none"):
        out.text = prior
        return out
    if isinstance(prior, Calibration):
        values = json.loads(prior._fitted.json())
        out.age_days, out.name = age_days or 0.0, "an older calibration"
    else:
        out.name = path = _path(prior, "prior")
        values = json.loads(read_calibration(path).to_json())
        if age_days is None:
            out.age_days = max(0.0, (time.time() - os.stat(path).st_mtime) / 86400.0)
    if axes is None:
        values.pop("axes", None)  # those of arrays are not known
    out.text = os.path.join(folder, "prior.json")
    with open(out.text, "w", encoding="utf-8") as file:
        json.dump(values, file)
    return out


def calibrate(recordings: Recordings, *, noise: Optional[NoiseLike] = None,
              gravity: Optional[float] = None, motion: str = "auto",
              mag_time_offset: Optional[bool] = None, gyro_matrix: Optional[bool] = None,
              node_every: int = 0, dip_deg: Optional[float] = None, location: str = "",
              hemisphere: str = "", field_prior: bool = False,
              prior: Union[str, PathLike, Calibration] = "default",
              prior_age: Optional[float] = None, prior_drift: Optional[float] = None,
              method: str = "map", as_published: bool = False, threads: int = 0) -> Calibration:
    """Calibrates accelerometer, gyroscope and magnetometers together.

    Args:
        recordings: one, or several of one device, which share its parameters.
        noise: densities per sqrt(Hz): m/s^2, rad/s, uT. Default: estimated.
        gravity: m/s^2. Default: of the location, else 9.80665.
        motion: "rotation" (the sensor only turned), "hand_held" (a hand moved it within its
            reach), "travelling" (it walked, drove or flew) or "auto": decided from the data, and said in ``motion_reason``.
        mag_time_offset: estimate the magnetometer's lag; None: where the data show one.
        gyro_matrix: estimate scale errors and misalignment of the gyroscope; None: where
            left-out data are predicted better.
        node_every: magnetometer samples a node; 0: automatic.
        dip_deg: start from this dip, positive downward. Default: from the data.
        location: "LAT,LON[,ALT],DATE", such as "52.51,13.33,2026-07-31": strength and dip are
            compared with the World Magnetic Model.
        hemisphere: "north" or "south": only the sign of the dip is.
        field_prior: let the location's field take part in the estimate.
        prior: what is known of the device beforehand: "default" (usual parts), "none", or an
            older calibration of it (also its path).
        prior_age: days since then (default: since the file was written; 0 of a Calibration).
        prior_drift: times the usual change since; 0: nothing has changed, and it is the same place.
        method: "map", or the rivals "kok" and "wu" (for a sensor that only turns).
        as_published: these as published code runs them.
        threads: at most so many; 0: all.

    Returns:
        The calibration. A recording that permits none has ``trust.verdict`` "no", with reasons.

    Raises:
        InputError: of what cannot be read or used. TooLittleError: too short to begin with.
        KeyboardInterrupt: Ctrl-C ends the fit. Other threads run meanwhile.
    """
    model = _model(noise, gravity, motion, location, hemisphere, field_prior)
    _typed(_FLAG, "True, False or None", mag_time_offset=mag_time_offset, gyro_matrix=gyro_matrix)
    _typed(_WHOLE, "a whole number", node_every=node_every, threads=threads)
    _typed(str, "a text", method=method)
    if dip_deg is not None:
        _typed(_NUMBER, "a number", dip_deg=dip_deg)
    if isinstance(recordings, Iterable) and not isinstance(recordings, (str, np.ndarray)):
        recordings = list(recordings)
    given = native(recordings, "calibrate")
    axes = axes_of(recordings if isinstance(recordings, list) else [recordings])
    with tempfile.TemporaryDirectory() as folder:
        before = _prior(prior, prior_age, prior_drift, axes, folder)
        fitted = _core.calibrate(given, model, before, axes, mag_time_offset, gyro_matrix,
                                 node_every, dip_deg, method, as_published, threads)
    return calibration_of(fitted)


def diagnose(recordings: Recordings, *, noise: Optional[NoiseLike] = None,
             gravity: Optional[float] = None, motion: str = "auto",
             false_alarm_rate: float = 0.01, against: Optional[Calibration] = None,
             base: Optional[Calibration] = None, threads: int = 0) -> Diagnosis:
    """Finds what the simulation of the sensor gets wrong in recordings, and why.

    Args:
        recordings, noise, gravity, motion, threads: as in :func:`calibrate`.
        false_alarm_rate: how often anything may be named where there is nothing.
        against: does this calibration still predict the recordings, and what has changed?
        base: start from the model of this calibration instead of the one with 19 parameters.
    """
    model = _model(noise, gravity, motion)
    _typed(_NUMBER, "a number", false_alarm_rate=false_alarm_rate)
    _typed(_WHOLE, "a whole number", threads=threads)
    stored, begun = (None if c is None else _calibration(c, name)
                     for c, name in ((against, "against"), (base, "base")))
    return diagnosis_of(*_core.diagnose(native(recordings, "diagnose"), model, false_alarm_rate,
                                        stored, begun, threads))


def info(recording: Recording, *, noise: Optional[NoiseLike] = None,
         gravity: Optional[float] = None, motion: str = "auto", location: str = "",
         hemisphere: str = "", threads: int = 0) -> Info:
    """Looks at a recording before a fit: rates, faults with their remedies, axes, the motion that
    is missing, and how well each parameter could be known. Arguments as in :func:`calibrate`."""
    model = _model(noise, gravity, motion, location, hemisphere)
    _typed(_WHOLE, "a whole number", threads=threads)
    return info_of(_core.info(one(recording, "info"), model, threads))


@dataclass
class Applied:
    """A recording, corrected: what was done (formulas with numbers), and what was left."""

    recording: Recording
    formulas: list[str]
    not_applied: list[str]


def apply(calibration: Calibration, recording: Recording, *, keep_times: bool = False,
          force: bool = False) -> Applied:
    """Corrects a recording; readings stay in m/s^2, rad/s and uT, in the IMU's axes.

    Args:
        keep_times: a lag of the magnetometer is otherwise taken out by earlier times.
        force: use a calibration whose verdict is "no" all the same (else NotTrustedError).
    """
    fitted, given = _calibration(calibration, "apply"), one(recording, "apply")
    if calibration.trust.verdict == "no" and not force:
        reasons = " ".join(calibration.trust.reasons)
        raise NotTrustedError(f"the verdict of this calibration is \"no\": {reasons}; "
                              "make a better recording, or give force=True",
                              problem=reasons, remedy="make a better recording, or force=True")
    corrected, formulas, not_applied = _core.apply(fitted, given, not keep_times)
    return Applied(Recording._of(corrected), list(formulas), list(not_applied))


@dataclass
class Exported:
    """A calibration for another system: the file's text, and what that system cannot hold."""

    text: str
    lost: list[str]

    def save(self, path: PathLike) -> None:
        """Writes the file, whole or not at all."""
        _core.write_atomically(os.fspath(path), self.text)


def export(calibration: Calibration, to: str, *, field_strength: float = 0.0,
           with_rotation: bool = False, only: Sequence[str] = (), allow_loss: bool = False,
           force: bool = False) -> Exported:
    """A calibration in another system's own names, units and convention.

    Args:
        to: "px4", "ardupilot", "ros", "matlab" or "c".
        field_strength: length of corrected readings, uT; 0: the calibration's own.
        with_rotation: px4, ardupilot: carry the magnetometer's rotation as mounting angles.
        only: px4, ardupilot: of these sensors alone, such as ``["mag"]``.
        allow_loss: make a file that loses a large rotation, too (else InputError).
        force: use a calibration whose verdict is "no" all the same (else NotTrustedError).
    """
    fitted = _calibration(calibration, "export")
    _typed(str, "a text", to=to)
    _typed(_NUMBER, "a number", field_strength=field_strength)
    if calibration.trust.verdict == "no" and not force:
        reasons = " ".join(calibration.trust.reasons)
        raise NotTrustedError(f"the verdict of this calibration is \"no\": {reasons}; "
                              "make a better recording, or give force=True",
                              problem=reasons, remedy="make a better recording, or force=True")
    text, lost, harmful = _core.export(fitted, to, field_strength, with_rotation, list(only))
    if harmful and not allow_loss:
        raise refused("export", " ".join(harmful), "or make it all the same: allow_loss=True")
    return Exported(text, list(lost))


def read_calibration(path: PathLike) -> Calibration:
    """A calibration that the program or :meth:`Calibration.save` has written.

    How its fit went stays in the file: ``fit``, ``residuals`` and ``checks`` are read as they
    stand there, trajectories are not.
    """
    name = _path(path, "read_calibration")
    try:
        with open(name, encoding="utf-8") as file:
            text = file.read()
    except OSError as error:
        raise refused(name, f"cannot be read: {error.strerror}",
                      "give what `magimu calibrate -o` or Calibration.save writes") from None
    except UnicodeDecodeError:
        raise refused(name, "it is not JSON",
                      "give what `magimu calibrate -o` or Calibration.save writes") from None
    fitted = _core.fitted_from(text, name)
    out = calibration_of(fitted)
    stored = _build(Calibration, json.loads(text))
    for name in ("fit", "residuals", "checks", "disturbances", "set_aside", "warnings"):
        setattr(out, name, getattr(stored, name))
    return out


@dataclass
class Simulation:
    """A recording and the truth behind it: ``truth`` has the names of a calibration's file."""

    recording: Recording
    truth: dict[str, Any]
    motion: Motion


def simulate(*, motion: str = "paper", rate: float = 80.0, mag_ratio: int = 1,
             duration: float = 0.0, rest: float = -1.0, seed: int = 1, gravity: float = 9.80665,
             noise: Optional[Sequence[float]] = None, magnetometers: int = 1,
             displacement: float = -1.0, effects: Sequence[str] = ()) -> Simulation:
    """Makes a recording whose truth is known, as ``magimu simulate`` does.

    Args:
        motion: "paper" (six slow turns), "hand" (turned in the hands), "hand_held" (moved, too),
            "sequence" (the half turns that serve best).
        rate: IMU samples a second. mag_ratio: IMU samples per magnetometer sample.
        duration: s; 0: the motion's own. rest: s at rest first; -1: the motion's own.
        seed: names the data set. gravity: m/s^2.
        noise: densities per sqrt(Hz): m/s^2, rad/s, uT; zeros: exact readings.
        magnetometers: how many on one board. displacement: m RMS of "hand_held".
        effects: hidden in it, such as ``["mag_lag=0.012:"]`` (docs/effects.md).
    """
    _typed(str, "a text", motion=motion)
    _typed(_NUMBER, "a number", rate=rate, duration=duration, rest=rest, gravity=gravity,
           displacement=displacement)
    _typed(_WHOLE, "a whole number", mag_ratio=mag_ratio, seed=seed, magnetometers=magnetometers)
    if isinstance(effects, str):
        raise refused("effects", "it is one text", f"give a list: [{effects!r}]")
    if seed < 0:
        raise refused("seed", f"it is {seed}", "give a whole number from 0 on")
    if noise is not None and np.shape(noise) != (3,):
        raise refused("noise", "it is not three numbers",
                      "give densities per sqrt(Hz): m/s^2, rad/s, uT")
    made, truth, path = _core.simulate(motion, rate, mag_ratio, duration, rest, seed, gravity,
                                       None if noise is None else list(noise), magnetometers,
                                       displacement, list(effects))
    return Simulation(Recording._of(made), json.loads(truth), Motion(*path))


class Stream:
    """Calibrates while samples arrive::

        stream = magimu.Stream()
        for t, acc, gyr, mag in source:
            update = stream.add(t, acc, gyr, mag)
            if update:
                print(update.headline, update.guidance)
        calibration = stream.finish()

    Args:
        magnetometers: how many there are.
        target: good enough, as "heading=0.3deg,mag_bias=0.2uT" (default: heading=0.5deg).
        window_s: seconds a window; each gives an :class:`Update`.
        noise, gravity, motion, location, hemisphere, field_prior: as in :func:`calibrate`.

    It may be fed from any thread, one at a time.
    """

    def __init__(self, magnetometers: int = 1, *, target: str = "", window_s: float = 1.0,
                 noise: Optional[NoiseLike] = None, gravity: Optional[float] = None,
                 motion: str = "auto", location: str = "", hemisphere: str = "",
                 field_prior: bool = False) -> None:
        _typed(_WHOLE, "a whole number", magnetometers=magnetometers)
        _typed(str, "a text", target=target)
        _typed(_NUMBER, "a number", window_s=window_s)
        self._magnetometers = magnetometers
        model = _model(noise, gravity, motion, location, hemisphere, field_prior)
        self._native = _core.Stream(magnetometers, model, target, window_s)

    def add(self, t: float, acc: Optional[ArrayLike] = None, gyr: Optional[ArrayLike] = None,
            mag: Optional[ArrayLike] = None) -> Optional[Update]:
        """One moment: (3,) of each sensor (mag: (m, 3) of several), None where one has no sample.
        An update where this completes a window."""
        def rows(v: Optional[ArrayLike], sensor: str, many: int) -> list[np.ndarray]:
            if v is None:
                return [np.full((1, 3), np.nan)] * many
            values = numbers(v, sensor)
            if values.shape != (many, 3) and (many > 1 or values.shape != (3,)):
                expected = "(3,)" if many == 1 else f"({many}, 3)"
                raise refused(sensor, f"its shape is {values.shape}",
                              f"give x, y, z of one moment: shape {expected}")
            return list(values.reshape(many, 1, 3))

        lines = self._native.feed(np.atleast_1d(numbers(t, "t")), rows(acc, "acc", 1)[0],
                                  rows(gyr, "gyr", 1)[0], rows(mag, "mag", self._magnetometers))
        return update_of(lines[0]) if lines else None

    def feed(self, t: ArrayLike, acc: ArrayLike, gyr: ArrayLike,
             mag: Union[ArrayLike, Sequence[ArrayLike]]) -> list[Update]:
        """Many moments: t (n,), sensors (n, 3), rows of nan where one has no sample; several
        magnetometers as in :class:`Recording`. The updates of all windows completed."""
        times = numbers(t, "t")
        lines = self._native.feed(times, numbers(acc, "acc"), numbers(gyr, "gyr"),
                                  several(mag, times.size))
        return [update_of(line) for line in lines]

    def finish(self) -> Calibration:
        """The calibration of all samples so far. More may be added after it."""
        return calibration_of(self._native.finish())
