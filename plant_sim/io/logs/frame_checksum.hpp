// SPDX-License-Identifier: Apache-2.0
// Byte 7 of a frame as a check of the others.
#pragma once
#include "io/logs/recorded_frame.hpp"
#include "io/logs/role_source.hpp"

namespace voltlap::plant {

/// Whether it holds; without a rule it always does, and never for a frame that has not 8 bytes.
///   kOrion: (identifier + 8 + bytes 0 to 6) mod 256
///   kSum:   (bytes 0 to 6) mod 256
///   kCrc8:  SAE J1850 over two bytes of the identifier, high byte first, and bytes 0 to 6 (can_dbc/car.dbc)
[[nodiscard]] bool checksum_holds(FrameChecksum rule, const RecordedFrame& frame);

}  // namespace voltlap::plant
