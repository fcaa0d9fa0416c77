// SPDX-License-Identifier: Apache-2.0
// A line as a chain of nodes, each of which moves across it, with what depends on the moves d in first order: the
// curvature at the nodes, its change from one to the next, and how far points lie off the line.
#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "race/track/import/plane_point.hpp"

namespace voltlap::plant {

/// value + sum slope_k d_(node_k): a quantity that some neighbouring nodes move.
template <std::size_t N>
struct NodeFunction {
  double value = 0.0;
  std::array<std::size_t, N> node{};
  std::array<double, N> slope{};

  [[nodiscard]] double at(const std::vector<double>& moves) const {
    double sum = value;
    for (std::size_t k = 0; k < N; ++k) sum += slope[k] * moves[node[k]];
    return sum;
  }
};

using NodeCurvature = NodeFunction<3>;    ///< turned angle over length, 1/m, above 0 to the left
using CurvatureChange = NodeFunction<4>;  ///< from a node to the next
/// Distance of a point from the line, above 0 to the left.
struct PointOffset : NodeFunction<2> {
  std::size_t point = 0;  ///< index
  double weight = 1.0;  ///< below 1 for a point that lies much farther off than the others
};

class NodeChain {
 public:
  /// `points` must outlive it and its copies.
  NodeChain(PointList nodes, const PointList& points, bool closed);

  /// Curvatures, changes and offsets about the nodes where they are now.
  void linearise();
  /// Moves the nodes across the line by `moves`, or by the share of it that keeps the farthest below 1 m.
  void move(const std::vector<double>& moves);
  /// Lays the nodes out evenly again.
  void respace(double step_m);

  [[nodiscard]] std::size_t size() const { return nodes_.size(); }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] std::size_t next(std::size_t node) const {
    return node + 1 < size() ? node + 1 : closed_ ? 0 : node;
  }
  [[nodiscard]] std::size_t before(std::size_t node) const { return node == 0 ? (closed_ ? size() - 1 : 0) : node - 1; }
  [[nodiscard]] const PointList& nodes() const { return nodes_; }
  [[nodiscard]] const PointList& points() const { return *points_; }
  [[nodiscard]] const std::vector<NodeCurvature>& curvatures() const { return curvatures_; }
  /// Change k is the one from node k + `first_change()` to the next.
  [[nodiscard]] const std::vector<CurvatureChange>& changes() const { return changes_; }
  [[nodiscard]] std::size_t first_change() const { return closed_ ? 0 : 1; }
  [[nodiscard]] const std::vector<PointOffset>& offsets() const { return offsets_; }
  /// Lengths along the arcs from each node to the next.
  [[nodiscard]] std::vector<double> arc_lengths() const;

 private:
  static constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

  void find_edges();
  [[nodiscard]] NodeCurvature curvature_at(std::size_t node) const;
  void find_offsets();
  [[nodiscard]] std::size_t nearest_edge(std::size_t point, std::size_t about, std::size_t window, double& away) const;
  [[nodiscard]] std::size_t edge_of(std::size_t point, std::size_t edge_before) const;
  void weigh_far_points();

  PointList nodes_;
  const PointList* points_;
  bool closed_;
  std::vector<double> edge_length_m_;  ///< edge j goes from node j to the next
  PointList across_, normal_;          ///< unit vectors to the left: of edges, at nodes
  std::vector<NodeCurvature> curvatures_;
  std::vector<CurvatureChange> changes_;
  std::vector<PointOffset> offsets_;
  std::vector<std::size_t> edge_of_point_;
};

}  // namespace voltlap::plant
