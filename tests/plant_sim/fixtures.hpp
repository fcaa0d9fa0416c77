// SPDX-License-Identifier: Apache-2.0
// What the plant's suites share: a car, the courses, files that vanish with their test, and the text of an error.
#pragma once
#include <string>
#include <vector>

#include "core/errors.hpp"
#include "core/parameters.hpp"
#include "race/track/track.hpp"

namespace voltlap::plant::test {

/// plant_sim/data/vehicles/vtm16e.toml with its cell.
[[nodiscard]] VehicleParameters vtm16e();

/// plant_sim/data/vehicles/amk_4wd.toml: four hub motors.
[[nodiscard]] VehicleParameters amk_4wd();

/// vtm16e with the efficiencies below 1 that the reference study prints: every conversion has a loss.
[[nodiscard]] VehicleParameters lossy_vtm16e();

/// A cell whose parameters do not depend on anything, with a flat OCV: closed forms exist for it.
[[nodiscard]] CellParameters constant_cell();

/// R0, and R of each branch that the cell has.
[[nodiscard]] std::vector<CellParameterMap*> resistances_of(CellParameters& cell);
/// Those and the time constants.
[[nodiscard]] std::vector<CellParameterMap*> maps_of(CellParameters& cell);

/// Course of a year, from the project's data.
[[nodiscard]] Track michigan(int year);

/// A file with the given text; removed at the end of its scope.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text);
  ~TemporaryFile();
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Message of the InputError that `action` throws; empty when it throws none.
template <class Action>
[[nodiscard]] std::string input_error(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

}  // namespace voltlap::plant::test
