// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/search.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::explain {
namespace {

constexpr std::size_t kBestSingles = 12, kBestPairs = 6;  // that are grown
constexpr double kOfWhole = 0.2;     // of what a set takes from the error: a part worth a name of its own
constexpr double kCancelling = 2.5;  // effect of one cause over that of all together
constexpr int kSteps = 3;            // of Gauss-Newton
constexpr double kPractical = 0.8;   // of a practical size, as measured from a part of the log

/// A step may have left what is physically possible.
void hold_inside(const Family& family, const std::vector<plant::Cause>& causes, std::size_t member,
                 std::vector<double>& values) {
  const plant::Cause& cause = causes[static_cast<std::size_t>(family.suspects[member].cause)];
  for (std::size_t p = 0; p < values.size(); ++p) {
    values[p] = std::clamp(values[p], cause.parameters[p].low, cause.parameters[p].high);
  }
}

}  // namespace

std::vector<Index> columns_of(const Family& family, const std::vector<std::size_t>& members) {
  std::vector<Index> out;
  for (const std::size_t m : members) {
    out.insert(out.end(), family.suspects[m].columns.begin(), family.suspects[m].columns.end());
  }
  return out;
}

void put_values(const Family& family, const Fit& fit, const std::vector<std::vector<double>>& from,
                const std::vector<std::vector<std::size_t>>& parameters, Set& set) {
  set.values = from;
  set.sigma.clear();
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const Suspect& c = family.suspects[set.members[m]];
    set.sigma.emplace_back(from[m].size(), 0.0);
    for (std::size_t k = 0; k < c.columns.size(); ++k) {
      const auto at = std::find(fit.columns.begin(), fit.columns.end(), c.columns[k]) - fit.columns.begin();
      set.values[m][parameters[m][k]] += fit.size(at) * family.typical(c.columns[k]);
      set.sigma[m][parameters[m][k]] = std::sqrt(fit.covariance(at, at)) * family.typical(c.columns[k]);
    }
  }
}

Use use_of(const Family& family, const Fit& better, const Fit& worse) {
  Use out;
  for (std::size_t c = 0; c < family.problem.channels.size(); ++c) {
    const auto row = static_cast<Index>(c);
    const double count = family.problem.channels[c].all[0].count;
    const double gone = (worse.left.row(row).sum() - better.left.row(row).sum()) / std::max(1.0, count);
    const double size = gone > 0.0 ? std::sqrt(gone) / family.practical[c] : 0.0;
    if (size > out.practical) out = {size, c};
  }
  return out;
}

bool is_worth_more(const Family& family, const Set& set, const Set& subset) {
  const double least = std::max(kPractical, kOfWhole * set.use.practical);
  return lead_of(set.fit, subset.fit).decisive && use_of(family, set.fit, subset.fit).practical > least;
}

Search::Search(const Family& family, const std::vector<plant::Cause>& causes)
    : family_(family), causes_(causes), nothing_(fit_of(family.problem, {})) {
  for (std::size_t k = 0; k < family.suspects.size(); ++k) static_cast<void>(of({k}));
  grow(1, kBestSingles);
  grow(2, kBestPairs);
}

void Search::grow(std::size_t from_size, std::size_t best) {
  std::vector<std::vector<std::size_t>> seeds;
  for (const Set* set : ranked()) {
    if (set->members.size() == from_size && set->lead.ln > 0.0 && is_possible(*set)) seeds.push_back(set->members);
    if (seeds.size() == best) break;
  }
  for (const std::vector<std::size_t>& seed : seeds) {
    for (std::size_t k = 0; k < family_.suspects.size(); ++k) {
      std::vector<std::size_t> members = seed;
      members.push_back(k);
      std::sort(members.begin(), members.end());
      if (fits_together(members)) static_cast<void>(of(members));
    }
  }
}

bool Search::fits_together(const std::vector<std::size_t>& members) const {
  for (std::size_t a = 0; a < members.size(); ++a) {
    for (std::size_t b = a + 1; b < members.size(); ++b) {
      const Suspect &x = family_.suspects[members[a]], &y = family_.suspects[members[b]];
      if (x.cause == y.cause && x.channel == y.channel) return false;
    }
  }
  return true;
}

bool Search::is_possible(const Set& set) const {
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const Suspect& c = family_.suspects[set.members[m]];
    for (const std::size_t p : c.form.linear) {
      const plant::CauseParameter& range = causes_[static_cast<std::size_t>(c.cause)].parameters[p];
      if (set.values[m][p] < range.low || set.values[m][p] > range.high) return false;
    }
  }
  return true;
}

