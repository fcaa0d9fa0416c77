// SPDX-License-Identifier: Apache-2.0
// Frames as lines of text: candump -l, and SLCAN with its stamp of 16 bits.
#pragma once
#include <string>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

/// (1436509052.249713) vcan0 044#2A36, FD 044##02A36; with the end of the line. Appended to `out`.
void append_candump(const RecordedFrame& frame, const std::string& bus, std::string& out);

/// t6B380050000551178EE0071F, with CR as the adapters have it. CAN FD by d and D, with the
/// data sent faster b and B.
void append_slcan(const RecordedFrame& frame, double origin_s, std::string& out);

}  // namespace voltlap::plant
