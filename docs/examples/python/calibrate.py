# SPDX-License-Identifier: BSD-3-Clause
# A notebook in plain Python: editors show the parts between "# %%" as cells.

# %% [markdown]
# # Calibrating a magnetometer and an IMU from NumPy arrays
# No sensor at hand? This makes a recording whose truth is known.

# %%
import numpy as np

import magimu

made = magimu.simulate(motion="hand", rate=100, duration=100, seed=8)
t, acc = made.recording.acc.t, made.recording.acc.v  # s; m/s^2, shape (n, 3)
gyr, mag = made.recording.gyr.v, made.recording.mag.v  # rad/s; uT

# %% [markdown]
# ## Before the fit: is the recording good enough?

# %%
recording = magimu.Recording(t, acc=acc, gyr=gyr, mag=mag, name="example")
info = magimu.info(recording)
for sensor in info.sensors:
    print(f"{sensor.name}: {sensor.samples} samples at {sensor.rate_hz:.0f} Hz")
for issue in info.issues:
    print(f"{issue.severity}: {issue.problem}; {issue.remedy}.")
assert not [i for i in info.issues if i.severity == "fatal"]

# %% [markdown]
# ## The calibration, and whether to believe it

# %%
calibration = magimu.calibrate(recording)
print(calibration)
print("trust:", calibration.trust.verdict, *calibration.trust.reasons)
assert calibration.trust

magnetometer = calibration.magnetometers[0]
for axis, value, sigma in zip("xyz", magnetometer.bias, magnetometer.bias_sigma):
    print(f"hard iron {axis}: {value:.3f} +- {sigma:.3f} uT")

# %% [markdown]
# The truth lies within its standard deviations.

# %%
true_bias = np.array(made.truth["magnetometers"][0]["bias"])
print("off by", (magnetometer.bias - true_bias) / magnetometer.bias_sigma, "sigmas")
assert np.all(np.abs(magnetometer.bias - true_bias) < 5 * magnetometer.bias_sigma)

# %% [markdown]
# ## Using it
# The unit field in the IMU's frame, for single readings or whole arrays; its length was anything
# before and is 1 now.

# %%
unit = magnetometer.unit_field(mag)
before, after = np.linalg.norm(mag, axis=1), np.linalg.norm(unit, axis=1)
print(f"length of the field varies by {before.std() / before.mean():.1%} before, "
      f"{after.std() / after.mean():.2%} after")
assert after.std() < 0.01

# %% [markdown]
# Everything that was found, taken out of a recording at once:

# %%
corrected = magimu.apply(calibration, recording)
print(*corrected.formulas, sep="\n")

# %% [markdown]
# ## The estimated attitude
# `matrix[k]` turns vectors of the IMU's frame into n (X east, Y magnetic north, Z up).

# %%
path = calibration.trajectories[0]
up_in_body = path.matrix[:, 2, :]  # the last row of R is "up", seen from the sensor
print("attitudes:", path.matrix.shape, "- up points along the sensor's z axis",
      f"{np.mean(up_in_body[:, 2] > 0.9):.0%} of the time")

# %% [markdown]
# ## While you collect
# Feed samples as they come; every second there is an update that says what to do next.

# %%
stream = magimu.Stream(target="heading=0.5deg")
for k in range(len(t)):
    update = stream.add(t[k], acc[k], gyr[k], mag[k])
    if update and update.phase == "converged":
        print(f"good enough after {update.t:.0f} s: {update.headline}")
        break
print("heading, when it ended:", update.target[0].sigma, "deg")

# %% [markdown]
# ## Does the simulation predict the data?

# %%
diagnosis = magimu.diagnose(recording)
print(diagnosis.answer, *diagnosis.answer_evidence)
for finding in diagnosis.findings:
    print(finding.sentence)
