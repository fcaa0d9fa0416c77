// SPDX-License-Identifier: Apache-2.0
// The low-speed internal oscillator, which counts for the watchdog and is the second one of a part.
#pragma once
#include <cstdint>

namespace voltlap::port::stm32 {

/// The range of the oscillator by the datasheet.
struct LsiRange {
  std::uint32_t slowest_hz;
  std::uint32_t fastest_hz;
};
inline constexpr LsiRange kLsiStm32f4{17'000, 47'000};  // DS8626, "LSI oscillator characteristics"
inline constexpr LsiRange kLsiStm32g4{29'500, 34'000};  // DS12288, the same, over temperature and supply

}  // namespace voltlap::port::stm32
