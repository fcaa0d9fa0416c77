// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/stage_methods.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Free = Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>;

constexpr std::array kNames{"ipo", "fpo", "ilo", "flo", "ffo"};

/// One local problem: rows, nodes, and what the branches carry at its beginning.
struct Local {
  Index first, last;
  NodeTable table;
  Eigen::Vector2d before_v = Eigen::Vector2d::Zero();
};

/// A run with its sections, and what has been done to it.
class Stages {
 public:
  Stages(const MeasuredRun& whole, const MeasuredRun& fitted)
      : whole_(whole), fitted_(fitted), sections_(pulse_sections(fitted)) {}

  void initial_pulse();
  void final_pulse();
  /// Averages what two pulses say of one SOC.
  void average();
  void layered(bool all_free);
  [[nodiscard]] StageFit result() const;

 private:
  [[nodiscard]] NodeTable estimated(const PulseSection& section) const;
  void fit(Local& local, const Free& free);
  [[nodiscard]] Eigen::Vector2d after(const Local& local, Index last) const;
  [[nodiscard]] Local layer(Index node) const;
  void score();

  const MeasuredRun& whole_;
  const MeasuredRun& fitted_;
  std::vector<PulseSection> sections_;
  std::vector<Local> locals_;
  NodeTable nodes_;
  std::vector<SectionScore> scores_;
  int iterations_ = 0;
};

/// Em from the rests at both ends, R0 from the steps nearest to them, time constants from the relaxation.
NodeTable Stages::estimated(const PulseSection& section) const {
  NodeTable out{{section.soc_before, section.soc_after}, Eigen::MatrixXd::Zero(2, kParameterColumns)};
  out.values(0, kEm) = fitted_.voltage_v(section.first);
  out.values(1, kEm) = fitted_.voltage_v(section.last - 1);
  std::vector<StepEstimate> steps = resistance_steps(part_of(fitted_, section.first, section.last));
  if (steps.empty()) steps = resistance_steps(fitted_);
  for (Index end = 0; end < 2; ++end) {
    const double at = out.soc[static_cast<std::size_t>(end)];
    const auto nearest = std::min_element(steps.begin(), steps.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.soc - at) < std::abs(b.soc - at);
    });
    // Starts of R1 and R2 by the study's Table 6.1, as shares of its R0 of 1.4 mOhm.
    out.values(end, kLnR0) = std::log(nearest->resistance_ohm);
    out.values(end, kLnR1) = std::log(0.3 * nearest->resistance_ohm);
    out.values(end, kLnR2) = std::log(0.6 * nearest->resistance_ohm);
  }
  const Eigen::Vector2d taus = relaxation_taus(fitted_, section.load_end, section.last);
  out.values.rightCols(2) = taus.array().log().matrix().transpose().replicate(2, 1);
  return out;
}

void Stages::fit(Local& local, const Free& free) {
  SectionFit done = fit_section(part_of(fitted_, local.first, local.last), local.table, free, local.before_v);
  local.table = std::move(done.table);
  iterations_ += done.iterations;
}

/// Branch voltages at row `last` of a local problem.
Eigen::Vector2d Stages::after(const Local& local, Index last) const {
  Eigen::VectorXd states;
  (void)simulate(local.table.model(), part_of(fitted_, local.first, last + 1), local.before_v, &states);
  return states;
}

void Stages::initial_pulse() {
  Free free = Free::Constant(2, kParameterColumns, false);
  free.middleCols(kLnR1, 2) = true;
  for (const PulseSection& section : sections_) {
    locals_.push_back({section.first, section.last, estimated(section)});
    fit(locals_.back(), free);
  }
  score();
}

void Stages::final_pulse() {
  const Free free = Free::Constant(2, kParameterColumns, true);
  for (std::size_t k = 0; k < locals_.size(); ++k) {
    if (k > 0) locals_[k].before_v = after(locals_[k - 1], locals_[k].first);
    fit(locals_[k], free);
  }
  score();
}

void Stages::average() {
  VOLTLAP_DEMAND(!locals_.empty());
  const auto count = static_cast<Index>(locals_.size());
  nodes_ = {{locals_.front().table.soc[0]}, Eigen::MatrixXd(count + 1, kParameterColumns)};
  for (const Local& local : locals_) nodes_.soc.push_back(local.table.soc[1]);
  nodes_.values.row(0) = locals_.front().table.values.row(0);
  nodes_.values.row(count) = locals_.back().table.values.row(1);
  for (Index k = 1; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const auto before = locals_[at - 1].table.values.row(1), after = locals_[at].table.values.row(0);
    nodes_.values(k, kEm) = 0.5 * (before(kEm) + after(kEm));
    for (Index column = kLnR0; column < kParameterColumns; ++column)
      nodes_.values(k, column) = std::log(0.5 * (std::exp(before(column)) + std::exp(after(column))));
  }
}

