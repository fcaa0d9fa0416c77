// SPDX-License-Identifier: Apache-2.0
// A measured log of a cell, a pack or a car as signals by role on the rows of its current, SI units, discharge
// positive. A value that is missing or not to be trusted is NaN; nothing is filled in.
#pragma once
#include <Eigen/Dense>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/parameter_file.hpp"

namespace voltlap::plant {

/// A stretch that is not used, and why.
struct Masked {
  std::string channel;
  double start_s, end_s;
  std::string reason;
};

struct Recording {
  std::string path;
  Eigen::VectorXd time_s;                          ///< strictly increasing
  std::map<std::string, Eigen::VectorXd> signals;  ///< by role; never `time`
  std::map<std::string, Eigen::VectorXd>
      age_s;  ///< of the values of roles that are read more seldom than the current
  std::map<std::string, Eigen::VectorXd> read_s;  ///< by role: when the value that a row holds was read
  std::map<std::string, std::vector<double>>
      passed_s;  ///< by role: between these times its values are straight lines, and say nothing of what was there
  std::set<std::string> derived;  ///< roles that were reckoned from others: no evidence of their own
  bool temperatures_of_core = false;         ///< of the cells within, not where a thermistor sits
  bool cells_at_rows = false;               ///< a table: within a row nobody knows when a cell was read
  bool cells_apart = false;                 ///< and of other times than its current, or than each other
  bool pack_is_nearer = false;              ///< the voltage of the pack is of the current's time then
  bool published_is_no_measurement = false;  ///< of the pack's voltage: it rises with the discharge current
  std::vector<Masked> masked;
  std::vector<std::string> repairs;  ///< in words, for the report

  /// Else what a current takes from the cells, and what heats them, no voltage says.
  [[nodiscard]] bool has_voltage_of_its_time() const { return !cells_apart || pack_is_nearer; }
  [[nodiscard]] Eigen::Index rows() const { return time_s.size(); }
  [[nodiscard]] const Eigen::VectorXd* find(const std::string& role) const;
  /// cell_voltage_1, cell_voltage_2 ... as far as they are recorded.
  [[nodiscard]] std::vector<std::string> numbered(const std::string& stem) const;
};

/// Reads a log; `map` is a name, a path or empty. Throws InputError for a log without time, current and a voltage.
[[nodiscard]] Recording read_recording(const DataFolder& data, const std::string& path, const std::string& map);

}  // namespace voltlap::plant
