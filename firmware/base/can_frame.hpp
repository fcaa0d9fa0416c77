// SPDX-License-Identifier: Apache-2.0
// A classic CAN frame as every node, port and log of the project sees it.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap {

/// One CAN 2.0 data frame. `id` carries the identifier; bit 31 set means a 29-bit identifier.
/// Bytes beyond `dlc` are zero, so that two equal frames compare equal byte for byte.
struct Frame {
  static constexpr std::uint32_t kExtendedFlag = 0x80000000U;
  static constexpr std::size_t kMaxBytes = 8;

  std::uint32_t id = 0;
  std::uint8_t dlc = 0;
  std::uint8_t data[kMaxBytes] = {};

  friend constexpr bool operator==(const Frame& a, const Frame& b) {
    for (std::size_t i = 0; i < kMaxBytes; ++i) {
      if (a.data[i] != b.data[i]) return false;
    }
    return a.id == b.id && a.dlc == b.dlc;
  }
  friend constexpr bool operator!=(const Frame& a, const Frame& b) { return !(a == b); }
};

/// Frames that a node wants to send in one step, in order of sending. Bounded; `push` says whether there was room.
class TxQueue {
 public:
  static constexpr std::size_t kCapacity = 24;

  [[nodiscard]] bool push(const Frame& frame) {
    if (count_ >= kCapacity) return false;
    frames_[count_++] = frame;
    return true;
  }
  void clear() { count_ = 0; }
  [[nodiscard]] std::size_t size() const { return count_; }
  [[nodiscard]] const Frame& operator[](std::size_t i) const { return frames_[i]; }
  [[nodiscard]] const Frame* begin() const { return frames_; }
  [[nodiscard]] const Frame* end() const { return frames_ + count_; }

 private:
  Frame frames_[kCapacity] = {};
  std::size_t count_ = 0;
};

/// Frames handed to a node in one step, in order of arrival. A view: the caller owns the memory.
struct FrameView {
  const Frame* first = nullptr;
  std::size_t count = 0;
  [[nodiscard]] const Frame* begin() const { return first; }
  [[nodiscard]] const Frame* end() const { return first + count; }
};

}  // namespace voltlap
