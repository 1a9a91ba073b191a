#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""docs/check.py fails where a room includes another one than docs/design.md says."""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def check_in(root):
    spec = importlib.util.spec_from_file_location("check", ROOT / "docs/check.py")
    check = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(check)
    check.ROOT = root
    return check


class IncludesOfRooms(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = pathlib.Path(folder.name)
        (self.root / "docs").mkdir()
        shutil.copy(ROOT / "docs/design.md", self.root / "docs")
        self.check = check_in(self.root)

    def faults(self, room, *lines):
        """The numbers of the lines that are faults."""
        file = f"{room}/planted.h"
        (self.root / room).mkdir(parents=True, exist_ok=True)
        (self.root / file).write_text("\n".join(lines) + "\n")
        return [int(said.split(":")[1]) for said in self.check.check_rooms([file])]

    def test_an_include_of_any_room_further_down_is_a_fault(self):
        rooms = list(self.check.rooms_of_table())
        self.assertGreater(len(rooms), 60)
        for i, room in enumerate(rooms):
            below = [other for other in rooms[i + 1:] if not other.startswith(("graph/", "statistics"))]
            planted = [f'#include "{other}/anything.h"' for other in below]
            told = [below[number - 1] for number in self.faults(room, *planted)]
            self.assertEqual(told, below, room)

    def test_an_include_of_a_room_that_is_named_is_none(self):
        may = self.check.rooms_of_table()
        for room, names in may.items():
            planted = [f'#include "{other}/anything.h"' for other in names or []]
            self.assertEqual(self.faults(room, *planted), [], room)

    def test_no_way_of_writing_it_hides_it(self):
        for line in ('#include "diagnosis/diagnose.h"', '  #  include "diagnosis/diagnose.h"',
                     "#include <diagnosis/diagnose.h>", "#include <magimu/diagnosis/diagnose.h>"):
            self.assertEqual(self.faults("graph", line), [1], line)
        self.assertEqual(self.faults("graph", "#include <vector>"), [])


class TheWholeCheck(unittest.TestCase):
    def test_fails_by_one_planted_include_and_by_nothing_else(self):
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT,
                                capture_output=True, text=True)
        if listed.returncode != 0:
            self.skipTest("no git repository")
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in listed.stdout.splitlines():
                if (ROOT / name).is_file():
                    (root / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(ROOT / name, root / name)
            subprocess.run(["git", "init", "-q", folder], check=True)

            def run():
                return subprocess.run([sys.executable, root / "docs/check.py"],
                                      capture_output=True, text=True)

            before = run()
            self.assertEqual((before.returncode, before.stderr), (0, ""))
            header = root / "graph/rot3.h"
            header.write_text(header.read_text() + '#include "calibration/calibrate.h"\n')
            after = run()
            self.assertEqual(after.returncode, 1)
            self.assertEqual(len(after.stderr.splitlines()), 1, after.stderr)
            self.assertIn("graph/ does not include calibration/", after.stderr)


if __name__ == "__main__":
    unittest.main()
