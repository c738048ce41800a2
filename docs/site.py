#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes a site of the docs: README and docs with search, and the runtime's interface from its headers.

usage: docs/site.py [-o FOLDER] [--serve [PORT]]

  -o FOLDER        folder of the site; default build/site. This version goes to FOLDER/VERSION, other versions stay there,
                   and FOLDER/index.html leads to the newest
  --serve [PORT]   then shows the site at http://localhost:PORT (8000); the search needs a server

Needs the Debian packages mkdocs-material and doxygen. The pages are those of docs/README.md, in its order. If a page links
to a source, the site contains the source as a text. A link that leads nowhere is an error: exit 1.
"""
import argparse
import functools
import http.server
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
RUNTIME = "runtime/include/nlo/"
LINK = re.compile(r"(!?\[(?:[^\]\\]|\\.)*\]\()([^)\s#]+)(#[^)]*)?(\))")

MKDOCS = """site_name: nlo {version}
site_description: "Neural Luenberger observers: learned offline, flown on small hardware"
docs_dir: {pages}
site_dir: {site}
use_directory_urls: false
theme:
  name: material
  font: false
  features: [navigation.tracking, navigation.top, search.suggest, search.highlight]
  palette:
    - media: "(prefers-color-scheme: light)"
      scheme: default
      primary: teal
      toggle: {{icon: material/weather-night, name: Dark}}
    - media: "(prefers-color-scheme: dark)"
      scheme: slate
      primary: teal
      toggle: {{icon: material/weather-sunny, name: Light}}
plugins: [search]
markdown_extensions: [tables, fenced_code, toc, admonition, pymdownx.highlight, pymdownx.superfences]
extra:
  generator: false
  version: {{provider: mike}}
nav: {nav}
"""

DOXYGEN = """PROJECT_NAME = "nlo runtime"
PROJECT_NUMBER = {version}
PROJECT_BRIEF = "header-only, C++20, no heap, no exceptions"
INPUT = {root}/runtime/include/nlo
RECURSIVE = YES
FILE_PATTERNS = *.h
STRIP_FROM_PATH = {root}/runtime/include
INPUT_FILTER = "{site} --top-comment"
EXCLUDE_SYMBOLS = nlo::kernels* nlo::detail*
EXTRACT_ALL = YES
OUTPUT_DIRECTORY = {pages}
HTML_OUTPUT = api
GENERATE_LATEX = NO
GENERATE_TREEVIEW = YES
HTML_COLORSTYLE_HUE = 174
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = NLO_INLINE=inline
HAVE_DOT = NO
QUIET = YES
WARNINGS = NO
"""


def version_of_project():
    return re.search(r"^project\(nlo VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.M)[1]


def path_in_tree(page, target):
    """Where a link of `page` leads, both from the root; None outside of the tree."""
    path = os.path.normpath(page.parent / target)
    return None if path.startswith("..") else path


def doxygen_page(header):
    """The name that Doxygen gives the page of a header."""
    name = pathlib.PurePath(header).name
    return "api/" + re.sub(r"([A-Z])", lambda m: "_" + m[1].lower(), name.replace("_", "__")).replace(".", "_8") + ".html"


class Stage:
    """The pages as mkdocs reads them, in a folder that mirrors the tree."""

    def __init__(self, folder):
        self.folder = folder
        self.waiting = []  # pages of the tree, to be copied
        self.known = set()
        self.api = set()  # pages, and what of Doxygen they link to
        self.errors = []

    def add(self, page):
        if page not in self.known:
            self.known.add(page)
            self.waiting.append(page)

    def write(self, path, text):
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def copy_all(self):
        while self.waiting:
            page = self.waiting.pop()
            source = ROOT / page
            if page.endswith(".md"):
                self.write(page, self.linked(pathlib.PurePath(page), source.read_text()))
            elif source.is_dir():
                names = sorted(file.name + "/" * file.is_dir() for file in source.iterdir())
                self.write(page + ".txt", "\n".join(names) + "\n")
            elif source.suffix in (".svg", ".png"):
                (self.folder / page).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(source, self.folder / page)
            else:
                self.write(page + ".txt", source.read_text())  # a text that browsers show, and no page of the search

    def linked(self, page, text):
        def replaced(match):
            before, target, anchor, after = match[1], match[2], match[3] or "", match[4]
            if re.match(r"[a-z]+:", target):
                return match[0]
            path = path_in_tree(page, target)
            if path is None or not (ROOT / path).exists():
                self.errors.append(f"{page}: {target} is not in the tree")
                return match[0]
            if path.startswith(RUNTIME) and path.endswith(".h"):
                leads_to = doxygen_page(path)
                self.api.add((str(page), leads_to))
            else:
                self.add(path)
                leads_to = path if path.endswith((".md", ".svg", ".png")) else path + ".txt"
            return before + os.path.relpath(leads_to, page.parent) + anchor + after

        parts = re.split(r"(^```.*?^```\n)", text, flags=re.M | re.S)  # code is not read
        return "".join(part if part.startswith("```") else LINK.sub(replaced, part) for part in parts)


def name_of(page):
    path = pathlib.PurePath(page)
    return (path.parent.name if path.stem == "README" else path.stem).replace("_", " ").capitalize()


def navigation():
    """Pages in the order of docs/README.md, each under the first of its questions."""
    groups, seen = [], set()
    page = pathlib.PurePath("docs/README.md")
    for line in (ROOT / page).read_text().splitlines():
        if not line.startswith("|") or line.startswith("|---"):
            continue
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        links = [path_in_tree(page, match[2]) for match in LINK.finditer(cells[-1])]
        if not links:
            groups.append((cells[0].replace("`", ""), []))
        for link in links:
            if link not in seen:
                seen.add(link)
                groups[-1][1].append({name_of(link): link})
    titled = [{title[0].upper() + title[1:]: pages} for title, pages in groups if pages]
    return [{"nlo": "README.md"}, {"Which page?": "docs/README.md"}, *titled,
            {"Changes": "CHANGELOG.md"}, {"Runtime, header by header": "api/files.html"}]


def with_top_comment(header):
    """A header begins with what it is for, in lines of //: as Doxygen reads the text of a file."""
    top, lines = [], header.split("\n")
    while lines and lines[0].startswith("//"):
        top.append(re.sub("^// ?", "", lines.pop(0)))
    return "/*! \\file\n\\verbatim\n" + "\n".join(top[1:]) + "\n\\endverbatim */\n" + "\n".join(lines)


