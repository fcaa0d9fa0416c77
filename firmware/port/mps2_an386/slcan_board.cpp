// SPDX-License-Identifier: Apache-2.0
// The same board with UART 0 for a bus: SLCAN lines, which put it onto a CAN interface (`voltlap ecu-slcan`):
//
//   qemu-system-arm -M mps2-an386 -kernel IMAGE.elf -serial pty -semihosting-config enable=on,target=native
#include "port/board.hpp"
#include "port/lockstep/lockstep_board.hpp"
#include "port/mps2_an386/reset.hpp"
#include "port/serial/slcan_rig.hpp"

namespace voltlap::port {
namespace {

/// CMSDK APB UART (Application Note 386, table 4-1; Cortex-M System Design Kit TRM, 3.4).
struct UartRegisters {
  volatile std::uint32_t data, state, ctrl, interrupt, baud_divider;
};
constexpr std::uint32_t kTxFull = 1U << 0, kRxFull = 1U << 1;
constexpr std::uint32_t kTxEnable = 1U << 0, kRxEnable = 1U << 1;
constexpr std::uint32_t kDivider = 25;  // 1 Mbaud of 25 MHz; the emulator takes the bytes as they come
constexpr std::uint32_t kPollsPerHello = 500'000;  // some tenths of a second on an emulator

class Uart final : public Serial {
 public:
  Uart() {
    registers().baud_divider = kDivider;
    registers().ctrl = kTxEnable | kRxEnable;
  }
  bool read(std::uint8_t& byte) override {
    if ((registers().state & kRxFull) == 0) return false;
    byte = static_cast<std::uint8_t>(registers().data);
    return true;
  }
  void write(std::uint8_t byte) override {
    while ((registers().state & kTxFull) != 0) {
    }
    registers().data = byte;
  }

 private:
  static UartRegisters& registers() { return *reinterpret_cast<UartRegisters*>(0x4000'4000U); }
};

__attribute__((section(".nvm"))) RamNvm::Memory nvm_memory;

}  // namespace

Board start_board() {
  static Uart uart;
  static SlcanRig rig(uart, reset_processor, kPollsPerHello);
  const LockstepBoard lockstep = board_around(rig, nvm_memory);
  lockstep.plant.join();
  return lockstep.board;
}

}  // namespace voltlap::port
