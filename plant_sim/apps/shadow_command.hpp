// SPDX-License-Identifier: Apache-2.0
// `voltlap shadow`: the firmware beside the car's own unit on a live bus. It listens, records, and replays the
// recording from its beginning again and again, since a replay learns from the whole of it; at the end once more, for
// the result.
#pragma once
#include <CLI/CLI.hpp>
#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "apps/bus_options.hpp"
#include "apps/map_finding.hpp"
#include "apps/replay_outputs.hpp"
#include "apps/replay_run.hpp"
#include "apps/status_line.hpp"
#include "core/parameter_file.hpp"
#include "replay/shadow_words.hpp"

namespace voltlap::plant {

class BusCapture;

class ShadowCommand {
 public:
  explicit ShadowCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  /// Runs it and returns the exit code.
  [[nodiscard]] int run(const DataFolder& data);

 private:
  using Clock = std::chrono::steady_clock;

  void check(const DataFolder& data) const;
  void watch(BusCapture& capture, const std::string& log, const DataFolder& data);
  void replay_so_far(BusCapture& capture, const std::string& log, const DataFolder& data);
  void conclude(const std::string& log, const DataFolder& data);

  CLI::App* command_;
  BusOptions bus_;
  ReplayAsked asked_;
  MapFinding finding_;
  ReplayOutputs outputs_;
  std::string log_;
  double for_s_ = 0.0;  ///< 0: until Ctrl-C

  NewDisagreements disagreements_;
  StatusLine status_;
  enum class Stage { kNone, kListens, kWaits, kReplays };
  Stage stage_ = Stage::kListens;
  std::string state_ = "listens";  ///< of the replay before, in words
  Clock::time_point next_{};       ///< when the next replay is due
};

}  // namespace voltlap::plant
