// SPDX-License-Identifier: Apache-2.0
// Separable least squares (variable projection): for given time constants the voltage is linear in Em, R0 and R_k.
//
//   minimise  sum w (V - V_model)^2 + s^2 (|D Em|^2 / m^2 + |D R|^2 / (c R_typical)^2) + n^2 sum (Em + e (T -
//   T_ref) - OCV)^2 / sigma^2
//
// w: seconds a row stands for; D: roughness; s = 2 mV s^0.5, a fixed scale; c: `smoothness`, larger is rougher;
// n^2 [V^2 s]: power density of the residual, which puts prior knowledge and data on one scale. R >= 0 by active
// set.
#pragma once
#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "learn/identify/circuit/circuit_rows.hpp"

namespace voltlap::plant {

/// What is known of the OCV beforehand: from rests, a slow test or another cell file.
struct OcvKnowledge {
  double soc, voltage_v, sigma_v;
  double temperature_c = std::nan("");  ///< at which it was read; NaN: at the reference temperature of the laws

  [[nodiscard]] double warmer_k(const ResistanceLaws& laws) const {
    return std::isfinite(temperature_c) ? temperature_c - laws.reference_temperature_c : 0.0;
  }
};

struct FitPriors {
  double smoothness = 0.5;         ///< c [1]; of the OCV where the resistances are constant
  double resistance_scale = 1e-3;  ///< R_typical [ohm]
  double em_roughness_v = 1.0;     ///< m [V]
  double noise_v2_s = 1e-4;        ///< n^2 [V^2 s]
  double state_sigma_v = 0.03;     ///< of a branch's unknown voltage after a gap
  double log_tau_roughness = 1.0;  ///< roughness of ln(tau) over SOC that counts as one s
  double log_tau_sigma = 0.5;      ///< how far a node's ln(tau) may stray from its branch's centre, for one sigma
  bool constant = false;           ///< resistances and time constants may not change with SOC
  double tau_longest_s = 5000.0;   ///< what the longest rest can still tell from a drift of the OCV
  double tau_bound_s = 5000.0;     ///< of the time constant at any one SOC
  double tau_shortest_s = 0.2;     ///< what the rows can still tell from R0
  ResistanceLaws laws;             ///< at which linear fits are made, and from which full ones begin
  LawPriors law_priors;
  std::vector<OcvKnowledge> ocv;
  std::vector<SocDoubt> soc_doubts;  ///< one a run, or none; full fits find them, linear ones take them as zero
  /// Weight of the roughness of each table [V s^0.5 over its unit]: Em, R0 .. RK, ln tau1 .. ln tauK. Empty: from
  /// `smoothness`.
  Eigen::VectorXd roughness_weights;
  [[nodiscard]] double roughness_weight(Eigen::Index table, Eigen::Index branches) const;
};

struct LinearSolution {
  Eigen::VectorXd x;  ///< [Em | R0 | R1 .. RK | free states]
  double cost = 0.0;
};

class CircuitFit {
 public:
  /// `runs` must outlive the fit.
  CircuitFit(const std::vector<MeasuredRun>& runs, Eigen::Index branches, FitPriors priors,
             SocGrid grid = breakpoint_grid());

  [[nodiscard]] LinearSolution solve(const Eigen::MatrixXd& tau_s) const;
  /// Cost with time constants that do not depend on SOC, from their logarithms; branches that change their order or
  /// are longer than the recordings can tell cost more.
  [[nodiscard]] double cost_of_taus(const Eigen::VectorXd& log_tau) const;
  /// Time constants that do not depend on SOC: the best by a simplex search from `start_s`.
  [[nodiscard]] Eigen::VectorXd search_taus(const Eigen::VectorXd& start_s, int evaluations) const;
  [[nodiscard]] CircuitModel model_of(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const;

  [[nodiscard]] Eigen::Index em_count() const { return ocv_.size(); }
  [[nodiscard]] Eigen::Index r_count() const { return grid_.size(); }
  [[nodiscard]] Eigen::Index branches() const { return branches_; }
  [[nodiscard]] Eigen::Index state_count() const { return rows_.states; }
  [[nodiscard]] Eigen::Index linear_count() const { return em_count() + r_count() * (branches_ + 1) + rows_.states; }
  [[nodiscard]] const std::vector<MeasuredRun>& runs() const { return runs_; }
  [[nodiscard]] const FitPriors& priors() const { return priors_; }
  [[nodiscard]] const SocGrid& ocv() const { return ocv_; }
  [[nodiscard]] const SocGrid& grid() const { return grid_; }
  /// D of resistances and time constants, banded: its roughness or, where they are constant, its slopes.
  [[nodiscard]] const Eigen::MatrixXd& r_roughness() const { return r_rough_; }

  [[nodiscard]] const CircuitRows& rows() const { return rows_; }
  [[nodiscard]] CircuitLayout layout() const {
    return {em_count(), r_count(), branches_, rows_.states, 2 * static_cast<Eigen::Index>(priors_.soc_doubts.size())};
  }

 private:
  void add_priors(Eigen::MatrixXd& normal, Eigen::VectorXd& right, double& square) const;

  const std::vector<MeasuredRun>& runs_;
  SocGrid ocv_ = ocv_grid(), grid_;
  Eigen::Index branches_;
  FitPriors priors_;
  CircuitRows rows_;
  Eigen::MatrixXd em_rough_, r_rough_;
};

}  // namespace voltlap::plant
