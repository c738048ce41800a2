# SPDX-License-Identifier: MIT
"""Functions of all four converters: read tables, write CSV files, and raise errors that name the file."""
import csv
import pathlib
import sys


def fail(message):
    sys.exit(f"{pathlib.Path(sys.argv[0]).name}: error: {message}")


def folders(arguments, usage):
    """Returns CHECKOUT and OUT of the command line as paths, and creates OUT."""
    if len(arguments) != 3 or arguments[1] in ("-h", "--help"):
        print(usage.strip())
        sys.exit(0 if len(arguments) == 2 and arguments[1] in ("-h", "--help") else 2)
    checkout, out = pathlib.Path(arguments[1]), pathlib.Path(arguments[2])
    if not checkout.is_dir():
        fail(f"{checkout} is not a folder: give the checkout of the repository")
    out.mkdir(parents=True, exist_ok=True)
    return checkout, out


def table(text, headings, name):
    """Returns the columns of a CSV text by heading, as lists of floats. A cell that is not a number is an error."""
    rows = list(csv.DictReader(text.splitlines()))
    missing = [h for h in headings if not rows or h not in rows[0]]
    if missing:
        fail(f"{name}: no column {missing[0]!r}" + (f" among {', '.join(rows[0])}" if rows else ": it is empty"))
    columns = {}
    for heading in headings:
        try:
            columns[heading] = [float(row[heading]) for row in rows]
        except (TypeError, ValueError):
            line = next(i for i, row in enumerate(rows, 2) if not is_number(row[heading]))
            fail(f"{name}:{line}: {heading!r} is not a number")
    return columns


def is_number(cell):
    try:
        float(cell)
        return True
    except (TypeError, ValueError):
        return False


def write(file, columns, decimals):
    """Writes a CSV file. columns: heading -> values, all of one length; decimals: heading -> digits after the point."""
    with open(file, "w", newline="") as out:
        out.write(",".join(columns) + "\n")
        for row in zip(*columns.values(), strict=True):
            out.write(",".join(f"{value:.{decimals[heading]}f}" for heading, value in zip(columns, row)) + "\n")
    print(f"{file}  {len(next(iter(columns.values())))} rows")
