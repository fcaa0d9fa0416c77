// SPDX-License-Identifier: Apache-2.0
#include "identify/circuit_cost.hpp"

#include <ceres/ceres.h>

#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kScale = 2e-3;            // s of circuit_fit.hpp [V s^0.5]
constexpr double kLogTauSigma = 0.5;       // how far a node's ln(tau) may stray from its centre, for one sigma
constexpr double kResistanceFloor = 1e-3;  // of the typical resistance, where the linear fit says zero

/// One branch on its way through a run: voltage and its derivatives by each node's ln R and ln tau.
struct BranchTrack {
  double v = 0.0, u_before = 0.0, decay = 1.0;
  Eigen::VectorXd by_r, by_tau;
};

}  // namespace

CircuitCost::CircuitCost(const CircuitFit& fit, Eigen::VectorXd tau_centre_s)
    : fit_(fit),
      log_centre_(tau_centre_s.array().log()),
      em_(fit.em_count()),
      r_(fit.r_count()),
      branches_(fit.branches()),
      first_tau_(em_ + r_ * (branches_ + 1)),
      first_state_(first_tau_ + r_ * branches_),
      parameters_(first_state_ + fit.state_count()),
      em_rough_(fit.ocv().roughness()),
      r_rough_(fit.grid().roughness()) {
  for (const TestRun& run : fit.runs()) data_rows_ += (run.weight_s.array() > 0.0).count();
  prior_rows_ = em_rough_.rows() + r_rough_.rows() * (2 * branches_ + 1) + r_ * branches_ +
                static_cast<Index>(fit.priors().ocv.size()) + fit.state_count();
}

Eigen::VectorXd CircuitCost::pack(const LinearSolution& solution, const Eigen::MatrixXd& tau_s) const {
  Eigen::VectorXd p(parameters_);
  p.head(em_) = solution.x.head(em_);
  const double floor = kResistanceFloor * fit_.priors().resistance_scale;
  p.segment(em_, first_tau_ - em_) = solution.x.segment(em_, first_tau_ - em_).array().max(floor).log();
  p.segment(first_tau_, first_state_ - first_tau_) = tau_s.reshaped().array().log();
  p.tail(fit_.state_count()) = solution.x.tail(fit_.state_count());
  return p;
}

CircuitModel CircuitCost::model_of(const Eigen::VectorXd& p) const {
  CircuitModel model;
  model.em = p.head(em_);
  model.r = p.segment(em_, first_tau_ - em_).array().exp().reshaped(r_, branches_ + 1);
  model.tau = p.segment(first_tau_, first_state_ - first_tau_).array().exp().reshaped(r_, branches_);
  return model;
}

void CircuitCost::evaluate(const double* p, double* residuals, double* jacobian) const {
  if (jacobian != nullptr) std::fill(jacobian, jacobian + residual_count() * parameters_, 0.0);
  data_residuals(p, residuals, jacobian);
  prior_residuals(p, residuals + data_rows_, jacobian == nullptr ? nullptr : jacobian + data_rows_ * parameters_);
}

void CircuitCost::data_residuals(const double* p, double* residuals, double* jacobian) const {
  const SocGrid& grid = fit_.grid();
  const Eigen::VectorXd r = Eigen::Map<const Eigen::VectorXd>(p + em_, first_tau_ - em_).array().exp();
  const Eigen::VectorXd tau = Eigen::Map<const Eigen::VectorXd>(p + first_tau_, r_ * branches_).array().exp();
  std::vector<BranchTrack> tracks(static_cast<std::size_t>(branches_));
  Index out = 0, next_state = first_state_;
  for (const TestRun& run : fit_.runs()) {
    Index open_state = -1;
    for (Index row = 0; row < run.rows(); ++row) {
      const SocGrid::Place at = grid.find(run.soc(row));
      const double scale = run.resistance_scale(row);
      if (run.is_reset(row)) {
        open_state = run.at_rest_before[static_cast<std::size_t>(row)] ? -1 : next_state;
        if (open_state >= 0) next_state += branches_;
      }
      const SocGrid::Place middle = row > 0 ? grid.find(0.5 * (run.soc(row) + run.soc(row - 1))) : at;
      const SocGrid::Place was = row > 0 ? grid.find(run.soc(row - 1)) : at;
      for (Index k = 0; k < branches_; ++k) {
        BranchTrack& track = tracks[static_cast<std::size_t>(k)];
        const double* rk = r.data() + (k + 1) * r_;
        const double u_now = scale * (rk[at.node] + at.fraction * (rk[at.node + 1] - rk[at.node]));
        if (run.is_reset(row)) {
          track = {open_state >= 0 ? p[open_state + k] : 0.0, u_now, 1.0, Eigen::VectorXd::Zero(r_),
                   Eigen::VectorXd::Zero(r_)};
          continue;
        }
        const double* tk = tau.data() + k * r_;
        const double t = tk[middle.node] + middle.fraction * (tk[middle.node + 1] - tk[middle.node]);
        const IntervalResponse w = interval_response(run.dt_s(row), t);
        const double begin = run.current_begin_a(row), end = run.current_end_a(row);
        if (jacobian != nullptr) {
          track.by_r *= w.a;
          const double earlier = w.g0 * begin * run.resistance_scale(row - 1), later = w.g1 * end * scale;
          track.by_r(was.node) += earlier * (1.0 - was.fraction) * rk[was.node];
          track.by_r(was.node + 1) += earlier * was.fraction * rk[was.node + 1];
          track.by_r(at.node) += later * (1.0 - at.fraction) * rk[at.node];
          track.by_r(at.node + 1) += later * at.fraction * rk[at.node + 1];
          const double by_t = w.da * track.v + w.dg0 * track.u_before * begin + w.dg1 * u_now * end;
          track.by_tau *= w.a;
          track.by_tau(middle.node) += by_t * (1.0 - middle.fraction) * tk[middle.node];
          track.by_tau(middle.node + 1) += by_t * middle.fraction * tk[middle.node + 1];
          track.decay *= w.a;
        }
        track.v = w.a * track.v + w.g0 * track.u_before * begin + w.g1 * u_now * end;
        track.u_before = u_now;
      }
      if (run.weight_s(row) <= 0.0) continue;
      const double root = std::sqrt(run.weight_s(row)), i = scale * run.current_a(row);
      const SocGrid::Place e = fit_.ocv().find(run.soc(row));
      const double r0 = r(at.node) + at.fraction * (r(at.node + 1) - r(at.node));
      double v = p[e.node] + e.fraction * (p[e.node + 1] - p[e.node]) - r0 * i;
      for (const BranchTrack& track : tracks) v -= track.v;
      residuals[out] = root * (v - run.voltage_v(row));
      if (jacobian != nullptr) {
        double* line = jacobian + out * parameters_;
        line[e.node] = root * (1.0 - e.fraction);
        line[e.node + 1] = root * e.fraction;
        line[em_ + at.node] = -root * i * (1.0 - at.fraction) * r(at.node);
        line[em_ + at.node + 1] = -root * i * at.fraction * r(at.node + 1);
        for (Index k = 0; k < branches_; ++k) {
          const BranchTrack& track = tracks[static_cast<std::size_t>(k)];
          Eigen::Map<Eigen::VectorXd>(line + em_ + (k + 1) * r_, r_) = -root * track.by_r;
          Eigen::Map<Eigen::VectorXd>(line + first_tau_ + k * r_, r_) = -root * track.by_tau;
          if (open_state >= 0) line[open_state + k] = -root * track.decay;
        }
      }
      ++out;
    }
  }
}

