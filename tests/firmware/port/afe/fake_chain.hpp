// SPDX-License-Identifier: Apache-2.0
// A chain of LTC6811-1 as the datasheet describes it: bytes in, bytes out, PEC both ways, wires that are off, chips
// that do not answer or start anew. A conversion is ready when the next exchange after a wake comes, not before.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <vector>

#include "port/afe/spi.hpp"

namespace voltlap::port::afe::test {

class FakeChain final : public Spi {
 public:
  struct Chip {
    std::uint16_t cell[12] = {};   ///< [100 uV] true
    std::uint16_t input[5] = {};   ///< [100 uV] at G1 to G5
    std::uint16_t reference = 30'000;
    std::set<int> wires_off;       ///< pins C0 to C12
    int cells = 12;
    bool answers = true;
    bool reference_on = false;
    std::uint8_t settings[6] = {};
    std::uint16_t seen_cell[12], seen_input[6];
    Chip() { start(); }
    void start() {
      for (auto& s : settings) s = 0;
      for (auto& v : seen_cell) v = 0xFFFF;
      for (auto& v : seen_input) v = 0xFFFF;
    }
    [[nodiscard]] std::uint16_t shunts() const {
      return static_cast<std::uint16_t>(settings[4] | (settings[5] & 0xF) << 8);
    }
  };

  explicit FakeChain(std::size_t chips) : chip(chips) {}
  std::vector<Chip> chip;
  std::function<void(std::vector<std::uint8_t>&)> disturb = [](auto&) {};  ///< bytes on their way to the controller
  bool awake = false;
  std::uint32_t exchanges = 0, bytes = 0, refused = 0;

  void wake(std::uint32_t us) override {
    awake = us >= 10;
    if (pending_) pending_();
    pending_ = nullptr;
  }
  void exchange(const std::uint8_t* out, std::size_t out_count, std::uint8_t* in, std::size_t in_count) override {
    ++exchanges;
    bytes += static_cast<std::uint32_t>(out_count + in_count);
    std::vector<std::uint8_t> answer(in_count, 0xFF);
    const bool good = awake && out_count >= 4 && get16(out + 2) == crc(out, 2);
    if (!good) ++refused;
    if (good) run(get16(out), out + 4, out_count - 4, answer);
    disturb(answer);
    for (std::size_t i = 0; i < in_count; ++i) in[i] = answer[i];
  }

  /// Independent of the driver's: the datasheet's description bit by bit.
  static std::uint16_t crc(const std::uint8_t* data, std::size_t count) {
    bool r[15] = {};
    r[4] = true;  // 000000000010000
    for (std::size_t i = 0; i < count; ++i) {
      for (int bit = 7; bit >= 0; --bit) {
        const bool in0 = ((data[i] >> bit & 1) != 0) != r[14];
        const bool in[15] = {in0, r[0], r[1], r[2] != in0, r[3] != in0, r[4], r[5], r[6] != in0, r[7] != in0, r[8],
                             r[9] != in0, r[10], r[11], r[12], r[13] != in0};
        for (int k = 0; k < 15; ++k) r[k] = in[k];
      }
    }
    std::uint16_t out = 0;
    for (int k = 0; k < 15; ++k) out = static_cast<std::uint16_t>(out | (r[k] ? 1 : 0) << (k + 1));
    return out;
  }

 private:
  static std::uint16_t get16(const std::uint8_t* at) { return static_cast<std::uint16_t>(at[0] << 8 | at[1]); }

  /// What a cell reads: pull is +1 with the pull-up of ADOW, -1 with its pull-down, 0 in a measurement.
  static std::uint16_t reads(const Chip& c, int i, int pull) {
    const bool low_off = c.wires_off.count(i) != 0, high_off = c.wires_off.count(i + 1) != 0;
    if (!low_off && !high_off) return c.cell[i];
    if (pull == 0) return static_cast<std::uint16_t>(c.cell[i] / 2 + 3'000);  // floats
    const bool widened = (high_off && pull > 0) || (low_off && pull < 0);
    const int other = high_off ? i + 1 : i - 1;
    if (!widened) return 0;
    return static_cast<std::uint16_t>(c.cell[i] + (other >= 0 && other < c.cells ? c.cell[other] / 4 : 0));
  }
  void convert_cells(int pull) {
    pending_ = [this, pull] {
      for (Chip& c : chip) {
        for (int i = 0; i < 12; ++i) c.seen_cell[i] = i < c.cells ? reads(c, i, pull) : std::uint16_t{0};
      }
    };
  }
  void convert_inputs() {
    pending_ = [this] {
      for (Chip& c : chip) {
        const bool on = (c.settings[0] & 4) != 0;
        for (int i = 0; i < 5; ++i) c.seen_input[i] = on && (c.settings[0] >> (3 + i) & 1) != 0 ? c.input[i] : 0;
        c.seen_input[5] = on ? c.reference : 0;
      }
    };
  }

  void run(std::uint16_t code, const std::uint8_t* data, std::size_t count, std::vector<std::uint8_t>& answer) {
    if (code == 0x711 || code == 0x712) {
      for (Chip& c : chip) {
        for (auto& v : c.seen_cell) v = code == 0x711 ? std::uint16_t{0xFFFF} : v;
        for (auto& v : c.seen_input) v = code == 0x712 ? std::uint16_t{0xFFFF} : v;
      }
    } else if (code == 0x001) {
      write(data, count);
    } else if ((code & 0x668) == 0x260) {
      convert_cells(0);
    } else if ((code & 0x628) == 0x228) {
      convert_cells((code & 0x40) != 0 ? 1 : -1);
    } else if ((code & 0x678) == 0x460) {
      convert_inputs();
    } else {
      answer_of(code, answer);
    }
  }
  void write(const std::uint8_t* data, std::size_t count) {
    for (std::size_t k = 0; k < chip.size() && 8 * (k + 1) <= count; ++k) {
      Chip& c = chip[chip.size() - 1 - k];
      if (!c.answers || get16(data + 8 * k + 6) != crc(data + 8 * k, 6)) continue;
      for (std::size_t i = 0; i < 6; ++i) c.settings[i] = data[8 * k + i];
    }
  }
  void answer_of(std::uint16_t code, std::vector<std::uint8_t>& answer) {
    for (std::size_t k = 0; k < chip.size() && 8 * (k + 1) <= answer.size(); ++k) {
      const Chip& c = chip[k];
      if (!c.answers) return;  // nor is anything heard from behind it
      std::uint8_t* const to = answer.data() + 8 * k;
      for (std::size_t i = 0; i < 3; ++i) {
        std::uint16_t word = 0;
        if (code >= 0x004 && code <= 0x00A) word = c.seen_cell[(code - 4) / 2 * 3 + i];
        if (code == 0x00C || code == 0x00E) word = c.seen_input[(code - 0xC) / 2 * 3 + i];
        if (code == 0x002) word = static_cast<std::uint16_t>(c.settings[2 * i] | c.settings[2 * i + 1] << 8);
        to[2 * i] = static_cast<std::uint8_t>(word);
        to[2 * i + 1] = static_cast<std::uint8_t>(word >> 8);
      }
      const std::uint16_t pec = crc(to, 6);
      to[6] = static_cast<std::uint8_t>(pec >> 8);
      to[7] = static_cast<std::uint8_t>(pec);
    }
  }

  std::function<void()> pending_;
};

}  // namespace voltlap::port::afe::test
