# SPDX-License-Identifier: BSD-3-Clause
"""The functions of magimu, as the program's commands have them."""
from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, Iterable, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._errors import InputError, NotTrustedError
from ._recording import Motion, Recording, _several, native
from ._results import (Calibration, Diagnosis, Info, Noise, PathLike, Update, calibration_of,
                       diagnosis_of, info_of, update_of)

Recordings = Union[Recording, Iterable[Recording]]
NoiseLike = Union[Noise, Sequence[float]]


def _densities(noise: Optional[NoiseLike]) -> Optional[list[float]]:
    if noise is None:
        return None
    values = [noise.acc, noise.gyro, noise.mag] if isinstance(noise, Noise) else list(noise)
    if len(values) != 3 or not all(0.0 < float(v) < float("inf") for v in values):
        raise InputError("noise: give three positive densities per sqrt(Hz): m/s^2, rad/s, uT",
                         problem="noise is not three positive numbers",
                         remedy="give densities per sqrt(Hz): m/s^2, rad/s, uT")
    return [float(v) for v in values]


def _model(noise: Optional[NoiseLike], gravity: Optional[float], motion: str,
           location: str = "", hemisphere: str = "", field_prior: bool = False) -> Any:
    out = _core.ModelOptions()
    out.noise = _densities(noise)
    out.gravity = gravity
    out.motion = motion
    out.location = location
    out.hemisphere = hemisphere
    out.field_prior = field_prior
    return out


def _pairs(given: Optional[Mapping[str, Any]]) -> list[str]:
    return [f"{k}={v}" for k, v in (given or {}).items()]


def read(path: PathLike, *, map: Optional[Mapping[str, str]] = None,
         unit: Optional[Mapping[str, Union[str, float]]] = None,
         axes: Optional[Mapping[str, str]] = None, rate: Optional[float] = None,
         gyro_interval: str = "forward", columns: Sequence[str] = (),
         sensors: Sequence[str] = ()) -> Recording:
    """Reads a recording: every file that the program reads.

    Args:
        map: our columns by the file's: ``{"acc_x": "ax"}``.
        unit: the file's units: ``{"gyr": "deg/s", "mag": "gauss", "t": "ms"}``.
        axes: where the device's x, y, z are among a sensor's axes: ``{"mag": "y,-x,z"}``.
        rate: Hz, for a file without times.
        gyro_interval: a gyroscope sample is the mean rate over the interval that begins at its
            time ("forward"), has it in the middle ("centred") or ends there ("backward").
        columns: the names that a file without a header lacks; "-" ignores a column.
        sensors: of a log with several of a kind those to read, as `info` lists them:
            ``["mag=sensor_mag[1]"]``.
    """
    return Recording._of(_core.read(os.fspath(path), _pairs(map), _pairs(unit), _pairs(axes),
                                    rate or 0.0, gyro_interval, ",".join(columns),
                                    list(sensors)))


