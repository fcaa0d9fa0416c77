// SPDX-License-Identifier: Apache-2.0
// Several cells of one type, each identified by itself, to a mean model with its spread (reference study, 2016,
// section 6.7: the cells' tables, on the same SOC breakpoints, are averaged).
#pragma once
#include <string>
#include <vector>

#include "learn/identify/cell_identification.hpp"

namespace voltlap::plant {

struct MeanCell {
  CellIdentification identified;  ///< means in place of one cell's parameters; recordings and notes of all
  /// Sample standard deviation between the cells, test group by test group, in the order of the packed parameters:
  /// Em in V, R and tau relative to the mean.
  std::vector<Eigen::VectorXd> spread;
  std::vector<double> capacity_ah;  ///< of each cell
  double capacity_spread_ah = 0.0;
};

/// Cells are put on one SOC scale first, by their OCV curves; that settles each cell's capacity and initial charge
/// deficit (Eq. 6.9 and 6.10) against the cell that was discharged deepest. `names` for the notes and for errors.
/// Throws InputError when the cells were not tested alike.
[[nodiscard]] MeanCell mean_cell(std::vector<CellIdentification> cells, const std::vector<std::string>& names);

/// For a person: the reference group's tables with their spread.
[[nodiscard]] std::string spread_text(const MeanCell& mean);
/// The spread as comment lines of a cell file.
[[nodiscard]] std::string spread_comment(const MeanCell& mean);
/// The text of the mean's JSON with `cells` (each cell's own JSON) and `spread` in it.
[[nodiscard]] std::string with_spread(const std::string& identification, const MeanCell& mean,
                                      const std::vector<std::string>& cells);

/// What stands before "_cell<n>" at the end of a file's name is its test, what stands behind is its cell: "cell3".
/// Empty for other names.
[[nodiscard]] std::string cell_of_file(const std::string& path);

}  // namespace voltlap::plant
