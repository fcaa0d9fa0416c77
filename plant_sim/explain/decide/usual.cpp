// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/usual.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace voltlap::explain {
namespace {

constexpr double kFreedom = 8.0;  // of the prior of a spread
constexpr double kOfPractical =
    1.0 / 7;                       // of an effect that is worth a word: its spread where no reference tells it
constexpr double kOfError = 0.25;  // of what sound logs leave in the channel that shows it: that spread, then
constexpr double kChance = 1e-3;
constexpr double kLeastSlow = 0.2;  // of a practical size: slow noise that any log may have
constexpr double kAloneSlow = 2.0;  // where no reference tells it
constexpr double kMoreSlow = 1.5;   // than the noisiest reference

/// RMS [practical sizes] that this much of a column adds to a channel, beyond what nuisances can take.
double effect_in(const Family& family, std::size_t c, Index column, double size) {
  const ChannelGram& channel = family.problem.channels[c];
  const MatrixXd& gram = channel.all[0].gram;
  const auto place = [&](Index wanted) {
    const auto found = std::lower_bound(channel.column.begin(), channel.column.end(), wanted);
    return found != channel.column.end() && *found == wanted ? found - channel.column.begin() : Index{-1};
  };
  const Index own = place(column);
  if (own < 0) return 0.0;
  std::vector<Index> starts;
  std::vector<double> sigma;
  for (const Index n : family.problem.nuisances) {
    if (place(n) < 0) continue;
    starts.push_back(place(n));
    sigma.push_back(family.problem.prior_sigma(n));
  }
  const auto count = static_cast<Index>(starts.size());
  MatrixXd a(count, count);
  VectorXd b(count);
  for (Index i = 0; i < count; ++i) {
    b(i) = size * gram(own, starts[static_cast<std::size_t>(i)]);
    for (Index j = 0; j < count; ++j)
      a(i, j) = gram(starts[static_cast<std::size_t>(i)], starts[static_cast<std::size_t>(j)]);
  }
  const double least = family.problem.least_sigma[c] * family.problem.least_sigma[c];
  for (Index i = 0; i < count; ++i)
    a(i, i) += least / (sigma[static_cast<std::size_t>(i)] * sigma[static_cast<std::size_t>(i)]);
  const VectorXd x = bounded_starts(a, b, Eigen::Map<const VectorXd>(sigma.data(), count));
  const double left = size * size * gram(own, own) - 2.0 * b.dot(x) + x.dot(a * x);
  return std::sqrt(std::max(0.0, left) / std::max(1.0, channel.all[0].count)) / family.practical[c];
}

/// How much of a column adds a practical size to the channel that shows it best.
double practical_amount(const Family& family, Index column) {
  constexpr double kMost = 1e6;
  const auto shown = [&](double size) {
    double most = 0.0;
    for (std::size_t c = 0; c < family.problem.channels.size(); ++c)
      most = std::max(most, effect_in(family, c, column, size));
    return most;
  };
  double low = 1.0, high = 1.0;
  while (low > 1.0 / kMost && shown(low) > 1.0) low *= 0.5;
  while (high < kMost && shown(high) < 1.0) high *= 2.0;
  for (int round = 0; round < 12; ++round) {
    const double middle = std::sqrt(low * high);
    (shown(middle) < 1.0 ? low : high) = middle;
  }
  return high;
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
    const double unit = 1.0 / practical_amount(family, suspect.columns[k]);
    out.value = std::hypot(out.value, fit.size(at[k]) * unit);
    out.sigma = std::hypot(out.sigma, std::sqrt(fit.covariance(at[k], at[k])) * unit);
  }
  return out;
}

/// Where a cause has one number: what it is where its bend was followed. None of a set of which only the columns are
/// known.
std::optional<Size> followed_size(const Family& family, const Set& set, std::size_t member) {
  const Suspect& suspect = family.suspects[member];
  if (set.values.empty() || suspect.columns.size() != 1 || suspect.form.refined != suspect.form.linear)
    return std::nullopt;
  const auto at = static_cast<std::size_t>(std::find(set.members.begin(), set.members.end(), member) -
                                           set.members.begin());
  const std::size_t p = suspect.form.linear.front();
  const double unit = family.typical(suspect.columns.front());
  return Size{(set.values[at][p] - suspect.form.at[p]) / unit, set.sigma[at][p] / unit};
}

