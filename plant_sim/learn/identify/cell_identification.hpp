// SPDX-License-Identifier: Apache-2.0
// Several tests of one cell at several temperatures and currents, each identified by itself, and their tables
// stacked over (SOC, temperature, current) as the plant's cell files hold them.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/parameters.hpp"
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
  std::size_t reference = 0;  ///< group that gives OCV and capacity: nearest to 25 degC
  [[nodiscard]] const OperatingPoint& at(std::size_t temperature, std::size_t current) const;
  /// False where the tables are filled from a neighbour: no test was made there.
  [[nodiscard]] bool was_tested(std::size_t temperature, std::size_t current) const;
};

/// Groups recordings by mean temperature (within 4 K) and, where each draws one current only, by that current
/// (within 20 %); one that stays below C/8 joins the nearest group. Identifies the reference group, then the others with its capacity, in parallel.
[[nodiscard]] CellIdentification identify_cell(std::vector<CellLog> logs, const std::vector<double>& temperatures_c,
                                      const IdentifyOptions& options);

/// The cell as the plant takes it. Thermal numbers and name are `like`'s; R and tau of a branch that was not fitted
/// are tiny. An OCV that falls with SOC is levelled, and `notes` says by how much.
[[nodiscard]] CellParameters cell_parameters(const CellIdentification& identified, const CellParameters& like,
                                             const std::string& name, std::vector<std::string>& notes);

/// Fit of fifth order to the OCV, from SOC^0 up (kind of reference study, 2016, Eq. 6.7), with its largest error.
struct OcvPolynomial {
  std::vector<double> coefficients_v;
  double error_max_v;
};
[[nodiscard]] OcvPolynomial ocv_polynomial(const CircuitModel& model);

/// A node counts as excited when the recordings pass it and say enough: its 95 % interval, in which smoothness counts
/// only as much as it was found in these recordings, is narrower than +- 1 % (R0), 5 % (R1 .. RK), 10 % (tau).
[[nodiscard]] bool is_excited(const IdentifyResult& result, Eigen::Index table, Eigen::Index node);
/// The same of a node of the OCV, with +- 2 mV.
[[nodiscard]] bool is_ocv_excited(const IdentifyResult& result, Eigen::Index node);

}  // namespace voltlap::plant
