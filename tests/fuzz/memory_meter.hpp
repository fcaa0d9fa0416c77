// SPDX-License-Identifier: Apache-2.0
// The most memory that malloc had given at one time since the meter was made, beyond what it had before. One meter at a
// time. How it is told stands in memory_meter.cpp, and for the address sanitizer in memory_meter_sanitized.cpp.
#pragma once
#include <cstddef>

namespace voltlap::plant {

class MemoryMeter {
 public:
  MemoryMeter();
  [[nodiscard]] std::size_t most() const;
};

}  // namespace voltlap::plant
