#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the folders of the project in one picture, docs/architecture.svg, from the #include lines of the sources.

usage: docs/architecture.py [--check]

  (none)   writes docs/architecture.svg
  --check  exits with 1 and prints the differences if the committed picture does not fit the present includes

A room is a folder with sources; the first comment of its CMakeLists.txt says what the room is for. A room stands above the
rooms that it includes. An arrow that follows from two others is left out. An arrow against the layering is part of a circle
and red: tests/properties/include_arrows_test.cpp names its files.
"""
import pathlib
import re
import sys
import textwrap

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs/architecture.svg"
SOURCES = {".h", ".cpp", ".inc"}
COLOURS = {"runtime": "#dcefe3", "codegen": "#e3e9f7", "trainer": "#f8efdc"}
BOX_WIDTH, BOX_HEIGHT, GAP_X, GAP_Y, MARGIN = 186, 66, 34, 50, 24
FONT = "font-family='DejaVu Sans, Verdana, sans-serif'"


def room_of(path):
    """The room of a file or an include, both as paths from the root; None for what is not ours."""
    parts = path.split("/")
    if parts[0] in ("nlo", "runtime"):
        return "runtime"
    if parts[0] not in ("codegen", "trainer") or len(parts) < 2:
        return None
    return "/".join(parts[:2]) if len(parts) > 2 else parts[0]


def edges_of_the_sources():
    """{(room, room it includes): number of includes}"""
    edges = {}
    for part in COLOURS:
        for file in sorted((ROOT / part).rglob("*")):
            if file.suffix not in SOURCES:
                continue
            room = room_of(file.relative_to(ROOT).as_posix())
            for target in re.findall(r'^\s*#\s*include\s*[<"]([^>"]+)', file.read_text(), re.M):
                other = room_of(target)
                if other and other != room:
                    edges[room, other] = edges.get((room, other), 0) + 1
    return edges


def against_the_layering(edges):
    """Returns the edges that close a cycle. Rooms are placed from the bottom up; the next one includes the fewest unplaced rooms."""
    rooms = {room for edge in edges for room in edge}
    placed, against = set(), set()
    while rooms - placed:
        left = {(a, b): n for (a, b), n in edges.items() if b not in placed}
        circles = {(a, b): n for (a, b), n in left.items() if a in reached(left, b)}

        def balance(room):
            out = sum(n for (a, _), n in circles.items() if a == room)
            into = sum(n for (_, b), n in circles.items() if b == room)
            return (any(a == room for a, _ in left), not into, out - into, room)
        room = min(rooms - placed, key=balance)
        against |= {(a, b) for a, b in edges if a == room and b not in placed}
        placed.add(room)
    return against


def reached(edges, start):
    seen, todo = set(), [start]
    while todo:
        room = todo.pop()
        for a, b in edges:
            if a == room and b not in seen:
                seen.add(b)
                todo.append(b)
    return seen


def without_the_implied(edges):
    """Those edges that do not follow from two others (edges without circles)."""
    below = {room: reached(edges, room) for edge in edges for room in edge}
    return {(a, b) for a, b in edges if not any(b in below[c] for x, c in edges if x == a and c != b)}


def levels(edges):
    """How many rooms are below each on the longest way down."""
    level = {}

    def depth(room):
        if room not in level:
            level[room] = 1 + max((depth(b) for a, b in edges if a == room), default=-1)
        return level[room]

    for edge in edges:
        for room in edge:
            depth(room)
    return level


def arrange(level, drawn):
    """Returns the rows from the bottom up, and the path of each edge through them. A long edge has a point in each row that it crosses."""
    rows = [[] for _ in range(max(level.values()) + 1)]
    for room in sorted(level):
        rows[level[room]].append(room)
    ways, links = {}, []
    for a, b in sorted(drawn):
        way = [a]
        for row in range(level[a] - 1, level[b], -1):
            way.append((a, b, row))
            rows[row].append((a, b, row))
        way.append(b)
        ways[a, b] = way
        links += zip(way, way[1:])

    def crossings():
        place = {node: i for row in rows for i, node in enumerate(row)}
        row_of = {node: r for r, row in enumerate(rows) for node in row}
        count = 0
        for i, (a, b) in enumerate(links):
            for c, d in links[:i]:
                if row_of[a] == row_of[c] and (place[a] - place[c]) * (place[b] - place[d]) < 0:
                    count += 1
        return count

    best, fewest = [list(row) for row in rows], crossings()
    for sweep in range(24):  # each node to the middle of its neighbours in the row before, upwards and downwards in turn
        up = sweep % 2 == 0
        for r in (range(1, len(rows)) if up else range(len(rows) - 2, -1, -1)):
            before = {node: i / max(1, len(rows[r - 1 if up else r + 1]) - 1)
                      for i, node in enumerate(rows[r - 1 if up else r + 1])}
            middle = {}
            for i, node in enumerate(rows[r]):
                near = [before[b if up else a] for a, b in links if (a if up else b) == node]
                middle[node] = sum(near) / len(near) if near else i / max(1, len(rows[r]) - 1)
            rows[r].sort(key=lambda node: middle[node])
        if crossings() < fewest:
            best, fewest = [list(row) for row in rows], crossings()
    return best, ways


def spread(wanted, widths, weights):
    """Places near the wanted ones, in this order and without overlap: least squares by pooling neighbours."""
    offsets = [0.0]
    for w0, w1 in zip(widths, widths[1:]):
        offsets.append(offsets[-1] + (w0 + w1) / 2 + GAP_X)
    pools = []  # [mean, weight, how many]
    for want, offset, weight in zip(wanted, offsets, weights):
        pools.append([want - offset, weight, 1])
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            mean, w, n = pools.pop()
            last = pools[-1]
            pools[-1] = [(last[0] * last[1] + mean * w) / (last[1] + w), last[1] + w, last[2] + n]
    means = [mean for mean, _, n in pools for _ in range(n)]
    return [mean + offset for mean, offset in zip(means, offsets)]


def places(rows, ways):
    """The middle of each node, so that long edges are straight and rooms are above those they include. All are drawn to
    one middle a little: else rows lean further and further to a side."""
    near = {node: [] for row in rows for node in row}
    for way in ways.values():
        for a, b in zip(way, way[1:]):
            near[a].append(b)
            near[b].append(a)
    x = {}
    for row in rows:
        x.update(zip(row, spread([0.0] * len(row), [width_of(n) for n in row], [1] * len(row))))
    for sweep in range(60):
        for row in rows if sweep % 2 else rows[::-1]:
            middle = sum(x.values()) / len(x)
            wanted = [middle + 0.9 * (sum(x[n] for n in near[node]) / len(near[node]) - middle) for node in row]
            weights = [1 if isinstance(node, str) else 8 for node in row]
            x.update(zip(row, spread(wanted, [width_of(n) for n in row], weights)))
    return x


def width_of(node):
    return BOX_WIDTH if isinstance(node, str) else 12


def purpose(room):
    lists = ROOT / room / "CMakeLists.txt"
    match = re.search(r"^#\s*(.+)", lists.read_text(), re.M) if lists.exists() else None
    return match.group(1).split(". ")[0].rstrip(".").replace("`", "") if match else ""


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;")


def picture(edges):
    against = against_the_layering(edges)
    down = set(edges) - against
    drawn, level = without_the_implied(down), levels(down)
    rows, ways = arrange(level, drawn)

    x = places(rows, ways)
    left = min(x[n] - width_of(n) / 2 for n in x) - MARGIN
    x = {node: place - left for node, place in x.items()}
    width = max(x[n] + width_of(n) / 2 for n in x) + MARGIN
    height = len(rows) * (BOX_HEIGHT + GAP_Y) - GAP_Y + 2 * MARGIN + 40
    y = {node: height - MARGIN - 40 - r * (BOX_HEIGHT + GAP_Y) - BOX_HEIGHT / 2
         for r, row in enumerate(rows) for node in row}

    out = [f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width:.0f} {height:.0f}' {FONT}>",
           "<!-- Drawn by docs/architecture.py from the includes: run it again, do not edit. -->",
           "<defs><marker id='tip' viewBox='0 0 8 8' refX='7' refY='4' markerWidth='7' markerHeight='7' orient='auto'>"
           "<path d='M0 0 8 4 0 8z' fill='context-stroke'/></marker></defs>",
           f"<rect width='{width:.0f}' height='{height:.0f}' fill='white'/>"]
    for (a, b), way in sorted(ways.items()):
        points = [(x[a], y[a] + BOX_HEIGHT / 2)]
        for node in way[1:-1]:
            points += [(x[node], y[node] - BOX_HEIGHT / 2), (x[node], y[node] + BOX_HEIGHT / 2)]
        points.append((x[b], y[b] - BOX_HEIGHT / 2 - 1))
        path = f"M{points[0][0]:.0f} {points[0][1]:.0f}"
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            bend = (y1 - y0) / 2
            path += f" C{x0:.0f} {y0 + bend:.0f} {x1:.0f} {y1 - bend:.0f} {x1:.0f} {y1:.0f}"
        out.append(f"<path d='{path}' fill='none' stroke='#55606b' stroke-width='1.3' marker-end='url(#tip)'/>")
    for a, b in sorted(against):
        top, bottom = y[a] - BOX_HEIGHT / 2, y[b] + BOX_HEIGHT / 2 + 1
        out.append(f"<path d='M{x[a] + 30:.0f} {top:.0f} L{x[b] + 30:.0f} {bottom:.0f}' "
                   "fill='none' stroke='#c62828' stroke-width='1.5' stroke-dasharray='5 3' marker-end='url(#tip)'/>")
    for room in sorted(level):
        known = ", ".join(sorted(b for a, b in edges if a == room)) or "nothing here"
        out.append(f"<g><title>{room} includes {known}</title>"
                   f"<rect x='{x[room] - BOX_WIDTH / 2:.0f}' y='{y[room] - BOX_HEIGHT / 2:.0f}' width='{BOX_WIDTH}' "
                   f"height='{BOX_HEIGHT}' rx='6' fill='{COLOURS[room.split('/')[0]]}' stroke='#55606b'/>"
                   f"<text x='{x[room]:.0f}' y='{y[room] - 14:.0f}' text-anchor='middle' font-size='14' "
                   f"font-weight='bold'>{room}</text>")
        for i, line in enumerate(textwrap.wrap(purpose(room), 30, max_lines=2, placeholder=" …")):
            out.append(f"<text x='{x[room]:.0f}' y='{y[room] + 5 + 15 * i:.0f}' text-anchor='middle' "
                       f"font-size='10.5'>{escaped(line)}</text>")
        out.append("</g>")
    caption = "An arrow: includes. What follows from two arrows is not drawn."
    if against:
        caption += " Red: against the layering."
    out.append(f"<text x='{width / 2:.0f}' y='{height - MARGIN:.0f}' text-anchor='middle' font-size='12'>{caption}</text>")
    return "\n".join(out + ["</svg>", ""])


def main(arguments):
    if arguments not in ([], ["--check"]):
        print(__doc__)
        return 2
    today = picture(edges_of_the_sources())
    if not arguments:
        PICTURE.write_text(today)
        return 0
    committed = PICTURE.read_text() if PICTURE.exists() else ""
    if committed == today:
        return 0

    def titles(text):
        return set(re.findall(r"<title>(.*?)</title>", text))

    for line in sorted(titles(committed) - titles(today)):
        print("-", line)
    for line in sorted(titles(today) - titles(committed)):
        print("+", line)
    print("docs/architecture.svg is older than the includes: run docs/architecture.py and commit what it draws")
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
