// SPDX-License-Identifier: Apache-2.0
// What a cell file says to a recorded current: voltage, heat and temperature, row by row.
//
//   V = OCV(s, T) + dE(s, T, I) - drop        the drop, the heat and both temperatures: car/battery/cell.hpp
//
// dE is what single tests found apart from the curve over SOC (`ocv.table` of the cell file); the plant leaves it
// out.
#pragma once
#include <Eigen/Dense>
#include <optional>
#include <string>
#include <vector>

#include "car/battery/cell.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// Whose open-circuit voltage: the plant's curve over SOC, or that curve with what each test found apart from it.
enum class OcvOf { kSoc, kSocTemperatureCurrent };

class CellModel {
 public:
  /// Throws InputError for tables that do not fit (CellTables).
  explicit CellModel(const CellParameters& cell, OcvOf ocv = OcvOf::kSoc);

  [[nodiscard]] const Cell& one_cell() const { return cell_; }
  [[nodiscard]] const CellParameters& cell() const { return cell_.parameters(); }
  [[nodiscard]] const CellTables& tables() const { return cell_.tables(); }
  [[nodiscard]] double ocv(double soc, double temperature_c, double current_a) const;

 private:
  Cell cell_;
  std::optional<CellTables> ocv_by_test_;  ///< its r0 is the open-circuit voltage [V]: the same lookup
};

/// Temperatures that a recording offers.
struct RecordedTemperature {
  std::vector<double> cell_c;     ///< empty: not recorded, the model's own is used
  std::vector<double> ambient_c;  ///< empty: constant at `start_c`
  double start_c = 25.0;
  std::string start_from = "assumed";  ///< recorded, --temperature, its ambient, assumed

  /// Of a recording. One without the cell's temperature starts at `otherwise_c` when that was `told`, else at its
  /// ambient, as a cell that has rested there, else at `otherwise_c`.
  RecordedTemperature(const CellLog& log, double otherwise_c, bool told = false);
};

struct CellResponse {
  Eigen::VectorXd voltage, temperature;
  Eigen::VectorXd heat_w;        ///< of the interval that ends at the row
  Eigen::VectorXd reversible_w;  ///< of it by the entropy
};

/// Lookup by SOC, temperature and the last current above 0.5 % of the recording's largest. The temperature is the
/// recorded one, else the one that the cell's own heat makes from the start on.
/// `states_v`: of each reset at which the branches are not known to be at rest their voltages, one after the other, as
/// identify's `simulate` takes them; without, they begin at rest.
[[nodiscard]] CellResponse respond(const CellModel& model, const MeasuredRun& run,
                                   const RecordedTemperature& temperature, const Eigen::VectorXd& states_v = {});

}  // namespace voltlap::plant