/// From the onset of the pulse before a node to the end of the load after it, where the study's own choice is free.
Local Stages::layer(Index node) const {
  const auto count = static_cast<Index>(sections_.size());
  const Index low = std::max<Index>(0, node - 1), high = std::min(count, node + 1);
  Local out;
  out.first = node == 0 ? 0 : sections_[static_cast<std::size_t>(node - 1)].first;
  out.last = node == count ? sections_.back().last : sections_[static_cast<std::size_t>(node)].load_end;
  out.table = {{nodes_.soc.begin() + low, nodes_.soc.begin() + high + 1},
               nodes_.values.middleRows(low, high - low + 1)};
  return out;
}

void Stages::layered(bool all_free) {
  const auto count = static_cast<Index>(sections_.size());
  VOLTLAP_DEMAND(nodes_.values.rows() == count + 1);
  locals_.clear();
  for (Index node = 0; node <= count; ++node) {
    Local local = layer(node);
    if (node > 0) local.before_v = after(locals_.back(), local.first);
    const Index own = node == 0 ? 0 : 1;
    Free free = Free::Constant(local.table.values.rows(), kParameterColumns, false);
    free.row(own).tail(all_free ? kParameterColumns : kParameterColumns - kLnR1) = true;
    fit(local, free);
    nodes_.values.row(node) = local.table.values.row(own);
    locals_.push_back(std::move(local));
  }
  score();
}

void Stages::score() {
  scores_.clear();
  const double* times = whole_.time_s.data();
  const auto row_of = [&](double time) {
    return static_cast<Index>(std::lower_bound(times, times + whole_.rows(), time) - times);
  };
  for (const Local& local : locals_) {
    const Index first = row_of(fitted_.time_s(local.first)), last = row_of(fitted_.time_s(local.last - 1)) + 1;
    const MeasuredRun part = part_of(whole_, first, last);
    scores_.push_back(score_of(part, simulate(local.table.model(), part, local.before_v)));
  }
}

StageFit Stages::result() const {
  return {nodes_.on_breakpoints(), scores_, iterations_};
}

}  // namespace

const char* name_of(Method method) {
  return kNames[static_cast<std::size_t>(method)];
}

std::optional<Method> method_of(const std::string& name) {
  for (const Method method : kMethods) {
    if (name == name_of(method)) return method;
  }
  return std::nullopt;
}

SectionScore score_of(const MeasuredRun& part, const Eigen::VectorXd& voltage_v) {
  VOLTLAP_DEMAND(part.rows() > 0 && voltage_v.size() == part.rows());
  const double seconds = part.weight_s.sum();
  const double square = part.weight_s.dot((voltage_v - part.voltage_v).cwiseAbs2()) / seconds;
  return {square, part.weight_s.dot(part.voltage_v) / seconds / std::sqrt(square)};
}

StageFit stage_fit(const MeasuredRun& whole, const MeasuredRun& fitted, Method method) {
  VOLTLAP_DEMAND(whole.rows() >= fitted.rows() && method != Method::kFinalFull);
  Stages stages(whole, fitted);
  stages.initial_pulse();
  if (method >= Method::kFinalPulse) stages.final_pulse();
  stages.average();
  if (method >= Method::kInitialLayered) stages.layered(false);
  if (method >= Method::kFinalLayered) stages.layered(true);
  return stages.result();
}

double noise_floor(const MeasuredRun& whole) {
  double sum = 0.0, count = 0.0;
  for (const PulseSegment& s : segments(whole)) {
    if (s.kind != PulseSegment::Kind::kRest) continue;
    for (Index row = s.first + (s.last - s.first) / 2 + 1; row + 1 < s.last; ++row) {
      const bool usable = whole.weight_s.segment(row - 1, 3).minCoeff() > 0.0 && !whole.is_reset(row) &&
                          std::abs(whole.dt_s(row + 1) - whole.dt_s(row)) < 0.1 * whole.dt_s(row);
      if (!usable) continue;
      const double second = whole.voltage_v(row - 1) - 2.0 * whole.voltage_v(row) + whole.voltage_v(row + 1);
      sum += second * second / 6.0;  // variance of a second difference of white noise: 1 + 4 + 1
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace voltlap::plant
