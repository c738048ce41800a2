#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that pages, help texts and errors use plain words, that links have a target and examples are valid TOML.

usage: tests/properties/pages.py

Prints each word of WORDS in README, docs, the latest part of CHANGELOG, help texts, errors, templates of generated code
and the comments of runtime and examples as FILE:LINE: WHAT. Also prints each link whose file or heading does not exist,
and each TOML example of a page that cannot be parsed. The exit code is 1 if there is one, or if the made-up faults of
check_the_scan() are not found. Nothing counts lines or words.
"""
import pathlib
import re
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent

# Words that are not used, and their replacements.
WORDS = {
    r"mend(s|ed|ing)?": "fix, repair, remedy",
    r"anew|afresh": "again, a new ...",
    r"(?<!there )(?<!there, )is no (?!longer|more|less|better|worse|larger|smaller)": "is not a ..., has no ...",
    r"(that|which) is none|and none is": "is not one",
    r"none is (?!better|worse|needed)": "there is none",
    r"(past|out of|left the) (all|finite|the) numbers|the finite numbers": "overflowed, is not finite",
    r"off by": "wrong by, has an error of",
    r"tells? not|knows? not|says? not|cares? not": "does not ...",
    r"by turns|takes? turns": "in turn, alternate",
    r"whoever|wheresoever": "who, a user",
    r"so as to": "to",
    r"lies as it": "is stored as it",
    r"(has|have) the last word": "decides",
    r"goes? astray|strays?": "fails, leaves",
}

PATTERNS = [(re.compile(rf"\b(?:{word})\b", re.I), instead) for word, instead in WORDS.items()]
STRING = re.compile(r'"((?:[^"\\\n]|\\.)*)"')
RAW_STRING = re.compile(r'R"(\w*)\((.*?)\)\1"', re.S)
LINK = re.compile(r"\]\(([^)\s]+)\)")
TOML_BLOCK = re.compile(r"^```toml\n(.*?)^```", re.S | re.M)


def pages():
    return [*sorted(ROOT.glob("*.md")),
            *(page for part in ("docs", "examples", "bindings") for page in sorted((ROOT / part).rglob("*.md")))]


def read_by_users(file, text):
    """Yields (line number, text) of all text that users of the program or the runtime read."""
    lines = text.splitlines()
    if file.name == "CHANGELOG.md":  # up to the second release
        releases = [i for i, line in enumerate(lines) if line.startswith("## [")]
        lines = lines[:releases[2]] if len(releases) > 2 else lines
    if file.suffix in (".md", ".in", ".toml"):
        yield from enumerate(lines, 1)
    elif file.suffix == ".sh":
        yield from ((n, line) for n, line in enumerate(lines, 1) if not line.lstrip().startswith("#"))
    else:
        for raw in RAW_STRING.finditer(text):
            first = text.count("\n", 0, raw.start()) + 1
            yield from ((first + i, line) for i, line in enumerate(raw[2].splitlines()))
        for n, line in enumerate(RAW_STRING.sub(lambda m: "\n" * m[0].count("\n"), text).splitlines(), 1):
            comment = line.find("//")
            for string in STRING.finditer(line):
                if comment < 0 or string.start() < comment or '"' in line[:comment].replace('\\"', "")[-1:]:
                    yield n, string[1]
            if ("runtime/include" in file.as_posix() or "examples" in file.parts) and comment >= 0:
                yield n, line[comment:]


def words_not_used(file, text):
    for n, line in read_by_users(file, text):
        for pattern, instead in PATTERNS:
            if found := pattern.search(line):
                yield f"{n}: \"{found[0].strip()}\": write {instead}"


def anchors(text):
    """Returns the anchors that a forge makes from the headings."""
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.S), re.M)}


def dead_links(file, text):
    for n, line in enumerate(text.splitlines(), 1):
        for target in LINK.findall(line):
            if target.startswith("http"):
                continue
            name, _, anchor = target.partition("#")
            page = file.parent / name if name else file
            if not page.exists():
                yield f"{n}: {target}: there is no such file"
            elif anchor and anchor not in anchors(text if page == file else page.read_text()):
                yield f"{n}: {target}: there is no such heading"


def broken_examples(file, text):
    if file.suffix != ".md":
        return
    for block in TOML_BLOCK.finditer(text):
        try:
            tomllib.loads(block[1])
        except tomllib.TOMLDecodeError as error:
            yield f"{text[:block.start()].count(chr(10)) + 1}: this example is not valid TOML: {error}"


def check_the_scan():
    """Returns a made-up fault that the scan misses, or a plain text that it reports; None if there is none."""
    bad = ["has the mends", "begins anew", "a wrap that is none", "64K is no amount", "grew past all numbers",
           "is off by 3", "says what it knows not", "goes by turns"]
    for what in bad:
        code = f'fail("{what}");'
        for name, text in (("a.md", what), ("a.cpp", code), ("examples/a/a.h", f"/// {what}"),
                           ("runtime/include/nlo/a.h", f"/// {what}")):
            if not list(words_not_used(ROOT / name, text)):
                return f'"{what}" is not seen in {name}'
    for what in ("there is no such file", "a recommendation", "it is no longer than that", "amended", "knows nothing"):
        if list(words_not_used(ROOT / "a.md", what)):
            return f'"{what}" is plain'
    if list(words_not_used(ROOT / "a.cpp", "int mend;  // anew")):
        return "code and comments are not for users"
    with tempfile.TemporaryDirectory() as folder:
        page = pathlib.Path(folder) / "page.md"
        text = "# One two, three\n[a](#one-two-three) [b](#one) [c](no.md) [d](page.md#one-two-three)\n"
        page.write_text(text)
        if len(list(dead_links(page, text))) != 2:
            return "of four links two are dead"
    for example, faults in (("a = 1\nb = 2", 0), ("a = 1 b = 2", 1)):
        if len(list(broken_examples(ROOT / "a.md", f"```toml\n{example}\n```\n"))) != faults:
            return f"the example {example} has {faults} faults"
    return ""


def main():
    if missed := check_the_scan():
        print(f"the scan has a fault: {missed}")
        return 1
    faults = []
    for file in pages():
        text = file.read_text()
        faults += [f"{file.relative_to(ROOT)}:{what}" for what in [*words_not_used(file, text), *dead_links(file, text), *broken_examples(file, text)]]
    sources = [ROOT / "demo.sh", ROOT / "test.sh"]
    for part in ("runtime", "codegen", "trainer", "bindings", "examples"):
        sources += [file for file in sorted((ROOT / part).rglob("*"))
                    if file.suffix in (".h", ".cpp", ".inc", ".in", ".toml", ".c")]
    for file in sources:
        faults += [f"{file.relative_to(ROOT)}:{what}" for what in words_not_used(file, file.read_text())]
    print("\n".join(faults) or f"{len(pages())} pages")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
