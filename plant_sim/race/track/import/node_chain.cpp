// SPDX-License-Identifier: Apache-2.0
#include "race/track/import/node_chain.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "race/track/import/smooth_path.hpp"

namespace voltlap::plant {
namespace {

constexpr double kFarthestMove_m = 1.0;
constexpr std::size_t kWindow = 16;        // edges about the one where a point was last
constexpr double kSearchFirst_m = 10.0;    // about the point before, when it was nowhere yet
constexpr double kFarPoint = 6.0;          // times the median: four standard deviations
constexpr double kLeastMedian_m = 0.3;

double square(double v) { return v * v; }
PlanePoint along(PlanePoint across) { return {across.y_m, -across.x_m}; }

}  // namespace

NodeChain::NodeChain(PointList nodes, const PointList& points, bool closed)
    : nodes_(std::move(nodes)), points_(&points), closed_(closed), edge_of_point_(points.size(), kNowhere) {
  VOLTLAP_DEMAND(nodes_.size() >= 8 && points.size() >= 3);
}

void NodeChain::find_edges() {
  const std::size_t n = size(), edges = closed_ ? n : n - 1;
  edge_length_m_.resize(edges);
  across_.resize(edges);
  for (std::size_t j = 0; j < edges; ++j) {
    const PlanePoint edge = nodes_[next(j)] - nodes_[j];
    edge_length_m_[j] = std::max(1e-9, length(edge));
    across_[j] = (1.0 / edge_length_m_[j]) * left_of(edge);
  }
  normal_.resize(n);
  for (std::size_t j = 0; j < n; ++j) {
    const PlanePoint sum = across_[before(j)] + across_[std::min(j, edges - 1)];
    normal_[j] = (1.0 / std::max(1e-9, length(sum))) * sum;
  }
}

NodeCurvature NodeChain::curvature_at(std::size_t node) const {
  const std::size_t a = before(node), b = next(node);
  const PlanePoint across_a = across_[a], across_b = across_[node];
  const double mean = 0.5 * (edge_length_m_[a] + edge_length_m_[node]);
  const double turn = std::atan2(cross(across_a, across_b), dot(across_a, across_b));
  NodeCurvature c{turn / mean, {a, node, b}, {}};
  // d turn = n_b (dp_b - dp) / l_b - n_a (dp - dp_a) / l_a;  d mean = (t_b (dp_b - dp) + t_a (dp - dp_a)) / 2
  const PlanePoint turn_a = (1.0 / edge_length_m_[a]) * across_a, turn_b = (1.0 / edge_length_m_[node]) * across_b;
  const PlanePoint mean_a = -0.5 * along(across_a), mean_b = 0.5 * along(across_b);
  c.slope[0] = dot(turn_a - c.value * mean_a, normal_[a]) / mean;
  c.slope[1] = dot(c.value * (mean_a + mean_b) - (turn_a + turn_b), normal_[node]) / mean;
  c.slope[2] = dot(turn_b - c.value * mean_b, normal_[b]) / mean;
  return c;
}

void NodeChain::linearise() {
  find_edges();
  const std::size_t n = size(), first = closed_ ? 0 : 1, end = closed_ ? n : n - 1;
  curvatures_.assign(n, {});
  for (std::size_t j = first; j < end; ++j) curvatures_[j] = curvature_at(j);
  if (!closed_) {
    curvatures_.front().value = curvatures_[1].value;
    curvatures_.back().value = curvatures_[n - 2].value;
  }
  changes_.clear();
  for (std::size_t j = first; j + (closed_ ? 0 : 1) < end; ++j) {
    const NodeCurvature &a = curvatures_[j], &b = curvatures_[next(j)];
    changes_.push_back({b.value - a.value,
                        {a.node[0], a.node[1], a.node[2], b.node[2]},
                        {-a.slope[0], b.slope[0] - a.slope[1], b.slope[1] - a.slope[2], b.slope[2]}});
  }
  find_offsets();
  VOLTLAP_DEMAND(changes_.size() + (closed_ ? 0 : 3) == n);
}

std::size_t NodeChain::nearest_edge(std::size_t point, std::size_t about, std::size_t window, double& away) const {
  const std::size_t edges = edge_length_m_.size();
  std::size_t best = kNowhere;
  away = std::numeric_limits<double>::max();
  const std::size_t first = closed_ ? about + edges - std::min(window, edges / 2) : about - std::min(window, about);
  const std::size_t last = closed_ ? first + std::min(2 * window, edges - 1) : std::min(edges - 1, about + window);
  for (std::size_t k = first; k <= last; ++k) {
    const std::size_t j = k % edges;
    const PlanePoint from = (*points_)[point] - nodes_[j], t = along(across_[j]);
    const double way = std::clamp(dot(from, t), 0.0, edge_length_m_[j]);
    const double distance = length(from - way * t);
    if (distance < away) away = distance, best = j;
  }
  return best;
}

std::size_t NodeChain::edge_of(std::size_t point, std::size_t edge_before) const {
  double away = 0.0;
  const std::size_t known = edge_of_point_[point];
  if (known != kNowhere) return nearest_edge(point, known, kWindow, away);
  if (point > 0) {
    const double search = std::max(kSearchFirst_m, 2.0 * length((*points_)[point] - (*points_)[point - 1]));
    const auto window = static_cast<std::size_t>(search / edge_length_m_[edge_before]);
    const std::size_t near = nearest_edge(point, edge_before, window, away);
    if (away < kSearchFirst_m) return near;
  }
  return nearest_edge(point, 0, edge_length_m_.size(), away);
}

void NodeChain::find_offsets() {
  offsets_.clear();
  std::size_t edge = 0;
  for (std::size_t i = 0; i < points_->size(); ++i) {
    edge_of_point_[i] = edge = edge_of(i, edge);
    const double edge_length = edge_length_m_[edge];
    const PlanePoint from = (*points_)[i] - nodes_[edge];
    const double raw_share = dot(from, along(across_[edge])) / edge_length;
    if (!closed_ && (raw_share < 0.0 || raw_share > 1.0)) continue;  // before the start or beyond the end
    const double share = std::clamp(raw_share, 0.0, 1.0);
    const double curvature = 0.5 * (curvatures_[edge].value + curvatures_[next(edge)].value);
    const double sagitta = 0.5 * curvature * square(edge_length) * share * (1.0 - share);  // arc right of its chord
    PointOffset offset;
    offset.point = i;
    offset.value = dot(from, across_[edge]) + sagitta;
    offset.node = {edge, next(edge)};
    offset.slope = {share - 1.0, -share};
    offsets_.push_back(offset);
  }
  weigh_far_points();
}

void NodeChain::weigh_far_points() {
  std::vector<double> away;
  for (const PointOffset& offset : offsets_) away.push_back(std::abs(offset.value));
  const double far = kFarPoint * std::max(kLeastMedian_m, median(away));
  for (PointOffset& offset : offsets_) {
    if (std::abs(offset.value) > far) offset.weight = square(square(far / offset.value));
  }
}

void NodeChain::move(const std::vector<double>& moves) {
  VOLTLAP_DEMAND(moves.size() == size() && all_finite(moves));
  double farthest = 0.0;
  for (const double move : moves) farthest = std::max(farthest, std::abs(move));
  const double share = farthest > kFarthestMove_m ? kFarthestMove_m / farthest : 1.0;
  for (std::size_t j = 0; j < moves.size(); ++j) nodes_[j] = nodes_[j] + share * moves[j] * normal_[j];
}

void NodeChain::respace(double step_m) {
  nodes_ = evenly_spaced(nodes_, step_m, closed_);
  edge_of_point_.assign(points_->size(), kNowhere);
  VOLTLAP_DEMAND(nodes_.size() >= 8);
}

std::vector<double> NodeChain::arc_lengths() const {
  std::vector<double> arcs;
  for (std::size_t j = 0; j < edge_length_m_.size(); ++j) {
    const double half_turn = 0.25 * edge_length_m_[j] * (curvatures_[j].value + curvatures_[next(j)].value);
    arcs.push_back(edge_length_m_[j] * (std::abs(half_turn) < 1e-6 ? 1.0 : half_turn / std::sin(half_turn)));
  }
  VOLTLAP_DEMAND(all_finite(arcs));
  return arcs;
}

}  // namespace voltlap::plant
