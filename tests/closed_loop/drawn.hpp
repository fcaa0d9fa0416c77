// SPDX-License-Identifier: Apache-2.0
// What drawn tests of this folder share: the seed that repeats a draw, and plain draws.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <random>

#include "base/can_frame.hpp"
#include "can_dbc/tables.hpp"

namespace voltlap::plant::test {

/// VOLTLAP_TEST_SEED, or another one each time; a test prints it where it fails.
inline std::uint64_t drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
}

class Drawn {
 public:
  explicit Drawn(std::uint64_t seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  int whole(int low, int high) { return std::uniform_int_distribution(low, high)(random_); }
  bool chance(double share) { return between(0.0, 1.0) < share; }

 private:
  std::mt19937_64 random_;
};

/// Loses a share of all frames at each of their two receivers. Of a message that comes ten times a second at most four
/// in a row: five, the 500 ms of BMS-014, are lost by chance once in a hundred hours at 5 %.
class RandomLoss {
 public:
  RandomLoss(std::uint64_t seed, double share) : random_(seed), share_(share) {}
  bool operator()(const Frame& frame) {
    Receivers& at = heard_[frame.id];
    int& gap = at.gap[at.asked++ % 2];
    const bool kept = uniform_(random_) >= share_ || (gap == kSlowInARow && is_slow(frame.id));
    gap = kept ? 0 : gap + 1;
    return !kept;
  }

 private:
  struct Receivers {
    std::size_t asked = 0;
    int gap[2] = {};
  };

  static constexpr int kSlowInARow = 4;

  static bool is_slow(std::uint32_t id) {
    for (const can::MessageRow& row : can::kMessages) {
      if (row.id == id) return row.cycle_ms >= 100;
    }
    return false;
  }

  std::mt19937_64 random_;
  std::uniform_real_distribution<double> uniform_{0.0, 1.0};
  double share_;
  std::map<std::uint32_t, Receivers> heard_;
};

}  // namespace voltlap::plant::test
