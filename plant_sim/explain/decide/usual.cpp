// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/usual.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace voltlap::explain {
namespace {

constexpr double kFreedom = 8.0;  // of the prior of a spread
constexpr double kOfPractical =
    1.0 / 7;  // of an effect that is worth a word: its spread where no reference tells it
constexpr double kChance = 1e-3;

/// The suspect of another log's family.
std::optional<std::size_t> same_in(const Family& other, const Suspect& wanted) {
  for (std::size_t k = 0; k < other.suspects.size(); ++k) {
    const Suspect& c = other.suspects[k];
    if (c.cause == wanted.cause && c.number == wanted.number && (c.channel == wanted.channel || !c.form.apply))
      return k;
  }
  return std::nullopt;
}

/// RMS that one unit of a column adds, in practical sizes, where that is most; what nuisances take is no part of
/// it.
double effect_of_unit(const Family& family, Index column) {
  double most = 0.0;
  for (std::size_t c = 0; c < family.problem.channels.size(); ++c) {
    const ChannelGram& channel = family.problem.channels[c];
    const MatrixXd& gram = channel.all[0].gram;
    const auto place = [&](Index wanted) {
      const auto found = std::lower_bound(channel.column.begin(), channel.column.end(), wanted);
      return found != channel.column.end() && *found == wanted ? found - channel.column.begin() : Index{-1};
    };
    const Index own = place(column);
    if (own < 0) continue;
    std::vector<Index> starts;
    for (const Index n : family.problem.nuisances) {
      if (place(n) >= 0) starts.push_back(place(n));
    }
    const auto count = static_cast<Index>(starts.size());
    MatrixXd a(count, count);
    VectorXd b(count);
    for (Index i = 0; i < count; ++i) {
      b(i) = gram(own, starts[static_cast<std::size_t>(i)]);
      for (Index j = 0; j < count; ++j)
        a(i, j) = gram(starts[static_cast<std::size_t>(i)], starts[static_cast<std::size_t>(j)]);
    }
    const double taken = count > 0 ? b.dot(a.completeOrthogonalDecomposition().solve(b)) : 0.0;
    const double rms = std::sqrt(std::max(0.0, gram(own, own) - taken) / std::max(1.0, channel.all[0].count));
    most = std::max(most, rms / family.practical[c]);
  }
  return most;
}

/// Size of a member's columns as one number: its own where there is one, else what they add together in practical
/// sizes.
struct Size {
  double value = 0.0, sigma = 0.0;
};
Size size_of(const Family& family, const Fit& fit, const Suspect& suspect) {
  std::vector<Index> at;
  for (const Index column : suspect.columns) {
    at.push_back(std::find(fit.columns.begin(), fit.columns.end(), column) - fit.columns.begin());
  }
  if (at.size() == 1) return {fit.size(at[0]), std::sqrt(fit.covariance(at[0], at[0]))};
  Size out;
  for (std::size_t k = 0; k < at.size(); ++k) {
    const double unit = effect_of_unit(family, suspect.columns[k]);
    out.value = std::hypot(out.value, fit.size(at[k]) * unit);
    out.sigma = std::hypot(out.sigma, std::sqrt(fit.covariance(at[k], at[k])) * unit);
  }
  return out;
}

std::vector<double> in_references(const Family& family, const Set& set, std::size_t member,
                                  const std::vector<const Family*>& references) {
  std::vector<double> out;
  for (const Family* reference : references) {
    std::vector<std::size_t> members;
    for (const std::size_t m : set.members) {
      const auto same = same_in(*reference, family.suspects[m]);
      if (same) members.push_back(*same);
    }
    const auto own = same_in(*reference, family.suspects[member]);
    if (!own) continue;
    const Fit fit = fit_of(reference->problem, columns_of(*reference, members));
    out.push_back(size_of(*reference, fit, reference->suspects[*own]).value);
  }
  return out;
}

}  // namespace

double critical_t(double probability, double freedom) {
  // The tail of G. W. Hill, Comm. ACM 13, 1970, algorithm 396: within 0.3 % from 8 degrees of freedom and 1e-3 on.
  const double n = freedom;
  const double a = 1.0 / (n - 0.5), b = 48.0 / (a * a);
  const double c = ((20700.0 * a / b - 98.0) * a - 16.0) * a + 96.36;
  const double d = ((94.5 / (b + c) - 3.0) / b + 1.0) * std::sqrt(a * 1.5707963267948966) * n;
  double y = std::pow(d * probability, 2.0 / n);
  y = ((1.0 / (((n + 6.0) / (n * y) - 0.089 * d - 0.822) * (n + 2.0) * 3.0) + 0.5 / (n + 4.0)) * y - 1.0) *
          (n + 1.0) / (n + 2.0) +
      1.0 / y;
  return std::sqrt(n * y);
}

Unlike unlike_of(const Family& family, const Set& set, std::size_t member,
                 const std::vector<const Family*>& references, double alike) {
  const Suspect& suspect = family.suspects[member];
  const Size size = size_of(family, set.linear, suspect);
  const double unit = suspect.columns.size() == 1 ? effect_of_unit(family, suspect.columns[0]) : 1.0;
  const double least = kOfPractical / std::max(1e-12, unit);
  const std::vector<double> seen = in_references(family, set, member, references);
  const auto n = static_cast<double>(seen.size());
  Unlike out;
  for (const double s : seen) out.habit.mean += s / (n + 1.0);
  double square = kFreedom * least * least;
  for (const double s : seen) square += (s - out.habit.mean) * (s - out.habit.mean);
  out.habit.references = static_cast<int>(seen.size());
  out.habit.spread = std::sqrt(square / (kFreedom + n) * (1.0 + 1.0 / (n + 1.0)));
  out.t = std::abs(size.value - out.habit.mean) / std::hypot(out.habit.spread, size.sigma);
  out.least = critical_t(kChance / alike, kFreedom + n);
  out.is = out.t > out.least;
  return out;
}

}  // namespace voltlap::explain
