// SPDX-License-Identifier: Apache-2.0
// All sets of up to three causes that could explain a family, each weighed on minutes it has not seen: singles,
// pairs of the best singles with any and of what is identified together, triples of the best pairs with any.
#pragma once
#include <map>
#include <vector>

#include "explain/fit/columns.hpp"

namespace voltlap::explain {

/// What a set takes away from the plain error of one channel: RMS of what is no longer there, in practical sizes,
/// on blocks that its fit did not see, but for the one where it spoils most: that may be all that tells a curve
/// there.
struct Use {
  double practical = 0.0;
  std::size_t channel = 0;
};
/// Of `better` against `worse`, in the channel where it is most of what is asked, and in one channel [practical sizes].
[[nodiscard]] Use use_of(const Family& family, const Fit& better, const Fit& worse);
[[nodiscard]] double use_in(const Family& family, std::size_t channel, const Fit& better, const Fit& worse);

struct Set {
  std::vector<std::size_t> members;                ///< of family.suspects, rising
  Fit linear;                                      ///< with signatures as straight lines
  Fit fit;                                         ///< as it is judged: where its causes' bends are followed
  std::vector<std::vector<double>> values, sigma;  ///< by member all its parameters; sigma 0: not estimated
  Lead lead;                                       ///< beyond nothing
  Use use;
  /// As a straight line it is larger than can be or a large part of that, or takes what is there and foresees
  /// badly: it is judged where its bends are followed.
  bool bends = false;
  bool stands = false;  ///< against nothing and against each of its subsets, by a practical amount
};

/// Is its use where one of its causes acts? What is wrong with the voltage alone is no explanation of the heat.
[[nodiscard]] bool is_at_home(const std::vector<plant::Cause>& causes, const Family& family, const Set& set);
/// What a fit leaves of a channel beyond what differs from reading to reading by `noise`, in practical sizes.
[[nodiscard]] double error_in(const Family& family, const Fit& fit, const Fit& noise, std::size_t channel);

/// Is it of practical size: by itself, and as a part of an error that is there anyway, noise apart?
[[nodiscard]] bool takes_enough(const Family& family, const Set& set, const Fit& nothing);
/// Is it as much as is asked of it where no reference tells how well the model does? What is less is not said; it
/// stands all the same, or another cause would be said for it that explains less.
[[nodiscard]] bool is_of_use(const Family& family, const Set& set);
/// Is a set worth more than one of its subsets: decisively, and by a practical amount that is a part of the whole?
[[nodiscard]] bool is_worth_more(const Family& family, const Set& set, const Set& subset);
/// Of `all` the part of `whole` that has no more causes than `other` and is decisively more probable; `other` where
/// there is none. What stands in for two causes does so no better than one of these.
[[nodiscard]] Set better_part(const std::vector<Set>& all, const Set& whole, const Set& other);

class Search {
 public:
  Search(const Family& family, const std::vector<plant::Cause>& causes);
  /// All that were weighed, the most probable first.
  [[nodiscard]] std::vector<const Set*> ranked() const;
  [[nodiscard]] const Fit& nothing() const { return nothing_; }
  [[nodiscard]] const Set& of(const std::vector<std::size_t>& members);

 private:
  void judge(Set& set);
  [[nodiscard]] bool fits_together(const std::vector<std::size_t>& members) const;
  [[nodiscard]] bool is_possible(const Set& set) const;
  [[nodiscard]] bool is_large(const Set& set) const;
  [[nodiscard]] bool is_seen(const Set& set) const;
  [[nodiscard]] std::vector<VectorXd> effects_in(const Set& set, std::size_t channel) const;
  [[nodiscard]] bool cancels(const Set& set) const;
  void pair_identified();
  void grow(std::size_t from_size, std::size_t best);

  const Family& family_;
  const std::vector<plant::Cause>& causes_;
  Fit nothing_;
  std::map<std::vector<std::size_t>, Set> sets_;
};

/// Columns of a set.
[[nodiscard]] std::vector<Index> columns_of(const Family& family, const std::vector<std::size_t>& members);
/// Values and their standard deviations of a set's members, from a fit that began at `from`; the columns of a
/// member are `parameters` of it.
void put_values(const Family& family, const Fit& fit, const std::vector<std::vector<double>>& from,
                const std::vector<std::vector<std::size_t>>& parameters, Set& set);
}  // namespace voltlap::explain
