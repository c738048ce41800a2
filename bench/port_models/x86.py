# SPDX-License-Identifier: MIT
"""The x86-64 assembly (AT&T) of GCC and clang for machine_code.py, as far as the kernels use it."""
import re

from machine_code import MASK, Core, Unknown

LONG = {f"{letter}x": f"r{letter}x" for letter in "abcd"} | {"si": "rsi", "di": "rdi", "bp": "rbp", "sp": "rsp"}
GENERAL = ["r15", "r14", "r13", "r12", "r11", "r10", "r9", "r8", "rbx", "rbp", "rax", "rcx", "rdx", "rsi", "rdi"]
ARGUMENTS = ["rdi", "rsi", "rdx", "rcx", "r8", "r9"]
MEMORY = re.compile(r"(?P<offset>[^(\s,]*)\((?P<base>%\w+)?(?:,\s*(?P<index>%\w+)(?:,\s*(?P<scale>\d))?)?\)")
VECTOR = re.compile(r"%([xyz])mm(\d+)")


PRODUCT = re.compile(r"(v(?:fn?m(?:add|sub)\d+|add|sub|mul|div|max|min)([ps]s))\t([^%]*\(.*?\))(\{1to\d+\})?(, .*%([xyz])mm\d+)")
# FAR: after so many instructions a load has arrived. NEVER: the position of the next read of a register that is not read again.
FAR, NEVER = 40, -1000


def loads_apart(text):
    """Returns the text with each load that is part of a product as a separate instruction before the product. Hardware starts
    such a load early, but llvm-mca starts it only when both factors are available. The load uses the vector register whose next
    read is the furthest away, so the value has arrived long before that read."""
    lines, read_at = [], {n: NEVER for n in range(32 if "%zmm" in text else 16)}
    for at, line in enumerate(reversed(text.splitlines())):
        numbers = [int(number) for _, number in VECTOR.findall(line)]
        written = re.search(r"%[xyz]mm(\d+)$", line)
        if written and not line.startswith("vf"):
            read_at[numbers.pop()] = NEVER
        product = PRODUCT.fullmatch(line)
        read_at |= {number: at for number in numbers}
        free = min((n for n in read_at if n != int(written[1])), key=read_at.get) if product else None
        if product and at - read_at[free] > FAR:
            name, scalar, address, everywhere, others, size = product.groups()
            lines.append(f"{name}\t%{size}mm{free}{others}")
            load = "vmovss" if scalar == "ss" else "vbroadcastss" if everywhere else "vmovups"
            line = f"{load}\t{address}, %{size}mm{free}"
        lines.append(line)
    return "\n".join(reversed(lines)) + "\n"


def long_name(register):
    """Returns the 64-bit register to which %eax, %r8d, ... belong; None for vectors."""
    name = register.lstrip("%")
    if name in GENERAL or name == "rsp":
        return name
    if re.fullmatch(r"r\d+[dwb]", name):
        return name[:-1]
    if re.fullmatch(r"e?(ax|bx|cx|dx|si|di|bp|sp)", name):
        return LONG[name[-2:]]
    return None


def narrow(register):
    return bool(re.fullmatch(r"%(e..|r\d+d)", register))


