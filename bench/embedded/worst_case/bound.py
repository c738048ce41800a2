#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the most instructions that each call of a program made by nlo_worst() can take, from its control-flow graph:
   usage: bound.py PROGRAM CALL...                    a line "CALL INSTRUCTIONS" each; exit 1 where there is no bound
   --doublings N                                      in place of what the program says of its model"""
import argparse
import sys

from functions import Bound
from program import Program
from instruction import Unknown
from walk import Walk

WORD, STATE, BYTES, DOUBLINGS, SECOND_POINTER = 4, 8, 12, 32, 36  # in bytes; all but the first of CalledObserver (calls.h)
MOST_PIECES = 64  # nlo::kMostPieces


def loops(doublings):
    """Loops that end by arithmetic, not by a counter, and what says when."""
    piece = "for (int i = 0; i < pieces; ++i) {"  # what pieces_of() gives at most
    halve = "for (; doublings < kMost && magnitude(w) > T(0.5); ++doublings) w = w * T(0.5);"
    window = "for (int s = 1; s <= samples; ++s) {"
    return [
        Bound("nlo/latent.h", halve, doublings),  # |lambda dt| of the longest step, halved to 1/2: of the model
        Bound("nlo/explicit_rk.h", piece, MOST_PIECES),
        Bound("nlo/prior_observer.h", piece, MOST_PIECES),
        Bound("nlo/window_observer.h", window, MOST_PIECES),
        Bound("nlo/driven_kkl_observer.h", piece, MOST_PIECES),
    ]


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("program")
    options.add_argument("calls", nargs="+")
    options.add_argument("--doublings", type=int)
    given = options.parse_args()
    program = Program(given.program)
    called = program.symbols["called"]
    state = program.word(called + STATE)
    program.frozen.add(state - WORD)  # the observer's pointer to its model, and that of its monitor
    if program.word(called + SECOND_POINTER) < program.word(called + BYTES):
        program.frozen.add(state + program.word(called + SECOND_POINTER))
    doublings = program.word(called + DOUBLINGS) if given.doublings is None else given.doublings
    walk = Walk(program, loops(doublings))
    for call in given.calls:
        print(call, walk.bound(program.symbols[call])[0])


if __name__ == "__main__":
    try:
        main()
    except Unknown as error:
        sys.exit(f"no bound: {error}")
