# SPDX-License-Identifier: BSD-3-Clause
"""What is given to the functions: wrong types have a remedy, and what several processes share goes
from one to the other."""
import copy
import json
import pickle
import unittest

import numpy as np

import magimu
from common import InFolder, recording, run_program


class Arguments(InFolder):
    def refused(self, pattern, call, *arguments, **options):
        with self.assertRaisesRegex(magimu.InputError, pattern):
            call(*arguments, **options)

    def test_a_path_or_an_array_is_no_recording(self):
        for call in (magimu.calibrate, magimu.diagnose, magimu.info):
            self.refused("is a path, not a Recording; read it first", call, "rec.csv")
            self.refused("ndarray is no Recording", call, np.zeros((3, 3)))
            self.refused("int is no Recording", call, 7)
        self.refused("is a path", magimu.calibrate, [recording(), "rec.csv"])
        self.refused("Recording is no Calibration", magimu.apply, recording(), recording())

    def test_options_of_another_type_are_named(self):
        for options in ({"motion": 5}, {"gravity": "high"}, {"node_every": "all"}, {"noise": "low"},
                        {"dip_deg": "steep"}, {"gyro_matrix": "on"}, {"method": None}):
            (name,) = options
            self.refused(f"^{name}: ", magimu.calibrate, recording(), **options)
        self.refused("^magnetometers: ", magimu.Stream, "two")
        self.refused("^rate: ", magimu.simulate, rate="fast")
        self.refused("such as {'gyr': 'deg/s'}", magimu.read, "rec.csv", unit="deg/s")
        self.refused("^read: int is no path", magimu.read, 3)

    def test_arrays_that_are_none(self):
        t, v = np.arange(10.0), np.zeros((10, 3))
        self.refused("^acc: it is None", magimu.Recording, t, acc=None, gyr=v, mag=v)
        self.refused("^gyr: it is no array of numbers", magimu.Recording, t, acc=v,
                     gyr=[["a", "b", "c"]] * 10, mag=v)
        self.refused("^t: these are dates", magimu.Recording, t.astype("datetime64[s]"), acc=v,
                     gyr=v, mag=v)
        self.refused(r"^acc: its shape is \(2,\)", magimu.Stream().add, 0.0, [1, 2], v[0], v[0])
        self.refused(r"^mag: its shape is \(2, 3\)", magimu.Stream(3).add, 0.0, v[0], v[0], v[:2])

    def test_several_magnetometers_as_nested_lists_are_those_of_arrays(self):
        t = np.arange(10.0)
        v = np.arange(30.0).reshape(10, 3)
        lists = magimu.Recording(t, acc=v, gyr=v, mag=[v.tolist(), (2 * v).tolist()])
        arrays = magimu.Recording(t, acc=v, gyr=v, mag=[v, 2 * v])
        one = magimu.Recording(t, acc=v, gyr=v, mag=np.stack([v, 2 * v], 1).tolist())
        for r in (lists, arrays, one):
            self.assertEqual(r.mag_names, ["mag1", "mag2"])
            np.testing.assert_array_equal(r.mags[1].v, 2 * v)

    def test_a_calibration_that_is_not_there_is_refused_as_a_recording_is(self):
        for read in (magimu.read, magimu.read_calibration):
            self.refused("absent", read, self.folder / "absent.json")

    def test_a_prior_may_be_a_calibration_or_its_file(self):
        c = magimu.calibrate(recording())
        c.save(self.folder / "old.json")
        ways = [magimu.calibrate(recording(), prior=p, prior_age=0, prior_drift=2)
                for p in (c, self.folder / "old.json")]
        np.testing.assert_array_equal(ways[0].magnetometers[0].bias, ways[1].magnetometers[0].bias)
        self.assertFalse(np.array_equal(ways[0].magnetometers[0].bias, c.magnetometers[0].bias))
        self.assertLess(ways[0].magnetometers[0].bias_sigma[0], c.magnetometers[0].bias_sigma[0])
        self.assertNotEqual(magimu.calibrate(recording(), prior="none").to_dict()["prior"],
                            c.to_dict()["prior"])
        self.refused("--prior-age", magimu.calibrate, recording(), prior_age=3)

    def test_an_export_is_that_of_the_program(self):
        c = magimu.calibrate(recording())
        c.save(self.folder / "cal.json")
        run_program("export", "cal.json", "--to", "ros", "-o", "ros.yaml", folder=self.folder)

        def numbers_of(text):
            return [line for line in text.splitlines() if not line.lstrip().startswith("#")]
        self.assertEqual(numbers_of(magimu.export(c, "ros").text),
                         numbers_of((self.folder / "ros.yaml").read_text()))
        self.refused("no system known", magimu.export, c, "mars")

    def test_a_file_has_the_axes_and_where_it_comes_from(self):
        recording().save(self.folder / "rec.csv")
        turned = magimu.read(self.folder / "rec.csv", axes={"mag": "-x,-y,-z"})
        file = magimu.calibrate(turned).to_dict()
        self.assertEqual(file["axes"], {"mag": "-x,-y,-z"})
        self.assertIn("rec.csv", file["provenance"]["files"][0])
        self.assertNotIn("axes", magimu.calibrate(recording()).to_dict())

    def test_a_calibration_that_was_read_is_written_as_it_was(self):
        recording().save(self.folder / "rec.csv")
        run_program("calibrate", "rec.csv", "-o", "cal.json", folder=self.folder)
        magimu.read_calibration(self.folder / "cal.json").save(self.folder / "again.json")
        self.assertEqual((self.folder / "again.json").read_text(),
                         (self.folder / "cal.json").read_text())

    def test_the_paper_s_sequence_is_simulated(self):
        self.assertGreater(magimu.simulate(motion="sequence").recording.duration_s, 30)


class Copies(unittest.TestCase):
    def test_of_a_recording_are_the_same_to_the_last_bit(self):
        made = magimu.simulate(motion="hand_held", magnetometers=2, duration=20).recording
        for r in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
            self.assertEqual(r.to_csv(), made.to_csv())
            self.assertEqual((r.name, r.mag_names, r.notes), (made.name, made.mag_names, made.notes))
            np.testing.assert_array_equal(r.mags[1].v, made.mags[1].v)

    def test_of_a_calibration_do_what_it_does(self):
        made = magimu.calibrate(recording())
        for c in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
            self.assertEqual(json.loads(c.to_json()), json.loads(made.to_json()))
            np.testing.assert_array_equal(c.trajectories[0].quaternion,
                                          made.trajectories[0].quaternion)
            np.testing.assert_array_equal(magimu.apply(c, recording()).recording.mag.v,
                                          magimu.apply(made, recording()).recording.mag.v)


class Masked(unittest.TestCase):
    def test_masked_samples_are_none_and_masked_times_are_refused(self):
        n = 300
        t, a = np.arange(n) * 0.02, np.random.default_rng(1).normal(size=(n, 3))
        mag = np.ma.array(30.0 * a, mask=np.zeros((n, 3), dtype=bool))
        mag[10:20] = np.ma.masked
        r = magimu.Recording(t, acc=a, gyr=a, mag=mag)
        self.assertEqual((len(r.acc), len(r.mag)), (n, n - 10))
        late = np.ma.array(t, mask=[True] + [False] * (n - 1))
        with self.assertRaisesRegex(magimu.InputError, "times are masked"):
            magimu.Recording(late, acc=a, gyr=a, mag=mag)


if __name__ == "__main__":
    unittest.main()