def run(*command, **options):
    result = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, **options)
    if result.returncode != 0:
        sys.exit(f"docs/site.py: {' '.join(command)}\n{result.stdout}")


def build(output):
    for program, package in (("mkdocs", "mkdocs-material"), ("doxygen", "doxygen")):
        if shutil.which(program) is None:
            sys.exit(f"docs/site.py: no {program}; apt-get install {package}")
    version = version_of_project()
    work = output / ".work"
    shutil.rmtree(work, ignore_errors=True)
    stage = Stage(work / "pages")
    nav = navigation()
    for group in nav:
        for entry in group.values():
            for page in [entry] if isinstance(entry, str) else [path for one in entry for path in one.values()]:
                if not page.startswith("api/"):
                    stage.add(page)
    stage.copy_all()
    if stage.errors:
        sys.exit("docs/site.py: " + "\ndocs/site.py: ".join(stage.errors))

    run("doxygen", "-", input=DOXYGEN.format(version=version, root=ROOT, pages=stage.folder, site=__file__))
    lost = [f"{page}: no {target}" for page, target in sorted(stage.api) if not (stage.folder / target).exists()]
    if lost:
        sys.exit("docs/site.py: " + "\ndocs/site.py: ".join(lost))
    config = work / "mkdocs.yml"
    config.write_text(MKDOCS.format(version=version, pages=stage.folder, site=output / version, nav=json.dumps(nav)))
    run("mkdocs", "build", "--strict", "--quiet", "--clean", "--config-file", str(config))
    shutil.rmtree(work)

    by_number = lambda name: [int(part) for part in name.split(".")]
    versions = sorted((file.name for file in output.iterdir() if re.fullmatch(r"\d+(\.\d+)*", file.name)), key=by_number)
    (output / "versions.json").write_text(
        json.dumps([{"version": name, "title": name, "aliases": []} for name in reversed(versions)]))
    (output / "index.html").write_text(f'<meta http-equiv="refresh" content="0; url={versions[-1]}/index.html">\n')
    print(f"docs/site.py: {output / version / 'index.html'}")


def main():
    if sys.argv[1:2] == ["--top-comment"]:  # Doxygen's filter of each header
        print(with_top_comment(pathlib.Path(sys.argv[2]).read_text()), end="")
        return
    arguments = argparse.ArgumentParser(usage=__doc__.split("usage: ")[1])
    arguments.add_argument("-o", dest="output", type=pathlib.Path, default=ROOT / "build/site")
    arguments.add_argument("--serve", nargs="?", type=int, const=8000)
    given = arguments.parse_args()
    output = given.output.resolve()
    output.mkdir(parents=True, exist_ok=True)
    build(output)
    if given.serve is not None:
        print(f"docs/site.py: http://localhost:{given.serve}, until Ctrl-C")
        handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=output)
        try:
            http.server.ThreadingHTTPServer(("localhost", given.serve), handler).serve_forever()
        except KeyboardInterrupt:
            pass


if __name__ == "__main__":
    main()
