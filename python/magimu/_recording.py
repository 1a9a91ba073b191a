# SPDX-License-Identifier: BSD-3-Clause
"""Recordings: NumPy arrays in, one object that every function of magimu takes."""
from __future__ import annotations

import datetime
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Iterable, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _core
from ._errors import InputError, refused


@dataclass(frozen=True)
class Series:
    """Samples of a sensor: t (n,) in s, v (n, 3) in the sensor's unit and axes."""

    t: np.ndarray
    v: np.ndarray

    def __len__(self) -> int:
        return len(self.t)

    @property
    def rate_hz(self) -> float:
        """Samples a second, by the median interval."""
        return float(1.0 / np.median(np.diff(self.t))) if len(self.t) > 1 else 0.0


@dataclass(frozen=True)
class Motion:
    """The true motion: t (n,), quaternion (n, 4) w x y z of the sensor in the reference frame,
    velocity and position (n, 3); empty where they are not known."""

    t: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    position: np.ndarray


def _unmasked(value: np.ma.MaskedArray, name: str) -> np.ndarray:
    """nan, no sample, for what is masked; InputError for times, which every row needs."""
    if name.endswith("t") and np.ma.is_masked(value):
        raise refused(name, "some times are masked",
                      "leave those rows out of all arrays: t[~t.mask], acc[~t.mask], ...")
    return value.astype(float).filled(np.nan)


