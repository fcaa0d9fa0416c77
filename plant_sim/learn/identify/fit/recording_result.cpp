// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/fit/recording_result.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

using Eigen::Index;

RecordingResult recording_result(const PreparedLog& prepared, const MeasuredRun& whole,
                                 const Eigen::VectorXd& error_v) {
  VOLTLAP_DEMAND(prepared.log != nullptr && prepared.run.anchor.row < prepared.log->rows());
  VOLTLAP_DEMAND(whole.rows() > 0 && error_v.size() == whole.rows());
  RecordingResult file{prepared.log->path, prepared.log->map,  prepared.log->repairs,
                   prepared.run.hold,  prepared.hold_from, prepared.run.anchor};
  file.soc_low = whole.soc.minCoeff();
  file.soc_high = whole.soc.maxCoeff();
  file.coldest_c = whole.temperature_c.minCoeff();
  file.warmest_c = whole.temperature_c.maxCoeff();
  file.duration_s = whole.time_s(whole.rows() - 1) - whole.time_s(0);
  file.rows = whole.rows();
  constexpr double kFollowed = 0.15;  // V; beyond it stand glitches and open contactors
  file.voltage_low_v = 1e9;
  for (Index row = 0; row < whole.rows(); ++row) {
    if (whole.weight_s(row) <= 0.0 || std::abs(error_v(row)) > kFollowed) continue;
    file.voltage_low_v = std::min(file.voltage_low_v, whole.voltage_v(row));
    file.voltage_high_v = std::max(file.voltage_high_v, whole.voltage_v(row));
  }
  const auto rms_from = [&](Index first) {
    const Eigen::ArrayXd w = whole.weight_s.tail(whole.rows() - first).array();
    return std::sqrt((w * error_v.tail(whole.rows() - first).array().square()).sum() / w.sum());
  };
  file.rms_v = rms_from(0);
  file.rms_pulses_v = rms_from(static_cast<Index>(prepared.run.anchor.row));
  file.trace = {whole.time_s, whole.current_a, whole.voltage_v, error_v, whole.soc, whole.weight_s};
  return file;
}

}  // namespace voltlap::plant
