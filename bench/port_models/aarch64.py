# SPDX-License-Identifier: MIT
"""The AArch64 assembly of GCC and clang for machine_code.py, as far as the kernels use it."""
import re

from machine_code import MASK, Core, Unknown, operands

MEMORY = re.compile(r"\[(?P<base>\w+)(?:,\s*(?P<offset>[^\]]*))?\](?P<before>!)?")
VECTOR = re.compile(r"\{?\s*([qdsv])(\d+)")
CONDITIONS = {"eq": "e", "ne": "ne", "lt": "l", "ge": "ge", "le": "le", "gt": "g", "cc": "b", "lo": "b", "cs": "ae",
              "hs": "ae", "ls": "be", "hi": "a", "mi": "s", "pl": "ns", "any": "ne", "none": "e"}


RESULTS = {"add": lambda a, b: a + b, "sub": lambda a, b: a - b, "and": lambda a, b: a & b, "orr": lambda a, b: a | b,
           "lsl": lambda a, b: a << (b & 63), "lsr": lambda a, b: a >> (b & 63), "mul": lambda a, b: a * b,
           "neg": lambda _, b: -b, "mov": lambda _, b: b, "sxtw": lambda _, b: b, "uxtw": lambda _, b: b}


class AArch64(Core):
    def __init__(self):
        super().__init__()
        self.registers = {f"x{n}": (n + 1) << 19 for n in range(31)} | {"sp": 99 << 19}

    @staticmethod
    def general():
        return [f"x{n}" for n in range(28, -1, -1) if n != 18]

    @staticmethod
    def uses(text, register):
        return re.search(rf"\b[xw]{register[1:]}\b", text) is not None

    @staticmethod
    def addressed_by(line, register):
        match = MEMORY.search(line)
        offset = match["offset"] if match["offset"] and match["offset"].isdigit() else None
        after = line[match.end():]
        text = line[:match.start()] + f"[{register}{f', {offset}' if offset and not match['before'] else ''}]"
        if match["before"] or after.strip():  # and the base register changes
            moved = match["offset"] if match["before"] else after.lstrip(", ")
            text += f"\nadd\t{match['base']}, {match['base']}, {moved}"
        return text

    @staticmethod
    def link(vector, register):
        return f"fmov\tw{register[1:]}, s{vector}"

    def value(self, operand):
        operand = operand.lstrip("#")
        if ":lo12:" in operand:  # adrp has already loaded the address; only the offset is missing
            return self.symbol(operand) & 0xffffff
        if operand in ("xzr", "wzr"):
            return 0
        if re.fullmatch(r"-?(0x)?[0-9a-f]+", operand) and not re.fullmatch(r"[a-f]\w*", operand):
            return int(operand, 0) & MASK
        if re.fullmatch(r"w\d+", operand):
            value = self.registers["x" + operand[1:]]
            return None if value is None else value & 0xffffffff
        return self.registers[operand]

    def put(self, operand, value):
        bits = 0xffffffff if operand[0] == "w" else MASK
        self.registers["x" + operand[1:] if operand[0] == "w" else operand] = None if value is None else value & bits

    def shifted(self, ops):
        """Returns the value of the last operand, which may be followed by "lsl 2" and the like."""
        match = re.fullmatch(r"(lsl|sxtw|uxtw)\s*#?(\d+)?", ops[-1])
        if not match:
            return self.value(ops[-1])
        value = self.value(ops[-2])
        if value is None:
            return None
        return (self.signed(value, 32) if match[1] == "sxtw" else value) << int(match[2] or 0)

    def jump(self, mnemonic, ops):
        if mnemonic == "b":
            return ops[0]
        if mnemonic in ("cbz", "cbnz", "tbz", "tbnz") and self.value(ops[0]) is None:
            raise Unknown("a jump that the caller's data decide")
        if mnemonic in ("cbz", "cbnz"):
            return ops[1] if (self.value(ops[0]) == 0) == (mnemonic == "cbz") else ""
        if mnemonic in ("tbz", "tbnz"):
            return ops[2] if (self.value(ops[0]) >> self.value(ops[1]) & 1 == 0) == (mnemonic == "tbz") else ""
        if re.fullmatch(r"b\.?(\w+)", mnemonic) and mnemonic.lstrip("b").lstrip(".") in CONDITIONS:
            return ops[0] if self.holds(CONDITIONS[mnemonic.lstrip("b").lstrip(".")]) else ""
        return None

    def execute(self, mnemonic, ops):
        if any(MEMORY.match(op) for op in ops):
            return self.access(mnemonic, ops)
        if mnemonic in ("fcmp", "fcmpe"):
            self.flags = None
        elif not VECTOR.match(ops[0]):
            self.integer(mnemonic, ops)
        return None, None, None

    def integer(self, mnemonic, ops):
        if mnemonic == "adrp":
            return self.put(ops[0], self.symbol(ops[1]) >> 24 << 24)
        if mnemonic == "ccmp":  # the numbers are the flags n z c v
            if self.holds(CONDITIONS[ops[3]]):
                return self.integer("cmp", ops[:2])
            self.flags = {0: (0, 1), 2: (1, 0), 4: (0, 0), 8: (0, 1)}[int(ops[2])]
            return None
        if mnemonic == "cmp":
            mnemonic, ops = "subs", ["xzr", *ops]
        name = mnemonic[:-1] if mnemonic in ("adds", "subs", "ands") else mnemonic
        known = name in RESULTS and not any(VECTOR.match(op) for op in ops)
        a = self.value(ops[1]) if known and len(ops) > 2 else 0
        b = self.shifted(ops[2:] or ops[1:]) if known else None
        result = None if None in (a, b) else RESULTS[name](a, b)
        self.put(ops[0], result)
        if name != mnemonic or not known:
            self.flags = None if result is None else (a & MASK, b & MASK) if name == "sub" else (result & MASK, 0)
        return None

    def access(self, mnemonic, ops):
        at = next(n for n, op in enumerate(ops) if MEMORY.match(op))
        match = MEMORY.fullmatch(ops[at])
        where, offset = self.value(match["base"]), self.shifted(operands(match["offset"])) if match["offset"] else 0
        if None in (where, offset):
            raise Unknown(f"the address {ops[at]}, which the caller's data decide")
        where += offset
        if match["before"]:
            self.put(match["base"], where)
        elif at + 1 < len(ops):
            self.put(match["base"], where + self.value(ops[at + 1]))
        vector = VECTOR.match(ops[0])
        if not vector:  # integers in the frame of the caller
            size = 8
            for n, register in enumerate(ops[:at]):
                if mnemonic.startswith("st"):
                    self.memory[where + n * size] = self.value(register)
                else:
                    self.put(register, self.memory.get(where + n * size))
            return None, None, None
        size = {"q": 16, "d": 8, "s": 4, "v": 16}[vector[1]] * (at if mnemonic in ("ldp", "stp") else 1)
        if mnemonic == "ld1r" or re.search(r"\.s\}?\[", ops[0]):
            size = 4
        if mnemonic.startswith("st"):
            return None, (where, size), VECTOR.match(ops[at - 1])[2]
        return (where, size), None, None

