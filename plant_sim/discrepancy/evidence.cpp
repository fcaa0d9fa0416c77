// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPriorOfOne = 40.0;      // causes that could be it
constexpr double kAnonymousPenalty = 1.0; // a shape without a name is less likely than a known cause
constexpr double kImpossible = -1e300;    // evidence of a set whose parameter has a sign that it cannot have
constexpr double kErrors = 20.0;          // standard errors: what can be told small is not unlikely for being small
constexpr Index kMost = 24;               // columns of a set
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;

/// What of a set's evidence does not depend on the score.
struct SetForm {
  std::vector<Index> rows;
  std::vector<int> signs;
  Small inverse;
  double constant = 0.0;
};

bool compatible(const Candidate& a, const Candidate& b) { return a.cause < 0 || a.cause != b.cause; }

double log_prior(const Candidate& c) {
  return -std::log(kPriorOfOne * c.trials) - (c.cause < 0 ? kAnonymousPenalty : 0.0);
}

bool form_of(const System& system, const std::size_t* members, std::size_t count, SetForm& out) {
  out.rows.clear();
  out.signs.clear();
  out.constant = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const Candidate& c = system.candidates[members[k]];
    out.rows.insert(out.rows.end(), c.rows.begin(), c.rows.end());
    out.signs.insert(out.signs.end(), c.signs.begin(), c.signs.end());
    out.signs.resize(out.rows.size(), 0);
    out.constant += log_prior(c);
  }
  const auto n = static_cast<Index>(out.rows.size());
  if (n > kMost) return false;
  Small a(n, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      a(i, j) = system.information(out.rows[static_cast<std::size_t>(i)], out.rows[static_cast<std::size_t>(j)]);
    }
    const double typical = system.prior_variance(out.rows[static_cast<std::size_t>(i)]);
    const double variance = a(i, i) * typical > kErrors * kErrors ? kErrors * kErrors / a(i, i) : typical;
    a(i, i) += 1.0 / variance;
    out.constant -= 0.5 * std::log(variance);
  }
  const Eigen::LLT<Small> factor(a);
  if (factor.info() != Eigen::Success) return false;
  for (Index i = 0; i < n; ++i) out.constant -= std::log(factor.matrixLLT()(i, i));
  out.inverse = factor.solve(Small::Identity(n, n));
  return true;
}

double evidence_of(const SetForm& form, const VectorXd& score) {
  const auto n = static_cast<Index>(form.rows.size());
  double sum = 0.0;
  for (Index i = 0; i < n; ++i) {
    double row = 0.0;
    for (Index j = 0; j < n; ++j) row += form.inverse(i, j) * score(form.rows[static_cast<std::size_t>(j)]);
    if (row * form.signs[static_cast<std::size_t>(i)] < 0.0) return kImpossible;
    sum += row * score(form.rows[static_cast<std::size_t>(i)]);
  }
  return 0.5 * sum + form.constant;
}

/// Does the set fit this score with effects that the residual has room for?
bool possible(const System& system, const SetForm& form) {
  const auto n = static_cast<Index>(form.rows.size());
  SmallVector size = SmallVector::Zero(n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) size(i) += form.inverse(i, j) * system.score(form.rows[static_cast<std::size_t>(j)]);
  }
  return std::all_of(system.bounds.begin(), system.bounds.end(), [&](const Bound& bound) {
    double energy = 0.0;
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        energy += size(i) * size(j) *
                  bound.gram(form.rows[static_cast<std::size_t>(i)], form.rows[static_cast<std::size_t>(j)]);
      }
    }
    return energy <= bound.most;
  });
}

template <class Use>
void for_each_set(const System& system, std::size_t largest, const Use& use) {
  const std::size_t n = system.candidates.size();
  std::size_t set[3];
  for (set[0] = 0; set[0] < n; ++set[0]) {
    use(set, std::size_t{1});
    for (set[1] = set[0] + 1; largest > 1 && set[1] < n; ++set[1]) {
      if (!compatible(system.candidates[set[0]], system.candidates[set[1]])) continue;
      use(set, std::size_t{2});
      if (system.candidates[set[0]].cause < 0 && system.candidates[set[1]].cause < 0) continue;
      for (set[2] = set[1] + 1; largest > 2 && set[2] < n; ++set[2]) {
        if (compatible(system.candidates[set[0]], system.candidates[set[2]]) &&
            compatible(system.candidates[set[1]], system.candidates[set[2]])) {
          use(set, std::size_t{3});
        }
      }
    }
  }
}

/// Chance of `count` or fewer events where this many are expected (Poisson).
double at_most(int count, double expected) {
  double term = std::exp(-expected), sum = 0.0;
  for (int k = 0; k <= count; ++k) {
    sum += term;
    term *= expected / (k + 1);
  }
  return sum;
}

MatrixXd block(const MatrixXd& from, const std::vector<Index>& rows, const std::vector<Index>& columns) {
  MatrixXd out(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  for (Index i = 0; i < out.rows(); ++i) {
    for (Index j = 0; j < out.cols(); ++j) {
      out(i, j) = from(rows[static_cast<std::size_t>(i)], columns[static_cast<std::size_t>(j)]);
    }
  }
  return out;
}

}  // namespace

