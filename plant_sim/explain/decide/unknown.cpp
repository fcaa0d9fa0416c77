// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/unknown.hpp"

#include <cmath>

#include "discrepancy/anonymous_shapes.hpp"

namespace voltlap::explain {

std::vector<Unnamed> unnamed_in(const Observed& log, const std::vector<VectorXd>& left) {
  plant::Design design;
  design.model = log.model;
  design.comparison = log.comparison;
  design.base = log.base;
  const std::vector<plant::Column> shapes = plant::anonymous_columns(design);
  std::vector<Unnamed> out;
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    const ReadChannel& channel = log.channels[c];
    ChannelColumns made{channel.reader.time_s(), channel.rough, {}, {}, log.blocks_of(channel)};
    std::vector<VectorXd> columns;
    std::vector<double> sigma;
    for (const plant::Column& shape : shapes) {
      if (shape.effect[c].size() == 0) continue;
      columns.push_back(channel.reader.of(shape.effect[c]));
      sigma.push_back(std::max(1.0, shape.usual));
    }
    if (columns.empty()) continue;
    made.values.resize(channel.residual.size(), static_cast<Index>(columns.size()) + 1);
    Problem problem;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      made.column.push_back(static_cast<Index>(k));
      made.values.col(static_cast<Index>(k)) = columns[k];
    }
    made.values.rightCols(1) = left[c];
    problem.blocks = log.blocks;
    problem.prior_sigma = Eigen::Map<const VectorXd>(sigma.data(), static_cast<Index>(sigma.size()));
    problem.least_sigma = {0.02 * channel.practical};
    problem.channels.push_back(gram_of(made, noise_grid(channel.balance != plant::Balance::kHeat), log.blocks));
    const Fit nothing = fit_of(problem, {}), all = fit_of(problem, made.column);
    const double gone =
        (nothing.left.sum() - all.left.sum()) / static_cast<double>(std::max<Index>(1, channel.residual.size()));
    out.push_back({channel.name, channel.balance, gone > 0.0 ? std::sqrt(gone) / channel.practical : 0.0,
                   lead_of(all, nothing)});
  }
  return out;
}

}  // namespace voltlap::explain
