# SPDX-License-Identifier: BSD-3-Clause
"""What is written of the module holds: the README's example, the docstrings, the stubs, the wheel."""
import inspect
import os
import re
import subprocess
import sys
import unittest
from pathlib import Path

import magimu
from common import SOURCE, InFolder, recording


def examples(text):
    """Indented pieces of code that import the module."""
    pieces = re.findall(r"(?:^(?:    .*)?\n)+", text, re.MULTILINE)
    return [inspect.cleandoc(p) for p in pieces if re.match(r"\s*import magimu", p)]


class Documents(InFolder):
    def test_examples_of_the_readme_run(self):
        recording().save(self.folder / "hand_rotation.csv")
        found = examples((SOURCE / "README.md").read_text(encoding="utf-8"))
        self.assertTrue(found)
        for code in found:
            done = subprocess.run([sys.executable, "-c", code], cwd=self.folder,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(done.stdout)

    def test_notebook_style_examples_run(self):
        found = sorted((SOURCE / "docs/examples/python").glob("*.py"))
        self.assertTrue(found)
        for example in found:
            done = subprocess.run([sys.executable, example], cwd=self.folder, capture_output=True,
                                  text=True)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_everything_public_has_a_docstring(self):
        for name in magimu.__all__:
            thing = getattr(magimu, name)
            if name.startswith("__"):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            if not inspect.isclass(thing):
                continue
            for member, value in vars(thing).items():
                if not member.startswith("_") and (inspect.isfunction(value)
                                                   or isinstance(value, property)):
                    self.assertTrue(value.__doc__, f"{name}.{member}")

    def test_stubs_name_what_the_compiled_part_has(self):
        stubs = (Path(magimu.__file__).parent / "_core.pyi").read_text(encoding="utf-8")
        said = set(re.findall(r"^(?:def|class) (\w+)|^(\w+):", stubs, re.MULTILINE))
        names = {a or b for a, b in said}
        there = {n for n in dir(sys.modules["magimu._core"]) if not n.startswith("_")}
        self.assertEqual(names, there)


class Wheel(InFolder):
    def test_installed_by_pip_it_is_complete(self):
        core = next(Path(magimu.__file__).parent.glob("_core*.so"), None)
        if core is None:
            self.skipTest("the compiled part is built into the interpreter (MAGIMU_PYTHON is OFF)")
        source = self.folder / "source"
        source.mkdir()
        for name in ("pyproject.toml", "setup.py", "README.md", "CMakeLists.txt", "LICENSE",
                     "python"):
            (source / name).symlink_to(SOURCE / name)
        target = self.folder / "site"
        done = subprocess.run([sys.executable, "-m", "pip", "install", "--no-build-isolation",
                               "--no-deps", "--no-index", "--target", target, source],
                              env={**os.environ, "MAGIMU_PREBUILT": str(core)},
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        installed = {p.name for p in (target / "magimu").iterdir() if p.is_file()}
        self.assertEqual(installed, {p.name for p in (SOURCE / "python/magimu").iterdir()
                                     if p.is_file()} | {core.name})
        done = subprocess.run([sys.executable, "-c", "import magimu; print(magimu.__version__)"],
                              env={**os.environ, "PYTHONPATH": str(target)}, cwd=self.folder,
                              capture_output=True, text=True)
        self.assertEqual(done.stdout.strip(), magimu.__version__, done.stderr)
        self.assertTrue(list(target.glob(f"magimu-{magimu.__version__}.dist-info")))


if __name__ == "__main__":
    unittest.main()