/// Do causes of the set undo each other? Then they follow, by their difference, a shape that none of them is.
bool Search::cancels(const Set& set) const {
  const auto starts = static_cast<Index>(family_.problem.nuisances.size());
  for (std::size_t c = 0; c < family_.problem.channels.size(); ++c) {
    const ChannelGram& channel = family_.problem.channels[c];
    VectorXd all = VectorXd::Zero(static_cast<Index>(channel.column.size()));
    std::vector<VectorXd> alone;
    Index at = starts;
    for (const std::size_t m : set.members) {
      VectorXd own = VectorXd::Zero(all.size());
      for (const Index column : family_.suspects[m].columns) {
        const auto found = std::lower_bound(channel.column.begin(), channel.column.end(), column);
        if (found != channel.column.end() && *found == column)
          own(found - channel.column.begin()) = set.linear.size(at);
        ++at;
      }
      all += own;
      alone.push_back(std::move(own));
    }
    const auto norm = [&](const VectorXd& x) {
      return std::sqrt(std::max(0.0, x.dot(channel.all[0].gram.topLeftCorner(x.size(), x.size()) * x)) /
                       channel.all[0].count);
    };
    const double together = std::max(norm(all), family_.practical[c]);
    for (const VectorXd& own : alone) {
      if (norm(own) > kCancelling * together) return true;
    }
  }
  return false;
}

const Set& Search::of(const std::vector<std::size_t>& members) {
  const auto found = sets_.find(members);
  if (found != sets_.end()) return found->second;
  Set made;
  made.members = members;
  made.linear = made.fit = fit_of(family_.problem, columns_of(family_, members));
  std::vector<std::vector<double>> from;
  std::vector<std::vector<std::size_t>> linear;
  for (const std::size_t m : members) {
    from.push_back(family_.suspects[m].form.at);
    linear.push_back(family_.suspects[m].form.linear);
  }
  put_values(family_, made.fit, from, linear, made);
  made.lead = lead_of(made.fit, nothing_);
  made.use = use_of(family_, made.fit, nothing_);
  judge(made);
  return sets_.emplace(members, std::move(made)).first->second;
}

void Search::judge(Set& set) {
  set.stands = set.lead.decisive && set.use.practical > kPractical && is_possible(set);
  if (set.members.size() < 2) return;
  for (std::size_t k = 0; set.stands && k < set.members.size(); ++k) {
    std::vector<std::size_t> rest = set.members;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
    const Set& smaller = of(rest);  // its reference stays: a map moves nothing
    set.stands = is_worth_more(family_, set, smaller);
  }
  if (set.stands) set.stands = !cancels(set);
}

Set refined(const Observed& log, const std::vector<plant::Cause>& causes, const Family& family, const Fit& nothing,
            const Set& set) {
  std::vector<std::vector<std::size_t>> parameters;
  for (const std::size_t m : set.members) {
    if (!family.suspects[m].form.apply) return set;  // a member's shapes are what they are
    parameters.push_back(family.suspects[m].form.refined);
  }
  Set out = set;
  for (int step = 0; step < kSteps; ++step) {
    for (std::size_t m = 0; m < set.members.size(); ++m) hold_inside(family, causes, set.members[m], out.values[m]);
    const Family there = at_values(log, causes, family, {set.members, out.values});
    out.fit = fit_of(there.problem, columns_of(there, set.members));
    put_values(there, out.fit, out.values, parameters, out);
    for (std::size_t m = 0; m < set.members.size(); ++m) hold_inside(family, causes, set.members[m], out.values[m]);
    out.lead = lead_of(out.fit, nothing);
    out.use = use_of(there, out.fit, nothing);
  }
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const plant::Cause& cause = causes[static_cast<std::size_t>(family.suspects[set.members[m]].cause)];
    for (const std::size_t p : parameters[m])
      out.stands = out.stands && plant::is_inside_prior(cause.parameters[p], out.values[m][p]);
  }
  out.stands = out.stands && out.lead.decisive;
  return out;
}

std::vector<const Set*> Search::ranked() const {
  std::vector<const Set*> out;
  for (const auto& [members, set] : sets_) out.push_back(&set);
  std::stable_sort(out.begin(), out.end(), [](const Set* a, const Set* b) { return a->lead.ln > b->lead.ln; });
  return out;
}

}  // namespace voltlap::explain
