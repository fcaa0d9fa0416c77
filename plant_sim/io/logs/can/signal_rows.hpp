// SPDX-License-Identifier: Apache-2.0
// The chosen signals of a recording, frame by frame: a row of values for each frame that carries some of them.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/logs/can/dbc_set.hpp"
#include "io/logs/can/signal_choice.hpp"

namespace voltlap::plant {

/// The frames of one identifier on one bus, of which signals are taken.
struct SignalGroup {
  std::string bus;
  std::string name;  ///< of the frame; with the sender's address where a parameter group of J1939 has another one
  std::uint32_t id = 0;
  const CompiledMessage* message = nullptr;
  std::vector<std::size_t> signals;  ///< numbers in the message

  [[nodiscard]] const DbcSignal& signal(std::size_t k) const { return message->message().signals[signals[k]]; }
};

class SignalRows {
 public:
  SignalRows(const DbcSet& dbc, const SignalChoice& choice);

  /// One frame's values, NaN where the frame does not carry the signal or says that it has none; nothing when no signal
  /// of the frame is chosen. The row is valid until the next call.
  struct Row {
    std::size_t group;
    double time_s;
    std::span<const double> values;  ///< as in the group's signals
  };
  [[nodiscard]] std::optional<Row> take(const RecordedFrame& frame, const std::vector<std::string>& buses);

  /// Groups in the order in which they were first heard.
  [[nodiscard]] const std::vector<SignalGroup>& groups() const { return groups_; }
  [[nodiscard]] std::size_t unknown_frames() const { return unknown_; }  ///< that no DBC knows
  [[nodiscard]] std::size_t refused_frames() const { return refused_; }  ///< that a DBC has and that cannot be used

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t group_of(const RecordedFrame& frame, const std::vector<std::string>& buses);

  const DbcSet& dbc_;
  const SignalChoice& choice_;
  std::map<std::pair<std::uint32_t, std::uint8_t>, std::size_t> group_of_;
  std::vector<SignalGroup> groups_;
  std::vector<double> decoded_, row_;
  std::vector<std::uint64_t> present_;
  std::size_t unknown_ = 0, refused_ = 0;
};

/// The name of a signal's column, with the frame before it where other groups have a signal of that name, and the bus
/// before that where two buses carry the frame.
[[nodiscard]] std::vector<std::vector<std::string>> column_names(const std::vector<SignalGroup>& groups);

}  // namespace voltlap::plant