std::vector<Size> in_references(const Family& family, const Set& set, std::size_t member,
                                const std::vector<Sound>& references) {
  std::vector<Suspect> asked;
  for (const std::size_t m : set.members) asked.push_back(family.suspects[m]);
  std::vector<Size> out;
  for (const Sound& reference : references) {
    const Family& theirs = reference(asked);
    std::vector<Index> all;
    for (const Suspect& s : theirs.suspects) all.insert(all.end(), s.columns.begin(), s.columns.end());
    const auto own = std::find_if(theirs.suspects.begin(), theirs.suspects.end(),
                                  [&](const Suspect& s) { return is_same(s, family.suspects[member]); });
    if (own == theirs.suspects.end()) continue;
    out.push_back(size_of(theirs, fit_of(theirs.problem, all), *own));
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

std::map<std::string, SoundError> errors_of_sound(const std::vector<Sound>& references) {
  std::map<std::string, SoundError> out;
  for (const Sound& reference : references) {
    const Family& theirs = reference({});
    const Fit fit = fit_of(theirs.problem, {});
    for (std::size_t c = 0; c < theirs.channel.size(); ++c) {
      SoundError& error = out[theirs.channel[c]];
      // Steps of a load between two rows are no error of the model.
      const double apart = theirs.apart.empty() ? 0.0 : theirs.apart[c];
      const double own = std::sqrt(std::max(0.0, std::pow(error_in(theirs, fit, fit, c), 2) - apart * apart));
      error.most = std::max(error.most, own);
      error.usual = std::sqrt((error.usual * error.usual * error.logs + own * own) / (error.logs + 1.0));
      error.logs += 1.0;
    }
  }
  return out;
}

void bound_noise(Family& family, const std::vector<Sound>& references) {
  for (std::size_t c = 0; c < family.channel.size(); ++c) {
    // Steps of a thermistor leave slow errors that nothing bounds.
    if (references.empty() && family.channel[c] == "temperature") continue;
    double most = (references.empty() ? kAloneSlow : kLeastSlow) * family.practical[c];
    for (const Sound& reference : references) {
      const Family& theirs = reference({});
      const Fit fit = fit_of(theirs.problem, {});
      for (std::size_t r = 0; r < theirs.channel.size(); ++r) {
        if (theirs.channel[r] == family.channel[c])
          most = std::max(most, kMoreSlow * slow_noise(theirs.problem, fit, r));
      }
    }
    family.problem.most_slow[c] = most;
  }
}

Unlike unlike_of(const Family& family, const Set& set, std::size_t member, const Asked& asked) {
  const Suspect& suspect = family.suspects[member];
  const Size size = followed_size(family, set, member).value_or(size_of(family, set.linear, suspect));
  const double usual = kOfError * asked.error(family.channel[set.use.channel]).usual;
  const double least = std::max(kOfPractical, usual) *
                       (suspect.columns.size() == 1 ? practical_amount(family, suspect.columns[0]) : 1.0);
  const std::vector<Size> seen = in_references(family, set, member, asked.references);
  Unlike out;
  double weights = 1.0 / (least * least);  // of one reference that shows none
  for (const Size& s : seen) weights += 1.0 / (least * least + s.sigma * s.sigma);
  for (const Size& s : seen) out.habit.mean += s.value / (least * least + s.sigma * s.sigma) / weights;
  double square = kFreedom * least * least, freedom = kFreedom;
  for (const Size& s : seen) {
    // A reference that hardly moves what the cause acts on says little of it, and its own error is no habit.
    const double off = s.value - out.habit.mean, said = least * least / (least * least + s.sigma * s.sigma);
    square += std::max(said * off * off, off * off - s.sigma * s.sigma);
    freedom += said;
  }
  out.habit.references = static_cast<int>(seen.size());
  out.habit.spread = std::sqrt(square / freedom + 1.0 / weights);
  out.t = std::abs(size.value - out.habit.mean) / std::hypot(out.habit.spread, size.sigma);
  out.least = critical_t(kChance / asked.alike, freedom);
  out.is = out.t > out.least;
  return out;
}

}  // namespace voltlap::explain
