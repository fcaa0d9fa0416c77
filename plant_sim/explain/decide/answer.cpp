// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/answer.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::explain {
namespace {

constexpr double kSameJob = 0.5;     // of what the best takes from the plain error, in the same channel
constexpr double kTells = 0.25;      // of a practical size: less does not tell two causes apart
constexpr double kSameClass = 0.98;  // overlap from which two sets look the same
constexpr std::size_t kRefined = 6;
constexpr std::size_t kShown = 8;

bool all_unlike(const Family& family, const Set& set, const Asked& asked) {
  for (const std::size_t m : set.members) {
    if (!unlike_of(family, set, m, asked.references, asked.alike).is) return false;
  }
  return true;
}

/// Decisively, and by more of the plain error than what models miss anyway: a likelihood of exact models would
/// decide by errors that nobody can see.
bool is_clearly_better(const Family& family, const Set& best, const Set& other) {
  return lead_of(best.fit, other.fit).decisive && use_of(family, best.fit, other.fit).practical > kTells;
}

/// What a set takes from one channel's plain squares.
double taken(const Fit& nothing, const Fit& fit, std::size_t channel) {
  const auto row = static_cast<Index>(channel);
  return nothing.left.row(row).sum() - fit.left.row(row).sum();
}

bool does_the_same(const Fit& nothing, const Set& best, const Set& set) {
  return taken(nothing, set.fit, best.use.channel) > kSameJob * taken(nothing, best.fit, best.use.channel);
}

/// Rows and columns of a channel's Gram matrix that belong to columns; -1 where it has none.
std::vector<Index> places(const ChannelGram& channel, const std::vector<Index>& columns) {
  std::vector<Index> out;
  for (const Index column : columns) {
    const auto found = std::lower_bound(channel.column.begin(), channel.column.end(), column);
    out.push_back(found != channel.column.end() && *found == column ? found - channel.column.begin() : -1);
  }
  return out;
}

/// Signatures are straight lines: beside one that bends a second cause may seem to be needed. Each set has to beat
/// its subsets where those bend as well.
void drop_needless(const Family& family, Search& search, const Refine& refine, std::vector<Set>& sets) {
  std::vector<Set> smaller;
  std::erase_if(sets, [&](const Set& set) {
    if (set.members.size() < 2) return false;
    for (std::size_t k = 0; k < set.members.size(); ++k) {
      std::vector<std::size_t> rest = set.members;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
      Set subset = refine(family, search.of(rest));
      if (is_worth_more(family, set, subset)) continue;
      smaller.push_back(std::move(subset));
      return true;
    }
    return false;
  });
  for (Set& set : smaller) {
    const bool there =
        std::any_of(sets.begin(), sets.end(), [&](const Set& s) { return s.members == set.members; });
    if (!there && set.stands) sets.push_back(std::move(set));
  }
}

/// A cause with another time constant is the same answer.
void drop_same_names(const Family& family, std::vector<Set>& sets) {
  std::vector<std::vector<std::string>> seen;
  std::erase_if(sets, [&](const Set& set) {
    std::vector<std::string> names;
    for (const std::size_t m : set.members)
      names.push_back(family.suspects[m].name + "/" + family.suspects[m].channel);
    std::sort(names.begin(), names.end());
    if (std::find(seen.begin(), seen.end(), names) != seen.end()) return true;
    seen.push_back(std::move(names));
    return false;
  });
}

}  // namespace

