// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/excitation.hpp"

#include <algorithm>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kTwoSided = 1.96;

bool was_passed(const IdentifyResult& result, double soc) {
  double low = 1.0, high = 0.0;
  for (const RecordingResult& file : result.files) {
    low = std::min(low, file.soc_low);
    high = std::max(high, file.soc_high);
  }
  return soc > low - 0.01 && soc < high + 0.01;
}

}  // namespace

bool is_excited(const IdentifyResult& result, Index table, Index node) {
  const Index at = result.model.em.size() + table * result.model.grid.size() + node;
  VOLTLAP_DEMAND(at >= 0 && at < result.uncertainty.sigma.size());
  return was_passed(result, result.model.grid.at(node)) &&
         kTwoSided * result.uncertainty.sigma(at) < kSettledWithin;
}

bool is_ocv_excited(const IdentifyResult& result, Index node) {
  VOLTLAP_DEMAND(node >= 0 && node < result.model.em.size() && node < result.uncertainty.sigma.size());
  return was_passed(result, result.model.ocv.at(node)) &&
         kTwoSided * result.uncertainty.sigma(node) < kOcvSettledWithin_v;
}

}  // namespace voltlap::plant
