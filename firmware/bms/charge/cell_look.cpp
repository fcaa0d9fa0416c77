// SPDX-License-Identifier: Apache-2.0
#include "bms/charge/cell_look.hpp"

#include "base/require.hpp"

namespace voltlap::bms {
namespace {

constexpr std::int32_t kMeanOf = 8;    // samples, 0.25 to 0.8 s: a noise of 1.5 mV leaves 0.4 mV
constexpr std::uint8_t kSamples = 32;  // a channel's noise of 1.5 mV leaves 0.3 mV; 3.2 s at the slowest cycle
constexpr CellVoltage kRelaxes = CellVoltage::from_raw(100);  // 10 mV; chosen, more than a charge ever left here
// Longer than command to the shunt, filter of the channel and way of its reading, each 100 ms at most.
constexpr Duration kSettling = Duration::from_ms(500);

void finish(const Config& config, CellLook& look) {
  look.lowest = look.highest = CellVoltage::from_raw(look.sum[0] / kSamples);
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    look.cell[i] = CellVoltage::from_raw(look.sum[i] / kSamples);
    look.lowest = min(look.lowest, look.cell[i]);
    look.highest = max(look.highest, look.cell[i]);
  }
  look.known = true;
}

}  // namespace

// BMS-055
void mark_bled_cells(const Config& config, Instant now, State& state) {
  Measured& m = state.measured;
  if (state.cells_bled == 0 && !m.some_bled) return;
  if (state.cells_bled > 0) state.look.bled = now;
  const bool settled = now - state.look.bled >= kSettling;
  m.some_bled = !settled;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) m.bled[i] = !settled && (m.bled[i] || state.balancing[i]);
}

void follow_highest(const Config& config, bool begin, State& state) {
  CellLook& look = state.look;
  const Measured& m = state.measured;
  if (begin) {
    for (std::uint16_t i = 0; i < config.cells_in_series; ++i) look.mean[i] = m.cell[i].value.raw() * 256;
  }
  for_each_arrived(config, m, [&](std::size_t i) {
    if (m.cell[i].good() && !m.bled[i]) look.mean[i] += (m.cell[i].value.raw() * 256 - look.mean[i]) / kMeanOf;
  });
  look.highest_now = CellVoltage{};
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    look.highest_now = max(look.highest_now, CellVoltage::from_raw(look.mean[i] / 256));
  }
}

// BMS-057
void set_floor(CellLook& look) { look.floor = look.lowest - kRelaxes; }

std::uint8_t farthest_cell(const Config& config, const CellLook& look) {
  std::int64_t sum = 0;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) sum += look.cell[i].raw();
  const auto mean = static_cast<std::int32_t>(sum / config.cells_in_series);
  std::int32_t most = -1;
  std::uint8_t farthest = kNoCell;
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    const std::int32_t off = look.cell[i].raw() - mean, size = off < 0 ? -off : off;
    if (size <= most) continue;
    most = size;
    farthest = static_cast<std::uint8_t>(i);
  }
  return farthest;
}

void begin_look(CellLook& look) {
  for (std::uint8_t& samples : look.samples) samples = 0;
  for (std::int32_t& sum : look.sum) sum = 0;
}

bool take_look(const Config& config, State& state) {
  VOLTLAP_REQUIRE(config.cells_in_series > 0 && config.cells_in_series <= kMaxCells);
  CellLook& look = state.look;
  for_each_arrived(config, state.measured, [&](std::size_t i) {
    if (!state.measured.cell[i].good() || state.measured.bled[i] || look.samples[i] >= kSamples) return;
    look.sum[i] += state.measured.cell[i].value.raw();
    ++look.samples[i];
  });
  for (std::uint16_t i = 0; i < config.cells_in_series; ++i) {
    if (look.samples[i] < kSamples) return false;
  }
  finish(config, look);
  return true;
}

}  // namespace voltlap::bms