namespace {

/// Sets that differ in one cause, whose effect looks the same on this log, are one answer: a class.
void join_classes(const Family& family, AnswerOf& out) {
  const Set best = out.sets.front();
  out.equivalent.assign(best.members.size(), {});
  std::erase_if(out.sets, [&](const Set& set) {
    std::vector<std::size_t> only_best, only_set;
    std::set_difference(best.members.begin(), best.members.end(), set.members.begin(), set.members.end(),
                        std::back_inserter(only_best));
    std::set_difference(set.members.begin(), set.members.end(), best.members.begin(), best.members.end(),
                        std::back_inserter(only_set));
    if (only_best.size() != 1 || only_set.size() != 1 || overlap(family, best, set) < kSameClass) return false;
    const auto at = std::find(best.members.begin(), best.members.end(), only_best.front()) - best.members.begin();
    out.equivalent[static_cast<std::size_t>(at)].push_back(only_set.front());
    return true;
  });
}

}  // namespace

double overlap(const Family& family, const Set& a, const Set& b) {
  const std::size_t starts = family.problem.nuisances.size();
  std::vector<Index> columns = a.linear.columns;
  columns.insert(columns.end(), b.linear.columns.begin() + static_cast<std::ptrdiff_t>(starts),
                 b.linear.columns.end());
  const auto n = static_cast<Index>(columns.size());
  MatrixXd gram = MatrixXd::Zero(n, n);
  for (std::size_t c = 0; c < family.problem.channels.size(); ++c) {
    const ChannelGram& channel = family.problem.channels[c];
    const std::vector<Index> at = places(channel, columns);
    const MatrixXd& g = channel.all[a.linear.noise[c]].gram;
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        const Index x = at[static_cast<std::size_t>(i)], y = at[static_cast<std::size_t>(j)];
        if (x >= 0 && y >= 0) gram(i, j) += g(x, y) / a.linear.variance(static_cast<Index>(c));
      }
    }
  }
  const auto s = static_cast<Index>(starts);
  const MatrixXd nn = gram.topLeftCorner(s, s) + 1e-12 * gram.trace() * MatrixXd::Identity(s, s);
  const MatrixXd own = gram.bottomRightCorner(n - s, n - s) -
                       gram.bottomLeftCorner(n - s, s) * nn.ldlt().solve(gram.topRightCorner(s, n - s));
  VectorXd x = VectorXd::Zero(n - s), y = x;
  const Index of_a = a.linear.size.size() - s, of_b = b.linear.size.size() - s;
  x.head(of_a) = a.linear.size.tail(of_a);
  y.tail(of_b) = b.linear.size.tail(of_b);
  const double xx = x.dot(own * x), yy = y.dot(own * y);
  return xx > 0.0 && yy > 0.0 ? x.dot(own * y) / std::sqrt(xx * yy) : 0.0;
}

AnswerOf answer_of(const Family& family, Search& search, const Asked& asked, const Refine& refine) {
  AnswerOf out;
  out.family = &family;
  out.nothing = search.nothing();
  std::vector<Set> standing;
  for (const Set* set : search.ranked()) {
    if (!set->stands || standing.size() == kRefined || !all_unlike(family, *set, asked)) continue;
    Set followed = refine(family, *set);
    if (followed.stands) standing.push_back(std::move(followed));
  }
  drop_needless(family, search, refine, standing);
  for (const Set* set : search.ranked()) {
    if (out.beaten.size() < kShown && set->lead.ln > 0.0) out.beaten.push_back(*set);
  }
  if (standing.empty()) return out;
  std::stable_sort(standing.begin(), standing.end(),
                   [](const Set& a, const Set& b) { return a.lead.ln > b.lead.ln; });
  const Set best = standing.front();
  std::vector<Set> rivals{best};
  for (std::size_t k = 1; k < standing.size(); ++k) {
    if (!is_clearly_better(family, best, standing[k]) && does_the_same(out.nothing, best, standing[k])) {
      rivals.push_back(standing[k]);
    }
  }
  drop_same_names(family, rivals);
  std::size_t least = best.members.size();
  for (const Set& set : rivals) least = std::min(least, set.members.size());
  for (Set& set : rivals) {
    if (set.members.size() == least) out.sets.push_back(std::move(set));
  }
  join_classes(family, out);
  return out;
}

}  // namespace voltlap::explain
