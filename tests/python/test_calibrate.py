# SPDX-License-Identifier: BSD-3-Clause
"""Calibrations from arrays: the program's numbers, to the last digit."""
import json
import time
import unittest

import numpy as np

import magimu
from common import InFolder, recording, run_program, without_times


class EqualToTheProgram(InFolder):
    def test_a_recording_from_arrays(self):
        run_program("simulate", "-q", "-o", "rec.csv", "--motion", "hand", "--rate", "50",
                    "--mag-ratio", "2", "--seed", "9", "--duration", "80", folder=self.folder)
        theirs = run_program("calibrate", "rec.csv", "--json", folder=self.folder)
        # As a user reads it, who has NumPy and nothing of ours.
        table = np.genfromtxt(self.folder / "rec.csv", delimiter=",", names=True)

        def vectors(sensor):
            return np.column_stack([table[f"{sensor}_{axis}"] for axis in "xyz"])

        mine = magimu.calibrate(magimu.Recording(table["t"], acc=vectors("acc"),
                                                 gyr=vectors("gyr"), mag=vectors("mag"),
                                                 name="rec.csv"))
        self.assertEqual(without_times(mine.to_json()), without_times(theirs))

    def test_a_file_read_by_the_module_with_options(self):
        recording().save(self.folder / "rec.csv")
        theirs = run_program("calibrate", "rec.csv", "--json", "--motion", "hand_held",
                             "--location", "52.51,13.33,2026-07-31", "--unit", "mag=4",
                             folder=self.folder)
        mine = magimu.calibrate(magimu.read(self.folder / "rec.csv", unit={"mag": 4}),
                                motion="hand_held", location="52.51,13.33,2026-07-31")
        self.assertEqual(without_times(mine.to_json()), without_times(theirs))
        self.assertEqual(mine.trust.verdict, "limited")  # twice the field of this place
        self.assertIn("WMM", mine.trust.reasons[0])
        self.assertTrue(mine.trust)

    def test_a_file_without_a_header(self):
        text = recording().to_csv()
        names, rows = text.split("\n", 1)
        (self.folder / "rows.csv").write_text(rows)
        read = magimu.read(self.folder / "rows.csv", columns=names.split(","))
        np.testing.assert_array_equal(read.mag.v, recording().mag.v)
        as_one_text = magimu.read(self.folder / "rows.csv", columns=names)
        np.testing.assert_array_equal(as_one_text.acc.v, recording().acc.v)
        with self.assertRaisesRegex(magimu.InputError, "columns"):
            magimu.read(self.folder / "rows.csv")

    def test_a_simulation(self):
        run_program("simulate", "-q", "-o", "rec.csv", "--truth", "truth.json", "--motion", "hand",
                    "--duration", "20", "--seed", "3", "--effect", "mag_lag=0.01:",
                    folder=self.folder)
        s = magimu.simulate(motion="hand", duration=20, seed=3, effects=["mag_lag=0.01:"])
        self.assertEqual(s.recording.to_csv(), (self.folder / "rec.csv").read_text())
        self.assertEqual(s.truth, json.loads((self.folder / "truth.json").read_text()))
        self.assertEqual(s.motion.quaternion.shape, (len(s.motion.t), 4))

    def test_a_diagnosis(self):
        s = magimu.simulate(motion="hand", rate=50, duration=90, seed=3,
                            effects=["mag_time_offset=0.02:"])
        s.recording.save(self.folder / "rec.csv")
        theirs = json.loads(run_program("diagnose", "rec.csv", "--json", folder=self.folder))
        d = magimu.diagnose(magimu.read(self.folder / "rec.csv"))
        mine = d.to_dict()
        for one in (mine, theirs):
            for key in ("seconds", "provenance", "calibration_before", "calibration_after"):
                one.pop(key, None)
        self.assertEqual(mine, theirs)
        self.assertEqual(d.answer, "explained")
        found = d.findings[0]
        self.assertIn(found.effect, ("mag_time_offset", "mag_lag"))
        self.assertAlmostEqual(found.parameters[0].value, 0.02,
                               delta=5 * found.parameters[0].sigma)
        self.assertIn("<html", d.report())

    def test_info(self):
        recording().save(self.folder / "rec.csv")
        theirs = json.loads(run_program("info", "-q", "--json", "rec.csv", folder=self.folder))
        mine = magimu.info(magimu.read(self.folder / "rec.csv"))
        self.assertEqual(mine.to_dict(), theirs)
        self.assertEqual([s.name for s in mine.sensors], ["acc", "gyr", "mag"])
        self.assertEqual(mine.rests.shape[1], 2)

    def test_apply(self):
        recording().save(self.folder / "rec.csv")
        run_program("calibrate", "-q", "rec.csv", "-o", "cal.json", folder=self.folder)
        run_program("apply", "-q", "cal.json", "rec.csv", "-o", "out.csv", folder=self.folder)
        c = magimu.read_calibration(self.folder / "cal.json")
        applied = magimu.apply(c, recording())
        self.assertEqual(applied.recording.to_csv(), (self.folder / "out.csv").read_text())
        lengths = np.linalg.norm(applied.recording.mag.v, axis=1)
        self.assertLess(np.std(lengths) / np.mean(lengths), 0.01)
        self.assertIn("mag", " ".join(applied.formulas))


