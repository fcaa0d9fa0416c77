// SPDX-License-Identifier: Apache-2.0
// One seed, many independent random streams: what one part of a campaign draws never shifts what another draws.
#pragma once
#include <cstdint>

namespace voltlap::plant {

enum class BenchStream : std::uint64_t { kCells, kInstruments, kInitialSoc, kNoise };

/// Seed of a stream; `index` numbers the tests. Mixer: SplitMix64 (Steele, Lea, Flood, 2014).
[[nodiscard]] inline std::uint64_t stream_seed(std::uint64_t seed, BenchStream stream, std::uint64_t index = 0) {
  std::uint64_t z = seed;
  for (const std::uint64_t word : {static_cast<std::uint64_t>(stream), index}) {
    z = (z ^ (word + 1)) + 0x9E3779B97F4A7C15U;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    z ^= z >> 31U;
  }
  return z;
}

}  // namespace voltlap::plant
