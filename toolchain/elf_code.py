# SPDX-License-Identifier: Apache-2.0
"""The code of a Thumb image as its disassembly has it: functions with their instructions, calls and frames."""
import re
import subprocess
from dataclasses import dataclass, field

HEAD = re.compile(r"^([0-9a-f]{8}) <(.+)>:$")
INSTRUCTION = re.compile(r"^\s+([0-9a-f]+):\t(\S+)\t?([^@;]*)")
LITERAL = re.compile(r"^\s+[0-9a-f]+:\tldr(?:\.w)?\t(r\d+), \[pc, .*\(([0-9a-f]+) <")
WORD = re.compile(r"^\s+([0-9a-f]+):\t\.word\t0x([0-9a-f]+)", re.MULTILINE)
BY_REGISTER = re.compile(r"sp, (r\d+)")
CALL_TARGET = re.compile(r"^([0-9a-f]+) <")
PUSHES = ("push", "stmdb")
JUMPS = ("b", "b.n", "b.w")


@dataclass
class Function:
    name: str
    address: int
    frame: int = 0                 # bytes that it pushes and reserves, all of them added up
    unknown_frame: str = ""        # an instruction that moves the stack by what is not written in it
    calls: set = field(default_factory=set)     # addresses
    indirect: int = 0              # calls through a register


def registers(text):
    """How many a list {r4-r11, lr} names."""
    inside = text[text.index("{") + 1:text.index("}")]
    count = 0
    for part in inside.split(","):
        ends = [int(word) for word in re.findall(r"r(\d+)", part)]
        count += ends[1] - ends[0] + 1 if "-" in part else 1
    return count


def frame_change(name, operands):
    """Bytes that the instruction takes off the stack pointer; None when it cannot be told."""
    if name in PUSHES and (name == "push" or operands.startswith("sp!")):
        return 4 * registers(operands)
    into_sp = re.match(r"(?:sp, )?sp, #(-?\d+)", operands)
    if name.startswith("sub") and operands.startswith("sp"):
        return int(into_sp[1]) if into_sp else None
    if name.startswith("add") and operands.startswith("sp") and not into_sp:
        return None
    stored = re.search(r"\[sp, #-(\d+)\]!", operands)
    return int(stored[1]) if stored else 0


def from_literal(operands, literals):
    """Bytes that `add sp, rN` takes off the stack pointer where rN holds a number that lies in the code."""
    register = BY_REGISTER.match(operands)
    value = literals.get(register[1]) if register else None
    return None if value is None else (2**32 - value if value >= 2**31 else 0)


def note_constant(name, operands, literals):
    """A small processor makes a number of its own where none lies in the code: a byte, shifted or negated."""
    if made := re.match(r"(r\d+), #(\d+)", operands) if name in ("movs", "mov") else None:
        literals[made[1]] = int(made[2])
    shifted = re.match(r"(r\d+), (r\d+), #(\d+)", operands)
    if shifted and name == "lsls":
        known = literals.get(shifted[2])
        literals[shifted[1]] = None if known is None else (known << int(shifted[3])) % 2**32
    if shifted and name in ("negs", "rsbs") and shifted[3] == "0":
        known = literals.get(shifted[2])
        literals[shifted[1]] = None if known is None else -known % 2**32


def read_instruction(function, name, operands, literals):
    change = frame_change(name, operands)
    if change is None and name.startswith("add"):
        change = from_literal(operands, literals)
    if change is None:
        function.unknown_frame = f"{name} {operands.strip()}"
    else:
        function.frame += max(change, 0)
    target = CALL_TARGET.match(operands)
    to = int(target[1], 16) if target else None
    if name == "bl" and target or name in JUMPS and target and to != function.address:  # a jump to itself is a loop
        function.calls.add(to)
    if name == "blx" or (name == "bx" and operands.strip() != "lr"):
        function.indirect += 1


def functions(elf, prefix="arm-none-eabi-"):
    """{address: Function} of all code in the file."""
    text = subprocess.run([prefix + "objdump", "-d", "-C", "--no-show-raw-insn", str(elf)], check=True,
                          capture_output=True, text=True).stdout
    constants = {int(at, 16): int(value, 16) for at, value in WORD.findall(text)}
    found, current, literals = {}, None, {}
    for line in text.splitlines():
        if head := HEAD.match(line):
            current = Function(head[2], int(head[1], 16))
            found[current.address] = current
            literals = {}
        elif current and (instruction := INSTRUCTION.match(line)):
            read_instruction(current, instruction[2], instruction[3], literals)
            note_constant(instruction[2], instruction[3], literals)
            if literal := LITERAL.match(line):
                literals[literal[1]] = constants.get(int(literal[2], 16))
    for function in found.values():
        function.calls = {call for call in function.calls if call in found}
    return found


def words(elf, prefix="arm-none-eabi-"):
    """Every aligned word of the loaded sections."""
    sections = [word for name in (".vectors", ".text", ".rodata", ".data") for word in ("-j", name)]
    text = subprocess.run([prefix + "objdump", "-s", *sections, str(elf)], capture_output=True, text=True).stdout
    found = set()
    for row in re.findall(r"^ [0-9a-f]+ ((?:[0-9a-f]{2,8} ){1,4})", text, re.MULTILINE):
        for word in row.split():
            if len(word) == 8:
                found.add(int.from_bytes(bytes.fromhex(word), "little"))
    return found
