// SPDX-License-Identifier: Apache-2.0
#include "discrepancy/further.hpp"

#include <algorithm>
#include <cmath>

namespace voltlap::plant {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Members = std::vector<std::size_t>;

constexpr std::size_t kMost = 3;   // causes of an answer
constexpr std::size_t kCurve = 3;  // columns from which a cause is a curve, which bends to whatever is left

VectorXd of_member(const System& system, std::size_t member, const VectorXd& all) {
  VectorXd out = VectorXd::Zero(all.size());
  for (const Index row : system.candidates[member].rows) out(row) = all(row);
  return out;
}

bool shares_cause(const System& system, const Members& members, std::size_t other) {
  return std::any_of(members.begin(), members.end(), [&](std::size_t m) { return same_name(system, m, other); });
}

/// The system once a set may have any size.
System given(const System& system, const Members& members) {
  const std::vector<Index> rows = rows_of(system, members);
  MatrixXd own = system.information(rows, rows);
  own.diagonal().array() += 1e-6;
  const MatrixXd across = system.information(Eigen::all, rows);
  System out = system;
  out.information -= across * own.ldlt().solve(across.transpose());
  return out;
}

struct Added {
  std::size_t candidate;
  double evidence;
};

/// What each candidate adds to the evidence of a set, best first.
std::vector<Added> additions(const Beside& beside, const Members& members) {
  const System& system = beside.system;
  const SetFit strong = fit_set(system, members);
  std::vector<Added> out;
  for (std::size_t k = 0; k < system.candidates.size(); ++k) {
    if (std::count(members.begin(), members.end(), k) > 0) continue;
    if (shares_cause(system, members, k)) continue;
    Members both = members;
    both.push_back(k);
    std::sort(both.begin(), both.end());
    const VectorXd sizes = sizes_of_all(system, both, fit_set(system, both).coefficients);
    const VectorXd own = of_member(system, k, sizes);
    const double like = likeness_by_block(beside, sizes - own, own);
    const System tempered = scaled(
        system, 1.0 / (1.0 + beside.signature_error * strong.gain * like + beside.usual_evidence / kDecisive));
    const auto without = evidence_of_set(tempered, members), with = evidence_of_set(tempered, both);
    if (without && with) out.push_back({k, *with - *without});
  }
  std::sort(out.begin(), out.end(), [](const Added& a, const Added& b) { return a.evidence > b.evidence; });
  return out;
}

/// Can this data not tell the two apart, whatever size the set has?
bool same_class(const System& rest, std::size_t a, std::size_t b) {
  return overlap(rest, {a}, fit_set(rest, {a}).coefficients, {b}) > kSameClass;
}

/// The one cause that is clearly more likely than nothing and than all others, with those of its class.
std::optional<std::pair<Added, Members>> clear_addition(const Beside& beside, const Members& members) {
  const std::vector<Added> all = additions(beside, members);
  if (all.empty() || all.front().evidence < kLarger) return std::nullopt;
  const Added best = all.front();
  const Candidate& first = beside.system.candidates[best.candidate];
  if (first.cause < 0 || first.rows.size() >= kCurve) return std::nullopt;
  const System rest = given(beside.system, members);
  Members equivalents;
  for (const Added& other : all) {
    if (other.candidate == best.candidate) continue;
    if (best.evidence - other.evidence > kDecisive) break;
    if (same_name(beside.system, best.candidate, other.candidate)) continue;
    if (!same_class(rest, best.candidate, other.candidate)) return std::nullopt;
    if (beside.system.candidates[other.candidate].cause >= 0) equivalents.push_back(other.candidate);
  }
  return std::pair{best, equivalents};
}

}  // namespace

double likeness_by_block(const Beside& beside, const VectorXd& one, const VectorXd& other) {
  double shared = 0.0, own = 0.0, theirs = 0.0;
  for (std::size_t c = 0; c < beside.score.channels.size(); ++c) {
    const double weight = 1.0 / beside.inflation[c];
    for (const BlockSum& block : beside.score.channels[c]) {
      const VectorXd seen = block.gram * other;
      shared += weight * std::abs(one.dot(seen));
      own += weight * one.dot(block.gram * one);
      theirs += weight * other.dot(seen);
    }
  }
  // Members of a group stand against the mean in no channel: what is left of the information is theirs.
  const MatrixXd& information = beside.system.information;
  shared = std::max(shared, std::abs(one.dot(information * other)));
  own = std::max(own, one.dot(information * one));
  theirs = std::max(theirs, other.dot(information * other));
  return own > 0.0 && theirs > 0.0 ? std::min(1.0, shared * shared / (own * theirs)) : 1.0;
}

std::optional<Decision> with_further_causes(const Beside& beside, const Decision& decision) {
  if (decision.members.empty() || decision.anonymous) return std::nullopt;
  Decision out = decision;
  while (out.members.size() < kMost) {
    const auto found = clear_addition(beside, out.members);
    if (!found) break;
    const auto& [added, equivalents] = *found;
    const auto at = std::lower_bound(out.members.begin(), out.members.end(), added.candidate) - out.members.begin();
    out.members.insert(out.members.begin() + at, added.candidate);
    out.equivalents.insert(out.equivalents.begin() + at, equivalents);
    out.margin = std::min(out.margin, added.evidence);
    out.next_gain = 0.0;
  }
  if (out.members.size() == decision.members.size()) return std::nullopt;
  return out;
}

}  // namespace voltlap::plant
