// SPDX-License-Identifier: Apache-2.0
// A board to start from: copy this folder and fill what says FILL; docs/porting.md goes through it. Until then it is
// safe: it links, its relays stay open, no frame goes out, and a BMS on it latches ConfigInvalid, for nobody knows
// its trips.
#include "port/board.hpp"

#include "port/image_info.hpp"
#include "port/stm32/systick.hpp"
#include "port/template/bus.hpp"
#include "port/template/memory.hpp"
#include "port/template/pins.hpp"

extern "C" [[noreturn]] void board_fault(std::uint32_t number);
extern "C" void systick_handler();

namespace voltlap::port {
namespace {

/// FILL 2: of the processor, after start_clocks().
constexpr std::uint32_t kCore_hz = 64'000'000;

/// Every Cortex-M has it at this address.
stm32::SysTickRegisters& systick() { return *reinterpret_cast<stm32::SysTickRegisters*>(0xE000'E010U); }
stm32::SysTick* volatile the_clock = nullptr;

/// FILL 2: crystal, PLL, wait states, the clocks of pins and bus. The bus needs a crystal: an internal oscillator is
/// too coarse. False when one does not come up within a bounded wait.
bool start_clocks() { return true; }

/// FILL 6: a counter with a clock of its own that resets the board. False until there is one: the loop runs on without.
class BoardWatchdog final : public Watchdog {
 public:
  bool start(Duration /*timeout*/) override { return false; }
  void feed() override {}
  [[nodiscard]] bool has_bitten() const override { return false; }
};

}  // namespace

Board start_board() {
  static BoardPins pins;
  if (!pins.init()) board_fault(0);  // first of all: the relays are driven open
  if (!start_clocks()) board_fault(0);
  static stm32::SysTick clock(systick());
  the_clock = &clock;
  if (!clock.start(kCore_hz)) board_fault(0);
  static BoardBus bus;
  if (!bus.init(kImageInfo.has_bms, kImageInfo.has_master)) board_fault(0);
  static BoardMemory memory;
  static BoardWatchdog watchdog;
  return {bus, clock, pins, memory, watchdog};
}

}  // namespace voltlap::port

extern "C" void systick_handler() { voltlap::port::the_clock->on_interrupt(); }

namespace voltlap {

void require_failed(const char* /*condition*/, const char* /*file*/, int /*line*/) { board_fault(0); }

}  // namespace voltlap

/// Relays open, and the node falls silent: every receiver opens or disables by timeout.
extern "C" void board_fault(std::uint32_t /*number*/) {
  voltlap::port::open_relays();
  for (;;) {
  }
}
