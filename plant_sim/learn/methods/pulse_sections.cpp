// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/pulse_sections.hpp"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Free = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

constexpr double kShortestRest = 60.0, kLeastSoc = 0.02;
constexpr std::size_t kFewest = 3;

[[noreturn]] void refuse(const MeasuredRun& run, const std::string& found) {
  throw InputError(run.name, found,
                   fmt::format("a test of at least {} pulses in one direction, each with a rest of {:.0f} s behind "
                               "it: the pulse and layered methods work section by section",
                               kFewest, kShortestRest),
                   "Leave out --method: the full fit needs no pulses");
}

/// The charge before a test, or behind it, is no part of it.
std::vector<PulseSection> longest_one_way(const std::vector<PulseSection>& sections) {
  std::vector<PulseSection> longest, current;
  for (const PulseSection& section : sections) {
    const auto way = [](const PulseSection& s) { return s.soc_after > s.soc_before; };
    if (!current.empty() && way(current.back()) != way(section)) current.clear();
    current.push_back(section);
    if (current.size() > longest.size()) longest = current;
  }
  return longest;
}

/// Residuals of a section over its free parameters.
class SectionCost {
 public:
  SectionCost(const MeasuredRun& part, const NodeTable& start, const Free& free, const Eigen::Vector2d& before_v)
      : part_(part), start_(start), before_v_(before_v) {
    for (Index column = 0; column < kParameterColumns; ++column) {
      for (Index node = 0; node < start.values.rows(); ++node) {
        if (free(node, column)) places_.push_back({node, column});
      }
    }
  }
  bool operator()(double const* const* p, double* residuals) const {
    const Eigen::VectorXd error = simulate(table_of(p[0]).model(), part_, before_v_) - part_.voltage_v;
    Eigen::Map<Eigen::VectorXd>(residuals, part_.rows()) = part_.weight_s.cwiseSqrt().cwiseProduct(error);
    return error.allFinite();
  }
  [[nodiscard]] NodeTable table_of(const double* p) const {
    NodeTable out = start_;
    for (const auto& [node, column] : places_) out.values(node, column) = *p++;
    return out;
  }
  [[nodiscard]] std::vector<double> start() const {
    std::vector<double> out;
    for (const auto& [node, column] : places_) out.push_back(start_.values(node, column));
    return out;
  }
  [[nodiscard]] Index column_of(std::size_t k) const { return places_[k].second; }

 private:
  const MeasuredRun& part_;
  NodeTable start_;
  Eigen::Vector2d before_v_;
  std::vector<std::pair<Index, Index>> places_;
};

/// Sum of squares of a relaxation's two exponentials for given time constants; v1 and v2 are the best.
double relaxation_error(const Eigen::VectorXd& t, const Eigen::VectorXd& y, const Eigen::VectorXd& w, double tau1,
                        double tau2) {
  const Eigen::ArrayXd a = (-t.array() / tau1).exp(), b = (-t.array() / tau2).exp();
  const auto dot = [&](const Eigen::ArrayXd& p, const Eigen::ArrayXd& q) { return (w.array() * p * q).sum(); };
  const double aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), ay = dot(a, y.array()), by = dot(b, y.array());
  const double det = std::max(aa * bb - ab * ab, 1e-12 * aa * bb);
  const double v1 = (bb * ay - ab * by) / det, v2 = (aa * by - ab * ay) / det;
  return (w.array() * (y.array() - v1 * a - v2 * b).square()).sum();
}

}  // namespace

std::vector<PulseSection> pulse_sections(const MeasuredRun& run) {
  std::vector<PulseSection> out;
  Index first = -1, load_end = -1;
  for (const PulseSegment& s : segments(run)) {
    if (s.kind != PulseSegment::Kind::kRest) {
      if (first < 0) first = std::max<Index>(0, s.first - 1);
      load_end = s.last;
      continue;
    }
    const bool moved = first >= 0 && std::abs(run.soc(s.last - 1) - run.soc(first)) >= kLeastSoc;
    if (!moved || s.duration_s < kShortestRest) continue;
    out.push_back({first, load_end, s.last, run.soc(first), run.soc(s.last - 1)});
    first = -1;
  }
  const std::vector<PulseSection> one_way = longest_one_way(out);
  if (one_way.size() < kFewest)
    refuse(run, fmt::format("{} pulses with rests, {} of them one after another in one direction", out.size(),
                            one_way.size()));
  return one_way;
}

MeasuredRun part_of(const MeasuredRun& run, Index first, Index last) {
  VOLTLAP_DEMAND(first >= 0 && first < last && last <= run.rows());
  MeasuredRun out;
  out.name = run.name;
  for (auto member : {&MeasuredRun::time_s, &MeasuredRun::current_a, &MeasuredRun::voltage_v, &MeasuredRun::soc,
                      &MeasuredRun::dt_s, &MeasuredRun::current_begin_a, &MeasuredRun::current_end_a,
                      &MeasuredRun::weight_s, &MeasuredRun::temperature_c}) {
    out.*member = (run.*member).segment(first, last - first);
  }
  out.reset.assign(run.reset.begin() + first, run.reset.begin() + last);
  out.at_rest_before.assign(run.at_rest_before.begin() + first, run.at_rest_before.begin() + last);
  out.reset[0] = true;
  out.at_rest_before[0] = false;
  return out;
}

