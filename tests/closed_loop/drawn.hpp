// SPDX-License-Identifier: Apache-2.0
// What drawn tests of this folder share: the seed that repeats a draw, and plain draws.
#pragma once
#include <cstdint>
#include <cstdlib>
#include <random>

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

}  // namespace voltlap::plant::test
