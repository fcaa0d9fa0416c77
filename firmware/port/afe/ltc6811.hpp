// SPDX-License-Identifier: Apache-2.0
// A chain of LTC6811-1 (datasheet rev C) behind the cells seam: up to 12 cells and 5 thermistors a chip, commands to
// all at once, their answers one behind the other. What is behind it is measured round by round:
//
//   tick    0            1                          2                        and in every kRoundsPerWireCheck-th round
//           cells: ADCV  read A to D, inputs: ADAX  read A and B, shunts     ADOW twice with, twice without pull-up
//
// Nothing waits for a conversion: it is read in the tick behind it (normal mode: 2.3 ms). Before each the registers are
// cleared, so that one that never happened reads as no value, not as an old one.
#pragma once
#include "port/afe/spi.hpp"
#include "port/afe/thermistor.hpp"
#include "port/cells.hpp"

namespace voltlap::port::afe {

inline constexpr std::size_t kChipsMax = 12;
inline constexpr std::size_t kCellsPerChip = 12;
inline constexpr std::size_t kInputsPerChip = 5;
inline constexpr std::size_t kGroupBytes = 6;  ///< of a register group
inline constexpr std::size_t kWordsPerGroup = 3;

class Ltc6811Chain final : public Cells {
 public:
  struct Chip {
    std::uint8_t cells = 0;        ///< from C1 on, 1 to 12
    std::uint8_t thermistors = 0;  ///< from GPIO1 on, 0 to 5
  };
  /// The first chip is the one next to the controller. Cells and thermistors are counted through the chips.
  struct Config {
    std::size_t chips = 0;
    Chip chip[kChipsMax] = {};
    ThermistorTable thermistor = kNtc10k3977;
  };
  struct Counts {
    std::uint32_t rounds = 0;
    std::uint32_t pec_errors = 0;     ///< groups of one chip that came damaged, or not at all
    std::uint32_t config_errors = 0;  ///< a chip's settings were not what it was told: it has started anew
  };

  Ltc6811Chain(Spi& spi, const Config& config) : spi_(spi), config_(config) {}

  /// False when the configuration is impossible: step() measures nothing then, and every reading stays away.
  [[nodiscard]] bool init();

  void step() override;
  bool take(can::CellVoltages& out) override;
  bool take(can::Temperatures& out) override;
  void bleed(const std::uint32_t* words, std::size_t count) override;

  [[nodiscard]] const Counts& counts() const { return counts_; }
  /// The wire of pin C`pin` of a chip is off, by the last check that could be read.
  [[nodiscard]] bool wire_is_off(std::size_t chip, std::size_t pin) const { return (off_[chip] >> pin & 1U) != 0; }

 private:
  /// In the order of a round; the last five only in one with a check of the wires.
  enum class Phase : std::uint8_t {
    kCells,
    kInputs,
    kShunts,
    kPullUp,
    kPullUpAgain,
    kPullDown,
    kPullDownAgain,
    kJudge,
  };
  struct Reading {
    std::uint16_t value = 0;
    bool good = false;
  };

  void command(std::uint16_t code);
  void read_group(std::uint16_t code, std::uint8_t (&bytes)[kChipsMax][kGroupBytes], bool (&good)[kChipsMax]);
  void read_words(const std::uint16_t* codes, std::size_t groups, Reading (&out)[kChipsMax][kCellsPerChip]);
  void write_settings();
  void check_settings();
  void settings_of(std::size_t chip, std::uint8_t (&bytes)[kGroupBytes]) const;
  void store_cells(const Reading (&read)[kChipsMax][kCellsPerChip]);
  void store_inputs(const Reading (&read)[kChipsMax][kCellsPerChip]);
  void judge_wires(const Reading (&pulled_down)[kChipsMax][kCellsPerChip]);
  void next_phase();

  Spi& spi_;
  const Config config_;
  Counts counts_{};
  bool ready_ = false;
  Phase phase_ = Phase::kCells;
  std::uint32_t rounds_to_check_ = 0;
  std::uint32_t bleed_ticks_ = 0;  ///< left
  bool bled_[kChipsMax * kCellsPerChip] = {};
  std::uint16_t off_[kChipsMax] = {};  ///< a bit a pin, C0 to C12
  Reading pulled_up_[kChipsMax][kCellsPerChip] = {};
  can::CellVoltages cells_[can::CellVoltages::kGroups] = {};
  can::Temperatures temperatures_[can::Temperatures::kGroups] = {};
  bool cells_new_[can::CellVoltages::kGroups] = {};
  bool temperatures_new_[can::Temperatures::kGroups] = {};
};

}  // namespace voltlap::port::afe
