// SPDX-License-Identifier: Apache-2.0
// Recordings of one cell at several temperatures and currents: each operating point identified by itself, with the
// capacity, the number of branches and the centre of the time constants that all have together.
#pragma once
#include <cstddef>
#include <vector>

#include "learn/identify/identify.hpp"

namespace voltlap::plant {

/// One place of the grid: the recordings made there, and what came out.
struct OperatingPoint {
  double temperature_c = 25.0, current_a = 0.0;
  std::vector<CellLog> logs;
  IdentifyResult result;
};

struct CellIdentification {
  std::vector<OperatingPoint> points;  ///< by temperature, then current
  std::vector<double> temperatures_c, currents_a;
  std::size_t reference = 0;  ///< point that gives OCV and capacity: nearest to 25 degC
  bool temperature_told = true;  ///< else that of the points is an assumption
  [[nodiscard]] const OperatingPoint& reference_point() const { return points[reference]; }
  [[nodiscard]] OperatingPoint& reference_point() { return points[reference]; }
  /// The point nearest to a place of the grid.
  [[nodiscard]] const OperatingPoint& at(std::size_t temperature, std::size_t current) const;
  /// False where the tables are filled from a neighbour: no test was made there.
  [[nodiscard]] bool was_tested(std::size_t temperature, std::size_t current) const;
};

/// Points by operating_grid(). Identifies the reference point, then the others with its capacity, in parallel.
/// `temperatures_c`: of each recording. Throws InputError as identify() does.
[[nodiscard]] CellIdentification identify_cell(std::vector<CellLog> logs, const std::vector<double>& temperatures_c,
                                               const IdentifyOptions& options);

}  // namespace voltlap::plant