class Results(InFolder):
    def test_are_named_fields_with_arrays(self):
        c = magimu.calibrate(recording())
        m = c.magnetometers[0]
        self.assertEqual((m.distortion.shape, m.bias.shape), ((3, 3), (3,)))
        self.assertEqual(c.covariance.matrix.shape, (19, 19))
        np.testing.assert_allclose(np.sqrt(c.covariance.of("field.dip_deg")[0, 0]),
                                   c.field.dip_deg_sigma, rtol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(m.unit_field(recording().mag.v), axis=1), 1.0,
                                   atol=0.02)
        path = c.trajectories[0]
        self.assertEqual(path.matrix.shape, (len(path.t), 3, 3))
        # Of n into the sensor's frame: what the accelerometer reads is what the matrix says.
        at = np.searchsorted(recording().acc.t, path.t[5])
        up = recording().acc.v[at] - c.accelerometer.bias
        np.testing.assert_allclose(up / 9.80665, path.matrix[5].T @ [0, 0, 1], atol=0.1)
        self.assertEqual({r.sensor for r in c.residual_series}, {"acc", "gyr", "mag"})
        self.assertIn("<html", c.report(recording()))

    def test_survive_a_file(self):
        c = magimu.calibrate(recording())
        c.save(self.folder / "cal.json")
        again = magimu.read_calibration(self.folder / "cal.json")
        np.testing.assert_array_equal(again.covariance.matrix, c.covariance.matrix)
        self.assertEqual(again.fit, c.fit)
        self.assertEqual(again.checks, c.checks)
        d = magimu.diagnose(recording(), against=again)
        self.assertTrue(d.against.tested)
        self.assertFalse(any(change.changed for change in d.against.groups))

    def test_come_for_several_recordings_and_magnetometers(self):
        one = magimu.simulate(motion="hand", rate=50, seed=4, duration=60, magnetometers=2)
        other = magimu.simulate(motion="hand", rate=50, seed=4, duration=50, magnetometers=2)
        r = one.recording
        rebuilt = magimu.Recording(r.acc.t, acc=r.acc.v, gyr=r.gyr.v, mag=[m.v for m in r.mags])
        self.assertEqual(rebuilt.mag_names, ["mag1", "mag2"])
        c = magimu.calibrate([rebuilt, other.recording])
        self.assertEqual(len(c.magnetometers), 2)
        self.assertEqual(len(c.fields), 2)


class Overhead(unittest.TestCase):
    def test_of_arrays_and_results_is_small(self):
        r = magimu.simulate(motion="hand_held", rate=200, seed=2, duration=128.715).recording
        t, acc, gyr, mag = r.acc.t, r.acc.v, r.gyr.v, r.mag.v
        self.assertEqual(len(t), 25743)
        # The fit works in threads of its own: what the calling thread computes is the overhead.
        # A share of all that is computed, so that a busy machine does not decide.
        overhead, share = [], []
        for _ in range(3):
            begin, begin_all = time.thread_time(), time.process_time()
            magimu.calibrate(magimu.Recording(t, acc=acc, gyr=gyr, mag=mag))
            overhead.append(time.thread_time() - begin)
            share.append(overhead[-1] / (time.process_time() - begin_all))
        print(f"overhead of 25743 samples: {1e3 * min(overhead):.1f} ms (asked: 10), "
              f"{100 * min(share):.1f} % of the calibration")
        self.assertLess(min(share), 0.05)


if __name__ == "__main__":
    unittest.main()
