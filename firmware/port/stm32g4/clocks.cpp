// SPDX-License-Identifier: Apache-2.0
#include "port/stm32g4/system_registers.hpp"

namespace voltlap::port::stm32g4 {
namespace {

constexpr std::uint32_t kHseOn = 1U << 16, kHseRdy = 1U << 17, kPllOn = 1U << 24, kPllRdy = 1U << 25;  // 7.4.1
// 7.4.4: source HSE, M less 1, N, R 2 and its output on.
constexpr std::uint32_t kPll = 3U | 5U << 4 | 72U << 8 | 1U << 24 | 0U << 25;
constexpr std::uint32_t kSwitchMask = 3U, kSwitchToPll = 3U, kSwitched = 3U << 2;     // 7.4.3
constexpr std::uint32_t kHalfMask = 0xFU << 4, kHalf = 8U << 4;                        // of AHB
constexpr std::uint32_t kBusesMask = 0x3FU << 8;                                      // APB1 and APB2: as AHB
constexpr std::uint32_t kLatencyMask = 0xFU, kLatency = 4U;                            // table 9: up to 150 MHz
constexpr std::uint32_t kCaches = 1U << 8 | 1U << 9 | 1U << 10;                        // prefetch, both caches
constexpr std::uint32_t kCrystalReads = 2'000'000;                                     // at 16 MHz, 8 cycles each: 1 s
constexpr std::uint32_t kMicrosecondReads = 32;                                        // at 72 MHz: 3.5 us

}  // namespace

bool start_clocks(RccRegisters& rcc, Register& flash_acr) {
  rcc.cr.set(kHseOn);
  if (!stm32::wait_set(rcc.cr, kHseRdy, kCrystalReads)) return false;
  rcc.pllcfgr.write(kPll);
  rcc.cr.set(kPllOn);
  if (!stm32::wait_set(rcc.cr, kPllRdy)) return false;
  flash_acr.replace(kLatencyMask, kLatency | kCaches);  // before the clock rises, and read back: 3.3.3
  if ((flash_acr.read() & kLatencyMask) != kLatency) return false;
  // 7.2.7: above 80 MHz by way of half of it, for a microsecond.
  rcc.cfgr.replace(kHalfMask | kBusesMask, kHalf);
  rcc.cfgr.replace(kSwitchMask, kSwitchToPll);
  if (!stm32::wait_set(rcc.cfgr, kSwitched)) return false;
  for (std::uint32_t i = 0; i < kMicrosecondReads; ++i) static_cast<void>(rcc.cfgr.read());
  rcc.cfgr.clear(kHalfMask);
  return true;
}

}  // namespace voltlap::port::stm32g4
