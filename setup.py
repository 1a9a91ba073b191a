# SPDX-License-Identifier: BSD-3-Clause
"""Builds the compiled part of the Python module by CMake: that target, no tests, no measurements.

MAGIMU_BUILD_DIR: a folder to build in and to keep; CMAKE_ARGS: more arguments for CMake; JOBS: how
many compilers at a time; MAGIMU_PREBUILT: the compiled part, where it is built already.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent


def version() -> str:
    """CMake's."""
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(magimu VERSION ([0-9.]+)", text).group(1)


def pybind11_folder() -> list[str]:
    """Where pip's pybind11 has its CMake files; CMake itself finds that of the system."""
    try:
        import pybind11
    except ImportError:
        return []
    folder = Path(pybind11.get_cmake_dir()) if hasattr(pybind11, "get_cmake_dir") else None
    return [f"-Dpybind11_DIR={folder}"] if folder and folder.is_dir() else []


class BuildWithCMake(build_ext):
    """The extension is CMake's target magimu_python."""

    def build_extension(self, ext: Extension) -> None:
        built = os.environ.get("MAGIMU_PREBUILT") or self.build_core()
        target = Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built, target)

    def build_core(self) -> Path:
        """By CMake, in a folder of its own."""
        build = Path(os.environ.get("MAGIMU_BUILD_DIR", Path(self.build_temp) / "cmake")).resolve()
        build.mkdir(parents=True, exist_ok=True)
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        configure = ["cmake", "-S", str(ROOT), "-B", str(build), *generator, *pybind11_folder(),
                     "-DCMAKE_BUILD_TYPE=Release", "-DMAGIMU_PYTHON=ON", "-DMAGIMU_BUILD_TESTS=OFF",
                     "-DMAGIMU_BUILD_BENCH=OFF", f"-DPython_EXECUTABLE={sys.executable}",
                     *os.environ.get("CMAKE_ARGS", "").split()]
        jobs = os.environ.get("JOBS", str(os.cpu_count() or 1))
        for command in (configure,
                        ["cmake", "--build", str(build), "--target", "magimu_python", "-j", jobs]):
            subprocess.run(command, check=True)
        return next((build / "python" / "magimu").glob("_core*.so"))


setup(version=version(), ext_modules=[Extension("magimu._core", sources=[])],
      cmdclass={"build_ext": BuildWithCMake})
