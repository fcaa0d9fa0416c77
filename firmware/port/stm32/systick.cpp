// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/systick.hpp"

namespace voltlap::port::stm32 {
namespace {

constexpr std::uint32_t kEnable = 1U << 0, kTickInt = 1U << 1, kClkSource = 1U << 2;
constexpr std::uint32_t kReloadMax = 0x00FF'FFFFU;

}  // namespace

bool SysTick::start(std::uint32_t clock_hz) {
  const std::uint32_t counts = clock_hz / 1000U;
  if (counts < 2 || counts - 1U > kReloadMax || clock_hz % 1000U != 0) return false;
  regs_.csr.write(0);
  regs_.rvr.write(counts - 1U);
  regs_.cvr.write(0);
  __atomic_store_n(&ms_, 0U, __ATOMIC_RELEASE);
  regs_.csr.write(kEnable | kTickInt | kClkSource);
  return true;
}

void SysTick::on_interrupt() { __atomic_store_n(&ms_, ms_ + 1U, __ATOMIC_RELEASE); }

Instant SysTick::now() const { return Instant::from_ms(__atomic_load_n(&ms_, __ATOMIC_ACQUIRE)); }

void SysTick::sleep_until(Instant at) {
  while ((at - now()).ms() > 0) wait_for_interrupt();
}

}  // namespace voltlap::port::stm32
