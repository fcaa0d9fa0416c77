// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/signal_choice.hpp"

#include <fnmatch.h>

#include <algorithm>

namespace voltlap::plant {
namespace {

bool fits(const std::string& pattern, const DbcMessage& message, const DbcSignal& signal) {
  return ::fnmatch(pattern.c_str(), signal.name.c_str(), 0) == 0 ||
         ::fnmatch(pattern.c_str(), (message.name + "." + signal.name).c_str(), 0) == 0;
}

}  // namespace

bool SignalChoice::has(const DbcMessage& message, const DbcSignal& signal) const {
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), [&](const std::string& pattern) {
           return fits(pattern, message, signal);
         });
}

std::vector<std::string> SignalChoice::without_match(const std::vector<const DbcMessage*>& messages) const {
  std::vector<std::string> out;
  for (const std::string& pattern : patterns_) {
    const bool any = std::any_of(messages.begin(), messages.end(), [&](const DbcMessage* message) {
      return std::any_of(message->signals.begin(), message->signals.end(),
                         [&](const DbcSignal& signal) { return fits(pattern, *message, signal); });
    });
    if (!any) out.push_back(pattern);
  }
  return out;
}

}  // namespace voltlap::plant
