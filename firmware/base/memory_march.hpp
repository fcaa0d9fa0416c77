// SPDX-License-Identifier: Apache-2.0
// A march through memory that keeps its content: March C- (van de Goor, "Testing Semiconductor Memories", 1991) over
// a block whose words are put aside, for a ground of zeros and one of 0x55555555. It finds, inside a block: bits that
// stay at one level, that cannot change, that change or follow another word's bit, and two addresses that are one
// word. The blocks overlap by half, so that neighbours across a border are neighbours in the next one.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap {

inline constexpr std::size_t kMarchBlock = 32;  ///< words

/// Words at an address. Nothing else may use them meanwhile: no interrupt, and not the stack of the march itself.
class MemoryWords {
 public:
  explicit MemoryWords(volatile std::uint32_t* first) : first_(first) {}
  [[nodiscard]] std::uint32_t read(std::size_t i) const { return first_[i]; }
  void write(std::size_t i, std::uint32_t value) { first_[i] = value; }

 private:
  volatile std::uint32_t* first_;
};

namespace march {

/// Every word reads as `expected` and becomes `next`, upwards or downwards.
template <class Words>
bool element(Words& words, std::size_t first, std::size_t count, std::uint32_t expected, std::uint32_t next, bool up) {
  bool good = true;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = first + (up ? k : count - 1 - k);
    if (words.read(i) != expected) good = false;
    words.write(i, next);
  }
  return good;
}

template <class Words>
bool block(Words& words, std::size_t first, std::size_t count) {
  std::uint32_t kept[kMarchBlock];
  for (std::size_t i = 0; i < count; ++i) kept[i] = words.read(first + i);
  bool good = true;
  const std::uint32_t grounds[] = {0x0000'0000U, 0x5555'5555U};
  for (const std::uint32_t ground : grounds) {
    const std::uint32_t other = ~ground;
    for (std::size_t i = 0; i < count; ++i) words.write(first + i, ground);
    good = element(words, first, count, ground, other, true) && good;
    good = element(words, first, count, other, ground, true) && good;
    good = element(words, first, count, ground, other, false) && good;
    good = element(words, first, count, other, ground, false) && good;
    good = element(words, first, count, ground, ground, true) && good;
  }
  for (std::size_t i = 0; i < count; ++i) {
    words.write(first + i, kept[i]);
    good = words.read(first + i) == kept[i] && good;
  }
  return good;
}

}  // namespace march

/// False when some word of the first `count` is bad. 44 accesses a word of either block.
template <class Words>
[[nodiscard]] bool march_keeping(Words& words, std::size_t count) {
  bool good = true;
  for (std::size_t first = 0; first < count; first += kMarchBlock / 2) {
    const std::size_t left = count - first;
    good = march::block(words, first, left < kMarchBlock ? left : kMarchBlock) && good;
  }
  return good;
}

}  // namespace voltlap
