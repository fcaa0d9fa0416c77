// SPDX-License-Identifier: Apache-2.0
#include "explain/fit/collected.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace voltlap::explain {

double least_noise(const ReadChannel& channel) {
  // Of a practical size: no sensor is better, and no model of a cell: cells differ by a part of a percent, and starts
  // that may be anything would follow a tenth of a millivolt of it.
  constexpr double kBestSensor = 0.1, kBestCell = 0.25;
  constexpr double kFinest_k = 0.1;  // of a thermistor without steps
  // Coarse steps of a thermistor make more worth a word, not its readings between them noisier.
  if (channel.balance == plant::Balance::kHeat) return kBestSensor * std::min(kFinest_k, channel.practical);
  return (channel.name == "voltage" ? kBestCell : kBestSensor) * channel.practical;
}

Problem problem_of(const std::vector<const ReadChannel*>& channels, const Observed& log, const Collected& columns,
                   const std::vector<Index>& nuisances, Noises noises) {
  Problem out;
  out.nuisances = nuisances;
  out.free = nuisances.size();
  out.blocks = log.blocks;
  out.curves = columns.curves;
  out.prior_sigma = Eigen::Map<const VectorXd>(columns.sigma.data(), static_cast<Index>(columns.sigma.size()));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const ReadChannel& channel = *channels[c];
    ChannelColumns made{channel.reader.even_time_s(), channel.rough, {}, {}, log.blocks_of(channel)};
    for (std::size_t k = 0; k < columns.effect.size(); ++k) {
      if (columns.effect[k][c].size() > 0) made.column.push_back(static_cast<Index>(k));
    }
    made.values.resize(channel.residual.size(), static_cast<Index>(made.column.size()) + 1);
    for (std::size_t k = 0; k < made.column.size(); ++k) {
      made.values.col(static_cast<Index>(k)) = columns.effect[static_cast<std::size_t>(made.column[k])][c];
    }
    made.values.rightCols(1) = channel.residual;
    out.least_sigma.push_back(least_noise(channel));
    out.most_slow.push_back(std::numeric_limits<double>::infinity());
    std::vector<NoisePoint> grid = noise_grid(channel.balance != plant::Balance::kHeat);
    if (noises == Noises::kWhite) grid.resize(1);
    out.channels.emplace_back(std::move(made), std::move(grid), log.blocks);
  }
  return out;
}

void describe(const std::vector<const ReadChannel*>& channels, const Collected& columns, Family& out) {
  for (const ReadChannel* channel : channels) {
    out.channel.push_back(channel->name);
    out.practical.push_back(channel->practical);
    out.apart.push_back(channel->apart);
  }
  out.typical = Eigen::Map<const VectorXd>(columns.typical.data(), static_cast<Index>(columns.typical.size()));
}

}  // namespace voltlap::explain
