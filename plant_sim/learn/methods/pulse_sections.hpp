// SPDX-License-Identifier: Apache-2.0
// A pulse test cut at the onsets of its loads (reference study, 2016, sections 6.2 to 6.5): each section is a load
// with the rest behind it, between two SOC nodes. Between nodes every parameter is straight.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "learn/identify/circuit/circuit_model.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// Rows first to last (exclusive). The first row is the last one before the load, the last row the last one of the
/// rest: neighbouring sections share a row.
struct PulseSection {
  Eigen::Index first, load_end, last;
  double soc_before, soc_after;
};

/// Loads with a rest of at least 60 s behind them. Loads that move the SOC by less than 2 % belong to the section of
/// the next that does. Of a recording that goes both ways the most sections in a row that go one way. Throws
/// InputError when those are fewer than three.
[[nodiscard]] std::vector<PulseSection> pulse_sections(const MeasuredRun& run);

/// A part of a run that begins with known branch voltages.
[[nodiscard]] MeasuredRun part_of(const MeasuredRun& run, Eigen::Index first, Eigen::Index last);

/// Parameters at SOC nodes, one row a node: Em [V], and the logarithms of R0, R1, R2 [ohm], tau1, tau2 [s].
enum ParameterColumn : Eigen::Index { kEm, kLnR0, kLnR1, kLnR2, kLnTau1, kLnTau2, kParameterColumns };
struct NodeTable {
  std::vector<double> soc;  ///< rising or falling
  Eigen::MatrixXd values;

  [[nodiscard]] CircuitModel model() const;
  /// The same circuit on the grids of a cell file, straight between the nodes.
  [[nodiscard]] CircuitModel on_breakpoints() const;
};

/// Least squares of part's voltage over the values of `table` that are `free` (same shape), from those given, by a
/// trust region. Resistances stay within a factor of a thousand of where they began, time constants between 0.2 s and
/// three times the part.
struct SectionFit {
  NodeTable table;
  int iterations = 0;
};
[[nodiscard]] SectionFit fit_section(const MeasuredRun& part, const NodeTable& start,
                                     const Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>& free,
                                     const Eigen::Vector2d& before_v);

/// Time constants of a rest by Eq. 6.2 of the reference study, 2016: V = Em - v1 exp(-t/tau1) - v2 exp(-t/tau2), Em
/// its last voltage. Rows first to last (exclusive).
[[nodiscard]] Eigen::Vector2d relaxation_taus(const MeasuredRun& run, Eigen::Index first, Eigen::Index last);

}  // namespace voltlap::plant
