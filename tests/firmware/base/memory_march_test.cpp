// SPDX-License-Identifier: Apache-2.0
#include "base/memory_march.hpp"

#include <functional>
#include <vector>

#include "CppUTest/TestHarness.h"

using namespace voltlap;

namespace {

/// Memory with a fault: what a write makes of the words, and what a read sees.
struct Faulty {
  explicit Faulty(std::size_t count) : word(count) {
    for (std::size_t i = 0; i < count; ++i) word[i] = static_cast<std::uint32_t>(0x9E37'79B9U * (i + 1));
  }
  std::vector<std::uint32_t> word;
  std::function<void(std::size_t, std::uint32_t, std::uint32_t)> after_write = [](auto, auto, auto) {};
  std::function<std::size_t(std::size_t)> address = [](std::size_t i) { return i; };

  [[nodiscard]] std::uint32_t read(std::size_t i) const { return word[address(i)]; }
  void write(std::size_t i, std::uint32_t value) {
    const std::uint32_t before = word[address(i)];
    word[address(i)] = value;
    after_write(address(i), before, value);
  }
};

constexpr std::size_t kWords = 100;

}  // namespace

TEST_GROUP(MemoryMarch){};

// BMS-090
TEST(MemoryMarch, GoodMemoryPassesAndKeepsItsContent) {
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{31}, std::size_t{32}, kWords}) {
    Faulty memory(kWords);
    const std::vector<std::uint32_t> before = memory.word;
    CHECK(march_keeping(memory, count));
    CHECK(before == memory.word);
  }
}

// BMS-090
TEST(MemoryMarch, WordsAtAnAddressAreMarchedAndKept) {
  volatile std::uint32_t memory[40] = {};
  for (std::uint32_t i = 0; i < 40; ++i) memory[i] = 0x9E37'79B9U * i;
  MemoryWords words(memory + 4);
  CHECK(march_keeping(words, 32));
  for (std::uint32_t i = 0; i < 40; ++i) LONGS_EQUAL(0x9E37'79B9U * i, memory[i]);
  words.write(3, 77U);
  LONGS_EQUAL(77, memory[7]);
}

TEST(MemoryMarch, EveryBitThatStaysAtOneLevelIsFound) {
  for (std::size_t bad = 0; bad < kWords; bad += 3) {
    for (int bit = 0; bit < 32; ++bit) {
      for (const bool level : {false, true}) {
        Faulty memory(kWords);
        const std::uint32_t mask = 1U << bit;
        memory.after_write = [&](std::size_t i, std::uint32_t, std::uint32_t) {
          if (i == bad) memory.word[i] = level ? memory.word[i] | mask : memory.word[i] & ~mask;
        };
        CHECK(!march_keeping(memory, kWords));
      }
    }
  }
}

TEST(MemoryMarch, ABitThatCannotRiseOrCannotFallIsFound) {
  for (const bool rise : {false, true}) {
    Faulty memory(kWords);
    memory.after_write = [&](std::size_t i, std::uint32_t before, std::uint32_t value) {
      const std::uint32_t bit = 1U << 7;
      if (i == 40 && ((before & bit) == 0) == rise && ((value & bit) != 0) == rise) memory.word[i] = value ^ bit;
    };
    CHECK(!march_keeping(memory, kWords));
  }
}

/// One cell's change flips, or sets the level of, another's: within a block and across the border of two.
TEST(MemoryMarch, ACellThatDisturbsAnotherWithinHalfABlockIsFound) {
  int found = 0, all = 0;
  for (std::size_t from = 20; from < 50; ++from) {
    for (std::size_t to = 20; to < 50; ++to) {
      const std::size_t apart = from < to ? to - from : from - to;
      if (apart == 0 || apart > kMarchBlock / 2) continue;
      for (const bool rising : {false, true}) {
        Faulty memory(kWords);
        memory.after_write = [&](std::size_t i, std::uint32_t before, std::uint32_t value) {
          const bool rises = (before & 1U) == 0 && (value & 1U) != 0, falls = (before & 1U) != 0 && (value & 1U) == 0;
          if (i == from && (rising ? rises : falls)) memory.word[to] ^= 1U;
        };
        ++all;
        if (!march_keeping(memory, kWords)) ++found;
      }
    }
  }
  LONGS_EQUAL(all, found);
}

TEST(MemoryMarch, TwoAddressesThatAreOneWordAreFound) {
  for (const std::size_t line : {1U, 2U, 4U, 8U}) {
    Faulty memory(kWords);
    memory.address = [line](std::size_t i) { return i & ~line; };  // an address line that is stuck
    CHECK(!march_keeping(memory, kWords));
  }
}
