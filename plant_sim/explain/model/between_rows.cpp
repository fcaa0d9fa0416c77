// SPDX-License-Identifier: Apache-2.0
#include "explain/model/between_rows.hpp"

#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "explain/balances/car_balances.hpp"

namespace voltlap::explain {
namespace {

/// RMS of what is off, where the current is even: a reading in which a load goes on or off may be off by all of it and
/// tells nothing of the others.
double rms_where_even(const VectorXd& off, const VectorXd& rough) {
  constexpr double kRough = 10.0;  // as the noise that grows with how fast the current changes
  const VectorXd weight = (1.0 + kRough * rough.array().square()).inverse();
  return std::sqrt(weight.dot(off.cwiseAbs2()) / std::max(1e-300, weight.sum()));
}

/// Every second row, from row `first` on, as if it had not been recorded.
void thin(VectorXd& values, Index first) {
  for (Index row = first; row + 1 < values.size(); row += 2) values(row) = 0.5 * (values(row - 1) + values(row + 1));
}

/// Predictions without every second row of what drives battery and car. A row beside which a pedal moved stays: what
/// was gained there is not judged.
plant::Prediction thinned_prediction(Observed& log, Index first) {
  std::map<std::string, VectorXd>& signals = log.comparison.log.signals;
  const std::vector<bool> knows = plant::knows_gain(log.comparison.log);
  std::map<std::string, VectorXd> driven_by;  // as it was recorded
  for (const char* role : {"current", "motor_torque", "accelerator", "brake", "lateral_acceleration"}) {
    const auto found = signals.find(role);
    if (found == signals.end()) continue;
    VectorXd& values = found->second;
    const VectorXd& recorded = driven_by[role] = values;
    thin(values, first);
    if (std::string_view(role) == "current") continue;
    for (std::size_t row = 0; row + 1 < knows.size(); ++row) {
      if (!knows[row] || !knows[row + 1]) values(static_cast<Index>(row)) = recorded(static_cast<Index>(row));
    }
  }
  VectorXd current_a = log.comparison.facts.current_a;
  thin(log.comparison.facts.current_a, first);
  plant::Prediction out = plant::predict(log.model, log.comparison);
  for (auto& [role, values] : driven_by) signals[role] = std::move(values);
  log.comparison.facts.current_a = std::move(current_a);
  return out;
}

}  // namespace

void put_between_rows(Observed& log) {
  constexpr double kOfHalf = 0.5;
  std::vector<VectorXd> off(log.channels.size());
  for (const Index first : {1, 2}) {
    const plant::Prediction changed = thinned_prediction(log, first);
    for (std::size_t c = 0; c < log.channels.size(); ++c) {
      VectorXd by_row = changed.channels[c] - log.base.channels[c];
      by_row = by_row.array().isFinite().select(by_row, 0.0);
      thin(by_row, first);  // of the rows that are left: what goes on in them from those that are not
      off[c] = first == 1 ? by_row : VectorXd(0.5 * (off[c] + by_row));
    }
  }
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    ReadChannel& channel = log.channels[c];
    channel.between_rows = kOfHalf * rms_where_even(channel.reader.of(off[c]), channel.rough) / channel.practical;
  }
}

}  // namespace voltlap::explain
