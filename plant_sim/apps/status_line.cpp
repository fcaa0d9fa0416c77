// SPDX-License-Identifier: Apache-2.0
#include "apps/status_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace voltlap::plant {

void StatusLine::show(const std::string& text, bool at_once) {
  constexpr std::chrono::seconds kLogPeriod{5};
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  const auto now = Clock::now();
  if (!terminal && !at_once && now - shown_ < kLogPeriod) return;
  shown_ = now;
  fmt::print(stderr, "{}{}{}", terminal ? "\r\x1b[K" : "", text, terminal ? "" : "\n");
  std::fflush(stderr);
  open_ = terminal;
}

void StatusLine::clear() {
  if (open_) fmt::print(stderr, "\r\x1b[K");
  open_ = false;
}

}  // namespace voltlap::plant
