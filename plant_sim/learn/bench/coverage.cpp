// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/coverage.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

std::size_t nearest(const std::vector<double>& at, double x) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    if (std::abs(at[i] - x) < std::abs(at[best] - x)) best = i;
  }
  return best;
}

double interval(const BenchRecord& record, std::size_t row) {
  return row + 1 < record.time_s.size() ? record.time_s[row + 1] - record.time_s[row]
                                        : record.duration_s() - record.time_s[row];
}

}  // namespace

Coverage::Coverage(const CellParameters& cell)
    : soc_(cell.soc_breakpoints),
      temperature_(cell.temperature_breakpoints_c),
      current_(cell.current_breakpoints_a),
      load_s_(soc_.size() * temperature_.size() * current_.size()),
      rest_s_(load_s_.size()) {
  VOLTLAP_DEMAND(increasing(soc_) && increasing(temperature_) && increasing(current_));
  VOLTLAP_DEMAND(!load_s_.empty());
}

void Coverage::add(const BenchRecord& record) {
  VOLTLAP_DEMAND(!record.cells.empty() && record.true_current_a.size() == record.time_s.size());
  const CellRecord& cell = record.cells.front();
  VOLTLAP_DEMAND(cell.true_soc.size() == record.time_s.size());
  double last_load = 0.0;
  for (std::size_t row = 0; row < record.time_s.size(); ++row) {
    const double current = std::abs(record.true_current_a[row]);
    if (current > 0.0) last_load = current;
    const std::size_t at = node(nearest(soc_, cell.true_soc[row]),
                                nearest(temperature_, cell.true_temperature_c[row]), nearest(current_, last_load));
    (current > 0.0 ? load_s_ : rest_s_)[at] += interval(record, row);
  }
}

std::size_t Coverage::visited(double load_s_min) const {
  return static_cast<std::size_t>(
      std::count_if(load_s_.begin(), load_s_.end(), [=](double s) { return s >= load_s_min; }));
}

std::string taus_text(const RestSummary& rests) {
  std::vector<std::string> out;
  for (std::size_t k = 0; k < rests.taus.size(); ++k) {
    out.push_back(fmt::format("{}tau{}{} {:.0f} to {:.0f} s", k == 0 ? "" : "its ", k + 1, k == 0 ? " is" : "",
                              rests.taus[k].min_s, rests.taus[k].max_s));
  }
  return fmt::format("{}", fmt::join(out, " and "));
}

void RestSurvey::add(const BenchRecord& record) {
  VOLTLAP_DEMAND(!record.cells.empty());
  const CellRecord& cell = record.cells.front();
  double last_load = 0.0;
  for (const BenchPhase& phase : record.phases) {
    if (phase.load) {
      last_load = 3600.0 * std::abs(phase.charge_ah) / (phase.end_s - phase.begin_s);
      continue;
    }
    if (last_load == 0.0) continue;  // the rest before the first pulse shows nothing
    const auto row =
        std::lower_bound(record.time_s.begin(), record.time_s.end(), phase.begin_s) - record.time_s.begin();
    const auto at = std::min(static_cast<std::size_t>(row), record.time_s.size() - 1);
    const CircuitParameters p = tables_.circuit(phase.soc, cell.true_temperature_c[at], last_load);
    const double length = phase.end_s - phase.begin_s;
    for (std::size_t k = 0; k < sum_.taus.size(); ++k) {
      sum_.taus[k].min_s = std::min(sum_.taus[k].min_s, p.tau_s[k]);
      sum_.taus[k].max_s = std::max(sum_.taus[k].max_s, p.tau_s[k]);
    }
    sum_.shorter_than_last_tau += length < p.tau_s[sum_.taus.size() - 1] ? 1U : 0U;
    lengths_.push_back(length);
  }
}

RestSummary RestSurvey::summary() const {
  RestSummary out = sum_;
  out.count = lengths_.size();
  if (lengths_.empty()) {
    for (RestSummary::TauRange& tau : out.taus) tau = {0.0, 0.0};
    return out;
  }
  const auto [shortest, longest] = std::minmax_element(lengths_.begin(), lengths_.end());
  out.shortest_s = *shortest;
  out.median_s = median(lengths_);
  out.longest_s = *longest;
  return out;
}

}  // namespace voltlap::plant
