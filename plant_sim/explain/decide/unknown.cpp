// SPDX-License-Identifier: Apache-2.0
#include "explain/decide/unknown.hpp"

#include <cmath>
#include <limits>

#include "explain/fit/collected.hpp"
#include "explain/shapes/anonymous_shapes.hpp"

namespace voltlap::explain {

std::vector<Unnamed> unnamed_in(const Observed& log, const std::vector<VectorXd>& left, double least) {
  std::vector<plant::Shape> shapes;
  std::vector<Unnamed> out;
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    const ReadChannel& channel = log.channels[c];
    const double rows = static_cast<double>(left[c].size());
    if (left[c].squaredNorm() < std::pow(least * channel.practical, 2) * rows) continue;
    ChannelColumns made{channel.reader.even_time_s(), channel.rough, {}, {}, log.blocks_of(channel)};
    std::vector<VectorXd> columns;
    std::vector<double> sigma;
    if (shapes.empty()) shapes = plant::anonymous_shapes({log.model, log.comparison, log.base});
    for (const plant::Shape& shape : shapes) {
      if (shape.channel != c) continue;
      columns.push_back(channel.reader.of(shape.effect));
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
    problem.least_sigma = {least_noise(channel)};
    problem.most_slow = {std::numeric_limits<double>::infinity()};
    problem.channels.emplace_back(std::move(made), noise_grid(channel.balance != plant::Balance::kHeat),
                                  log.blocks);
    const Fit nothing = fit_of(problem, {}), all = fit_of(problem, problem.channels.front().column);
    const double gone =
        (nothing.left.sum() - all.left.sum()) / static_cast<double>(std::max<Index>(1, channel.residual.size()));
    out.push_back({channel.name, channel.balance, gone > 0.0 ? std::sqrt(gone) / channel.practical : 0.0,
                   lead_of(all, nothing)});
  }
  return out;
}

}  // namespace voltlap::explain
