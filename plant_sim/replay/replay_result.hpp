// SPDX-License-Identifier: Apache-2.0
// What the firmware made of a recording: what it allowed, what it complained of, beside what the recording says itself.
#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/can_frame.hpp"
#include "can_dbc/car.hpp"
#include "io/logs/drive_log.hpp"

namespace voltlap::plant {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A fault bit that came: of the BMS or of the master controller, by its name in car.dbc.
struct ReplayFault {
  std::string id, node;
  double time_s = 0.0;
  bool opens = false;      ///< with it the BMS left TsActive
  std::string about{};     ///< the channel that is not believed, and why
};

/// A stretch in which a cell was outside of the BMS's voltage limits, by the recording's own samples.
struct LimitViolation {
  double time_s = 0.0, until_s = 0.0;
  int cell = 0;  ///< from 1
  double voltage_v = 0.0, limit_v = 0.0, worst_s = 0.0;  ///< the voltage farthest from the limit, and when
};

/// A stretch in which the recorded current was beyond what the firmware allowed.
struct OverLimit {
  bool charging = false;
  double begin_s = 0.0, end_s = 0.0, worst_s = 0.0;
  double current_a = 0.0, limit_a = 0.0;  ///< when the excess was largest; both positive
  can::LimitReason reason = can::LimitReason::kNone;
  int cell = 0;  ///< from 1; 0: no cell sets the limit
  [[nodiscard]] double excess_a() const { return current_a - limit_a; }
};

/// A logged SOC that jumps: from, to, and the charge that flowed meanwhile.
struct SocJump {
  double begin_s = 0.0, end_s = 0.0, from = 0.0, to = 0.0, charge_ah = 0.0;
  double explained = kUnknown;  ///< share of the capacity that is that charge
};

/// One moment; NaN where nothing is known.
struct ReplayRow {
  double time_s = 0.0, current_a = kUnknown, cell_min_v = kUnknown, cell_max_v = kUnknown, temperature_max_c = kUnknown;
  double soc = kUnknown, logged_soc = kUnknown;
  double discharge_limit_a = kUnknown, logged_discharge_limit_a = kUnknown;
  double charge_limit_a = kUnknown, logged_charge_limit_a = kUnknown;
  can::LimitReason discharge_reason{}, charge_reason{};
  int limiting_cell = 0;  ///< from 1; 0: none
  can::BmsState state{};
  std::uint32_t faults = 0;
};

/// A fault word of the car's own unit that came or changed.
struct LoggedFault {
  std::string role, source;
  double time_s = 0.0, value = 0.0;
};

/// A stretch in which the recording has no current and no voltage.
struct RecordingHole {
  double begin_s = 0.0, end_s = 0.0;
};

/// The mean cell of a moment at little current, and what the pack file says of it.
struct QuietCell {
  double time_s = 0.0, voltage_v = 0.0, ocv_v = 0.0;
  double counted = 0.0, by_voltage = 0.0;  ///< SOC
};

/// What the firmware's filter has learned of a cell by the end; the deviations are the filter's own.
struct CellEstimate {
  int cell = 0;                                          ///< from 1
  double soc = kUnknown;
  double resistance = kUnknown, resistance_sd = kUnknown;  ///< of what the pack file says
  double capacity_ah = kUnknown, capacity_sd_ah = kUnknown;  ///< of the parallel group, as the log's sensor measures it
};

/// Two things that do not agree, with the stretch of the recording that decides between them.
struct Disagreement {
  double weight = 0.0;  ///< how much it matters; the table is sorted by it
  double begin_s = 0.0, end_s = 0.0;
  std::string what, decided_by;
};

/// Our own recording: the frames that the nodes answered beside those that were recorded.
struct FrameComparison {
  struct Node {
    std::size_t recorded = 0, same = 0, different = 0, missing = 0, extra = 0;
  };
  Node bms{}, master{};
  struct Difference {
    double time_s = 0.0;
    std::string node, message, recorded, answered;  ///< frames as candump writes them; empty: there is none
  };
  std::optional<Difference> first{};
  [[nodiscard]] bool identical() const { return !first && bms.recorded + master.recorded > 0; }
};

/// What the firmware's SOC starts from: cells at rest, or, in a recording that begins under load, see soc_start.hpp.
enum class SocSource { kRest, kCountedBack, kLogged, kUnloaded };
inline constexpr const char* kSocSourceNames[] = {"cells at rest", "a later rest, counted back",
                                                  "the log's own SOC", "cells under load"};

/// The same log once more, by other settings or another firmware.
struct SecondRun {
  std::string name;                  ///< of its curves: what is other
  std::string since;                 ///< what the changes lead away from, in words
  std::vector<ReplayRow> rows{};
  std::vector<std::string> changes{};  ///< see replay_baseline.hpp
};

struct ReplayResult {
  std::string log, map, pack;            ///< pack empty: no cell model
  FrameAccount frames{};
  double begin_s = 0.0, duration_s = 0.0;  ///< of the recording that was replayed
  std::size_t cells = 0, thermistors = 0;
  double capacity_ah = 0.0;              ///< as the firmware is told; 0: not known
  double computed_s = 0.0;               ///< firmware and frames; reading apart
  double firmware_s = 0.0;               ///< simulated time that it ran, bringing it up included
  std::vector<ReplayRow> rows;
  std::vector<ReplayFault> faults;
  std::vector<LimitViolation> violations;
  std::vector<OverLimit> over_limits;
  std::vector<LogDefect> defects;
  std::vector<Disagreement> disagreements;
  std::vector<std::string> assumptions;  ///< what stands for what the recording does not have
  std::vector<std::string> notes;        ///< of the reading
  std::string never_ready;               ///< why the firmware never became active; empty: it did
  std::vector<LoggedFault> logged_faults{};
  std::vector<RecordingHole> holes{};
  std::vector<double> closed_again_s{};  ///< after a trip, in a log that goes on; what follows at once is of the replay
  std::vector<QuietCell> quiet_cells{};
  std::vector<CellEstimate> estimates{};      ///< empty: no filter of every cell
  std::size_t cells_recorded = 0;             ///< cells that have readings of their own
  double open_s = 0.0, open_ah = 0.0;    ///< the log drove on while the firmware's contactors were open
  std::optional<FrameComparison> comparison{};
  std::optional<SocJump> soc_jump{};
  SocSource soc_from = SocSource::kRest;
  std::optional<SecondRun> second{};

  [[nodiscard]] bool has_cell_model() const { return !pack.empty(); }
  [[nodiscard]] double soc_start() const;
  [[nodiscard]] double soc_end() const;
  [[nodiscard]] double logged_soc_start() const;
  [[nodiscard]] double logged_soc_end() const;
};

/// Names of the bits of a fault word, joined.
[[nodiscard]] std::string bms_fault_names(std::uint32_t bits);

}  // namespace voltlap::plant
