// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/watchdog.hpp"

namespace voltlap::port::stm32 {
namespace {

// RM0090 21.4.1 IWDG_KR
constexpr std::uint32_t kUnlock = 0x5555, kReload = 0xAAAA, kStart = 0xCCCC;
constexpr std::uint32_t kBusy = 0x7;           // PVU, RVU, WVU: a register is on its way into the other clock
constexpr std::uint32_t kCountsMax = 4096;     // RLR counts 12 bits
constexpr std::uint32_t kPrescalerCodes = 7;   // 4, 8 ... 256
constexpr std::uint32_t kBitten = 1U << 29;    // RCC_CSR.IWDGRSTF

constexpr std::uint32_t divider(std::uint32_t code) { return 4U << code; }

}  // namespace

Iwdg::Counts Iwdg::counts_for(Duration timeout) const {
  if (timeout.ms() <= 0) return {};
  for (std::uint32_t code = 0; code < kPrescalerCodes; ++code) {
    const std::uint64_t counts =
        std::uint64_t{static_cast<std::uint32_t>(timeout.ms())} * lsi_.slowest_hz / (1000ULL * divider(code));
    if (counts >= 1 && counts <= kCountsMax) return {code, static_cast<std::uint32_t>(counts)};
  }
  return {};
}

Duration Iwdg::earliest_bite(Duration timeout) const {
  const Counts c = counts_for(timeout);
  return Duration::from_ms(
      static_cast<std::int32_t>(std::uint64_t{c.counts} * 1000U * divider(c.prescaler_code) / lsi_.fastest_hz));
}

// DIA-004
bool Iwdg::start(Duration timeout) {
  const Counts c = counts_for(timeout);
  if (c.counts == 0) return false;
  regs_.kr.write(kStart);  // first: it starts the oscillator that takes over PR and RLR
  regs_.kr.write(kUnlock);
  regs_.pr.write(c.prescaler_code);
  regs_.rlr.write(c.counts - 1U);
  const bool taken = wait_clear(regs_.sr, kBusy);
  regs_.kr.write(kReload);
  return taken && regs_.pr.read() == c.prescaler_code && regs_.rlr.read() == c.counts - 1U;
}

void Iwdg::feed() { regs_.kr.write(kReload); }

bool Iwdg::has_bitten() const { return (reset_flags_.read() & kBitten) != 0; }
void Iwdg::forget_bite() { reset_flags_.set(remove_flags_); }

}  // namespace voltlap::port::stm32