std::vector<WeighedSet> weigh_sets(const System& system, std::size_t keep) {
  std::vector<WeighedSet> out;
  SetForm form;
  double worst_kept = -1e300;
  for_each_set(system, 3, [&](const std::size_t* set, std::size_t count) {
    if (!form_of(system, set, count, form)) return;
    const double evidence = evidence_of(form, system.score);
    if (evidence == kImpossible || (count > 1 && evidence < worst_kept) || !possible(system, form)) return;
    WeighedSet made{{set, set + count}, evidence, true};
    for (const std::size_t m : made.members) made.named = made.named && system.candidates[m].cause >= 0;
    out.push_back(std::move(made));
    if (out.size() > 4 * keep) {
      std::nth_element(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(keep), out.end(),
                       [](const WeighedSet& a, const WeighedSet& b) { return a.evidence > b.evidence; });
      worst_kept = out[keep].evidence;
      std::erase_if(out, [&](const WeighedSet& s) { return s.members.size() > 1 && s.evidence < worst_kept; });
    }
  });
  std::sort(out.begin(), out.end(), [](const WeighedSet& a, const WeighedSet& b) { return a.evidence > b.evidence; });
  return out;
}

std::optional<double> evidence_of_set(const System& system, const std::vector<std::size_t>& members) {
  SetForm form;
  if (!form_of(system, members.data(), members.size(), form)) return std::nullopt;
  const double evidence = evidence_of(form, system.score);
  if (evidence == kImpossible || !possible(system, form)) return std::nullopt;
  return evidence;
}

double best_evidence(const System& system) {
  double best = 0.0;
  SetForm form;
  for_each_set(system, 2, [&](const std::size_t* set, std::size_t count) {
    if (!form_of(system, set, count, form)) return;
    const double evidence = evidence_of(form, system.score);
    if (evidence > best && possible(system, form)) best = evidence;
  });
  return best;
}

System tempered(const System& system, double usual_evidence, double signature_error) {
  constexpr double kDecides = 2.995732;      // ln 20
  double best = -1e300, gain = 0.0;
  SetForm form;
  for_each_set(system, 2, [&](const std::size_t* set, std::size_t count) {
    if (!form_of(system, set, count, form)) return;
    const double evidence = evidence_of(form, system.score);
    if (evidence == kImpossible || evidence <= best) return;
    best = evidence;
    gain = 2.0 * (evidence - form.constant);
  });
  return scaled(system, 1.0 / (1.0 + signature_error * gain + usual_evidence / kDecides));
}

System scaled(System system, double factor) {
  system.information *= factor;
  system.score *= factor;
  return system;
}

std::vector<Index> rows_of(const System& system, const std::vector<std::size_t>& members) {
  std::vector<Index> rows;
  for (const std::size_t m : members) {
    rows.insert(rows.end(), system.candidates[m].rows.begin(), system.candidates[m].rows.end());
  }
  return rows;
}

SetFit fit_set(const System& system, const std::vector<std::size_t>& members) {
  const std::vector<Index> rows = rows_of(system, members);
  MatrixXd a = block(system.information, rows, rows);
  VectorXd s(a.rows());
  for (Index i = 0; i < s.size(); ++i) s(i) = system.score(rows[static_cast<std::size_t>(i)]);
  a.diagonal().array() += 1e-6;
  const auto factor = a.ldlt();
  SetFit out{factor.solve(s), factor.solve(MatrixXd::Identity(a.rows(), a.cols())), 0.0};
  out.gain = s.dot(out.coefficients);
  return out;
}

VectorXd sizes_of_all(const System& system, const std::vector<std::size_t>& members, const VectorXd& coefficients) {
  VectorXd out = VectorXd::Zero(system.score.size());
  out(rows_of(system, members)) = coefficients;
  return out;
}

double null_probability(const System& system, double evidence, double freedom, int draws, std::uint64_t seed,
                        double level) {
  constexpr double kUnsure = 0.005;
  constexpr int kLookEvery = 20;
  std::vector<SetForm> forms;
  for_each_set(system, 2, [&](const std::size_t* set, std::size_t count) {
    SetForm form;
    if (form_of(system, set, count, form)) forms.push_back(std::move(form));
  });
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(system.information);
  const MatrixXd root = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::chi_squared_distribution<double> spread(freedom);
  int reached = 0, drawn = 0;
  while (drawn < draws) {
    VectorXd z(system.score.size());
    for (double& v : z) v = normal(random);
    const VectorXd score = root * z * std::sqrt(freedom / spread(random));
    const bool any = std::any_of(forms.begin(), forms.end(),
                                 [&](const SetForm& form) { return evidence_of(form, score) >= evidence; });
    reached += any ? 1 : 0;
    ++drawn;
    if (level <= 0.0 || drawn % kLookEvery != 0) continue;
    const double expected = level * drawn;
    if (at_most(reached, expected) < kUnsure || 1.0 - at_most(reached - 1, expected) < kUnsure) break;
  }
  return (1.0 + reached) / (1.0 + drawn);
}

double overlap(const System& system, const std::vector<std::size_t>& of, const VectorXd& coefficients,
               const std::vector<std::size_t>& by) {
  const std::vector<Index> rows = rows_of(system, of), others = rows_of(system, by);
  const double whole = coefficients.dot(block(system.information, rows, rows) * coefficients);
  if (whole <= 0.0) return 0.0;
  MatrixXd a = block(system.information, others, others);
  a.diagonal().array() += 1e-6;
  const VectorXd shared = block(system.information, others, rows) * coefficients;
  return std::clamp(shared.dot(a.ldlt().solve(shared)) / whole, 0.0, 1.0);
}

}  // namespace voltlap::plant
