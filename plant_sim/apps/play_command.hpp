// SPDX-License-Identifier: Apache-2.0
// `voltlap play`: a recording onto a CAN interface at its own pace, for live nodes and for tools.
#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "apps/bus_options.hpp"
#include "apps/recording_input.hpp"
#include "core/parameter_file.hpp"
#include "io/play/frame_choice.hpp"
#include "io/play/player.hpp"

namespace voltlap::plant {

class PlaySocket;

class PlayCommand {
 public:
  explicit PlayCommand(CLI::App& app);
  [[nodiscard]] bool chosen() const { return command_->parsed(); }
  /// Runs it and returns the exit code.
  [[nodiscard]] int run(const DataFolder& data);

 private:
  [[nodiscard]] PlayList read(const DataFolder& data);
  [[nodiscard]] PlayPlan plan(const PlayList& list) const;
  void announce(const PlayList& list, const PlayPlan& plan) const;
  void sum_up(const PlayList& list, const PlayPlan& plan, const PlayResult& result, const PlaySocket& socket) const;

  CLI::App* command_;
  CLI::Option* loop_flag_ = nullptr;
  RecordingInput recording_;
  BusOptions bus_;
  FrameChoice choice_;
  std::string speed_ = "1";
  std::vector<std::string> ids_;
  std::uint64_t rounds_ = 0;
  bool broken_ = false;  ///< the recording breaks off
};

}  // namespace voltlap::plant
