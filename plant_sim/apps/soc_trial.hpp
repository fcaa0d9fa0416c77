// SPDX-License-Identifier: Apache-2.0
// One endurance, driven by a BMS that is told the truth, while others listen that are not.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/soc_listener.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

struct SocCase {
  std::string name;
  SocErrors errors;
};

struct SocScores {
  SocScore pack, weakest;
};

struct SocTrialRow {
  std::string name;
  SocScores ekf, coulomb;
};

struct SocTrialResult {
  EnduranceResult drive;
  std::vector<SocTrialRow> rows;
  double judged_s = 0.0;  ///< after the first tenth of the charge
};

/// `progress` is called with the fraction driven; true stops the run.
[[nodiscard]] SocTrialResult run_soc_trial(const EnduranceOptions& options, const std::vector<SocCase>& cases,
                                           const std::function<bool(double)>& progress);

}  // namespace voltlap::plant
