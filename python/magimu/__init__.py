# SPDX-License-Identifier: BSD-3-Clause
"""magimu: calibrates a magnetometer and an IMU together, and says how sure it is.

    import magimu

    recording = magimu.read("hand_rotation.csv")          # or magimu.Recording(t, acc=..., ...)
    calibration = magimu.calibrate(recording)
    print(calibration.trust.verdict, calibration.magnetometers[0].bias)
    calibration.save("cal.json")

Units are SI, but the magnetic field in microtesla: s, m/s^2, rad/s, uT. Frames: the sensor's own
axes; n has X east, Y magnetic north, Z up; R turns IMU-frame vectors into n. The models are

    acc = -R' g + o_a        gyr = omega + o_w        mag = D R' m(dip) + o_m

Everything is copied: arrays handed over may be changed afterwards. Fits release the interpreter's
lock, and Ctrl-C ends them.
"""
from ._api import (Applied, Exported, Simulation, Stream, apply, calibrate, diagnose, export, info,
                   read, read_calibration, simulate)
from ._core import version as __version__
from ._errors import InputError, NotTrustedError, NumericalError, TooLittleError
from ._recording import Motion, Recording, Series
from ._results import (Against, Calibration, Change, Check, Covariance, Diagnosis, Disturbance,
                       Effect, Finding, Fit, Info, Issue, Magnetometer, Noise, Parameter,
                       Trajectory, Trust, Update)

__all__ = [
    "Against", "Applied", "Calibration", "Change", "Check", "Covariance", "Diagnosis",
    "Disturbance", "Effect", "Exported", "Finding", "Fit", "Info", "InputError", "Issue", "Magnetometer",
    "Motion", "Noise", "NotTrustedError", "NumericalError", "Parameter", "Recording", "Series",
    "Simulation", "Stream", "TooLittleError", "Trajectory", "Trust", "Update", "__version__",
    "apply", "calibrate", "diagnose", "export", "info", "read", "read_calibration", "simulate",
]
