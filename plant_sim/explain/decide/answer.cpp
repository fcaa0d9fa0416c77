// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/answer.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace voltlap::explain {
namespace {

constexpr double kSameJob = 0.5;        // of what the best takes from the plain error, in the same channel
constexpr double kTells = 0.25;         // of a practical size: less does not tell two causes apart
constexpr double kTellsOfWhole = 0.03;  // of what the best takes: no signature is truer than that at any size
constexpr double kTellsOfSound = 0.25;  // of what sound logs leave
constexpr double kSameClass = 0.98;     // overlap from which two sets look the same
constexpr std::size_t kRefined = 6;     // sets of one cause that are followed for an answer, half as many of two
constexpr double kBent = 0.2;           // of what the best takes: what a bend may mend
constexpr double kNear = 0.7;  // of what the best takes: what a straight line is far behind with no bend mends
constexpr std::size_t kShown = 8;

/// Is the error that it takes larger than that of any sound log? Else it is one that the model always has. What
/// differs from reading to reading is that beside the set: a hypothesis without it may call all of the error noise.
bool is_beyond_sound(const Family& family, const Fit& nothing, const Set& set, const Asked& asked) {
  const SoundError sound = asked.error(family.channel[set.use.channel]);
  return error_in(family, nothing, set.fit, set.use.channel) > sound.most;
}

bool all_unlike(const Family& family, const Fit& nothing, const Set& set, const Asked& asked) {
  return is_of_use(family, set) && is_beyond_sound(family, nothing, set, asked) &&
         std::all_of(set.members.begin(), set.members.end(),
                     [&](std::size_t m) { return unlike_of(family, set, m, asked).is; });
}

bool is_clearly_better(const Family& family, const Set& best, const Set& other, const Asked& asked) {
  return is_clearly_better(family, best.fit, other.fit, best.use.practical, asked);
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

/// The causes of a set, in order.
std::vector<std::string> named(const Family& family, const Set& set) {
  std::vector<std::string> out;
  for (const std::size_t m : set.members) out.push_back(family.suspects[m].name + "/" + family.suspects[m].channel);
  std::sort(out.begin(), out.end());
  return out;
}

/// A cause with another time constant is the same answer; that with the fewest numbers is it.
void drop_same_names(const Family& family, std::vector<Set>& sets) {
  const std::vector<std::string> best = named(family, sets.front());
  for (std::size_t k = 1; k < sets.size(); ++k) {
    if (named(family, sets[k]) == best && sets[k].linear.columns.size() < sets.front().linear.columns.size())
      std::swap(sets.front(), sets[k]);
  }
  std::vector<std::vector<std::string>> seen;
  std::erase_if(sets, [&](const Set& set) {
    std::vector<std::string> names = named(family, set);
    if (std::find(seen.begin(), seen.end(), names) != seen.end()) return true;
    seen.push_back(std::move(names));
    return false;
  });
}

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

/// The smallest of the rivals, each name once.
void put_sets(std::vector<Set> rivals, AnswerOf& out) {
  drop_same_names(*out.family, rivals);
  std::size_t least = rivals.front().members.size();
  for (const Set& set : rivals) least = std::min(least, set.members.size());
  for (Set& set : rivals) {
    if (set.members.size() == least) out.sets.push_back(std::move(set));
  }
  // Of those that look the same, the one with the fewest numbers is said first.
  for (std::size_t k = 1; k < out.sets.size(); ++k) {
    Set &first = out.sets.front(), &set = out.sets[k];
    if (set.linear.columns.size() < first.linear.columns.size() && overlap(*out.family, first, set) >= kSameClass)
      std::swap(first, set);
  }
  join_classes(*out.family, out);
}

/// Members of a set that sound logs do not show.
std::vector<std::size_t> unlike_members(const Family& family, const Set& set, const Asked& asked) {
  std::vector<std::size_t> out;
  for (const std::size_t m : set.members) {
    if (unlike_of(family, set, m, asked).is) out.push_back(m);
  }
  return out;
}

/// The sets that may be the answer. Their signatures are straight lines until they are followed along their bends,
/// which costs as much as all other weighing: only those are that the answer depends on, each once.
class Standing {
 public:
  Standing(const Family& family, Search& search, const Asked& asked, const Refine& refine)
      : family_(family), search_(search), asked_(asked), refine_(refine) {
    for (const Set* set : search.ranked()) {
      if (set->stands || set->bends) sets_.push_back({*set, false});
    }
  }

  /// The most probable of all, followed; none where none is left that stands.
  std::optional<Set> best() {
    while (!sets_.empty()) {
      const auto top = std::max_element(sets_.begin(), sets_.end(),
                                        [](const One& a, const One& b) { return a.set.lead.ln < b.set.lead.ln; });
      if (top->followed) return top->set;
      if (is_known(top->set)) {
        sets_.erase(top);
      } else {
        follow(static_cast<std::size_t>(top - sets_.begin()));
      }
    }
    return std::nullopt;
  }

  /// Follows those that could do the best one's job, the most probable of each size; the rest of them is gone.
  void follow_rivals(const Fit& nothing, const Set& best) {
    const double most = taken(nothing, best.fit, best.use.channel);
    std::map<std::size_t, std::size_t> count;
    for (const Set& set : all()) {
      const double least = (set.bends ? kBent : kNear) * most;
      const bool near =
          taken(nothing, set.fit, best.use.channel) > least || !is_clearly_better(family_, best, set, asked_);
      if (!near || set.members.size() > best.members.size()) continue;
      if (!is_known(set) && count[set.members.size()] < kRefined / set.members.size()) {
        if (follow(set.members)) ++count[set.members.size()];
      } else {
        keep([&](const Set& other) { return other.members != set.members; });
      }
    }
  }

  /// Is it one of them, along its bends?
  bool follow(const std::vector<std::size_t>& members) {
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      if (sets_[k].set.members != members) continue;
      if (!sets_[k].followed) follow(k);
      return find(members) != nullptr;
    }
    return false;
  }

  /// What is left of a set without its usual members is the best no longer: the most probable of no more causes, all
  /// of which sound logs do not show, that clearly beats it at the same job; itself where none does.
  [[nodiscard]] Set better_than(const Set& left, const Fit& nothing) {
    for (const Set& set : all()) {
      if (set.members.size() > left.members.size() || !does_the_same(nothing, left, set)) continue;
      if (unlike_members(family_, set, asked_) != set.members) continue;
      if (is_clearly_better(family_, set, left, asked_) && follow(set.members)) return *find(set.members);
    }
    return left;
  }

  [[nodiscard]] std::vector<Set> all() const {
    std::vector<Set> out;
    for (const One& one : sets_) out.push_back(one.set);
    std::stable_sort(out.begin(), out.end(), [](const Set& a, const Set& b) { return a.lead.ln > b.lead.ln; });
    return out;
  }
  [[nodiscard]] const Set* find(const std::vector<std::size_t>& members) const {
    for (const One& one : sets_) {
      if (one.set.members == members) return &one.set;
    }
    return nullptr;
  }
  void keep(const std::function<bool(const Set&)>& is_kept) {
    std::erase_if(sets_, [&](const One& one) { return !is_kept(one.set); });
  }

 private:
  struct One {
    Set set;
    bool followed;
  };

  /// Do the same causes stand already, with as many numbers, followed from other time constants? They end at the same.
  [[nodiscard]] bool is_known(const Set& set) const {
    bool out = false;
    for (const One& one : sets_) {
      if (!one.followed) continue;
      if (one.set.members == set.members) return false;
      out = out || (named(family_, one.set) == named(family_, set) &&
                    one.set.linear.columns.size() == set.linear.columns.size());
    }
    return out;
  }

  const Set& followed(const Set& set) {
    const auto known = known_.find(set.members);
    return known != known_.end() ? known->second : known_.emplace(set.members, refine_(family_, set)).first->second;
  }

  /// In the place of its straight line, if it stands then: it has to beat each of its subsets where those bend as
  /// well, for beside one that bends a second cause may seem to be needed. A subset that it does not beat takes its
  /// place.
  void follow(std::size_t at) {
    const std::vector<std::size_t> members = sets_[at].set.members;
    const auto drop = [&] { sets_.erase(sets_.begin() + static_cast<std::ptrdiff_t>(at)); };
    const Set set = followed(sets_[at].set);
    if (!set.stands) return drop();
    for (std::size_t k = 0; members.size() > 1 && k < members.size(); ++k) {
      std::vector<std::size_t> rest = members;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
      const Set& smaller = followed(search_.of(rest));
      if (is_worth_more(family_, set, smaller)) continue;
      drop();
      if (smaller.stands && find(rest) == nullptr) sets_.push_back({smaller, true});
      return;
    }
    sets_[at] = {set, true};
  }

  const Family& family_;
  Search& search_;
  const Asked& asked_;
  const Refine& refine_;
  std::vector<One> sets_;
  std::map<std::vector<std::size_t>, Set> known_;
};

/// Causes of a set, the laws of one resistance as one.
std::size_t errors_of(const Family& family, const Set& set) {
  const auto laws = static_cast<std::size_t>(
      std::count_if(set.members.begin(), set.members.end(),
                    [&](std::size_t m) { return family.suspects[m].is_law_of_resistance; }));
  return set.members.size() - (laws > 1 ? laws - 1 : 0);
}

/// Does the best not tell itself from it? One of fewer errors it has to beat as it beats its own subsets: what two
/// causes follow better than the one that is there may be what no model has.
bool is_rival(const Family& family, const Set& best, const Set& set, const Asked& asked) {
  if (set.members.size() > best.members.size()) return false;
  if (errors_of(family, set) < errors_of(family, best)) return !is_worth_more(family, best, set);
  return !is_clearly_better(family, best, set, asked);
}

/// The smallest of them, without those that the most probable of these clearly beats.
void keep_smallest(const Family& family, const Asked& asked, std::vector<Set>& rivals) {
  std::size_t least = rivals.front().members.size();
  for (const Set& set : rivals) least = std::min(least, set.members.size());
  if (least == rivals.front().members.size()) return;
  std::erase_if(rivals, [&](const Set& set) { return set.members.size() > least; });
  const Set first = rivals.front();
  std::erase_if(rivals, [&](const Set& set) {
    return set.members != first.members && is_clearly_better(family, first, set, asked);
  });
}

/// The most probable set and those that it does not clearly beat at the same job. What sound logs show as well is
/// left out of it; where that is all of it, what it beats is the same usual error under another name (`usual`: the
/// first such sets).
std::vector<Set> most_probable(const Family& family, const Fit& nothing, const Asked& asked, Standing& standing,
                               std::vector<Set>& usual) {
  for (;;) {
    std::optional<Set> best = standing.best();
    if (!best) return {};
    standing.follow_rivals(nothing, *best);
    best = standing.best();
    const std::vector<std::size_t> unlike = unlike_members(family, *best, asked);
    if (standing.follow(unlike)) best = standing.better_than(*standing.find(unlike), nothing);
    std::vector<Set> rivals{*best};
    std::vector<std::vector<std::size_t>> done;
    const std::vector<Set> all = standing.all();
    for (const Set& set : all) {
      if (set.members == best->members) {
        done.push_back(set.members);
      } else if (does_the_same(nothing, *best, set)) {
        done.push_back(set.members);
        if (is_rival(family, *best, set, asked)) rivals.push_back(better_part(all, *best, set));
      }
    }
    const bool said = std::any_of(rivals.begin(), rivals.end(),
                                  [&](const Set& set) { return all_unlike(family, nothing, set, asked); });
    if (said) {
      keep_smallest(family, asked, rivals);
      return rivals;
    }
    if (usual.empty()) usual = std::move(rivals);
    standing.keep([&](const Set& set) { return std::find(done.begin(), done.end(), set.members) == done.end(); });
  }
}

}  // namespace

