// SPDX-License-Identifier: Apache-2.0
// Random numbers of a run: fast, and the same on every machine (splitmix64, Steele, Lea and Flood 2014).
#pragma once
#include <cstddef>
#include <cstdint>

namespace same_firmware {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : state_(seed) {}

  [[nodiscard]] std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15U);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
  }
  /// 0 to count - 1.
  [[nodiscard]] std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }
  [[nodiscard]] std::int32_t between(std::int32_t low, std::int32_t high) {
    return low + static_cast<std::int32_t>(below(static_cast<std::size_t>(std::int64_t{high} - low) + 1));
  }
  [[nodiscard]] double share() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  [[nodiscard]] bool chance(double probability) { return share() < probability; }
  /// 1 to `most`, small ones as likely as large ones.
  [[nodiscard]] std::int32_t duration(std::int32_t most) {
    std::int32_t top = most;
    while (top > 1 && chance(0.3)) top /= 2;
    return between(1, top);
  }
  template <class T, std::size_t N>
  [[nodiscard]] T of(const T (&choices)[N]) {
    return choices[below(N)];
  }

 private:
  std::uint64_t state_;
};

}  // namespace same_firmware
