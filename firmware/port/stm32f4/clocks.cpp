// SPDX-License-Identifier: Apache-2.0
#include "port/stm32f4/system_registers.hpp"

namespace voltlap::port::stm32f4 {
namespace {

constexpr std::uint32_t kHseOn = 1U << 16, kHseRdy = 1U << 17, kPllOn = 1U << 24, kPllRdy = 1U << 25;
constexpr std::uint32_t kPll = 8U | 336U << 6 | 0U << 16 | 1U << 22 | 7U << 24;  // M, N, P 2, from HSE, Q
constexpr std::uint32_t kBuses = 5U << 10 | 4U << 13;                            // APB1 over 4, APB2 over 2
constexpr std::uint32_t kSwitchToPll = 2U, kSwitchMask = 3U, kSwitched = 2U << 2, kSwitchedMask = 3U << 2;
// 5 wait states at 3.3 V and 168 MHz (table 10), prefetch, both caches.
constexpr std::uint32_t kFlash = 5U | 1U << 8 | 1U << 9 | 1U << 10;
constexpr std::uint32_t kCrystalReads = 2'000'000;  // at 16 MHz, 8 cycles a read: 1 s

}  // namespace

bool start_clocks(RccRegisters& rcc, Register& flash_acr) {
  rcc.cr.set(kHseOn);
  if (!stm32::wait_set(rcc.cr, kHseRdy, kCrystalReads)) return false;
  rcc.pllcfgr.write(kPll);
  rcc.cr.set(kPllOn);
  if (!stm32::wait_set(rcc.cr, kPllRdy)) return false;
  flash_acr.write(kFlash);  // before the clock rises
  rcc.cfgr.write(kBuses);
  rcc.cfgr.replace(kSwitchMask, kSwitchToPll);
  for (std::uint32_t i = 0; i < stm32::kHandshakeReads; ++i) {
    if ((rcc.cfgr.read() & kSwitchedMask) == kSwitched) return true;
  }
  return false;
}

}  // namespace voltlap::port::stm32f4