bool is_clearly_better(const Family& family, const Fit& best, const Fit& other, double use, const Asked& asked) {
  if (!lead_of(best, other).decisive) return false;
  double won = 0.0;  // what is better in one channel and worse in another tells nothing
  for (std::size_t c = 0; c < family.channel.size(); ++c)
    won += std::pow(use_in(family, c, best, other), 2) - std::pow(use_in(family, c, other, best), 2);
  if (won < 0.0) return false;
  for (std::size_t c = 0; c < family.channel.size(); ++c) {
    const double least =
        std::max({kTells, kTellsOfWhole * use, kTellsOfSound * asked.error(family.channel[c]).usual});
    if (use_in(family, c, best, other) > least) return true;
  }
  return false;
}

plant::World world_with(plant::World world, const AnswerOf& answer) {
  if (answer.sets.empty()) return world;
  const Set& set = answer.sets.front();
  for (std::size_t k = 0; k < set.members.size(); ++k)
    answer.family->suspects[set.members[k]].form.apply(world, set.values[k]);
  return world;
}

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
  for (auto k = static_cast<Index>(family.problem.free); k < s; ++k) {
    gram.row(k).setZero();
    gram.col(k).setZero();
  }
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
  Standing standing(family, search, asked, refine);
  for (const Set* set : search.ranked()) {
    if (out.beaten.size() < kShown && set->lead.ln > 0.0) out.beaten.push_back(*set);
  }
  std::vector<Set> usual_sets;
  std::vector<Set> rivals = most_probable(family, out.nothing, asked, standing, usual_sets);
  if (rivals.empty()) {
    out.usual = std::move(usual_sets);
  } else {
    put_sets(std::move(rivals), out);
  }
  return out;
}

void say_usual(AnswerOf& answer) {
  put_sets(std::exchange(answer.usual, {}), answer);
}

}  // namespace voltlap::explain
