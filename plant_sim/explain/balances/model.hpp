// SPDX-License-Identifier: Apache-2.0
// The model that a log is held against: a cell file (one cell), a pack file (a vehicle's [battery] alone), or a
// vehicle.
#pragma once
#include <string>
#include <vector>

#include "core/model_file.hpp"
#include "explain/balances/recording.hpp"
#include "explain/balances/world.hpp"

namespace voltlap::plant {

struct Model {
  ModelKind kind = ModelKind::kCell;
  std::string path;
  World world;
  bool temperature_stated = true;  ///< how warm the battery of this log begins, by who asks; else as any file has it
  double air_step_k = 0.0;  ///< last digit of how warm the air of this log was, by who asks; 0: not said
};

/// `settings` are key=value of the vehicle's keys; for a cell file battery.cells_in_series and
/// battery.cells_in_parallel say what the log's pack is made of. Throws InputError for a file that is none of the
/// three.
[[nodiscard]] Model load_model(const DataFolder& data, const std::string& name,
                               const std::vector<std::string>& settings);

/// Brings the number of cells in series of a cell file to the log's, and complains where the log's voltage is that
/// of another number of cells.
void fit_to_log(Model& model, const Recording& log);

}  // namespace voltlap::plant
