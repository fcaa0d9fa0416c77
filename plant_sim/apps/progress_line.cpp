// SPDX-License-Identifier: Apache-2.0
#include "apps/progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace voltlap::plant {
namespace {

constexpr std::chrono::seconds kQuiet{2}, kLogPeriod{5};
constexpr std::chrono::milliseconds kTerminalPeriod{200};

}  // namespace

void ProgressLine::show(const std::string& what, double fraction) {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  const auto now = Clock::now();
  if (now - begin_ < kQuiet || now - shown_ < (terminal ? std::chrono::milliseconds(kTerminalPeriod) : kLogPeriod))
    return;
  shown_ = now;
  fmt::print(stderr, "{}{}: {:3.0f} %, {}{}", terminal ? "\r" : "", doing_, 100.0 * fraction, what,
             terminal ? "   " : "\n");
  std::fflush(stderr);
  line_open_ = terminal;
}

void ProgressLine::end() {
  if (line_open_) fmt::print(stderr, "\r{:60}\r", "");
  line_open_ = false;
}

}  // namespace voltlap::plant