def numbers(value: Any, name: str) -> np.ndarray:
    """An array of numbers, or InputError."""
    if value is None:
        raise refused(name, "it is None", "give an array of numbers")
    try:
        if isinstance(value, np.ma.MaskedArray):
            value = _unmasked(value, name)
        array = np.asarray(value)
        if array.dtype.kind == "M" or (array.dtype.kind == "O" and array.size
                                       and isinstance(array.flat[0], datetime.date)):
            raise refused(name, "these are dates, not numbers",
                          "give seconds, such as (t - t[0]) / np.timedelta64(1, 's')")
        if array.dtype.kind == "m":
            raise refused(name, "these are differences of dates, not numbers",
                          "give seconds, such as dt / np.timedelta64(1, 's')")
        if array.dtype.kind == "c":
            raise refused(name, "these are complex numbers", "give real ones")
        return np.asarray(array, dtype=float)
    except (TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise refused(name, f"it is no array of numbers ({error})",
                      "give numbers, one row a sample") from None


def one_dimension(times: np.ndarray, name: str) -> np.ndarray:
    """Times of shape (n,), or InputError."""
    if times.ndim != 1:
        raise refused(name, f"its shape is {times.shape}",
                      "give one time a sample, in seconds: shape (n,)")
    return times


def several(mag: Any, times: Optional[int]) -> list[np.ndarray]:
    """The magnetometers' arrays: one (n, 3), or a list of them, or (n, m, 3)."""
    if isinstance(mag, (list, tuple)) and mag:
        each = [numbers(m, "mag") for m in mag]
        # Nested lists may be either; what has a row for each time is (n, m, 3).
        rows = len(each) == times and len(each[0]) != times
        if each[0].ndim == 2 and (not rows or isinstance(mag[0], np.ndarray)):
            return each
    array = numbers(mag, "mag")
    if array.ndim == 3:
        return [array[:, m, :] for m in range(array.shape[1])]
    return [array]


class Recording:
    """A recording of one device.

    All sensors at the same times, rows of nan where one has no sample::

        Recording(t, acc=acc, gyr=gyr, mag=mag)

    or each sensor at its own::

        Recording(acc_t=ta, acc=acc, gyr_t=tg, gyr=gyr, mag_t=tm, mag=mag)

    Args:
        t: (n,) times in seconds, increasing.
        acc: (n, 3) specific force in m/s^2: +9.81 on z at rest, level.
        gyr: (n, 3) rate in rad/s: the mean over [t_k, t_k+1).
        mag: (n, 3) field in uT; several magnetometers: a list of such, or (n, m, 3).
        acc_t, gyr_t, mag_t: times of one sensor, where they differ; mag_t may be a list.
        temp: (n,) temperature, K or deg C, at ``t``. current: (n,) A, at ``t``.
        name: for messages.

    All vectors are in the sensor's own axes. InputError says which array has a wrong shape.
    """

    def __init__(self, t: Optional[ArrayLike] = None, *, acc: ArrayLike, gyr: ArrayLike,
                 mag: Union[ArrayLike, Sequence[ArrayLike]], acc_t: Optional[ArrayLike] = None,
                 gyr_t: Optional[ArrayLike] = None,
                 mag_t: Union[None, ArrayLike, Sequence[ArrayLike]] = None,
                 temp: Optional[ArrayLike] = None, current: Optional[ArrayLike] = None,
                 name: str = "recording") -> None:
        def times(own: Any, sensor: str) -> np.ndarray:
            if own is not None:
                return one_dimension(numbers(own, f"{sensor}_t"), f"{sensor}_t")
            if t is not None:
                return one_dimension(numbers(t, "t"), "t")
            raise InputError(f"there are no times of {sensor}; give t, or {sensor}_t",
                             problem=f"there are no times of {sensor}",
                             remedy=f"give t, or {sensor}_t")

        own = mag_t if isinstance(mag_t, (list, tuple)) and mag_t and np.ndim(mag_t[0]) == 1 else None
        mags = several(mag, np.size(mag_t if mag_t is not None else t) if own is None else None)
        mag_times = [numbers(m, "mag_t") for m in own] if own is not None else [times(mag_t, "mag")] * len(mags)
        if len(mag_times) != len(mags):
            raise InputError(f"there are {len(mags)} magnetometers and {len(mag_times)} mag_t; "
                             "give one a magnetometer")
        aux = {k: (times(None, k), numbers(v, k)) for k, v in (("temp", temp), ("current", current))
               if v is not None}
        self._native = _core.Recording(str(name), times(acc_t, "acc"), numbers(acc, "acc"),
                                       times(gyr_t, "gyr"), numbers(gyr, "gyr"), mag_times, mags,
                                       aux)
        # As `read` was given them, SENSOR=A,B,C; None: not known.
        self._axes: Optional[list[str]] = None

    @classmethod
    def from_dataframe(cls, frame: Any, **reading: Any) -> Recording:
        """Of a pandas DataFrame, whose columns and index are named as a file's may be.

        ``reading`` is what :func:`read` takes: ``map``, ``unit``, ``axes``, ``rate``, ... Columns
        of several levels (``("acc", "x")``) are joined; the index is the time where no column is.
        """
        from ._api import read  # which needs this module

        if not hasattr(frame, "to_csv") or not hasattr(frame, "columns"):
            raise refused("from_dataframe", f"{type(frame).__name__} is no DataFrame",
                          "give one of pandas; arrays: magimu.Recording(t, acc=, gyr=, mag=)")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "DataFrame")
            frame.to_csv(path)
            return read(path, **reading)

    @classmethod
    def _of(cls, native_recording: Any, axes: Optional[list[str]] = None) -> Recording:
        out = cls.__new__(cls)
        out._native = native_recording
        out._axes = axes
        return out

    @property
    def name(self) -> str:
        """The file's name, or what it was called."""
        return str(self._native.name)

    @property
    def notes(self) -> list[str]:
        """What the reader did, in words."""
        return list(self._native.notes)

    @property
    def duration_s(self) -> float:
        """Seconds from the first to the last IMU sample."""
        return float(self._native.duration_s())

    @property
    def acc(self) -> Series:
        """Specific force, m/s^2."""
        return Series(*self._native.acc())

    @property
    def gyr(self) -> Series:
        """Angular rate, rad/s."""
        return Series(*self._native.gyr())

    @property
    def mags(self) -> list[Series]:
        """Each magnetometer, uT."""
        return [Series(t, v) for _, t, v in self._native.mags()]

    @property
    def mag(self) -> Series:
        """The first magnetometer, uT."""
        return self.mags[0]

    @property
    def mag_names(self) -> list[str]:
        """The magnetometers' names."""
        return [name for name, _, _ in self._native.mags()]

    @property
    def aux(self) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Other columns ("temp", "current"): times and values."""
        return dict(self._native.aux())

    @property
    def truth(self) -> Optional[Motion]:
        """The motion, where cameras or a simulation know it."""
        truth = self._native.truth()
        if truth is None:
            return None
        t, quaternion, position = truth
        return Motion(t, quaternion, np.empty((0, 3)), position)

    def to_csv(self) -> str:
        """As CSV text; numbers read back as the same."""
        return str(self._native.csv())

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Writes it as CSV, whole or not at all."""
        _core.write_atomically(os.fspath(path), self.to_csv())

    def __repr__(self) -> str:
        return (f"Recording({self.name!r}, {self.duration_s:.1f} s, {len(self.acc)} acc, "
                f"{len(self.gyr)} gyr, {' + '.join(str(len(m)) for m in self.mags)} mag)")


def one(recording: Any, function: str) -> Any:
    """The compiled part's recording, or InputError where it is none."""
    if isinstance(recording, Recording):
        return recording._native
    if isinstance(recording, (str, os.PathLike)):
        raise refused(function, f"{os.fspath(recording)!r} is a path, not a Recording",
                      "read it first: magimu.read(path)")
    raise refused(function, f"{type(recording).__name__} is no Recording",
                  "make one: magimu.read(path), or magimu.Recording(t, acc=, gyr=, mag=)")


def native(recordings: Union[Recording, Iterable[Recording]], function: str) -> list[Any]:
    """The compiled part's recordings, of one or several."""
    if isinstance(recordings, (list, tuple)):
        return [one(r, function) for r in recordings]
    if isinstance(recordings, (Recording, str, os.PathLike, np.ndarray)) or not isinstance(
            recordings, Iterable):
        return [one(recordings, function)]
    return [one(r, function) for r in recordings]


def axes_of(recordings: Sequence[Recording]) -> Optional[list[str]]:
    """The axes of all, where they are known and the same."""
    first = recordings[0]._axes if recordings else None
    return first if all(r._axes == first for r in recordings) else None
