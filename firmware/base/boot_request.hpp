// SPDX-License-Identifier: Apache-2.0
// How a node asks the boot loader behind its reset to stay: two words in memory that no start-up clears, one the
// inverse of the other, so that what happens to stand there after power-on is no request.
#pragma once
#include <cstdint>

namespace voltlap {

class BootRequest {
 public:
  /// Before the reset.
  void ask() {
    word_ = kStay;
    inverse_ = ~kStay;
  }
  /// In the boot loader, once: true when it is to stay. The request is gone then.
  [[nodiscard]] bool take() {
    const bool asked = word_ == kStay && inverse_ == ~kStay;
    word_ = 0;
    inverse_ = 0;
    return asked;
  }

 private:
  static constexpr std::uint32_t kStay = 0x7B00'710DU;
  volatile std::uint32_t word_;
  volatile std::uint32_t inverse_;
};
static_assert(sizeof(BootRequest) == 8, "boot loaders of others read it");

}  // namespace voltlap
