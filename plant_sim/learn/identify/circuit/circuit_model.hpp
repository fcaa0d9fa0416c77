// SPDX-License-Identifier: Apache-2.0
// An equivalent circuit whose elements are tables over SOC, and its exact response to a recorded current.
//
//   V = Em(s) - R0(s) I - sum_k v_k,   dv_k/dt = (R_k(s) I - v_k) / tau_k(s)          (discharge current positive)
//
// R and tau follow the temperature, and R0 the current, by the laws of resistance_laws.hpp.
// Over an interval u = R_k(s) I is straight from end to end, tau that of its middle: the step is the cell's own
// (car/battery/first_order.hpp), exact for a held current as for a straight one. Source: reference study, 2016,
// Eq. 4.18; signs after Thevenin.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <cstddef>
#include <vector>

#include "learn/identify/circuit/resistance_laws.hpp"

namespace voltlap::plant {

/// Nodes over SOC; beyond the ends the end value holds. Between nodes a curve is straight, as a table of the plant, or
/// smooth: the cubic through the four nodes around (a straight line in steps of 2.5 % misses an OCV that bends by
/// 20 V by 1.5 mV).
class SocGrid {
 public:
  enum class Shape { kStraight, kSmooth };
  explicit SocGrid(std::vector<double> at, Shape shape = Shape::kStraight) : at_(std::move(at)), shape_(shape) {}
  /// Of a smooth grid: the value is the sum of weight[k] y[first + k].
  struct Weights {
    Eigen::Index first;
    std::array<double, 4> weight;
  };
  [[nodiscard]] Weights weights(double soc) const;
  /// Of the slope by SOC.
  [[nodiscard]] Weights slope_weights(double soc) const;
  struct Place {
    Eigen::Index node;  ///< the value is (1 - fraction) y[node] + fraction y[node + 1]
    double fraction;
  };
  [[nodiscard]] Place find(double soc) const;
  [[nodiscard]] double value(const Eigen::Ref<const Eigen::VectorXd>& y, double soc) const;
  [[nodiscard]] Eigen::Index size() const { return static_cast<Eigen::Index>(at_.size()); }
  [[nodiscard]] double at(Eigen::Index node) const { return at_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const std::vector<double>& nodes() const { return at_; }
  /// Rows whose squares sum to the integral of the second derivative squared: what smoothness means on this grid.
  [[nodiscard]] Eigen::MatrixXd roughness() const;
  /// Rows of the differences between neighbours: all zero for a constant.
  [[nodiscard]] Eigen::MatrixXd slopes() const;

 private:
  [[nodiscard]] Weights weights_within(double soc) const;

  std::vector<double> at_;
  Shape shape_;
};

/// The 16 breakpoints of the reference study, 2016, Table 6.9.
[[nodiscard]] SocGrid breakpoint_grid();
/// The same nodes and one in the middle of each interval: node k is node 2 k there.
[[nodiscard]] SocGrid halved(const SocGrid& grid);
/// Nodes for the OCV, smooth between them: fine at the low end, where it bends.
[[nodiscard]] SocGrid ocv_grid();

/// What an interval does to a branch: v' = a v + g0 u_a + g1 u_b.
struct IntervalResponse {
  double a, g0, g1;
  /// Derivatives with respect to tau.
  double da, dg0, dg1;
};
[[nodiscard]] IntervalResponse interval_response(double dt_s, double tau_s);

struct CircuitModel {
  SocGrid ocv = ocv_grid(), grid = breakpoint_grid();
  Eigen::VectorXd em;   ///< [V] on `ocv`
  Eigen::MatrixXd r;    ///< [ohm] on `grid`; column 0 is R0, column k the resistance of branch k
  Eigen::MatrixXd tau;  ///< [s] on `grid`; column k - 1 is branch k
  double capacity_ah = 0.0;
  ResistanceLaws laws;         ///< from the tables' temperature to others
  double voltage_lag_s = 0.0;  ///< first-order lag of the recorded voltage behind the current; 0: none found

  [[nodiscard]] Eigen::Index branches() const { return tau.cols(); }
  /// R0 of a node [ohm] at a current and the tables' temperature, with what the charge transfer takes.
  [[nodiscard]] double r0_ohm(Eigen::Index node, double current_a) const {
    const double ct_v = charge_transfer_drop_v(laws, current_a, laws.reference_temperature_c);
    return r(node, 0) + (current_a > 0.0 ? ct_v / current_a : 0.0);
  }
};

struct MeasuredRun;
/// Voltage at every row of a run. Branches are at rest at its beginning and after gaps, unless `states_v` gives
/// their voltages: for each of the run's free resets one value a branch. `after_v` receives those after the last row.
[[nodiscard]] Eigen::VectorXd simulate(const CircuitModel& model, const MeasuredRun& run,
                                       const Eigen::Ref<const Eigen::VectorXd>& states_v = Eigen::VectorXd(),
                                       Eigen::VectorXd* after_v = nullptr);

}  // namespace voltlap::plant
