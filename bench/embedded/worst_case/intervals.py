# SPDX-License-Identifier: MIT
"""Floats that are known to lie between two numbers: ('~f', low, high), neither of them not-a-number. So the walk sees when
the halving of |lambda dt| ends, from the eigenvalues in flash and the longest step that a call takes.

Products of floats are exact in double and rounded once, which keeps their order; sums and quotients are widened by a float.
"""
import math
import struct

INFINITE = math.inf
KNOWN = {"vmul", "vadd", "vsub", "vneg", "vabs"}


def as_float(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


def rounded(x):
    """The nearest float."""
    try:
        return struct.unpack("<f", struct.pack("<f", x))[0]
    except OverflowError:
        return math.copysign(INFINITE, x)


def next_to(x, way):
    """The float beside a float, up or down."""
    if math.isinf(x):
        return x
    if x == 0:
        return math.copysign(2.0**-149, way)
    bits = struct.unpack("<i", struct.pack("<f", x))[0]
    bits += 1 if (x > 0) == (way > 0) else -1
    return struct.unpack("<f", struct.pack("<i", bits))[0]


def ends(value):
    """(low, high) of a known value, or None."""
    if value is None:
        return None
    if value[0] == "~f":
        return value[1:]
    if value[0] == "":
        x = as_float(value[1])
        return None if math.isnan(x) else (x, x)
    return None


def between(low, high):
    if math.isnan(low) or math.isnan(high) or (low == -INFINITE and high == INFINITE):
        return None
    return ("~f", low, high)


def product(a, b):
    if any(math.isinf(x) for x in a + b):
        return None
    all_of = [rounded(x * y) for x in a for y in b]
    return between(min(all_of), max(all_of))


def result(name, operands):
    """What a float instruction gives of (low, high) operands."""
    if any(o is None for o in operands):
        return None
    if name == "vmul" and len(operands) == 2:
        return product(*operands)
    if name == "vneg":
        return between(-operands[0][1], -operands[0][0])
    if name == "vabs":
        low, high = operands[0]
        return between(0.0 if low <= 0 <= high else min(abs(low), abs(high)), max(abs(low), abs(high)))
    if name in ("vadd", "vsub") and len(operands) == 2:
        (a, b), (c, d) = operands
        if name == "vsub":
            c, d = -d, -c
        return between(next_to(rounded(a + c), -1), next_to(rounded(b + d), 1))
    return None


def compare(a, b):
    """N, Z, C, V of floats where their order is known, else None of all."""
    if a and b:
        if a[1] < b[0]:
            return (1, 0, 0, 0)
        if a[0] > b[1]:
            return (0, 0, 1, 0)
        if a == b and a[0] == a[1]:
            return (0, 1, 1, 0)
    return (None,) * 4


# What a condition after vcmp says of the first operand, where it holds and neither is not-a-number for sure.
BELOW, ABOVE = {"mi", "ls", "eq"}, {"gt", "ge", "eq"}
OPPOSITE = {"lt": "ge", "le": "gt", "hi": "ls", "pl": "mi", "ne": "eq"}


def learnt(value, condition, held, other):
    """A value after a branch on its comparison with `other`: what `condition` and whether it held say of it."""
    if not held:
        condition = OPPOSITE.get(condition)
    low, high = ends(value) or (-INFINITE, INFINITE)
    if condition in BELOW:
        high = min(high, other[1])
    if condition in ABOVE:
        low = max(low, other[0])
    if condition not in BELOW | ABOVE or low > high:
        return value
    return between(low, high)
