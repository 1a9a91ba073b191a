# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the module share: the program to compare with, a recording, folders."""
import functools
import json
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import magimu

PROGRAM = os.environ["MAGIMU_BINARY"]
SOURCE = Path(os.environ["MAGIMU_SOURCE"])


def run_program(*arguments, folder, expect=0):
    """The program's standard output."""
    done = subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True)
    assert done.returncode == expect, done.stderr
    return done.stdout


@functools.lru_cache(maxsize=None)
def recording():
    """Turned in the hands for a minute and a half."""
    return magimu.simulate(motion="hand", rate=50, seed=4, duration=90).recording


def without_times(calibration):
    """A calibration's JSON without what differs from run to run, or names files."""
    out = json.loads(calibration) if isinstance(calibration, str) else dict(calibration)
    for key in ("provenance", "fields", "axes"):
        out.pop(key, None)
    out["fit"].pop("seconds", None)
    return out


class InFolder(unittest.TestCase):
    """Tests that write files."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