void CircuitCost::prior_residuals(const double* p, double* residuals, double* jacobian) const {
  const FitPriors& prior = fit_.priors();
  Index out = 0;
  const auto put = [&](Index row, Index column, double derivative) {
    if (jacobian != nullptr) jacobian[row * parameters_ + column] = derivative;
  };
  const Eigen::Map<const Eigen::VectorXd> all(p, parameters_);
  const double m = kScale / prior.em_roughness_v, c = kScale / (prior.smoothness * prior.resistance_scale),
               l = kScale / (prior.smoothness * prior.log_tau_roughness), noise = std::sqrt(prior.noise_v2_s);
  for (Index row = 0; row < em_rough_.rows(); ++row, ++out) {
    residuals[out] = m * em_rough_.row(row).dot(all.head(em_));
    for (Index k = row; k < row + 3; ++k) put(out, k, m * em_rough_(row, k));
  }
  for (Index table = 0; table < 2 * branches_ + 1; ++table) {
    const bool is_tau = table > branches_;
    const Index first = em_ + table * r_;
    const Eigen::VectorXd y =
        is_tau ? Eigen::VectorXd(all.segment(first, r_)) : Eigen::VectorXd(all.segment(first, r_).array().exp());
    for (Index row = 0; row < r_rough_.rows(); ++row, ++out) {
      residuals[out] = (is_tau ? l : c) * r_rough_.row(row).dot(y);
      for (Index k = row; k < row + 3; ++k) put(out, first + k, (is_tau ? l : c * y(k)) * r_rough_(row, k));
    }
  }
  for (Index k = 0; k < branches_; ++k) {
    for (Index node = 0; node < r_; ++node, ++out) {
      residuals[out] = noise / kLogTauSigma * (p[first_tau_ + k * r_ + node] - log_centre_(k));
      put(out, first_tau_ + k * r_ + node, noise / kLogTauSigma);
    }
  }
  for (const OcvKnowledge& known : prior.ocv) {
    const SocGrid::Place e = fit_.ocv().find(known.soc);
    const double weight = noise / known.sigma_v;
    residuals[out] = weight * (p[e.node] + e.fraction * (p[e.node + 1] - p[e.node]) - known.voltage_v);
    put(out, e.node, weight * (1.0 - e.fraction));
    put(out, e.node + 1, weight * e.fraction);
    ++out;
  }
  for (Index k = first_state_; k < parameters_; ++k, ++out) {
    residuals[out] = noise / prior.state_sigma_v * p[k];
    put(out, k, noise / prior.state_sigma_v);
  }
}

namespace {

/// All residuals as one block, so that a run is simulated once an evaluation.
class CeresCost final : public ceres::CostFunction {
 public:
  explicit CeresCost(const CircuitCost& cost) : cost_(cost) {
    set_num_residuals(static_cast<int>(cost.residual_count()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(cost.parameter_count()));
  }
  bool Evaluate(double const* const* p, double* residuals, double** jacobians) const override {
    cost_.evaluate(p[0], residuals, jacobians == nullptr ? nullptr : jacobians[0]);
    return Eigen::Map<const Eigen::VectorXd>(residuals, num_residuals()).allFinite();
  }

 private:
  const CircuitCost& cost_;
};

}  // namespace

RefineResult refine(const CircuitCost& cost, const Eigen::VectorXd& start, int iterations_max) {
  RefineResult out{start};
  ceres::Problem problem;
  problem.AddResidualBlock(new CeresCost(cost), nullptr, out.p.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = iterations_max;
  options.function_tolerance = 1e-5;
  options.parameter_tolerance = 1e-7;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  out.cost = summary.final_cost;
  out.iterations = static_cast<int>(summary.iterations.size()) - 1;
  out.converged = summary.termination_type == ceres::CONVERGENCE;
  return out;
}

}  // namespace voltlap::plant
