// SPDX-License-Identifier: Apache-2.0
#include "port/afe/ltc6811.hpp"

#include "can_dbc/tables.hpp"
#include "port/afe/pec15.hpp"

namespace voltlap::port::afe {
namespace {

// Datasheet, "Command codes"; MD = 10 (normal, 7 kHz), DCP = 0 (no bleeding while a cell is measured), all channels.
constexpr std::uint16_t kWriteSettings = 0x001, kReadSettings = 0x002;
constexpr std::uint16_t kReadCells[] = {0x004, 0x006, 0x008, 0x00A};
constexpr std::uint16_t kReadInputs[] = {0x00C, 0x00E};
constexpr std::uint16_t kMeasureCells = 0x260 | 2U << 7, kMeasureInputs = 0x460 | 2U << 7;
constexpr std::uint16_t kPullUp = 0x228 | 2U << 7 | 1U << 6, kPullDown = 0x228 | 2U << 7;
constexpr std::uint16_t kClearCells = 0x711, kClearInputs = 0x712;

constexpr std::uint32_t kWake_us = 400;                 // tWAKE of a chip, at most; each wakes the next
constexpr std::uint8_t kSettings0 = 0xF8U | 1U << 2;    // GPIO 1 to 5 are inputs, the reference stays on
constexpr std::uint32_t kRoundsPerWireCheck = 30;       // of 3 ticks: about once a second, and in the first
constexpr std::int32_t kWireOff_100uv = -4'000;         // "Open wire check": -400 mV between pull-up and pull-down
constexpr std::uint16_t kCleared = 0xFFFF;
constexpr std::size_t kReferenceWord = 5;               // of the inputs: G1 to G5, REF
constexpr std::uint32_t kReferenceMin = 29'000, kReferenceMax = 31'000;  // VREF2 is 3 V; 100 uV
constexpr std::uint32_t kBleedTicks = static_cast<std::uint32_t>(can::BalancingCommand::kTimeoutMs) / can::kTickMs;
constexpr std::size_t kCellsPerWord = 24;               // of BalancingCommand
constexpr std::size_t kPecBytes = 2;

void put16(std::uint8_t* at, std::uint16_t value) {
  at[0] = static_cast<std::uint8_t>(value >> 8);
  at[1] = static_cast<std::uint8_t>(value);
}
std::uint16_t get16(const std::uint8_t* at) { return static_cast<std::uint16_t>(at[0] << 8 | at[1]); }

}  // namespace

bool Ltc6811Chain::init() {
  std::size_t cells = 0, thermistors = 0;
  ready_ = config_.chips >= 1 && config_.chips <= kChipsMax && lawful(config_.thermistor);
  for (std::size_t i = 0; ready_ && i < config_.chips; ++i) {
    const Chip& chip = config_.chip[i];
    ready_ = chip.cells >= 1 && chip.cells <= kCellsPerChip && chip.thermistors <= kInputsPerChip;
    cells += chip.cells;
    thermistors += chip.thermistors;
  }
  ready_ = ready_ && cells <= can::CellVoltages::kGroups * can::CellVoltages::kPerFrame &&
           thermistors <= can::Temperatures::kGroups * can::Temperatures::kPerFrame;
  if (!ready_) return false;
  for (std::size_t i = 0; i < config_.chips; ++i) spi_.wake(kWake_us);
  write_settings();
  return true;
}

void Ltc6811Chain::command(std::uint16_t code) {
  std::uint8_t bytes[4];
  put16(bytes, code);
  put16(bytes + 2, pec15(bytes, 2));
  spi_.exchange(bytes, sizeof bytes, nullptr, 0);
}

/// The chip next to the controller answers first.
void Ltc6811Chain::read_group(std::uint16_t code, std::uint8_t (&bytes)[kChipsMax][kGroupBytes],
                              bool (&good)[kChipsMax]) {
  std::uint8_t out[4];
  put16(out, code);
  put16(out + 2, pec15(out, 2));
  std::uint8_t in[kChipsMax * (kGroupBytes + kPecBytes)];
  spi_.exchange(out, sizeof out, in, config_.chips * (kGroupBytes + kPecBytes));
  for (std::size_t chip = 0; chip < config_.chips; ++chip) {
    const std::uint8_t* const from = in + chip * (kGroupBytes + kPecBytes);
    for (std::size_t i = 0; i < kGroupBytes; ++i) bytes[chip][i] = from[i];
    good[chip] = get16(from + kGroupBytes) == pec15(from, kGroupBytes);
    if (!good[chip]) ++counts_.pec_errors;
  }
}

void Ltc6811Chain::read_words(const std::uint16_t* codes, std::size_t groups,
                              Reading (&out)[kChipsMax][kCellsPerChip]) {
  std::uint8_t bytes[kChipsMax][kGroupBytes];
  bool good[kChipsMax];
  for (std::size_t group = 0; group < groups; ++group) {
    read_group(codes[group], bytes, good);
    for (std::size_t chip = 0; chip < config_.chips; ++chip) {
      for (std::size_t i = 0; i < kWordsPerGroup; ++i) {
        const auto value = static_cast<std::uint16_t>(bytes[chip][2 * i] | bytes[chip][2 * i + 1] << 8);
        out[chip][group * kWordsPerGroup + i] = {value, good[chip] && value != kCleared};
      }
    }
  }
}

/// CFGR: GPIO and reference; no thresholds of the chip's own; the shunts; no time-out of theirs beyond the chip's
/// sleep.
void Ltc6811Chain::settings_of(std::size_t chip, std::uint8_t (&bytes)[kGroupBytes]) const {
  std::size_t first = 0;
  for (std::size_t i = 0; i < chip; ++i) first += config_.chip[i].cells;
  std::uint32_t shunts = 0;
  for (std::size_t i = 0; i < config_.chip[chip].cells; ++i) shunts |= (bled_[first + i] ? 1U : 0U) << i;
  bytes[0] = kSettings0;
  bytes[1] = bytes[2] = bytes[3] = 0;
  bytes[4] = static_cast<std::uint8_t>(shunts);
  bytes[5] = static_cast<std::uint8_t>(shunts >> 8 & 0xFU);
}

/// The last chip's settings go first: they are shifted through the others.
void Ltc6811Chain::write_settings() {
  std::uint8_t out[4 + kChipsMax * (kGroupBytes + kPecBytes)];
  put16(out, kWriteSettings);
  put16(out + 2, pec15(out, 2));
  std::size_t at = 4;
  for (std::size_t chip = config_.chips; chip-- > 0;) {
    std::uint8_t bytes[kGroupBytes];
    settings_of(chip, bytes);
    for (std::size_t i = 0; i < kGroupBytes; ++i) out[at + i] = bytes[i];
    put16(out + at + kGroupBytes, pec15(bytes, kGroupBytes));
    at += kGroupBytes + kPecBytes;
  }
  spi_.exchange(out, at, nullptr, 0);
}

/// A chip that has started anew has lost them; the next round writes them again.
void Ltc6811Chain::check_settings() {
  std::uint8_t bytes[kChipsMax][kGroupBytes];
  bool good[kChipsMax];
  read_group(kReadSettings, bytes, good);
  for (std::size_t chip = 0; chip < config_.chips; ++chip) {
    std::uint8_t told[kGroupBytes];
    settings_of(chip, told);
    bool same = (bytes[chip][0] & 1U << 2) != 0;
    for (std::size_t i = 4; i < kGroupBytes; ++i) same = same && bytes[chip][i] == told[i];
    if (good[chip] && !same) ++counts_.config_errors;
  }
}

void Ltc6811Chain::store_cells(const Reading (&read)[kChipsMax][kCellsPerChip]) {
  std::size_t cell = 0;
  for (std::size_t chip = 0; chip < config_.chips; ++chip) {
    for (std::size_t i = 0; i < config_.chip[chip].cells; ++i, ++cell) {
      const std::size_t group = cell / can::CellVoltages::kPerFrame, place = cell % can::CellVoltages::kPerFrame;
      // A wire that is off floats, and both cells that it belongs to read anything.
      const bool wired = (off_[chip] >> i & 3U) == 0;
      cells_[group].cell_100uv[place] = read[chip][i].value;
      cells_[group].cell_ok[place] = read[chip][i].good && wired;
      cells_new_[group] = true;
    }
  }
}

void Ltc6811Chain::store_inputs(const Reading (&read)[kChipsMax][kCellsPerChip]) {
  std::size_t sensor = 0;
  for (std::size_t chip = 0; chip < config_.chips; ++chip) {
    const Reading& reference = read[chip][kReferenceWord];
    const bool known = reference.good && kReferenceMin <= reference.value && reference.value <= kReferenceMax;
    for (std::size_t i = 0; i < config_.chip[chip].thermistors; ++i, ++sensor) {
      const std::size_t group = sensor / can::Temperatures::kPerFrame, place = sensor % can::Temperatures::kPerFrame;
      std::int32_t temperature = 0;
      const std::uint32_t share = known ? (std::uint32_t{read[chip][i].value} << 16) / reference.value : 0;
      const bool ok = known && read[chip][i].good && temperature_of(config_.thermistor, share, temperature);
      temperatures_[group].temperature_dc[place] = temperature;
      temperatures_[group].temperature_ok[place] = ok;
      temperatures_new_[group] = true;
    }
  }
}

/// Datasheet, "Open wire check". A chip whose readings are not good keeps its verdict.
void Ltc6811Chain::judge_wires(const Reading (&pulled_down)[kChipsMax][kCellsPerChip]) {
  for (std::size_t chip = 0; chip < config_.chips; ++chip) {
    const std::size_t cells = config_.chip[chip].cells;
    bool good = true;
    std::uint32_t off = 0;
    for (std::size_t i = 0; i < cells; ++i) {
      const Reading& up = pulled_up_[chip][i];
      const Reading& down = pulled_down[chip][i];
      good = good && up.good && down.good;
      const bool apart = std::int32_t{up.value} - down.value < kWireOff_100uv;
      if (i > 0 && apart) off |= 1U << i;  // pin C(i), between this cell and the one below
    }
    if (pulled_up_[chip][0].value == 0) off |= 1U;
    if (pulled_down[chip][cells - 1].value == 0) off |= 1U << cells;
    if (good) off_[chip] = static_cast<std::uint16_t>(off);
  }
}

void Ltc6811Chain::next_phase() {
  if (phase_ == Phase::kJudge) {
    phase_ = Phase::kCells;
    return;
  }
  if (phase_ == Phase::kShunts && rounds_to_check_ > 0) {
    --rounds_to_check_;
    phase_ = Phase::kCells;
    return;
  }
  if (phase_ == Phase::kShunts) rounds_to_check_ = kRoundsPerWireCheck;
  phase_ = static_cast<Phase>(static_cast<std::uint8_t>(phase_) + 1U);
}

void Ltc6811Chain::step() {
  if (!ready_) return;
  if (bleed_ticks_ > 0 && --bleed_ticks_ == 0) {
    for (bool& on : bled_) on = false;
    write_settings();
  }
  Reading read[kChipsMax][kCellsPerChip] = {};
  spi_.wake(kWake_us);  // the link sleeps after 4.3 ms of silence (tIDLE); chips that are awake take no notice
  switch (phase_) {
    case Phase::kCells:
      command(kClearCells);
      command(kMeasureCells);
      break;
    case Phase::kInputs:
      read_words(kReadCells, 4, read);
      store_cells(read);
      command(kClearInputs);
      command(kMeasureInputs);
      break;
    case Phase::kShunts:
      read_words(kReadInputs, 2, read);
      store_inputs(read);
      check_settings();
      write_settings();
      ++counts_.rounds;
      break;
    case Phase::kPullUp: command(kClearCells); command(kPullUp); break;
    case Phase::kPullUpAgain: command(kPullUp); break;
    case Phase::kPullDown:
      read_words(kReadCells, 4, pulled_up_);
      command(kClearCells);
      command(kPullDown);
      break;
    case Phase::kPullDownAgain: command(kPullDown); break;
    case Phase::kJudge:
      read_words(kReadCells, 4, read);
      judge_wires(read);
      break;
  }
  next_phase();
}

bool Ltc6811Chain::take(can::CellVoltages& out) {
  if (out.group >= can::CellVoltages::kGroups || !cells_new_[out.group]) return false;
  const std::uint8_t group = out.group;
  out = cells_[group];
  out.group = group;
  cells_new_[group] = false;
  return true;
}

bool Ltc6811Chain::take(can::Temperatures& out) {
  if (out.group >= can::Temperatures::kGroups || !temperatures_new_[out.group]) return false;
  const std::uint8_t group = out.group;
  out = temperatures_[group];
  out.group = group;
  temperatures_new_[group] = false;
  return true;
}

void Ltc6811Chain::bleed(const std::uint32_t* words, std::size_t count) {
  for (std::size_t i = 0; i < kChipsMax * kCellsPerChip; ++i) {
    const std::size_t word = i / kCellsPerWord;
    bled_[i] = word < count && (words[word] >> (i % kCellsPerWord) & 1U) != 0;
  }
  bleed_ticks_ = kBleedTicks;
}

}  // namespace voltlap::port::afe
