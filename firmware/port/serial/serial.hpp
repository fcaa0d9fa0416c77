// SPDX-License-Identifier: Apache-2.0
// The seam to a serial line: bytes in, bytes out.
#pragma once
#include <cstdint>

namespace voltlap::port {

class Serial {
 public:
  /// A byte that has come; false when there is none. Never waits.
  virtual bool read(std::uint8_t& byte) = 0;
  /// Waits for room.
  virtual void write(std::uint8_t byte) = 0;

 protected:
  ~Serial() = default;
};

}  // namespace voltlap::port
