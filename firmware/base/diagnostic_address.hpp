// SPDX-License-Identifier: Apache-2.0
// Identifiers of diagnosis: "normal fixed addressing" of ISO 15765-2, 29 bits, 0x18DA TTSS: target and source. They are
// the standard's and lie beside all of the car's messages.
#pragma once
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap {

inline constexpr std::uint8_t kTesterAddress = 0xF1;  ///< ISO 15765-4: of the tester outside of the car
inline constexpr std::uint8_t kBmsAddress = 0xB0;
inline constexpr std::uint8_t kMasterAddress = 0xB1;

[[nodiscard]] constexpr std::uint32_t diagnostic_id(std::uint8_t target, std::uint8_t source) {
  return Frame::kExtendedFlag | 0x18DA'0000U | std::uint32_t{target} << 8 | source;
}

}  // namespace voltlap
