// SPDX-License-Identifier: Apache-2.0
// Listens to the control units over a replay: what they last said, rows of a time series, faults, and where the
// recorded current goes beyond their limits.
#pragma once
#include "base/can_frame.hpp"
#include "replay/replay_result.hpp"

namespace voltlap::plant {

/// The latest of each message of the control units.
struct Said {
  can::ContactorCommand contactors{};
  can::BmsLimits limits{};
  can::BmsStatus bms{};
  can::MasterStatus master{};

  void take(const Frame& frame);
};

/// What the recording says at a moment, where it does; SI.
struct LoggedMoment {
  double current_a = kUnknown, cell_min_v = kUnknown, cell_max_v = kUnknown, temperature_max_c = kUnknown;
  double soc = kUnknown, discharge_limit_a = kUnknown, charge_limit_a = kUnknown;
};

class FirmwareWatch {
 public:
  /// `with_model`: the BMS knows its cells; without it SOC and limits mean nothing and are left out.
  FirmwareWatch(ReplayResult& result, bool with_model) : result_(result), with_model_(with_model) {}

  /// Once a tick, in the time of the recording.
  void tick(double time_s, const Said& said, const LoggedMoment& logged);
  /// Faults alone: of ticks that have no time in the recording.
  void note_faults(double time_s, const Said& said);
  void finish();

 private:
  void note_row(double time_s, const Said& said, const LoggedMoment& logged);
  void follow_limit(bool charging, double time_s, double current_a, double limit_a, const Said& said);

  struct Open {
    bool running = false;
    OverLimit stretch{};
  };

  ReplayResult& result_;
  bool with_model_;
  double next_row_s_ = 0.0;
  bool begun_ = false, was_active_ = false;
  std::uint32_t bms_faults_ = 0, master_faults_ = 0;
  Open discharge_{}, charge_{};
};

}  // namespace voltlap::plant