class X86(Core):
    def __init__(self):
        super().__init__()
        for n, register in enumerate(ARGUMENTS):
            self.registers[register] = (n + 1) << 20
        self.registers["rsp"] = 7 << 20

    @staticmethod
    def general():
        return GENERAL

    @staticmethod
    def uses(text, register):
        names = [register, register + "d"] if register[1:].isdigit() else [register, "e" + register[1:]]
        return re.search("|".join(f"%{name}\\b" for name in names), text) is not None

    @staticmethod
    def addressed_by(line, register):
        return MEMORY.sub(f"(%{register})", line, count=1)

    @staticmethod
    def link(vector, register):
        return f"vmovd\t%xmm{vector}, %{register}{'d' if register[1:].isdigit() else ''}"

    @staticmethod
    def fused(line):
        return line.startswith(("cmp", "test"))

    def address(self, operand):
        match = MEMORY.fullmatch(operand)
        if not match:
            return None
        offset = match["offset"]
        if match["base"] == "%rip":
            return self.symbol(offset)
        at = int(offset, 0) if re.fullmatch(r"-?\w+", offset or "0") and offset[-1:].isdigit() else 0
        at = self.symbol(offset) if offset and not re.fullmatch(r"-?\d+", offset) else at
        parts = [self.registers.get(long_name(match[part])) for part in ("base", "index") if match[part]]
        if None in parts:
            raise Unknown(f"the address {operand}, which the caller's data decide")
        if match["base"]:
            at += parts[0]
        if match["index"]:
            at += parts[-1] * int(match["scale"] or 1)
        return at & MASK

    def value(self, operand):
        if operand.startswith("$"):
            text = operand[1:]
            return int(text, 0) & MASK if re.fullmatch(r"-?\w+", text) and text.lstrip("-")[0].isdigit() else self.symbol(text)
        if operand.startswith("%"):
            value = self.registers.get(long_name(operand))
            return value & 0xffffffff if narrow(operand) and value is not None else value
        return self.memory.get(self.address(operand))  # None: data of the caller

    def put(self, operand, value):
        if operand.startswith("%"):
            bits = 0xffffffff if narrow(operand) else MASK
            self.registers[long_name(operand)] = None if value is None else value & bits
        else:
            self.memory[self.address(operand)] = value

    def jump(self, mnemonic, ops):
        """Returns the label of a jump, "" if the jump is not taken, or None if it is no jump."""
        if mnemonic == "jmp":
            return ops[0]
        if mnemonic.startswith("j"):
            return ops[0] if self.holds({"z": "e", "nz": "ne", "c": "b", "nc": "ae", "nb": "ae", "nbe": "a", "na": "be", "nae": "b", "nl": "ge", "nle": "g", "ng": "le", "nge": "l"}.get(mnemonic[1:], mnemonic[1:])) else ""
        return None

    def execute(self, mnemonic, ops):
        last = ops[-1] if ops else ""
        if mnemonic.startswith("v") or any(VECTOR.match(op) for op in ops):
            if last.startswith("%") and long_name(last):
                self.put(last, None)
            return self.vector(mnemonic, ops)
        known = re.fullmatch(r"(mov|lea|add|sub|and|or|xor|cmp|test|inc|dec|neg|sal|shl|sar|shr|imul|push|pop|movs|movz|movabs)"
                             r"[bwlq]{0,2}", mnemonic)
        if mnemonic in ("endbr64", "nop", "leave"):
            if mnemonic == "leave":
                self.registers["rsp"] = self.registers["rbp"] + 8
                self.registers["rbp"] = self.memory.get(self.registers["rbp"], 0)
            return None, None, None
        if known:
            self.integer(known[1], ops)
        else:
            self.flags = None
            if last.startswith("%"):
                self.put(last, None)
        return None, None, None

    def integer(self, what, ops):
        last = ops[-1]
        if what == "push":
            self.registers["rsp"] -= 8
            self.memory[self.registers["rsp"]] = self.registers.get(long_name(last), 0)
        elif what == "pop":
            self.registers[long_name(last)] = self.memory.get(self.registers["rsp"], 0)
            self.registers["rsp"] += 8
        elif what == "lea":
            self.put(last, self.address(ops[0]))
        elif what.startswith("mov"):
            self.put(last, self.value(ops[0]))
        elif what == "cmp":
            self.flags = (self.value(last), self.value(ops[0]))
        elif what == "test":
            a, b = self.value(last), self.value(ops[0])
            self.flags = None if None in (a, b) else (a & b, 0)
        elif what == "xor" and ops[0] == ops[1]:
            self.put(last, 0)
            self.flags = (0, 0)
        elif None in (self.value(ops[0]), self.value(last)):
            self.put(last, None)
            self.flags = None
        else:
            b, a = self.value(ops[0]), self.value(last)
            shift = b if len(ops) == 2 else 1
            result = {"add": a + b, "sub": a - b, "and": a & b, "or": a | b, "xor": a ^ b, "inc": a + 1, "dec": a - 1,
                      "neg": -a, "sal": a << (shift & 63), "shl": a << (shift & 63), "shr": a >> (shift & 63),
                      "sar": self.signed(a) >> (shift & 63), "imul": a * b}[what]
            self.put(last, result)
            self.flags = (a, b) if what == "sub" else (result & MASK, 0)

    def vector(self, mnemonic, ops):
        memory = [op for op in ops if MEMORY.search(op)]
        if not memory:
            return None, None, None
        where = self.address(re.sub(r"\{.*", "", memory[0]))
        widths = {"x": 16, "y": 32, "z": 64}
        size = max((widths[VECTOR.match(op)[1]] for op in ops if VECTOR.match(op)), default=64)
        if "{1to" in memory[0] or re.search("ss$|broadcastss|movd$|extractps|insertps", mnemonic):
            size = 4
        elif re.search("sd$|[lh]ps|movq$", mnemonic):
            size = 8
        elif re.search("32x4|64x2|128", mnemonic):
            size = 16
        if memory[0] == ops[-1]:
            register = next(VECTOR.match(op)[2] for op in ops if VECTOR.match(op))
            return None, (where, size), register
        return (where, size), None, None
