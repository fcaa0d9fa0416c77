// SPDX-License-Identifier: Apache-2.0
// Recordings laid out for many evaluations of one circuit: what does not depend on the parameters is worked out
// once, and derivatives are carried only at the nodes that the charge has passed lately.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <vector>

#include "learn/identify/circuit/circuit_model.hpp"
#include "learn/identify/recording/measured_run.hpp"

namespace voltlap::plant {

/// A row of a recording and the interval that ends there.
struct CircuitRow {
  struct Place {
    int node;
    double fraction;
  };
  double dt_s, begin_a, end_a;  ///< interval, and its currents
  double current_a;             ///< at the row
  double warm_was, warm;        ///< x of the laws [mol/kJ] at the row before and at the row
  double warmer_k;              ///< T - T_ref at the row
  double thermal_v;             ///< 4 R_g T / F at the row
  double hysteresis;            ///< h at the row
  double weight_s, voltage_v;
  Place was, middle, at;  ///< on the tables: row before, interval, row
  int em_node;
  std::array<double, 4> em_weight;
  bool load;  ///< current flows, for residuals of their own variance
  bool reset;
  int free_state;  ///< with `reset`: index of the first free state, or -1 for branches at rest
};

/// How far the SOC of a recording may be off, to be found with the tables: SOC + o + c (SOC - SOC at its anchor), which
/// is a start that is off by o and a capacity that is smaller by c, with what is believed of both.
struct SocDoubt {
  double anchor_soc = 1.0;
  double offset_mean = 0.0, offset_sigma = 0.0;  ///< o [1]
  double scale_mean = 0.0, scale_sigma = 0.0;    ///< c [1]
};

/// What a row adds to CircuitRow where SOC is in doubt.
struct DoubtedRow {
  std::array<double, 4> em_slope;  ///< weights of the OCV's slope, at the nodes of em_weight
  double from_anchor;              ///< SOC less that of the anchor
  int run;
};

struct CircuitRows {
  CircuitRows() = default;
  /// `laws`: their reference temperature, and whether there is a charge transfer. `doubts`: one a run, or none.
  CircuitRows(const std::vector<MeasuredRun>& runs, const SocGrid& ocv, const SocGrid& grid, Eigen::Index branches,
              const ResistanceLaws& laws, const std::vector<SocDoubt>& doubts = {});
  std::vector<CircuitRow> rows;
  Eigen::Index states = 0, used = 0;  ///< free states; rows with a weight
  bool isothermal = true;             ///< x is 0 at every row
  bool charge_transfer = false, hysteresis = false;
  std::vector<DoubtedRow> in_doubt;  ///< one a row, or none
};

/// Where each parameter stands in a vector: [Em | R0 .. RK | tau1 .. tauK | free states | o, c of each run | laws]; o
/// and c only where SOC is in doubt.
struct CircuitLayout {
  Eigen::Index em, nodes, branches, states, doubts = 0;
  [[nodiscard]] Eigen::Index r(Eigen::Index k) const { return em + k * nodes; }
  [[nodiscard]] Eigen::Index tau(Eigen::Index k) const { return em + (branches + 1 + k) * nodes; }
  [[nodiscard]] Eigen::Index state() const { return em + (2 * branches + 1) * nodes; }
  [[nodiscard]] Eigen::Index doubt() const { return state() + states; }
  [[nodiscard]] Eigen::Index law() const { return doubt() + doubts; }
  [[nodiscard]] Eigen::Index size() const { return law() + ResistanceLaws::kCount; }
  /// First entry and number of nodes of table 0: Em, then R0 .. RK, tau1 .. tauK.
  [[nodiscard]] Eigen::Index tables() const { return 2 * branches + 2; }
  [[nodiscard]] Eigen::Index first(Eigen::Index table) const { return table == 0 ? 0 : em + (table - 1) * nodes; }
  [[nodiscard]] Eigen::Index count(Eigen::Index table) const { return table == 0 ? em : nodes; }
};

/// Sums of squares that a least squares step needs, in R [ohm] and tau [s] themselves; rest and load apart.
struct NormalSums {
  Eigen::MatrixXd rest, load;  ///< J^T W J, both triangles
  Eigen::VectorXd gradient;    ///< J^T W e
  double rest_square = 0.0, load_square = 0.0;  ///< e^T W e [V^2 s]
  Eigen::Index rest_rows = 0, load_rows = 0;
};

/// Sums at parameters x (R and tau themselves). Without `with_tau` columns of time constants and laws stay zero: the
/// fit is linear then.
[[nodiscard]] NormalSums sums_of(const CircuitRows& rows, const CircuitLayout& layout, const double* x, bool with_tau);

/// Errors of the rows with a weight, times the root of the weight [V s^0.5]; `derivatives` is null or a row-major
/// matrix of rows x size, filled with zeros.
void residuals_of(const CircuitRows& rows, const CircuitLayout& layout, const double* x, double* residuals,
                  double* derivatives);

}  // namespace voltlap::plant
