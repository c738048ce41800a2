# SPDX-License-Identifier: MIT
"""What a Thumb instruction makes of known values: see thumb.py for what a value is."""
import intervals
from instruction import REGISTER, halves, number

WORD = 0xFFFFFFFF


def constant(value):
    return ("", value & WORD)


def is_number(value):
    return value is not None and value[0] == ""


def signed(n):
    return n - (1 << 32) if n & 0x80000000 else n


def low_bits(value):
    """The last three bits, where they are known: sp is a multiple of 8 where a function starts (AAPCS, 6.2.1.2)."""
    if value is not None and (value[0] in ("", "~") or value[0].startswith("sp:")):
        return value[1] & 7
    return None


def plus(a, b):
    if a is None or b is None or (a[0] and b[0]) or "~f" in (a[0], b[0]):
        return None
    total = a[1] + b[1]
    return (a[0] or b[0], signed(total & WORD)) if a[0] or b[0] else constant(total)


def minus(a, b):
    if a is None or b is None or "~f" in (a[0], b[0]):
        return None
    if a[0] == b[0]:
        return None if a[0].startswith("~") else constant(a[1] - b[1])
    return (a[0], signed((a[1] - b[1]) & WORD)) if b[0] == "" else None


def compare(a, b):
    """N, Z, C, V of a - b; None: not known. Two pointers into one thing compare as their offsets."""
    if a is None or b is None or a[0] != b[0] or a[0].startswith("~"):
        return (None,) * 4
    if a[0]:
        return (int(a[1] < b[1]), int(a[1] == b[1]), int(a[1] >= b[1]), 0)
    result = (a[1] - b[1]) & WORD
    overflow = signed(a[1]) - signed(b[1]) != signed(result)
    return (result >> 31, int(result == 0), int(a[1] >= b[1]), int(overflow))


def of_result(value, carry=None, overflow=None):
    if not is_number(value):
        return (None,) * 4
    return (value[1] >> 31, int(value[1] == 0), carry, overflow)


def holds(condition, flags):
    """Whether a condition holds; None: not known."""
    if not flags:
        return None
    n, z, c, v = flags

    def same(a, b):
        return None if a is None or b is None else a == b

    def both(a, b):
        return False if a is False or b is False else None if a is None or b is None else True

    def flag(f):
        return None if f is None else bool(f)

    def no(f):
        return None if f is None else not f

    rows = {"eq": flag(z), "cs": flag(c), "mi": flag(n), "vs": flag(v), "hi": both(flag(c), no(flag(z))),
            "ge": same(n, v), "gt": both(no(flag(z)), same(n, v))}
    opposite = {"ne": "eq", "cc": "cs", "pl": "mi", "vc": "vs", "ls": "hi", "lt": "ge", "le": "gt"}
    return rows[condition] if condition in rows else no(rows[opposite[condition]])


def shifted(value, how, by):
    if how == "lsl" and 29 <= by < 32 and low_bits(value) is not None:
        return constant(low_bits(value) << by)
    if not is_number(value):
        return value if by == 0 else None
    n = value[1]
    if by >= 32:
        return constant(-1 if how == "asr" and n >> 31 else 0)
    return constant({"lsl": n << by, "lsr": n >> by, "asr": signed(n) >> by, "ror": n >> by | n << (32 - by)}[how])


def operand(text, state):
    if text.startswith("#"):
        return constant(number(text))
    return state.get(text)


def last_operand(operands, state):
    """A second operand, which may be shifted: ['r1', 'lsl #2']"""
    if operands and " " in operands[-1]:
        how, by = operands[-1].split()
        by = operand(by, state)
        return shifted(operand(operands[-2], state), how, by[1] & 255) if is_number(by) else None
    return operand(operands[-1], state)


