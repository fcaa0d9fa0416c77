// SPDX-License-Identifier: Apache-2.0
// A board with an STM32F407xG, an 8 MHz crystal and a transceiver at CAN1 (PD0, PD1): a Discovery kit with one fits.
// What is behind which pin is the table below; another board is another table.
#include "port/board.hpp"

#include "base/boot_request.hpp"
#include "base/require.hpp"
#include "port/flash/flash_nvm.hpp"
#include "port/image_info.hpp"
#include "port/stm32/gpio.hpp"
#include "port/stm32/heard.hpp"
#include "port/stm32/lsi_clock.hpp"
#include "port/stm32/systick.hpp"
#include "port/stm32/watchdog.hpp"
#include "port/stm32f4/bxcan.hpp"
#include "port/stm32f4/flash.hpp"
#include "port/stm32f4/system_registers.hpp"

extern "C" [[noreturn]] void reset();
extern "C" [[noreturn]] void board_fault(std::uint32_t number);
extern "C" std::uint32_t __stack_top;

namespace voltlap::port {
namespace {

using stm32::Register;

template <class Block>
Block& at(std::uintptr_t address) {
  return *reinterpret_cast<Block*>(address);
}
// RM0090 2.3, table 1
stm32f4::BxCanRegisters& can1() { return at<stm32f4::BxCanRegisters>(0x4000'6400U); }
stm32f4::RccRegisters& rcc() { return at<stm32f4::RccRegisters>(0x4002'3800U); }
stm32f4::FlashRegisters& flash_registers() { return at<stm32f4::FlashRegisters>(0x4002'3C00U); }
stm32::TimerRegisters& tim5() { return at<stm32::TimerRegisters>(0x4000'0C00U); }
stm32::IwdgRegisters& iwdg() { return at<stm32::IwdgRegisters>(0x4000'3000U); }
stm32::GpioRegisters& gpio_d() { return at<stm32::GpioRegisters>(0x4002'0C00U); }
stm32::GpioRegisters& gpio_e() { return at<stm32::GpioRegisters>(0x4002'1000U); }
stm32::SysTickRegisters& systick() { return at<stm32::SysTickRegisters>(0xE000'E010U); }
Register& nvic_iser0() { return at<Register>(0xE000'E100U); }
Register& scb_vtor() { return at<Register>(0xE000'ED08U); }
Register& scb_aircr() { return at<Register>(0xE000'ED0CU); }

constexpr std::uint32_t kGpioDClock = 1U << 3, kGpioEClock = 1U << 4, kCan1Clock = 1U << 25, kTim5Clock = 1U << 3;
constexpr std::uint32_t kCan1Interrupts = 1U << 19 | 1U << 20 | 1U << 21;  // TX, RX0, RX1: RM0090 table 61
constexpr std::uint32_t kAlternate = 2, kAlternateCan1 = 9, kRemoveFlags = 1U << 24;
constexpr std::uint32_t kTi4IsLsi = 1U << 6;  // TIM5_OR, 18.4.21
constexpr std::size_t kCan1Banks = 14;  // as CAN2SB has it from reset
constexpr std::size_t kSectorBytes = 128 * 1024, kSectorsPerArea = 2;
constexpr std::uint32_t kSystemReset = 0x05FA'0004U;  // ARMv7-M B3.2.6: the key, SYSRESETREQ
constexpr std::size_t kSocAhead = 160;  // an endurance writes some 150

stm32::Pins pins() {
  stm32::Pins p;
  for (std::uint8_t i = 0; i < kDrives; ++i) p.drive[i] = {&gpio_e(), static_cast<std::uint8_t>(8 + i), false};
  for (std::uint8_t i = 0; i < kSenses; ++i) p.sense[i] = {&gpio_e(), i, false};
  return p;
}

void connect_can_pins() {
  stm32::GpioRegisters& d = gpio_d();
  d.afr[0].replace(0xFFU, kAlternateCan1 | kAlternateCan1 << 4);
  d.moder.replace(0xFU, kAlternate | kAlternate << 2);
}

/// What the interrupts reach. Set before they are let in.
stm32f4::BxCan* volatile the_can = nullptr;
stm32::SysTick* volatile the_clock = nullptr;

void on_systick() { the_clock->on_interrupt(); }
void on_can() {
  the_can->on_receive_interrupt();
  the_can->on_transmit_interrupt();
}
void on_nothing() {
  std::uint32_t number = 0;
  __asm__ volatile("mrs %0, ipsr" : "=r"(number));
  board_fault(number);
}

/// The 16 of the core and CAN1_TX, CAN1_RX0, CAN1_RX1; those up to it are faults, and none behind it is let in.
constexpr std::size_t kCore = 16, kCan1Tx = 19, kVectors = kCore + 22;
struct Vectors {
  const void* stack;
  void (*handler[kVectors - 1])();
};
constexpr Vectors make_vectors() {
  Vectors v{&__stack_top, {}};
  for (auto& handler : v.handler) handler = on_nothing;
  v.handler[0] = reset;
  v.handler[14] = on_systick;
  for (std::size_t i = 0; i < 3; ++i) v.handler[kCore + kCan1Tx + i - 1] = on_can;
  return v;
}
alignas(512) const Vectors kBoardVectors = make_vectors();  // 38 words: the next power of two is 256 bytes

/// What the nodes of this image listen to.
stm32::CanError join_bus(stm32f4::BxCan& bus) {
  const stm32f4::BxCan::Config config{stm32f4::kApb1_hz, can::kBitRate, stm32::kSamplePoint_permille, 0, kCan1Banks};
  const stm32::HeardRows heard = stm32::heard_by(kImageInfo.has_bms, kImageInfo.has_master);
  return bus.init(config, heard.rows, heard.count);
}

__attribute__((section(".noinit"))) BootRequest the_boot_request;

void open_relays() { gpio_e().bsrr.write(0x1FU << (16 + 8)); }

class ProcessorReset final : public Restart {
 public:
  void restart(bool into_boot_loader) override {
    open_relays();
    if (into_boot_loader) the_boot_request.ask();
    scb_aircr().write(kSystemReset);
    for (;;) {
    }
  }
};

[[noreturn]] void refuse() { board_fault(0); }

}  // namespace

Board start_board() {
  scb_vtor().write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&kBoardVectors)));
  rcc().ahb1enr.set(kGpioDClock | kGpioEClock);
  rcc().apb1enr.set(kCan1Clock | kTim5Clock);
  static stm32::BoardPins gpio(pins());
  if (!gpio.init()) refuse();  // first of all: the relays are driven open
  if (!stm32f4::start_clocks(rcc(), flash_registers().acr)) refuse();
  static stm32::SysTick clock(systick());
  the_clock = &clock;
  if (!clock.start(stm32f4::kCore_hz)) refuse();
  connect_can_pins();
  static stm32f4::BxCan bus(can1(), can1());
  the_can = &bus;
  const stm32::CanError error = join_bus(bus);
  if (error != stm32::CanError::kNone && error != stm32::CanError::kNotOnBus) refuse();
  nvic_iser0().write(kCan1Interrupts);
  static stm32f4::SectorFlash flash(flash_registers(), {8, &at<Register>(0x0808'0000U)},
                                    {10, &at<Register>(0x080C'0000U)}, kSectorsPerArea, kSectorBytes);
  static FlashNvm nvm(flash, kSocAhead);
  static ProcessorReset restart;
  static stm32::Iwdg watchdog(iwdg(), rcc().csr, kRemoveFlags, stm32::kLsiStm32f4);
  // Timers of a divided bus run twice as fast as it (7.2).
  static stm32::LsiClock second_clock(tim5(), {4, 0xFFFF'FFFFU, 2 * stm32f4::kApb1_hz, stm32::kLsiStm32f4});
  second_clock.start(rcc().csr, tim5().option, kTi4IsLsi);
  return {bus, clock, gpio, nvm, watchdog, nullptr, &restart, &second_clock};
}

}  // namespace voltlap::port

namespace voltlap {

void require_failed(const char* /*condition*/, const char* /*file*/, int /*line*/) { port::refuse(); }

}  // namespace voltlap

/// Relays open, and the node falls silent: every receiver opens or disables by timeout. The watchdog, where it runs,
/// starts the board anew.
extern "C" void board_fault(std::uint32_t /*number*/) {
  voltlap::port::open_relays();
  for (;;) {
  }
}
