# SPDX-License-Identifier: MIT
"""A linked 32-bit program: its instructions, its symbols and what its memory holds for good."""
import struct
import subprocess

import thumb


class Program:
    """What objdump and the ELF file say. `frozen`: addresses of words in RAM that nobody writes after start-up."""

    def __init__(self, path, tools="arm-none-eabi-"):
        self.path, self.tools, self.frozen, self.sources = path, tools, set(), {}
        with open(path, "rb") as file:
            self.bytes = file.read()
        listing = subprocess.run([tools + "objdump", "-d", "--no-show-raw-insn", path], check=True, capture_output=True,
                                 text=True).stdout
        self.code, self.names = thumb.read(listing)
        self.sections, self.symbols = [], {}
        self._read_sections()

    def _read_sections(self):
        table, = struct.unpack_from("<I", self.bytes, 32)
        size, count = struct.unpack_from("<HH", self.bytes, 46)
        rows = [struct.unpack_from("<10I", self.bytes, table + i * size) for i in range(count)]
        for _, kind, flags, address, offset, length, link, *_ in rows:
            if kind == 1 and flags & 2:  # PROGBITS, ALLOC
                self.sections.append((address, length, offset, bool(flags & 1)))
            if kind == 2:  # SYMTAB
                names = rows[link][4]
                for at in range(offset, offset + length, 16):
                    name, value, _, info, *_ = struct.unpack_from("<IIIBBH", self.bytes, at)
                    text = self.bytes[names + name : self.bytes.index(b"\0", names + name)].decode()
                    self.symbols[text] = value & ~1 if info & 15 == 2 else value

    def word(self, address, size=4):
        """What is at an address, where it cannot change; else None."""
        for start, length, offset, writable in self.sections:
            if start <= address and address + size <= start + length:
                if writable and address not in self.frozen:
                    return None
                return int.from_bytes(self.bytes[offset + address - start :][:size], "little")
        return None

    def lines(self, addresses):
        """{address: [(file, line, its text)]} of instructions, the innermost inlined function first. The program has
        debug information."""
        addresses = [f"{a:x}" for a in addresses]
        said = subprocess.run([self.tools + "addr2line", "-e", self.path, "-a", "-i", *addresses], check=True,
                              capture_output=True, text=True).stdout
        found = {}
        for line in said.splitlines():
            if line.startswith("0x"):
                places = found[int(line, 16)] = []
            else:
                file, _, number = line.split(" ")[0].rpartition(":")
                places.append((file, number, self.text_of(file, number)))
        return found

    def text_of(self, file, number):
        if file not in self.sources:
            try:
                with open(file, encoding="utf-8") as source:
                    self.sources[file] = source.read().splitlines()
            except OSError:
                self.sources[file] = []
        lines = self.sources[file]
        return lines[int(number) - 1].strip() if number.isdigit() and 0 < int(number) <= len(lines) else ""
