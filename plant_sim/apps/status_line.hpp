// SPDX-License-Identifier: Apache-2.0
// A line on stderr that says where something without an end stands: rewritten on a terminal, elsewhere now and then.
#pragma once
#include <chrono>
#include <string>

namespace voltlap::plant {

class StatusLine {
 public:
  StatusLine() = default;
  ~StatusLine() { clear(); }
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// `at_once`: also where the last line is not long ago.
  void show(const std::string& text, bool at_once);
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point shown_{};
  bool open_ = false;
};

}  // namespace voltlap::plant
