// SPDX-License-Identifier: Apache-2.0
// A line on stderr that says how far a command is, from two seconds on: rewritten on a terminal, now and then in a
// log.
#pragma once
#include <chrono>
#include <string>

namespace voltlap::plant {

class ProgressLine {
 public:
  explicit ProgressLine(std::string doing) : doing_(std::move(doing)) {}
  ~ProgressLine() { end(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& what, double fraction);
  /// Clears the line.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  std::string doing_;
  Clock::time_point begin_ = Clock::now(), shown_{};
  bool line_open_ = false;
};

}  // namespace voltlap::plant
