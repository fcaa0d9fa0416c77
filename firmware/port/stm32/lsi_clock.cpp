// SPDX-License-Identifier: Apache-2.0
#include "port/stm32/lsi_clock.hpp"

namespace voltlap::port::stm32 {
namespace {

constexpr std::uint32_t kLsiOn = 1U << 0, kLsiReady = 1U << 1;  // RCC_CSR of both parts
constexpr std::uint32_t kCountEnable = 1U << 0, kUpdate = 1U << 0, kDirect = 1U, kSelectMask = 0xFFU;
// The slowest period, 59 us, takes 9 900 cycles of 168 MHz; a read at least 8. Twice as long is a clock that is too
// fast, or an LSI that stands.
constexpr std::uint32_t kEdgeReads = 2'500;

constexpr std::uint32_t captured(std::uint8_t channel) { return 1U << channel; }
constexpr std::uint32_t over_captured(std::uint8_t channel) { return 1U << (8U + channel); }

}  // namespace

void LsiClock::start(Register& csr, Register& select, std::uint32_t lsi) {
  csr.set(kLsiOn);
  static_cast<void>(wait_set(csr, kLsiReady));
  const unsigned index = input_.channel - 1U, shift = index % 2U * 8U;
  select.write(lsi);
  timer_.psc.write(0);
  timer_.arr.write(input_.counter_mask);
  timer_.egr.write(kUpdate);  // the prescaler is taken over
  timer_.ccmr[index / 2U].replace(kSelectMask << shift, kDirect << shift);  // every edge, no filter
  timer_.ccer.replace(0xFU << (4U * index), 1U << (4U * index));            // rising
  timer_.cr1.write(kCountEnable);
}

bool LsiClock::in_range(std::uint32_t counts) const {
  const std::uint64_t hz = input_.timer_hz;
  const std::uint64_t least = hz / input_.lsi.fastest_hz, most = hz / input_.lsi.slowest_hz + 1U;
  return counts >= least && counts <= most;
}

/// Two edges that follow each other. An interrupt between them that lasts longer than a period leaves the flag of a
/// capture that was overwritten.
LsiClock::Look LsiClock::look() {
  const std::uint32_t flag = captured(input_.channel), over = over_captured(input_.channel);
  const Register& capture = timer_.ccr[input_.channel - 1U];
  timer_.sr.write(~(flag | over));
  if (!wait_set(timer_.sr, flag, kEdgeReads)) return Look::kBad;
  const std::uint32_t first = capture.read();
  if (!wait_set(timer_.sr, flag, kEdgeReads)) return Look::kBad;
  const std::uint32_t second = capture.read();
  if ((timer_.sr.read() & over) != 0) return Look::kTorn;
  return in_range((second - first) & input_.counter_mask) ? Look::kGood : Look::kBad;
}

// DIA-005
bool LsiClock::agrees() {
  if (lost_ || ticks_++ % kTicksPerLook != 0) return !lost_;
  const Look now = look();
  torn_ = now == Look::kTorn ? torn_ + 1U : 0U;
  if (now != Look::kTorn) bad_ = now == Look::kBad ? bad_ + 1U : 0U;
  lost_ = bad_ >= kLooksMost || torn_ >= kTornMost;
  return !lost_;
}

}  // namespace voltlap::port::stm32
