// SPDX-License-Identifier: Apache-2.0
// The bit of a classic CAN bus in quanta of a controller's clock: one quantum of synchronisation, segment 1 up to the
// sample point, segment 2 after it (ISO 11898-1, RM0090 32.7.7, RM0440 44.3.3).
#pragma once
#include <cstdint>

namespace voltlap::port::stm32 {

struct CanTiming {
  std::uint16_t prescaler = 0;  ///< clocks a quantum; 0: there is none
  std::uint16_t segment1 = 0;   ///< quanta
  std::uint16_t segment2 = 0;
  std::uint16_t jump = 0;       ///< resynchronisation jump width, quanta
};

/// What a controller's registers hold.
struct CanTimingLimits {
  std::uint16_t prescaler_max;
  std::uint16_t segment1_min, segment1_max;
  std::uint16_t segment2_min, segment2_max;
  std::uint16_t jump_max;
};

inline constexpr CanTimingLimits kBxCanLimits{1024, 1, 16, 1, 8, 4};       // RM0090 32.9.2 CAN_BTR
inline constexpr CanTimingLimits kFdCanLimits{512, 2, 256, 2, 128, 128};   // RM0440 44.4.7 FDCAN_NBTP
inline constexpr std::uint32_t kQuantaMin = 8, kQuantaMax = 25;            // of a bit, ISO 11898-1
inline constexpr std::uint32_t kSamplePoint_permille = 875;                // CiA 301, for all rates up to 1 Mbit/s
inline constexpr std::uint32_t kSamplePointMiss_permille = 50;             // further off is refused

/// The timing whose bit rate is exact and whose sample point is nearest to the one asked for; of equals the one with
/// the most quanta. prescaler 0 when the clock cannot make that bit rate, or only with a sample point more than
/// kSamplePointMiss_permille away.
[[nodiscard]] constexpr CanTiming can_timing(std::uint32_t clock_hz, std::uint32_t bit_rate, CanTimingLimits limits,
                                             std::uint32_t sample_point_permille = kSamplePoint_permille) {
  CanTiming best;
  std::uint32_t best_miss = kSamplePointMiss_permille + 1;
  if (bit_rate == 0) return best;
  for (std::uint32_t quanta = kQuantaMax; quanta >= kQuantaMin; --quanta) {
    const std::uint64_t per_quantum = std::uint64_t{bit_rate} * quanta;
    if (clock_hz % per_quantum != 0) continue;
    const std::uint64_t prescaler = clock_hz / per_quantum;
    if (prescaler == 0 || prescaler > limits.prescaler_max) continue;
    const std::uint32_t before = (quanta * sample_point_permille + 500) / 1000;  // synchronisation and segment 1
    if (before < 1U + limits.segment1_min || before > 1U + limits.segment1_max || before >= quanta) continue;
    const std::uint32_t after = quanta - before;
    if (after < limits.segment2_min || after > limits.segment2_max) continue;
    const std::uint32_t point = before * 1000 / quanta;
    const std::uint32_t miss = point > sample_point_permille ? point - sample_point_permille
                                                             : sample_point_permille - point;
    if (miss >= best_miss) continue;
    best_miss = miss;
    const std::uint32_t jump = after < limits.jump_max ? after : limits.jump_max;
    best = {static_cast<std::uint16_t>(prescaler), static_cast<std::uint16_t>(before - 1),
            static_cast<std::uint16_t>(after), static_cast<std::uint16_t>(jump)};
  }
  return best;
}

}  // namespace voltlap::port::stm32
