// SPDX-License-Identifier: Apache-2.0
// A board with an STM32G474xE, a 24 MHz crystal and a transceiver at FDCAN1 (PA11, PA12): a Nucleo-G474RE with one
// fits. What is behind which pin is the table below; another board is another table.
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
#include "port/stm32g4/fdcan.hpp"
#include "port/stm32g4/flash.hpp"
#include "port/stm32g4/system_registers.hpp"

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
// RM0440 2.2.2, table 3
stm32g4::FdCanRegisters& fdcan1() { return at<stm32g4::FdCanRegisters>(0x4000'6400U); }
stm32g4::MessageRam& message_ram() { return at<stm32g4::MessageRam>(0x4000'A400U); }
stm32g4::RccRegisters& rcc() { return at<stm32g4::RccRegisters>(0x4002'1000U); }
stm32g4::FlashRegisters& flash_registers() { return at<stm32g4::FlashRegisters>(0x4002'2000U); }
stm32::IwdgRegisters& iwdg() { return at<stm32::IwdgRegisters>(0x4000'3000U); }
stm32::TimerRegisters& tim16() { return at<stm32::TimerRegisters>(0x4001'4400U); }
stm32::GpioRegisters& gpio_a() { return at<stm32::GpioRegisters>(0x4800'0000U); }
stm32::GpioRegisters& gpio_c() { return at<stm32::GpioRegisters>(0x4800'0800U); }
stm32::SysTickRegisters& systick() { return at<stm32::SysTickRegisters>(0xE000'E010U); }
Register& nvic_iser0() { return at<Register>(0xE000'E100U); }
Register& scb_vtor() { return at<Register>(0xE000'ED08U); }
Register& scb_aircr() { return at<Register>(0xE000'ED0CU); }

constexpr std::uint32_t kGpioAClock = 1U << 0, kGpioCClock = 1U << 2;      // of AHB2
constexpr std::uint32_t kFdCanClock = 1U << 25, kTim16Clock = 1U << 17;    // of APB1, APB2
constexpr std::uint32_t kFdCanSourceMask = 3U << 24;                       // CCIPR.FDCANSEL 0: the crystal
constexpr std::uint32_t kTi1IsLsi = 6;                                     // TIM16_TISEL
constexpr std::uint32_t kAlternate = 2, kAlternateFdCan = 9, kRemoveFlags = 1U << 23;
constexpr std::size_t kPageBytes = 2048, kPagesPerArea = 64;
constexpr std::uint32_t kSystemReset = 0x05FA'0004U;  // ARMv7-M B3.2.6: the key, SYSRESETREQ
constexpr std::size_t kSocAhead = 75;  // of 144 cells, as many as an area holds: half an endurance

stm32::Pins pins() {
  stm32::Pins p;
  for (std::uint8_t i = 0; i < kDrives; ++i) p.drive[i] = {&gpio_c(), static_cast<std::uint8_t>(8 + i), false};
  for (std::uint8_t i = 0; i < kSenses; ++i) p.sense[i] = {&gpio_c(), i, false};
  return p;
}

void connect_can_pins() {
  stm32::GpioRegisters& a = gpio_a();
  a.afr[1].replace(0xFFU << 12, kAlternateFdCan << 12 | kAlternateFdCan << 16);
  a.moder.replace(0xFU << 22, kAlternate << 22 | kAlternate << 24);
}

/// What the interrupts reach. Set before they are let in.
stm32g4::FdCan* volatile the_can = nullptr;
stm32::SysTick* volatile the_clock = nullptr;
stm32g4::PageFlash* volatile the_flash = nullptr;

void on_systick() { the_clock->on_interrupt(); }
void on_can() { the_can->on_interrupt(); }
void on_nothing() {
  std::uint32_t number = 0;
  __asm__ volatile("mrs %0, ipsr" : "=r"(number));
  board_fault(number);
}
/// A record that was cut off; anything else is a fault.
void on_nmi() {
  stm32g4::PageFlash* const flash = the_flash;
  if (flash == nullptr || !flash->on_nmi()) on_nothing();
}

/// The 16 of the core and FDCAN1_IT0 (RM0440 table 97); those up to it are faults, and none behind it is let in.
constexpr std::size_t kCore = 16, kFdCan1 = 21, kVectors = kCore + kFdCan1 + 1;
struct Vectors {
  const void* stack;
  void (*handler[kVectors - 1])();
};
constexpr Vectors make_vectors() {
  Vectors v{&__stack_top, {}};
  for (auto& handler : v.handler) handler = on_nothing;
  v.handler[0] = reset;
  v.handler[1] = on_nmi;
  v.handler[14] = on_systick;
  v.handler[kCore + kFdCan1 - 1] = on_can;
  return v;
}
alignas(512) const Vectors kBoardVectors = make_vectors();  // 38 words: the next power of two is 256 bytes

/// What the nodes of this image listen to.
stm32::CanError join_bus(stm32g4::FdCan& bus) {
  const stm32g4::FdCan::Config config{stm32g4::kCrystal_hz, can::kBitRate, stm32::kSamplePoint_permille};
  const stm32::HeardRows heard = stm32::heard_by(kImageInfo.has_bms, kImageInfo.has_master);
  return bus.init(config, heard.rows, heard.count);
}

__attribute__((section(".noinit"))) BootRequest the_boot_request;

void open_relays() { gpio_c().bsrr.write(0x1FU << (16 + 8)); }

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

stm32::LsiClock& start_second_clock() {
  static stm32::LsiClock second_clock(tim16(), {1, 0xFFFFU, stm32g4::kCore_hz, stm32::kLsiStm32g4});
  second_clock.start(rcc().csr, tim16().tisel, kTi1IsLsi);
  return second_clock;
}

}  // namespace

Board start_board() {
  scb_vtor().write(static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&kBoardVectors)));
  rcc().ahb2enr.set(kGpioAClock | kGpioCClock);
  rcc().apb1enr1.set(kFdCanClock);
  rcc().apb2enr.set(kTim16Clock);
  static stm32::BoardPins gpio(pins());
  if (!gpio.init()) refuse();  // first of all: the relays are driven open
  if (!stm32g4::start_clocks(rcc(), flash_registers().acr)) refuse();
  rcc().ccipr.clear(kFdCanSourceMask);
  static stm32::SysTick clock(systick());
  the_clock = &clock;
  if (!clock.start(stm32g4::kCore_hz)) refuse();
  connect_can_pins();
  static stm32g4::FdCan bus(fdcan1(), message_ram());
  the_can = &bus;
  const stm32::CanError error = join_bus(bus);
  if (error != stm32::CanError::kNone && error != stm32::CanError::kNotOnBus) refuse();
  nvic_iser0().write(1U << kFdCan1);
  static stm32g4::PageFlash flash(flash_registers(), {0, true, &at<Register>(0x0804'0000U)},
                                  {kPagesPerArea, true, &at<Register>(0x0806'0000U)}, kPagesPerArea, kPageBytes);
  the_flash = &flash;
  static FlashNvm nvm(flash, kSocAhead);
  static ProcessorReset restart;
  static stm32::Iwdg watchdog(iwdg(), rcc().csr, kRemoveFlags, stm32::kLsiStm32g4);
  return {bus, clock, gpio, nvm, watchdog, nullptr, &restart, &start_second_clock()};
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
