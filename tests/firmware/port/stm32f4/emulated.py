# SPDX-License-Identifier: Apache-2.0
"""An image on an emulated STM32F407 with its bxCAN (the package labwired): frames in, frames out, tick by tick.

What the emulator has: the core, the interrupt controller, SysTick, clocks, pins and the bxCAN's hand-shakes, bit
timing, filter banks, FIFO 0 and mailboxes, each of which sends at once. What its bxCAN 0.25.0 lacks is done here, and
only this:

- it raises no interrupt: the lines of CAN1_TX and CAN1_RX0 are pulled here, by the interrupt controller's pending
  register, whenever the registers say that they would be (RM0090 32.8)
- it has no FIFO 1, no overrun and no bus-off: those are tested against tests/firmware/port/stm32f4/fake_bxcan.cpp
- it programs no flash of the STM32F4: the image's memory is one that cannot be used
- its TIM5 captures no edge of an LSI: the image's LsiClock::start() returns at once and agrees() says true, with the
  value of the image (toolchain/image_crc.py) placed again. tests/firmware/port/stm32/lsi_clock_test.cpp has the rest
- a millisecond of 168 000 cycles takes it 45 ms: SysTick is told to count 24 000 once the image has set it up, so that
  the processor has a seventh of the time for each tick that it has on the part
"""
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[4] / "toolchain"))
import image_crc  # noqa: E402

BXCAN = 0x40006400
TSR, RF0R, RF1R, IER, ESR = BXCAN + 0x08, BXCAN + 0x0C, BXCAN + 0x10, BXCAN + 0x14, BXCAN + 0x18
MSR, INAK = BXCAN + 0x04, 1 << 0
NVIC_ISPR0, SYST_RVR, SYST_CVR = 0xE000E200, 0xE000E014, 0xE000E018
CAN1_TX, CAN1_RX0 = 1 << 19, 1 << 20
TMEIE, FMPIE0, RQCP_ALL = 1 << 0, 1 << 1, 0x010101
CYCLES_PER_MS = 24_000
USED = {"rcc", "gpiod", "gpioe", "systick", "bxcan1", "nvic", "iwdg", "flash"}
EXTENDED = 0x80000000


def without_second_clock(elf, folder):
    """A copy of the image that compares its clock with nothing."""
    rows = subprocess.run(["arm-none-eabi-nm", elf], check=True, capture_output=True, text=True).stdout.splitlines()
    data = bytearray(elf.read_bytes())
    code = {"_ZN7voltlap4port5stm328LsiClock6agreesEv": b"\x01\x20\x70\x47",           # movs r0, #1; bx lr
            "_ZN7voltlap4port5stm328LsiClock5startERNS1_8RegisterES4_m": b"\x70\x47\x70\x47"}   # bx lr
    for name, instructions in code.items():
        address = next(int(row.split()[0], 16) for row in rows if row.endswith(" " + name)) & ~1
        begin, at, _ = next(part for part in image_crc.load_parts(bytes(data))
                            if part[0] <= address < part[0] + len(part[2]))
        data[at + address - begin:at + address - begin + 4] = instructions
    out = folder / "without_second_clock.elf"
    out.write_bytes(image_crc.placed(bytes(data)))
    return out


def system_file(configs, folder):
    """The package's STM32F407 with only the peripherals that the board uses, which is three times as fast."""
    chip = (configs / "chips" / "stm32f407.yaml").read_text()
    head, body = chip.split("peripherals:\n", 1)
    kept = []
    for item in re.split(r"(?m)^(?=  - id:)", body):
        name = re.match(r'  - id: "(\w+)"', item)
        if name and name[1] in USED:
            kept.append(re.sub(r"(?m)^\s*#.*\n", "", item).replace("../peripherals/", f"{configs}/peripherals/"))
    assert len(kept) == len(USED), "the package's stm32f407.yaml has other peripherals than 0.25.0"
    head = re.sub(r"(?m)^cpu_hz:.*$", f"cpu_hz: {CYCLES_PER_MS * 1000}", head)
    (folder / "chip.yaml").write_text(head + "peripherals:\n" + "".join(kept))
    system = folder / "system.yaml"
    system.write_text(f'name: "voltlap"\nchip: "{folder / "chip.yaml"}"\nexternal_devices: []\nboard_io: []\n')
    return system


class Board:
    """An image that has come up to the point where it waits for its first tick."""

    def __init__(self, labwired, elf, folder):
        configs = pathlib.Path(labwired.__file__).parent / "configs"
        self.sim = labwired.Sim(elf, system=system_file(configs, folder))
        for _ in range(60_000):  # the march through memory and the CRC over the image come first
            if self.sim.read_u32(IER) != 0 and self.sim.read_u32(MSR) & INAK == 0:
                break
            self.sim.run_for("20us")
        assert self.sim.read_u32(IER) != 0, "the image did not bring its CAN controller up"
        self.sim.write_u32(SYST_RVR, CYCLES_PER_MS - 1)
        self.sim.write_u32(SYST_CVR, 0)
        self.seen = 0

    def raise_interrupts(self):
        """The lines as they would stand, until none does."""
        for _ in range(20):
            enabled = self.sim.read_u32(IER)
            lines = 0
            if enabled & TMEIE and self.sim.read_u32(TSR) & RQCP_ALL:
                lines |= CAN1_TX
            if enabled & FMPIE0 and (self.sim.read_u32(RF0R) | self.sim.read_u32(RF1R)) & 3:
                lines |= CAN1_RX0
            if not lines:
                return
            self.sim.write_u32(NVIC_ISPR0, lines)
            self.sim.run_for("30us")
        raise AssertionError("an interrupt of the CAN controller does not end")

    def receive(self, can_id, data):
        """A frame on the bus; ValueError when no filter takes it."""
        self.sim.inject_can("bxcan1", can_id & 0x1FFFFFFF, data, extended=bool(can_id & EXTENDED))
        self.raise_interrupts()

    def sent(self):
        """Frames since the last call, as (id, data)."""
        frames = [f for f in self.sim.frames() if f["seq"] > self.seen]
        self.seen = max((f["seq"] for f in frames), default=self.seen)
        payloads = [f["payload"] for f in frames if f["payload"]["direction"] == "tx"]
        return [(p["id"] | (EXTENDED if p["extended"] else 0), bytes(p["data"])) for p in payloads]

    def run_until_sent(self, milliseconds=40):
        """To the end of the next tick: 2 ms after the first frame of it."""
        out = []
        for _ in range(milliseconds):
            self.sim.run_for("1ms")
            self.raise_interrupts()
            out += self.sent()
            if out:
                break
        for _ in range(2):
            self.sim.run_for("1ms")
            self.raise_interrupts()
            out += self.sent()
        return out
