// SPDX-License-Identifier: Apache-2.0
// Decoded signals as a table of text: one row for each frame with its own signals filled in, or rows at equal times
// with every signal's latest value.
#pragma once
#include <string>
#include <vector>

#include "io/logs/can/signal_rows.hpp"

namespace voltlap::plant {

class SignalCsv {
 public:
  /// `every_s` 0: a row for each frame. The groups must be known: see groups_of().
  SignalCsv(const std::vector<SignalGroup>& groups, double every_s);

  [[nodiscard]] std::string header() const;
  /// Appends the lines that are due.
  void add(const SignalRows::Row& row, std::string& out);
  /// The last line of a table of equal times.
  void finish(std::string& out);

 private:
  void append_row(double time_s, std::string& out) const;

  const std::vector<SignalGroup>& groups_;
  double every_s_;
  std::vector<std::size_t> first_column_;
  std::size_t columns_ = 0;
  std::vector<double> held_;
  bool begun_ = false;
  double begin_s_ = 0.0;
  long long next_ = 0;  ///< number of the next row of equal times
};

}  // namespace voltlap::plant
