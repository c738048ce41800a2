# SPDX-License-Identifier: MIT
"""AArch64 as GCC and clang write it, as far as kernels go: machine_code.py."""
import re

from machine_code import MASK, Core, Unknown, operands

MEMORY = re.compile(r"\[(?P<base>\w+)(?:,\s*(?P<offset>[^\]]*))?\](?P<before>!)?")
VECTOR = re.compile(r"\{?\s*([qdsv])(\d+)")
CONDITIONS = {"eq": "e", "ne": "ne", "lt": "l", "ge": "ge", "le": "le", "gt": "g", "cc": "b", "lo": "b", "cs": "ae",
              "hs": "ae", "ls": "be", "hi": "a", "mi": "s", "pl": "ns", "any": "ne", "none": "e"}


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
        if match["before"] or after.strip():  # and the base moves on
            moved = match["offset"] if match["before"] else after.lstrip(", ")
            text += f"\nadd\t{match['base']}, {match['base']}, {moved}"
        return text

    @staticmethod
    def link(vector, register):
        return f"fmov\tw{register[1:]}, s{vector}"

    def value(self, operand):
        operand = operand.lstrip("#")
        if ":lo12:" in operand:  # what adrp has loaded is all of the address here, but for what is added to the name
            return self.symbol(operand) & 0xffffff
        if operand in ("xzr", "wzr"):
            return 0
        if re.fullmatch(r"-?(0x)?[0-9a-f]+", operand) and not re.fullmatch(r"[a-f]\w*", operand):
            return int(operand, 0) & MASK
        if re.fullmatch(r"w\d+", operand):
            return self.registers["x" + operand[1:]] & 0xffffffff
        return self.registers[operand]

    def put(self, operand, value):
        if operand[0] == "w":
            self.registers["x" + operand[1:]] = value & 0xffffffff
        else:
            self.registers[operand] = value & MASK

    def shifted(self, ops):
        """The last operand, behind which "lsl 2" and the like may stand."""
        match = re.fullmatch(r"(lsl|sxtw|uxtw)\s*#?(\d+)?", ops[-1])
        if not match:
            return self.value(ops[-1])
        value = self.value(ops[-2])
        return (self.signed(value, 32) if match[1] == "sxtw" else value) << int(match[2] or 0)

    def jump(self, mnemonic, ops):
        if mnemonic == "b":
            return ops[0]
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
        if VECTOR.match(ops[0]):
            return None, None, None
        if not re.fullmatch(r"[xw](\d+|zr)|sp", ops[0]) or any(VECTOR.fullmatch(op) for op in ops[1:]):
            raise Unknown(f"{mnemonic} {', '.join(ops)}: a vector that decides an integer")
        if mnemonic == "ccmp" and not self.holds(CONDITIONS[ops[3]]):  # n z c v as a number
            self.flags = {0: (0, 1), 2: (1, 0), 4: (0, 0), 8: (0, 1)}[int(ops[2])]
        elif mnemonic in ("cmp", "ccmp"):
            ops = ops[:2] if mnemonic == "ccmp" else ops
            self.flags = (self.value(ops[0]), self.shifted(ops))
        elif mnemonic in ("mov", "sxtw", "uxtw"):
            self.put(ops[0], self.value(ops[1]))
        elif mnemonic == "adrp":
            self.put(ops[0], self.symbol(ops[1]) >> 24 << 24)
        elif mnemonic in ("add", "sub", "adds", "subs", "and", "ands", "lsl", "lsr", "neg", "mul", "orr"):
            a, b = (0 if mnemonic == "neg" else self.value(ops[1]), self.shifted(ops[2:] or ops[1:]))
            result = {"add": a + b, "sub": a - b, "and": a & b, "lsl": a << (b & 63), "lsr": a >> (b & 63), "neg": -b, "mul": a * b, "orr": a | b}[{"adds": "add", "subs": "sub", "ands": "and"}.get(mnemonic, mnemonic)]
            self.put(ops[0], result)
            if mnemonic == "subs":
                self.flags = (a & MASK, b & MASK)
            elif mnemonic in ("adds", "ands"):
                self.flags = (result & MASK, 0)
        else:
            raise Unknown(f"{mnemonic} {', '.join(ops)}")
        return None, None, None

    def access(self, mnemonic, ops):
        at = next(n for n, op in enumerate(ops) if MEMORY.match(op))
        match = MEMORY.fullmatch(ops[at])
        where = self.value(match["base"])
        if match["offset"]:
            where += self.shifted(operands(match["offset"]))
        if match["before"]:
            self.put(match["base"], where)
        elif at + 1 < len(ops):
            self.put(match["base"], where + self.value(ops[at + 1]))
        vector = VECTOR.match(ops[0])
        if not vector:  # integers: what the caller's frame holds
            size = 8
            for n, register in enumerate(ops[:at]):
                if mnemonic.startswith("st"):
                    self.memory[where + n * size] = self.value(register)
                else:
                    self.put(register, self.memory.get(where + n * size, 0))
            return None, None, None
        size = {"q": 16, "d": 8, "s": 4, "v": 16}[vector[1]] * (at if mnemonic in ("ldp", "stp") else 1)
        if mnemonic == "ld1r" or re.search(r"\.s\}?\[", ops[0]):
            size = 4
        if mnemonic.startswith("st"):
            return None, (where, size), VECTOR.match(ops[at - 1])[2]
        return (where, size), None, None

