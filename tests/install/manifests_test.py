#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""library.json (PlatformIO) and conanfile.py (Conan) give a program in an empty folder the headers that it includes.

usage: manifests_test.py SOURCE_DIR NLO WORK_DIR

Neither PlatformIO nor Conan runs here. The test follows their documentation:
it copies the exported files, sets the include path and calls the methods of the recipe. Then it compiles and runs an
exported observer with these headers alone.
"""
import fnmatch
import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys
import types

SOURCE, NLO, WORK = (pathlib.Path(argument).resolve() for argument in sys.argv[1:])


def flies(name, include_dirs, standard):
    """Compiles and runs flies.cpp in an empty folder that holds van_der_pol.h, with these include folders."""
    folder = WORK / name / "project"
    folder.mkdir(parents=True)
    shutil.copy(SOURCE / "tests/install/flies.cpp", folder)
    subprocess.run([NLO, "export", SOURCE / "examples/models/van_der_pol.json", "--quiet", "-o", folder / "van_der_pol.h"], check=True)
    command = ["g++", f"-std={standard}", "-o", "flies", "flies.cpp", *(f"-I{path}" for path in include_dirs)]
    if subprocess.run(command[:5], cwd=folder, capture_output=True).returncode == 0:
        sys.exit(f"FAILED: {name}: it compiles even without the package, so the test proves nothing")
    subprocess.run(command, cwd=folder, check=True)
    print(f"ok       {name}: {subprocess.run([folder / 'flies'], check=True, capture_output=True, text=True).stdout.strip()}")


def copy_matching(patterns, source, target):
    """Copies the files below source whose path, or whose folder, matches a pattern."""
    copied = 0
    for file in sorted(source.rglob("*")):
        path = file.relative_to(source)
        if file.is_file() and any(fnmatch.fnmatch(str(part), pattern) for part in [path, *path.parents] for pattern in patterns):
            (target / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, target / path)
            copied += 1
    return copied


def platformio():
    manifest = json.loads((SOURCE / "library.json").read_text())
    # Limits of PlatformIO's schema.
    limits = {"name": r"[a-zA-Z\d][a-zA-Z\d-]{,48}[a-zA-Z\d]", "version": r"\d+\.\d+\.\d+", "description": r".{1,255}",
              "license": "MIT", "frameworks": r"\*", "platforms": r"\*"}
    faults = [key for key, pattern in limits.items() if not re.fullmatch(pattern, manifest[key])]
    faults += [word for word in manifest["keywords"] if not re.fullmatch(r"[a-z\d][a-z\d-]{,48}[a-z\d]", word)]
    library = WORK / "platformio/lib/nlo"
    if not copy_matching(["library.json", *manifest["export"]["include"]], SOURCE, library):
        faults.append("nothing is exported")
    folders = [library / manifest["build"][key] for key in ("includeDir", "srcDir")]
    faults += [f"{header} is not there" for header in manifest["headers"] if not (folders[0] / header).is_file()]
    # All sources below srcDir would be compiled, for every board.
    faults += [file for file in folders[1].rglob("*") if file.suffix in (".c", ".cc", ".cpp", ".S", ".s")]
    if faults:
        sys.exit(f"FAILED: library.json: {faults}")
    flies("platformio", folders, "gnu++20")


def conan():
    copied = []

    def copy(_, pattern, source, target):
        copied.append(copy_matching([pattern], pathlib.Path(source), pathlib.Path(target)))

    for name, members in {"conan": {"ConanFile": object}, "conan.tools": {}, "conan.tools.build": {"check_min_cppstd": None},
                          "conan.tools.files": {"copy": copy}}.items():
        sys.modules[name] = types.ModuleType(name)
        sys.modules[name].__dict__.update(members)
    spec = importlib.util.spec_from_file_location("conanfile", SOURCE / "conanfile.py")
    module = importlib.util.module_from_spec(spec)
    sys.dont_write_bytecode = True
    spec.loader.exec_module(module)
    recipe = module.Nlo()
    recipe.source_folder, recipe.package_folder = str(WORK / "conan/source"), str(WORK / "conan/package")
    copy_matching(recipe.exports_sources, SOURCE, WORK / "conan/source")
    recipe.package()
    properties = {}
    recipe.cpp_info = types.SimpleNamespace(set_property=properties.__setitem__)
    recipe.package_info()
    if 0 in copied or not (WORK / "conan/package/licenses/LICENSE").is_file() or recipe.cpp_info.libdirs:
        sys.exit(f"FAILED: conanfile.py: copied {copied}")
    flies("conan", [WORK / "conan/package/include"], "c++20")


if __name__ == "__main__":
    shutil.rmtree(WORK, ignore_errors=True)
    platformio()
    conan()
