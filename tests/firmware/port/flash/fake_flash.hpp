// SPDX-License-Identifier: Apache-2.0
// Flash at the seam: bits fall when a unit is programmed and rise when an area is erased; the supply may be lost at any
// byte of any operation. Units that a loss left half done read as the draw has it.
#pragma once
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "firmware/port/stm32/fake_registers.hpp"
#include "port/flash/flash.hpp"

namespace voltlap::port::test {

/// How the operation that is cut off leaves its unit.
enum class Cut : int {
  kBefore = 0,  ///< nothing of it was done, but for cells that read as blank and are not
  k1Byte,
  kHalf,
  kAllButLast,
  kDrawn,  ///< any of its bits
  kAfter,  ///< done, but nobody was told
};
inline constexpr int kCuts = 6;

class FakeFlash final : public Flash {
 public:
  FakeFlash(std::size_t unit, std::size_t area_bytes, bool ecc) : unit_(unit), bytes_(area_bytes), ecc_(ecc) {
    for (auto& area : area_) area.assign(area_bytes, kFlashBlank);
    for (auto& state : state_) state.assign(area_bytes / unit, State::kErased);
  }

  std::uint64_t operations = 0;            ///< programmed units and erased areas
  std::uint64_t erasures = 0;
  std::uint64_t cut_at = UINT64_MAX;       ///< the operation of this number is cut off
  Cut cut = Cut::kBefore;
  std::mt19937_64* draw = nullptr;
  std::uint64_t fail_every = 0;            ///< each n-th programming reports an error
  bool programmed_twice = false;           ///< somebody wrote over a unit, or one that a cut left doubtful
  bool dead = false;                       ///< nothing is programmed or erased any more

  [[nodiscard]] std::size_t unit() const override { return unit_; }
  [[nodiscard]] std::size_t area_bytes() const override { return bytes_; }

  bool erase(std::size_t area) override {
    if (dead) return false;
    ++erasures;
    const bool lost = operations++ == cut_at;
    for (std::size_t u = 0; u < state_[area].size(); ++u) {
      if (lost && cut == Cut::kBefore) break;
      if (lost && cut != Cut::kAfter && !partly(u, state_[area].size())) {
        for (std::size_t i = 0; i < unit_; ++i) area_[area][u * unit_ + i] |= static_cast<std::uint8_t>((*draw)());
        state_[area][u] = State::kDoubtful;
        continue;
      }
      for (std::size_t i = 0; i < unit_; ++i) area_[area][u * unit_ + i] = kFlashBlank;
      state_[area][u] = State::kErased;
    }
    if (lost) throw stm32::test::PowerLost{};
    return true;
  }

  bool program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) override {
    if (dead) return false;
    State& state = state_[area][offset / unit_];
    bool zeros = true;  // RM0440 3.3.7: zeros may be programmed over anything
    for (std::size_t i = 0; i < unit_; ++i) zeros = zeros && unit_bytes[i] == 0;
    if (state != State::kErased && !zeros) programmed_twice = true;
    const bool lost = operations++ == cut_at;
    state = lost && cut != Cut::kAfter ? State::kDoubtful : State::kWritten;
    for (std::size_t i = 0; i < unit_; ++i) {
      std::uint8_t& cell = area_[area][offset + i];
      std::uint8_t value = unit_bytes[i];
      if (lost && cut != Cut::kAfter && i >= whole_bytes()) {
        value = cut == Cut::kDrawn ? static_cast<std::uint8_t>(value | (*draw)()) : kFlashBlank;
      }
      cell = static_cast<std::uint8_t>(cell & value);
    }
    if (lost) throw stm32::test::PowerLost{};
    if (fail_every != 0 && operations % fail_every == 0) {
      area_[area][offset] = 0;
      return false;
    }
    return true;
  }

  bool read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) override {
    bool good = true;
    std::memcpy(bytes, area_[area].data() + offset, count);
    for (std::size_t i = 0; ecc_ && i < count; ++i) {
      good = good && !(state_[area][(offset + i) / unit_] == State::kDoubtful && bytes[i] != kFlashBlank);
    }
    return good;
  }

  void spoil(std::size_t area, std::size_t offset, std::uint8_t value) { area_[area][offset] = value; }

 private:
  enum class State : std::uint8_t { kErased, kWritten, kDoubtful };

  [[nodiscard]] std::size_t whole_bytes() const {
    switch (cut) {
      case Cut::k1Byte: return 1;
      case Cut::kHalf: return unit_ / 2;
      case Cut::kAllButLast: return unit_ - 1;
      default: return 0;
    }
  }
  [[nodiscard]] bool partly(std::size_t u, std::size_t all) const {
    return u * unit_ < all * whole_bytes() || (cut == Cut::kDrawn && (*draw)() % 2 == 0);
  }

  std::size_t unit_;
  std::size_t bytes_;
  bool ecc_;
  std::vector<std::uint8_t> area_[kFlashAreas];
  std::vector<State> state_[kFlashAreas];
};

}  // namespace voltlap::port::test
