// SPDX-License-Identifier: Apache-2.0
#include "io/logs/can/signal_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

/// Twelve digits: more than any signal of 32 bits has, and none of the noise of its scale.
void append_number(double value, std::string& out) {
  if (!std::isfinite(value)) return;
  if (value == std::floor(value) && std::abs(value) < 1e15) {
    fmt::format_to(std::back_inserter(out), "{}", static_cast<long long>(value));
  } else {
    fmt::format_to(std::back_inserter(out), "{:.12g}", value);
  }
}

/// A name in quotation marks where it holds a comma or one of these.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

}  // namespace

SignalCsv::SignalCsv(const std::vector<SignalGroup>& groups, double every_s) : groups_(groups), every_s_(every_s) {
  VOLTLAP_DEMAND(every_s >= 0.0);
  for (const SignalGroup& group : groups) {
    first_column_.push_back(columns_);
    columns_ += group.signals.size();
  }
  held_.assign(columns_, std::numeric_limits<double>::quiet_NaN());
}

std::string SignalCsv::header() const {
  std::string out = "time_s";
  const auto names = column_names(groups_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (std::size_t k = 0; k < names[g].size(); ++k) {
      const std::string& unit = groups_[g].signal(k).unit;
      out += "," + field(unit.empty() ? names[g][k] : fmt::format("{} [{}]", names[g][k], unit));
    }
  }
  return out + "\n";
}

void SignalCsv::append_row(double time_s, std::string& out) const {
  fmt::format_to(std::back_inserter(out), "{:.6f}", time_s);
  for (const double value : held_) {
    out += ',';
    append_number(value, out);
  }
  out += '\n';
}

void SignalCsv::add(const SignalRows::Row& row, std::string& out) {
  VOLTLAP_DEMAND(row.group < groups_.size());
  const std::size_t first = first_column_[row.group];
  if (every_s_ == 0.0) {
    fmt::format_to(std::back_inserter(out), "{:.6f}", row.time_s);
    out.append(first + 1, ',');
    for (std::size_t k = 0; k < row.values.size(); ++k) {
      if (k > 0) out += ',';
      append_number(row.values[k], out);
    }
    out.append(columns_ - first - row.values.size(), ',');
    out += '\n';
    return;
  }
  if (!begun_) begin_s_ = row.time_s;
  begun_ = true;
  for (; row.time_s > begin_s_ + every_s_ * static_cast<double>(next_); ++next_) {
    append_row(begin_s_ + every_s_ * static_cast<double>(next_), out);
  }
  for (std::size_t k = 0; k < row.values.size(); ++k) {
    if (std::isfinite(row.values[k])) held_[first + k] = row.values[k];
  }
}

void SignalCsv::finish(std::string& out) {
  if (every_s_ > 0.0 && begun_) append_row(begin_s_ + every_s_ * static_cast<double>(next_), out);
}

}  // namespace voltlap::plant
