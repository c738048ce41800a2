#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that all files, `nlo` commands, options and tests that comments and docs name exist, and that versions agree.

usage: tests/properties/references.py

Prints each broken reference as FILE:LINE: WHAT, each file whose version differs from that of CMakeLists.txt, and
each exception below that is no longer needed. The exit code is 1 if there is one, or if a made-up reference is missed.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PARTS = ("runtime", "codegen", "trainer", "bindings", "tests", "bench", "examples", "docs", "cmake", "toolchains")
COMMENT = {".h": "//", ".cpp": "//", ".inc": "//", ".c": "//", ".sh": "#", ".py": "#", ".cmake": "#", ".txt": "#"}

FILE = re.compile(r"(?<![\w./~<>{}$*-])((?:[\w.-]+/)*[\w-]+\.(?:h|cpp|inc|sh|py|cmake|md))(?![\w/]|\.\w)")
COMMAND = re.compile(r"`(?:\./)?nlo ([a-z][a-z0-9-]*)")
OPTION = re.compile(r"(?<![\w-])(--[a-z][a-z0-9-]+)")
TEST = re.compile(r"\b([A-Z][a-z]\w*)\.([A-Z][a-z]+[A-Z]\w*)\b")

# File: pattern of its version; in a requirement, only major and minor version are compared.
VERSIONS = {
    "CMakeLists.txt": r"^project\(nlo VERSION ([\d.]+)",
    "conanfile.py": r"^    version = \"([\d.]+)",
    "library.json": r"^  \"version\": \"([\d.]+)",
    "CITATION.cff": r"^version: ([\d.]+)",
    "CHANGELOG.md": r"^## \[(\d[\d.]*)\]",
    "examples/minimal/CMakeLists.txt": r"find_package\(nlo ([\d.]+)",
    "examples/control_loop/CMakeLists.txt": r"find_package\(nlo ([\d.]+)",
    "tests/install/components_test.sh": r"find_package\(nlo ([\d.]+)",
}

# For each reference that may be broken, the reason.
GENERATED = "what a user exports"
PLACEHOLDER = "stands for any name"
REMOVED = "was removed, as the changelog says"
SLURM = "an option of sbatch"
EXCEPTIONS = {
    "van_der_pol.h": GENERATED,
    "van_der_pol_replay.h": GENERATED,
    "firmware/van_der_pol.h": GENERATED,
    "firmware/van_der_pol_replay.h": GENERATED,
    "pendulum.h": GENERATED,
    "--man": REMOVED,
    "--csv": REMOVED,
    "nlo bound": REMOVED,
    "nlo completion": REMOVED,
    "nlo man": REMOVED,
    "--fit": REMOVED,
    "NAME.h": PLACEHOLDER,
    "NAME_replay.h": PLACEHOLDER,
    "a_test.cpp": PLACEHOLDER,
    "b_test.cpp": PLACEHOLDER,
    "folder/source.cpp": PLACEHOLDER,
    "loop.cpp": "a user's own program",
    "DOCUMENT.md": PLACEHOLDER,
    "--array": SLURM,
    "--cpus-per-task": SLURM,
    "--requeue": SLURM,
}


def files():
    return [file for file in [*ROOT.glob("*.md"), *ROOT.glob("*.sh"), ROOT / "CMakeLists.txt",
                              *(file for part in PARTS for file in sorted((ROOT / part).rglob("*")))]
            if file.is_file() and (file.suffix in COMMENT or file.suffix == ".md") and "golden" not in file.parts]


def prose(file, text):
    """Yields (line number, text): all of a page, the comments of a source."""
    mark = COMMENT.get(file.suffix)
    for number, line in enumerate(text.splitlines(), 1):
        if mark is None:
            yield number, line
        elif match := re.search(rf"(?:^|\s){mark}+[!/<]*\s(.*)", line):
            yield number, match.group(1)


def other_versions(texts):
    """Returns the files of VERSIONS that name another version than that of the project, or no version."""
    found = {file: (re.search(pattern, texts[file], re.M) or [None, "none"])[1] for file, pattern in VERSIONS.items()}
    version = found["CMakeLists.txt"]
    return [f"{file}: names version {named}, CMakeLists.txt {version}" for file, named in found.items()
            if named != version and not (VERSIONS[file].startswith("find_package") and version.startswith(named + "."))]


class Known:
    def __init__(self):
        every = [file.relative_to(ROOT).as_posix() for file in ROOT.rglob("*")
                 if not {"build", "out", ".git"} & set(file.relative_to(ROOT).parts[:1])]
        # Files that the diffs of docs/extending.md add exist too.
        diffs = "\n".join(file.read_text() for file in sorted((ROOT / "docs/extending").glob("*.diff")))
        every += re.findall(r"^\+\+\+ b/(.+)$", diffs, re.M)
        self.ends = {path[i:] for path in every for i in [0] + [m.end() for m in re.finditer("/", path)]}
        sources = [file for file in files() if file.suffix != ".md" and file.name != "references.py"]
        # An option or a command exists if a source has it outside of comments.
        code = "\n".join(re.sub(rf"(^|\s){COMMENT[f.suffix]}.*", "", f.read_text(), flags=re.M) for f in sources)
        self.options = set(OPTION.findall(code))
        commands = "\n".join(file.read_text() for file in sorted((ROOT / "trainer/app/commands").glob("*.cpp"))) + diffs
        self.commands = set(re.findall(r'add_subcommand\(\s*"([a-z-]+)"', commands)) | set(
            re.findall(r'\{"([a-z-]+)",', commands))
        self.tests = {}
        for suite, test in re.findall(r"^(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", code, re.M):
            self.tests.setdefault(suite, set()).add(test)

    def objections(self, line):
        """Yields the broken references of a line."""
        for name in FILE.findall(line):
            name = re.sub(r"^(\.\.?/)+", "", name)
            if name not in self.ends and f"nlo/{name}" not in self.ends:
                yield name
        for name in COMMAND.findall(line):
            if name not in self.commands:
                yield f"nlo {name}"
        for name in OPTION.findall(line):
            if name not in self.options:
                yield name
        for suite, test in TEST.findall(line):
            if suite in self.tests and not any(name.startswith(test) for name in self.tests[suite]):
                yield f"{suite}.{test}"


def main():
    known = Known()
    made_up = "see trainer/no_such_file.h, `nlo conjure`, --no-such-option, Csv.HasNoSuchTest"
    seen = list(known.objections(made_up))
    if len(seen) != 4:
        print(f"the scan has a fault: of a file, a command, an option and a test that do not exist it found only {seen}")
        return 1
    texts = {file: (ROOT / file).read_text() for file in VERSIONS}
    seen = other_versions({**texts, "CMakeLists.txt": "project(nlo VERSION 0.0.1"})
    if len(seen) != len(VERSIONS) - 1 or not other_versions({**texts, "CITATION.cff": ""}):
        print(f"of {len(VERSIONS) - 1} old versions only these are seen, or one that is missing is not: {seen}")
        return 1
    failed, needed = False, set()
    for fault in other_versions(texts):
        print(fault)
        failed = True
    for file in files():
        for number, line in prose(file, file.read_text()):
            for reference in known.objections(line):
                if reference in EXCEPTIONS:
                    needed.add(reference)
                else:
                    print(f"{file.relative_to(ROOT)}:{number}: {reference} does not exist")
                    failed = True
    for reference in sorted(set(EXCEPTIONS) - needed):
        print(f"tests/properties/references.py: nothing names {reference} any more: remove it from EXCEPTIONS")
        failed = True
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
