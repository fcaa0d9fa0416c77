// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/signal_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace voltlap::plant {

SignalRows::SignalRows(const DbcSet& dbc, const SignalChoice& choice)
    : dbc_(dbc),
      choice_(choice),
      decoded_(dbc.most_signals()),
      row_(dbc.most_signals()),
      present_(presence_words(dbc.most_signals())) {}

std::size_t SignalRows::group_of(const RecordedFrame& frame, const std::vector<std::string>& buses) {
  const auto [at, is_new] = group_of_.try_emplace({frame.id, frame.bus}, kNone);
  if (!is_new) return at->second;
  const CompiledMessage* message = dbc_.find(frame.id);
  if (message == nullptr) return kNone;
  SignalGroup group{buses.at(frame.bus), message->message().name, frame.id, message, {}};
  if (frame.id != message->message().id) group.name += fmt::format("_{:02X}", frame.id & 0xFFU);
  const auto& signals = message->message().signals;
  for (std::size_t k = 0; k < signals.size(); ++k) {
    if (choice_.has(message->message(), signals[k])) group.signals.push_back(k);
  }
  if (group.signals.empty()) return kNone;
  at->second = groups_.size();
  groups_.push_back(std::move(group));
  return at->second;
}

std::optional<SignalRows::Row> SignalRows::take(const RecordedFrame& frame, const std::vector<std::string>& buses) {
  const std::size_t number = group_of(frame, buses);
  if (number == kNone) {
    const bool refused = dbc_.refusal(frame.id) != nullptr;
    refused_ += refused ? 1U : 0U;
    unknown_ += !refused && dbc_.find(frame.id) == nullptr ? 1U : 0U;
    return std::nullopt;
  }
  const SignalGroup& group = groups_[number];
  const std::vector<DbcSignal>& signals = group.message->message().signals;
  std::fill(present_.begin(), present_.end(), 0);
  group.message->decode_all(frame, decoded_, present_);
  bool any = false;
  for (std::size_t k = 0; k < group.signals.size(); ++k) {
    const std::size_t n = group.signals[k];
    const bool there = (present_[n / 64] >> (n % 64) & 1U) != 0 &&
                       (signals[n].invalid_codes.empty() || !signals[n].is_invalid_code(signals[n].raw(frame.data)));
    row_[k] = there ? decoded_[n] : std::numeric_limits<double>::quiet_NaN();
    any = any || there;
  }
  if (!any) return std::nullopt;
  return Row{number, frame.time_s, std::span<const double>(row_).first(group.signals.size())};
}

std::vector<std::vector<std::string>> column_names(const std::vector<SignalGroup>& groups) {
  std::map<std::string, std::size_t> by_name, by_frame;
  for (const SignalGroup& group : groups) {
    for (std::size_t k = 0; k < group.signals.size(); ++k) {
      ++by_name[group.signal(k).name];
      ++by_frame[group.name + "." + group.signal(k).name];
    }
  }
  std::vector<std::vector<std::string>> out;
  for (const SignalGroup& group : groups) {
    std::vector<std::string>& names = out.emplace_back();
    for (std::size_t k = 0; k < group.signals.size(); ++k) {
      std::string name = group.signal(k).name;
      if (by_name[name] > 1) {
        name = group.name + "." + name;
        if (by_frame[name] > 1) name = group.bus + "." + name;
      }
      names.push_back(std::move(name));
    }
  }
  return out;
}

}  // namespace voltlap::plant