SIMPLE = {"and": lambda a, b: a & b, "orr": lambda a, b: a | b, "eor": lambda a, b: a ^ b, "bic": lambda a, b: a & ~b,
          "mul": lambda a, b: a * b, "orn": lambda a, b: a | ~b, "udiv": lambda a, b: a // b if b else 0}
EXTENDS = {"uxtb": lambda n: n & 0xFF, "uxth": lambda n: n & 0xFFFF, "mvn": lambda n: ~n, "neg": lambda n: -n,
           "sxtb": lambda n: (n & 0xFF) - ((n & 0x80) << 1), "sxth": lambda n: (n & 0xFFFF) - ((n & 0x8000) << 1)}


def arithmetic(ins, state):
    """{written: value} of an integer instruction, with the flags where it sets them."""
    name, ops = ins.name, ins.operands
    sources = ops[1:]
    first = operand(ops[0] if len(sources) == 1 or (len(sources) == 2 and " " in sources[1]) else sources[0], state)
    last = last_operand(ops, state)
    value, flags = None, (None,) * 4
    if name in ("mov", "movw"):
        value = last
        flags = of_result(value)
    elif name == "add":
        value = plus(first, last)
        if is_number(first) and is_number(last):
            total = first[1] + last[1]
            flags = of_result(value, int(total > WORD), int(signed(first[1]) + signed(last[1]) != signed(value[1])))
    elif name in ("sub", "rsb"):
        a, b = (first, last) if name == "sub" else (last, first)
        value = minus(a, b)
        flags = compare(a, b)
    elif name == "neg":
        value = minus(constant(0), last)
        flags = compare(constant(0), last)
    elif name in SIMPLE:
        if is_number(first) and is_number(last):
            value = constant(SIMPLE[name](first[1], last[1]))
        elif name in ("and", "orr") and low_bits(first) is not None and low_bits(last) is not None:
            bits = SIMPLE[name](low_bits(first), low_bits(last))
            small = name == "and" and any(is_number(v) and v[1] < 8 for v in (first, last))
            value = constant(bits) if small else ("~", bits)  # ~: only these bits are known
        flags = of_result(value)
    elif name in EXTENDS:
        value = constant(EXTENDS[name](last[1])) if is_number(last) else None
        flags = of_result(value)
    elif name in ("lsl", "lsr", "asr", "ror"):
        value = shifted(first, name, last[1] & 255) if is_number(last) else None
        flags = of_result(value)
    elif name == "movt":
        value = constant((operand(ops[0], state) or ("", 0))[1] & 0xFFFF | last[1] << 16) if is_number(
            operand(ops[0], state)) else None
    elif name == "ubfx" and is_number(first):
        value = constant(first[1] >> number(ops[2]) & (1 << number(ops[3])) - 1)
    result = {ops[0]: value}
    if ins.sets_flags:
        result["flags"] = flags
    return result


def compared(ins, state):
    first, last = operand(ins.operands[0], state), last_operand(ins.operands, state)
    if ins.name == "cmp":
        if last is not None and state.get("#not " + ins.operands[0]) == last:
            return {"flags": (None, 0, None, None)}
        return {"flags": compare(first, last)}
    if ins.name in ("tst", "teq") and is_number(first) and is_number(last):
        bits = first[1] & last[1] if ins.name == "tst" else first[1] ^ last[1]
        return {"flags": of_result(constant(bits))}
    return {"flags": (None,) * 4}


def float_operand(text, state):
    return (0.0, 0.0) if text.startswith("#") else intervals.ends(state.get(text))


def moved(ins, state):
    to, source = halves(ins.operands[0]), ins.operands[1]
    if REGISTER.match(source):
        moved_values = [state.get(half) for half in halves(source)]
        return {name: None if name[0] == "r" and v and v[0] == "~f" else v for name, v in zip(to, moved_values)}
    known = constant(number(source)) if source.startswith("#") and len(to) == 1 else None
    return {half: known for half in to}


def effects(ins, state):
    """{written: value} of an instruction that neither loads nor stores nor goes anywhere."""
    if ins.name in ("cmp", "cmn", "tst", "teq"):
        return compared(ins, state)
    if ins.name == "vcmp":
        return {"fpscr": intervals.compare(*(float_operand(op, state) for op in ins.operands))}
    if ins.name == "vmov":
        return moved(ins, state)
    if ins.name == "vmrs" and "flags" in ins.writes:
        return {"flags": state.get("fpscr")}
    if ins.operation:
        return {ins.operands[0]: intervals.result(ins.operation, [float_operand(op, state) for op in ins.operands[1:]])}
    if ins.name in ("float", "several", "vmrs") or len(ins.operands) < 2 or not ins.writes:
        return {name: None for name in ins.writes}
    result = {name: None for name in ins.writes}
    known = arithmetic(ins, state)
    result.update((name, known[name]) for name in known if name in result)
    return result
