// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/node_moves.hpp"

#include <algorithm>

#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kRidge = 1e-9;                    // of nodes that no point is near
constexpr double kMoreDamping[] = {0.0, 1e-6, 1e-4, 1e-2, 1.0};

}  // namespace

NodeMoves::NodeMoves(const NodeChain& chain)
    : chain_(chain), system_(chain.size(), chain.closed() ? 6 : 3), right_(chain.size(), 0.0) {}

bool NodeMoves::try_solve(const std::vector<double>& weights, double damping) {
  VOLTLAP_DEMAND(weights.size() == chain_.changes().size());
  system_.clear();
  std::fill(right_.begin(), right_.end(), 0.0);
  for (const PointOffset& offset : chain_.offsets()) add(offset, offset.weight);
  for (std::size_t k = 0; k < weights.size(); ++k) add(chain_.changes()[k], weights[k]);
  for (std::size_t j = 0; j < chain_.size(); ++j) system_.add(j, j, kRidge + damping);
  if (!system_.factorise()) return false;
  const std::vector<double> by_row = system_.solved(right_);
  moves_.resize(by_row.size());
  for (std::size_t j = 0; j < moves_.size(); ++j) moves_[j] = by_row[row(j)];
  return true;
}

void NodeMoves::solve(const std::vector<double>& weights, double damping) {
  const bool solved = std::any_of(std::begin(kMoreDamping), std::end(kMoreDamping),
                                  [&](double more) { return try_solve(weights, damping + more); });
  if (!solved) {
    throw InputError("the points", "a line through them that no arithmetic follows: neighbours lie far apart",
                     "points in the order in which they were driven, none of them far from the others",
                     "Take out the points that are far from their neighbours");
  }
}

double NodeMoves::squares_left() const {
  double sum = 0.0;
  for (const PointOffset& offset : chain_.offsets()) {
    const double left = offset.at(moves_);
    sum += offset.weight * left * left;
  }
  return sum;
}

}  // namespace voltlap::plant
