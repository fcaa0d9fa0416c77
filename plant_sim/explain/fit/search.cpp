// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/search.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::explain {
namespace {

constexpr std::size_t kBestSingles = 12, kBestPairs = 6;  // that are grown
constexpr double kOfWhole = 0.2;     // of what a set takes from the error: a part worth a name of its own
constexpr double kCancelling = 2.5;  // effect of one cause over that of all together
constexpr double kReachOfMember = 2.0;  // of the range: one cell can be worse than all, and no bend of it is followed
constexpr double kLarge = 0.25;       // of the range: what a straight line says little of
constexpr double kOfError = 0.19;     // of the squares of the error in a channel: a tenth of its RMS
constexpr double kInstruments = 2.0;  // practical sizes, where no reference tells how true they are
constexpr double kPractical = 0.8;    // of a practical size, as measured from a part of the log

/// Is it something that an instrument within its class, or a table of many numbers, is wrong by anyway: gain and
/// offset of a sensor, a curve?
bool is_of_instruments(const Family& family, const std::vector<std::size_t>& members) {
  return std::all_of(members.begin(), members.end(), [&](std::size_t m) {
    const Suspect& suspect = family.suspects[m];
    return suspect.form.bend > 0.0 || suspect.name.ends_with("_gain") || suspect.name.ends_with("_offset");
  });
}

/// RMS of columns of these sizes in a channel.
double rms_of(const ChannelGram& channel, const VectorXd& sizes) {
  const MatrixXd& gram = channel.all[0].gram;
  return std::sqrt(std::max(0.0, sizes.dot(gram.topLeftCorner(sizes.size(), sizes.size()) * sizes)) /
                   channel.all[0].count);
}

/// What is asked of a use in a channel [practical sizes].
double asked_in(const Family& family, std::size_t channel) {
  return family.asked.empty() ? 1.0 : family.asked[channel];
}

}  // namespace

bool is_at_home(const std::vector<plant::Cause>& causes, const Family& family, const Set& set) {
  if (family.channel[set.use.channel] != "temperature") return true;
  return std::any_of(set.members.begin(), set.members.end(), [&](std::size_t m) {
    const plant::Balance balance = causes[static_cast<std::size_t>(family.suspects[m].cause)].balance;
    const std::string& name = family.suspects[m].name;
    return balance == plant::Balance::kHeat || name.starts_with("current_");
  });
}

double error_in(const Family& family, const Fit& fit, const Fit& noise, std::size_t channel) {
  const double count = std::max(1.0, family.problem.channels[channel].all[0].count);
  const double left =
      fit.left.row(static_cast<Index>(channel)).sum() / count - fast_variance(family.problem, noise, channel);
  return std::sqrt(std::max(0.0, left)) / family.practical[channel];
}

bool takes_enough(const Family& family, const Set& set, const Fit& nothing) {
  const Use& use = set.use;
  const double error = error_in(family, nothing, nothing, use.channel);
  return use.practical > kPractical && use.practical * use.practical > kOfError * error * error;
}

bool is_of_use(const Family& family, const Set& set) {
  if (family.asked.empty()) return true;
  const double asked = asked_in(family, set.use.channel);
  return set.use.practical >
         kPractical * (is_of_instruments(family, set.members) ? std::max(asked, kInstruments) : asked);
}

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

double use_in(const Family& family, std::size_t channel, const Fit& better, const Fit& worse) {
  const auto row = static_cast<Index>(channel);
  const double count = family.problem.channels[channel].all[0].count;
  const double gone = (worse.left.row(row).sum() - better.left.row(row).sum()) / std::max(1.0, count);
  return gone > 0.0 ? std::sqrt(gone) / family.practical[channel] : 0.0;
}

Use use_of(const Family& family, const Fit& better, const Fit& worse) {
  Use out;
  double most = 0.0;
  for (std::size_t c = 0; c < family.problem.channels.size(); ++c) {
    const double size = use_in(family, c, better, worse), of_asked = size / asked_in(family, c);
    if (of_asked > most) most = of_asked, out = {size, c};
  }
  return out;
}

bool is_worth_more(const Family& family, const Set& set, const Set& subset) {
  const Use more = use_of(family, set.fit, subset.fit);
  return lead_of(set.fit, subset.fit).decisive &&
         more.practical > std::max(kPractical * asked_in(family, more.channel), kOfWhole * set.use.practical);
}

Set better_part(const std::vector<Set>& all, const Set& whole, const Set& other) {
  for (const Set& part : all) {
    const bool is_part = part.members != whole.members && std::ranges::includes(whole.members, part.members);
    if (is_part && part.stands && part.members.size() <= other.members.size() && lead_of(part.fit, other.fit).decisive)
      return part;
  }
  return other;
}

