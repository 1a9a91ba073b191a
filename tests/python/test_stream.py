# SPDX-License-Identifier: BSD-3-Clause
"""Streams fed from Python: the program's lines and calibration."""
import json
import unittest

import numpy as np

import magimu
from common import InFolder, recording, run_program, without_times


class Stream(InFolder):
    def test_says_what_the_program_says(self):
        r = recording()
        r.save(self.folder / "rec.csv")
        out = run_program("stream", "rec.csv", "-o", "cal.json", folder=self.folder)
        lines = [json.loads(line) for line in out.splitlines()]
        stream = magimu.Stream()
        updates = stream.feed(r.acc.t, r.acc.v, r.gyr.v, r.mag.v)
        self.assertEqual(len(updates), len([line for line in lines if line["window"]["dof"] >= 0
                                            and line["samples"] <= len(r.acc)]))
        for update, line in zip(updates, lines):
            self.assertEqual((update.t, update.samples, update.phase, update.headline),
                             (line["t"], line["samples"], line["phase"], line["headline"]))
            if update.theta:
                self.assertEqual(update.theta.magnetometers[0].bias.tolist(),
                                 line["theta"]["magnetometers"][0]["bias"])
        c = stream.finish()
        theirs = json.loads((self.folder / "cal.json").read_text())
        theirs["method"] = "map"
        self.assertEqual(without_times(c.to_json()), without_times(theirs))

    def test_takes_samples_one_by_one_and_whole_arrays_alike(self):
        r = recording()
        n = 1500
        one, many = magimu.Stream(), magimu.Stream()
        single = []
        for k in range(n):
            # Every other sample of the magnetometer only.
            update = one.add(r.acc.t[k], r.acc.v[k], r.gyr.v[k], r.mag.v[k] if k % 2 else None)
            if update:
                single.append(update)
        mag = r.mag.v[:n].copy()
        mag[::2] = np.nan
        whole = many.feed(r.acc.t[:n], r.acc.v[:n], r.gyr.v[:n], mag)
        self.assertGreater(len(whole), 20)
        self.assertEqual([u.guidance for u in single], [u.guidance for u in whole])
        self.assertEqual(single[-1].theta.field, whole[-1].theta.field)

    def test_refuses_time_that_goes_back(self):
        stream = magimu.Stream()
        zero = np.zeros(3)
        stream.add(1.0, zero, zero, zero)
        with self.assertRaises(magimu.InputError):
            stream.add(0.5, zero, zero, zero)

    def test_names_a_wrong_unit(self):
        r = recording()
        stream = magimu.Stream()
        updates = stream.feed(r.acc.t, r.acc.v, r.gyr.v, 1000 * r.mag.v)
        self.assertIn("nT", updates[-1].issues[0].remedy)
        with self.assertRaisesRegex(magimu.InputError, "nT"):
            stream.finish()

    def test_of_two_magnetometers(self):
        s = magimu.simulate(motion="hand", rate=50, duration=60, seed=2, magnetometers=2)
        r = s.recording
        stream = magimu.Stream(2, target="heading=2deg")
        stream.feed(r.acc.t, r.acc.v, r.gyr.v, [m.v for m in r.mags])
        self.assertEqual([m.name for m in stream.finish().magnetometers], ["mag1", "mag2"])


if __name__ == "__main__":
    unittest.main()