def calibrate(recordings: Recordings, *, noise: Optional[NoiseLike] = None,
              gravity: Optional[float] = None, motion: str = "auto",
              mag_time_offset: Optional[bool] = None, gyro_matrix: Optional[bool] = None,
              node_every: int = 0, dip_deg: Optional[float] = None, location: str = "",
              hemisphere: str = "", field_prior: bool = False, method: str = "map",
              as_published: bool = False, threads: int = 0) -> Calibration:
    """Calibrates accelerometer, gyroscope and magnetometers together.

    Args:
        recordings: one, or several of one device, which share its parameters.
        noise: densities per sqrt(Hz): m/s^2, rad/s, uT. Default: estimated.
        gravity: m/s^2. Default: of the location, else 9.80665.
        motion: "rotation" (the sensor only turned), "hand_held" (a hand moved it within its
            reach) or "auto": decided from the data, and said in ``motion_reason``.
        mag_time_offset: estimate the magnetometer's lag; None: where the data show one.
        gyro_matrix: estimate scale errors and misalignment of the gyroscope; None: where
            left-out data are predicted better.
        node_every: magnetometer samples a node; 0: automatic.
        dip_deg: start from this dip, positive downward. Default: from the data.
        location: "LAT,LON[,ALT],DATE", such as "52.51,13.33,2026-07-31": strength and dip are
            compared with the World Magnetic Model.
        hemisphere: "north" or "south": only the sign of the dip is.
        field_prior: let the location's field take part in the estimate.
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
    return calibration_of(_core.calibrate(native(recordings), model, mag_time_offset, gyro_matrix,
                                          node_every, dip_deg, method, as_published, threads))


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
    return diagnosis_of(*_core.diagnose(native(recordings), model, false_alarm_rate,
                                        against._fitted if against else None,
                                        base._fitted if base else None, threads))


def info(recording: Recording, *, noise: Optional[NoiseLike] = None,
         gravity: Optional[float] = None, motion: str = "auto", location: str = "",
         hemisphere: str = "", threads: int = 0) -> Info:
    """Looks at a recording before a fit: rates, faults with their remedies, axes, the motion that
    is missing, and how well each parameter could be known. Arguments as in :func:`calibrate`."""
    model = _model(noise, gravity, motion, location, hemisphere)
    return info_of(_core.info(recording._native, model, threads))


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
    if calibration.trust.verdict == "no" and not force:
        reasons = " ".join(calibration.trust.reasons)
        raise NotTrustedError(f"the verdict of this calibration is \"no\": {reasons}; "
                              "make a better recording, or give force=True",
                              problem=reasons, remedy="make a better recording, or force=True")
    corrected, formulas, not_applied = _core.apply(calibration._fitted, recording._native,
                                                   not keep_times)
    return Applied(Recording._of(corrected), list(formulas), list(not_applied))


def read_calibration(path: PathLike) -> Calibration:
    """A calibration that the program or :meth:`Calibration.save` has written.

    How its fit went stays in the file: ``fit``, ``residuals`` and ``checks`` are read as they
    stand there, trajectories are not.
    """
    with open(path, encoding="utf-8") as file:
        text = file.read()
    fitted = _core.fitted_from(text, os.fspath(path))
    out = calibration_of(fitted)
    from ._results import _build
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
        motion: "paper" (six slow turns), "hand" (turned in the hands), "hand_held" (moved, too).
        rate: IMU samples a second. mag_ratio: IMU samples per magnetometer sample.
        duration: s; 0: the motion's own. rest: s at rest first; -1: the motion's own.
        seed: names the data set. gravity: m/s^2.
        noise: densities per sqrt(Hz): m/s^2, rad/s, uT; zeros: exact readings.
        magnetometers: how many on one board. displacement: m RMS of "hand_held".
        effects: hidden in it, such as ``["mag_lag=0.012:"]`` (docs/effects.md).
    """
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
        self._magnetometers = magnetometers
        model = _model(noise, gravity, motion, location, hemisphere, field_prior)
        self._native = _core.Stream(magnetometers, model, target, window_s)

    def add(self, t: float, acc: Optional[ArrayLike] = None, gyr: Optional[ArrayLike] = None,
            mag: Optional[ArrayLike] = None) -> Optional[Update]:
        """One moment: (3,) of each sensor (mag: (m, 3) of several), None where one has no sample.
        An update where this completes a window."""
        def row(v: Optional[ArrayLike]) -> np.ndarray:
            return np.full((1, 3), np.nan) if v is None else np.reshape(np.asarray(v, float), (1, 3))

        if mag is None:
            mags = [row(None)] * self._magnetometers
        else:
            mags = [row(v) for v in np.reshape(np.asarray(mag, float), (-1, 3))]
        lines = self._native.feed(np.array([t], float), row(acc), row(gyr), mags)
        return update_of(lines[0]) if lines else None

    def feed(self, t: ArrayLike, acc: ArrayLike, gyr: ArrayLike,
             mag: Union[ArrayLike, Sequence[ArrayLike]]) -> list[Update]:
        """Many moments: t (n,), sensors (n, 3), rows of nan where one has no sample; several
        magnetometers as in :class:`Recording`. The updates of all windows completed."""
        return [update_of(line) for line in self._native.feed(t, acc, gyr, _several(mag))]

    def finish(self) -> Calibration:
        """The calibration of all samples so far. More may be added after it."""
        return calibration_of(self._native.finish())