Search::Search(const Family& family, const std::vector<plant::Cause>& causes)
    : family_(family), causes_(causes), nothing_(fit_of(family.problem, {})) {
  for (std::size_t k = 0; k < family.suspects.size(); ++k) static_cast<void>(of({k}));
  grow(1, kBestSingles);
  pair_identified();
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

/// What is identified together may be no better alone, for then its sum is wrong.
void Search::pair_identified() {
  std::vector<std::size_t> identified;
  for (std::size_t k = 0; k < family_.suspects.size(); ++k) {
    if (causes_[static_cast<std::size_t>(family_.suspects[k].cause)].is_identified) identified.push_back(k);
  }
  for (const std::size_t a : identified) {
    for (const std::size_t b : identified) {
      if (a < b && fits_together({a, b})) static_cast<void>(of({a, b}));
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
      const double reach = c.form.apply ? 1.0 : kReachOfMember;
      if (set.values[m][p] < reach * range.low || set.values[m][p] > reach * range.high) return false;
    }
  }
  return true;
}

/// Is a size so large a part of what can be that a straight line says little of what it takes? Two fifths of the
/// heat capacity warm as much as a straight line of -150 %.
bool Search::is_large(const Set& set) const {
  for (std::size_t m = 0; m < set.members.size(); ++m) {
    const Suspect& c = family_.suspects[set.members[m]];
    for (const std::size_t p : c.form.linear) {
      const plant::CauseParameter& range = causes_[static_cast<std::size_t>(c.cause)].parameters[p];
      if (set.values[m][p] < kLarge * range.low || set.values[m][p] > kLarge * range.high) return true;
    }
  }
  return false;
}

/// Sizes of each member's columns, as straight lines, by the columns of a channel.
std::vector<VectorXd> Search::effects_in(const Set& set, std::size_t channel) const {
  const std::vector<Index>& columns = family_.problem.channels[channel].column;
  std::vector<VectorXd> out;
  auto at = static_cast<Index>(family_.problem.nuisances.size());
  for (const std::size_t m : set.members) {
    VectorXd& own = out.emplace_back(VectorXd::Zero(static_cast<Index>(columns.size())));
    for (const Index column : family_.suspects[m].columns) {
      const auto found = std::lower_bound(columns.begin(), columns.end(), column);
      if (found != columns.end() && *found == column) own(found - columns.begin()) = set.linear.size(at);
      ++at;
    }
  }
  return out;
}

/// Is its effect of practical size where it was fitted? Where it acts for a minute alone, or begins at a charge that
/// the fit moves, the rest of the log foresees little of it before its bends are followed.
bool Search::is_seen(const Set& set) const {
  for (std::size_t c = 0; c < family_.problem.channels.size(); ++c) {
    const ChannelGram& channel = family_.problem.channels[c];
    const std::vector<VectorXd> effects = effects_in(set, c);
    VectorXd all = VectorXd::Zero(static_cast<Index>(channel.column.size()));
    for (const VectorXd& own : effects) all += own;
    if (rms_of(channel, all) > kPractical * family_.practical[c]) return true;
  }
  return false;
}

/// Do causes of the set undo each other? Then they follow, by their difference, a shape that none of them is. What
/// is identified together counts as one: its sum is right.
bool Search::cancels(const Set& set) const {
  for (std::size_t c = 0; c < family_.problem.channels.size(); ++c) {
    const ChannelGram& channel = family_.problem.channels[c];
    const std::vector<VectorXd> effects = effects_in(set, c);
    VectorXd all = VectorXd::Zero(static_cast<Index>(channel.column.size())), identified = all;
    std::vector<VectorXd> alone;
    for (std::size_t k = 0; k < effects.size(); ++k) {
      all += effects[k];
      if (causes_[static_cast<std::size_t>(family_.suspects[set.members[k]].cause)].is_identified) {
        identified += effects[k];
      } else {
        alone.push_back(effects[k]);
      }
    }
    alone.push_back(std::move(identified));
    const double together = std::max(rms_of(channel, all), family_.practical[c]);
    for (const VectorXd& own : alone) {
      if (rms_of(channel, own) > kCancelling * together) return true;
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
  const bool possible = is_possible(set);
  const bool takes = takes_enough(family_, set, nothing_);
  set.bends = set.members.size() == 1 &&
              (set.lead.decisive ? !possible || is_large(set) || (!takes && is_seen(set)) : takes);
  set.stands = set.lead.decisive && takes && is_at_home(causes_, family_, set) && possible;
  if (set.members.size() < 2) return;
  for (std::size_t k = 0; set.stands && k < set.members.size(); ++k) {
    std::vector<std::size_t> rest = set.members;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
    const Set& smaller = of(rest);  // its reference stays: a map moves nothing
    set.stands = is_worth_more(family_, set, smaller);
  }
  if (set.stands) set.stands = !cancels(set);
}

std::vector<const Set*> Search::ranked() const {
  std::vector<const Set*> out;
  for (const auto& [members, set] : sets_) out.push_back(&set);
  std::stable_sort(out.begin(), out.end(), [](const Set* a, const Set* b) { return a->lead.ln > b->lead.ln; });
  return out;
}

}  // namespace voltlap::explain
