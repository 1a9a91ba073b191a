# SPDX-License-Identifier: BSD-3-Clause
"""What goes wrong is an exception that says what to do; fits are interrupted, and lock nothing."""
import os
import signal
import subprocess
import sys
import threading
import time
import unittest

import numpy as np

import magimu
from common import InFolder, recording


class Errors(InFolder):
    def test_of_shapes_name_the_array_and_the_remedy(self):
        t, v = np.arange(10.0), np.zeros((10, 3))
        with self.assertRaises(magimu.InputError) as caught:
            magimu.Recording(t, acc=v[:, :2], gyr=v, mag=v)
        self.assertEqual(caught.exception.file, "acc")
        self.assertIn("(10, 2)", caught.exception.problem)
        self.assertIn("(n, 3)", caught.exception.remedy)
        with self.assertRaisesRegex(magimu.InputError, "9 rows, but there are 10 times"):
            magimu.Recording(t, acc=v, gyr=v[:9], mag=v)
        with self.assertRaisesRegex(magimu.InputError, "does not increase: 4 s after 5 s, at row 6"):
            magimu.Recording(np.array([0, 1, 2, 3, 4, 5, 4, 7, 8, 9]), acc=v, gyr=v, mag=v)
        with self.assertRaisesRegex(magimu.InputError, "no times of mag; give t, or mag_t"):
            magimu.Recording(acc_t=t, acc=v, gyr_t=t, gyr=v, mag=v)

    def test_of_files_name_line_and_column(self):
        (self.folder / "bad.csv").write_text("t,acc_x,acc_y,acc_z,gyr_x,gyr_y,gyr_z,mag_x,mag_y,"
                                             "mag_z\n0,1,2,x3,4,5,6,7,8,9\n")
        with self.assertRaises(magimu.InputError) as caught:
            magimu.read(self.folder / "bad.csv")
        self.assertEqual((caught.exception.line, caught.exception.column), (2, 4))
        self.assertTrue(caught.exception.remedy)
        with self.assertRaises(magimu.InputError):
            magimu.read(self.folder / "absent.csv")
        with self.assertRaises(ValueError):
            magimu.read_calibration(self.folder / "bad.csv")

    def test_of_options(self):
        for options in ({"motion": "walk"}, {"method": "best"}, {"hemisphere": "west"},
                        {"noise": (1, 2)}, {"location": "here"}, {"field_prior": True}):
            with self.subTest(options), self.assertRaises(magimu.InputError):
                magimu.calibrate(recording(), **options)
        with self.assertRaises(magimu.InputError):
            magimu.calibrate([])
        with self.assertRaises(magimu.InputError):
            magimu.Stream(target="speed=3")

    def test_of_wrong_units_and_too_little(self):
        r = recording()
        with self.assertRaisesRegex(magimu.InputError, "nT"):
            magimu.calibrate(magimu.Recording(r.acc.t, acc=r.acc.v, gyr=r.gyr.v,
                                              mag=1000 * r.mag.v))
        short = magimu.calibrate(magimu.Recording(r.acc.t[:20], acc=r.acc.v[:20],
                                                  gyr=r.gyr.v[:20], mag=r.mag.v[:20]))
        self.assertEqual(short.trust.verdict, "no")
        self.assertTrue(short.trust.reasons)

    def test_a_calibration_that_must_not_be_used_is_refused(self):
        r = recording()
        still = magimu.Recording(r.acc.t[:140], acc=r.acc.v[:140], gyr=r.gyr.v[:140],
                                 mag=r.mag.v[:140])
        c = magimu.calibrate(still)
        self.assertEqual(c.trust.verdict, "no")
        self.assertTrue(c.trust.reasons)
        with self.assertRaises(magimu.NotTrustedError):
            magimu.apply(c, still)


LONG = """
import os, signal, sys, threading, time
import magimu
r = magimu.simulate(motion="hand_held", rate=400, duration=300, seed=2).recording
begin = time.monotonic()
threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    {call}
except KeyboardInterrupt:
    took = time.monotonic() - begin
    c = magimu.calibrate(magimu.simulate(motion="hand", rate=50, duration=60).recording)
    print("interrupted", took, c.trust.verdict)
"""


class LongWork(unittest.TestCase):
    def test_is_ended_by_ctrl_c(self):
        for call in ("magimu.diagnose([r, r, r])", "magimu.calibrate([r] * 12)",
                     "s = magimu.Stream(); s.feed(r.acc.t, r.acc.v, r.gyr.v, r.mag.v); "
                     "time.sleep(1)"):
            with self.subTest(call):
                done = subprocess.run([sys.executable, "-c", LONG.format(call=call)],
                                      capture_output=True, text=True, timeout=120)
                self.assertEqual(done.stdout.split()[:1], ["interrupted"], done.stderr)

    def test_lets_other_threads_run(self):
        r = magimu.simulate(motion="hand", rate=100, duration=117, seed=2).recording
        done, ticks = threading.Event(), []

        def work():
            magimu.diagnose([r, r])
            done.set()

        worker = threading.Thread(target=work)
        worker.start()
        while not done.wait(0.005):
            ticks.append(time.monotonic())
        worker.join()
        self.assertGreater(len(ticks), 10)


if __name__ == "__main__":
    unittest.main()
