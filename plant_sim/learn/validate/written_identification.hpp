// SPDX-License-Identifier: Apache-2.0
// What identify writes: the fit, the cell that it makes, its file, and what that file misses of the recordings.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "car/battery/cell_thermal.hpp"
#include "core/parameter_file.hpp"
#include "learn/identify/mean_cell.hpp"
#include "learn/identify/result/cell_body.hpp"

namespace voltlap::plant {

struct WrittenIdentification {
  std::vector<CellIdentification> each;  ///< cell by cell
  std::optional<MeanCell> mean;          ///< of several
  CellIdentification identified;         ///< of the one or the mean, with the errors of the file
  CellBody body;
  CellParameters cell;
  std::string toml;
};

struct IdentificationWriter {
  const DataFolder& data;
  ToldBody told;
  std::string cell_name;
  int cells_in_series;
  std::vector<std::string> names;  ///< of the cells that are identified
  std::function<std::vector<CellIdentification>(const IdentifyOptions&)> identify;

  [[nodiscard]] CellThermal thermal(double capacity_ah) const;
  /// Throws InputError for what is no cell (require_possible_cell).
  [[nodiscard]] WrittenIdentification with(const IdentifyOptions& options) const;
  /// Where a cell warms and nobody measured it, tables that little tells may make another heat than they were fitted
  /// with, and the file misses what the fit did not (lost_by_file). Then one RC branch and a plain circuit are tried,
  /// and the file that misses least of all recordings is taken, with a note. Throws InputError where that is not to be
  /// trusted either (require_file_follows).
  [[nodiscard]] WrittenIdentification that_holds_most(const IdentifyOptions& options) const;

 private:
  [[nodiscard]] CellParameters shipped(const std::string& cell) const;
};

}  // namespace voltlap::plant