CircuitModel NodeTable::model() const {
  VOLTLAP_DEMAND(soc.size() > 1 && values.rows() == static_cast<Index>(soc.size()));
  CircuitModel out;
  const bool falling = soc.front() > soc.back();
  const Eigen::MatrixXd rising = falling ? values.colwise().reverse() : values;
  std::vector<double> at = soc;
  if (falling) std::reverse(at.begin(), at.end());
  out.ocv = out.grid = SocGrid(std::move(at));
  out.em = rising.col(kEm);
  out.r = rising.middleCols(kLnR0, 3).array().exp();
  out.tau = rising.middleCols(kLnTau1, 2).array().exp();
  return out;
}

CircuitModel NodeTable::on_breakpoints() const {
  const CircuitModel nodes = model();
  CircuitModel out;
  out.em.resize(out.ocv.size());
  for (Index k = 0; k < out.ocv.size(); ++k) out.em(k) = nodes.ocv.value(nodes.em, out.ocv.at(k));
  const auto table = [&](const Eigen::MatrixXd& from) {
    Eigen::MatrixXd to(out.grid.size(), from.cols());
    for (Index column = 0; column < from.cols(); ++column) {
      for (Index k = 0; k < out.grid.size(); ++k)
        to(k, column) = nodes.grid.value(from.col(column), out.grid.at(k));
    }
    return to;
  };
  out.r = table(nodes.r);
  out.tau = table(nodes.tau);
  return out;
}

SectionFit fit_section(const MeasuredRun& part, const NodeTable& start, const Free& free,
                       const Eigen::Vector2d& before_v) {
  VOLTLAP_DEMAND(free.rows() == start.values.rows() && free.cols() == kParameterColumns && free.any());
  VOLTLAP_DEMAND(part.rows() > 1);
  constexpr double kShortest = 0.2, kLongest = 3.0;  // s; of the part: beyond it a branch is a drift of Em
  const double reach = std::log(1000.0), shortest = std::log(kShortest),
               longest = std::log(kLongest * (part.time_s(part.rows() - 1) - part.time_s(0)));
  auto* cost = new SectionCost(part, start, free, before_v);  // Ceres owns it
  std::vector<double> p = cost->start();
  auto* numeric = new ceres::DynamicNumericDiffCostFunction<SectionCost, ceres::CENTRAL>(cost);
  numeric->AddParameterBlock(static_cast<int>(p.size()));
  numeric->SetNumResiduals(static_cast<int>(part.rows()));
  ceres::Problem problem;
  problem.AddResidualBlock(numeric, nullptr, p.data());
  for (std::size_t k = 0; k < p.size(); ++k) {
    const auto index = static_cast<int>(k);
    const Index column = cost->column_of(k);
    if (column == kEm) continue;
    const bool is_tau = column >= kLnTau1;
    if (is_tau) p[k] = std::clamp(p[k], shortest + 1e-6, longest - 1e-6);
    problem.SetParameterLowerBound(p.data(), index, is_tau ? shortest : p[k] - reach);
    problem.SetParameterUpperBound(p.data(), index, is_tau ? longest : p[k] + reach);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 50;
  options.function_tolerance = 1e-5;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {cost->table_of(p.data()), static_cast<int>(summary.iterations.size()) - 1};
}

Eigen::Vector2d relaxation_taus(const MeasuredRun& run, Index first, Index last) {
  constexpr int kPoints = 12, kRounds = 3;
  constexpr double kApart = 1.5, kLongest = 2.0;  // tau2 over tau1; of the rest
  VOLTLAP_DEMAND(first >= 0 && first < last && last <= run.rows());
  const Index n = last - first;
  const Eigen::VectorXd t = run.time_s.segment(first, n).array() - run.time_s(first);
  const Eigen::VectorXd y = run.voltage_v(last - 1) - run.voltage_v.segment(first, n).array();
  const Eigen::VectorXd w = run.weight_s.segment(first, n);
  const double least = std::log(1.0), most = std::log(kLongest * std::max(10.0, t(n - 1)));
  Eigen::Vector2d best(0.3 * most, 0.8 * most);
  double width = 0.5 * (most - least), error = 1e300;
  Eigen::Vector2d centre(0.5 * (least + most), 0.5 * (least + most));
  for (int round = 0; round < kRounds; ++round, centre = best, width *= 2.0 / kPoints) {
    for (int i = -kPoints; i <= kPoints; ++i) {
      for (int k = -kPoints; k <= kPoints; ++k) {
        const double a = std::clamp(centre(0) + width * i / kPoints, least, most),
                     b = std::clamp(centre(1) + width * k / kPoints, least, most);
        if (b < a + std::log(kApart)) continue;
        const double at = relaxation_error(t, y, w, std::exp(a), std::exp(b));
        if (at >= error) continue;
        error = at;
        best = {a, b};
      }
    }
  }
  return best.array().exp();
}

}  // namespace voltlap::plant
