// SPDX-License-Identifier: Apache-2.0
// What an explanation changes in the prediction of an endurance: the same race with the model as it was given, with
// the extended car under a BMS whose tables are still the old ones, and with both extended.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "explain/extend/extended_model.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

struct RacePrediction {
  EnduranceResult result;
  double bms_soc_error_end_pct = 0.0;  ///< the BMS's SOC minus the car's at the end, percent of charge
};

struct RaceChange {
  std::string course, car;  ///< what was driven, in words
  int laps = 0;
  RacePrediction before, after_old_bms, after;
  std::vector<std::string> left_out;  ///< causes that the simulated car has no parameter for
  std::string impossible;             ///< why there is no prediction; else empty
  bool stopped = false;               ///< it was interrupted
};

struct RaceTools {
  std::function<std::unique_ptr<Ecus>(const VehicleParameters&)> firmware;  ///< control units configured for a car
  std::function<void(const std::string&, double)> progress;
  std::function<bool()> stop_requested;
};

/// Cell and pack files are put into the standard car; the cell of another size in as many in parallel as come
/// nearest to the capacity of the standard pack.
[[nodiscard]] RaceChange race_change(const DataFolder& data, const Model& model, const World& extended,
                                     const RaceTools& tools);

}  // namespace voltlap::plant
