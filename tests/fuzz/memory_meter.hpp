// SPDX-License-Identifier: Apache-2.0
// The most memory that was allocated at one time since the meter was made, beyond what was before. Under the address
// sanitizer all of malloc counts (memory_meter_sanitized.cpp), else what `new` gave (memory_meter.cpp). One at a time.
#pragma once
#include <cstddef>

namespace voltlap::plant {

class MemoryMeter {
 public:
  MemoryMeter();
  [[nodiscard]] std::size_t most() const;
};

}  // namespace voltlap::plant
