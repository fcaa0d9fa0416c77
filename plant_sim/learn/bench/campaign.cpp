// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/campaign.hpp"

#include <algorithm>
#include <random>

#include "core/demand.hpp"
#include "learn/bench/random_stream.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSpreadsMax = 2.5;  // a cell further out would not have been built in

class Spread {
 public:
  explicit Spread(std::uint64_t seed) : random_(seed) {}
  double operator()(double deviation) {
    return deviation * std::clamp(normal_(random_), -kSpreadsMax, kSpreadsMax);
  }

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// One nominal cell that stands for all, ideal instruments, a reading a second (or slower, as the plan logs).
BenchPlan rehearsal_of(const BenchPlan& plan) {
  BenchPlan out = plan;
  out.instruments.sensors.noise = out.instruments.sensors.quantisation = out.instruments.systematic = false;
  out.cells.capacity_scale.clear();
  out.cells.resistance_scale.clear();
  out.cells.soc_offset.clear();
  out.cells.capacity_spread = out.cells.resistance_spread = out.cells.soc_spread = 0.0;
  const double readings_wanted = 4.0 / plan.rest.window_s;
  out.sampling.rate_hz = out.sampling.log_hz = std::min(plan.sampling.rate_hz, std::max(1.0, readings_wanted));
  return out;
}

}  // namespace

Campaign::Campaign(BenchPlan plan, CellParameters cell, std::uint64_t seed)
    : plan_(std::move(plan)),
      rehearsal_(rehearsal_of(plan_)),
      cell_(std::move(cell)),
      seed_(seed),
      tests_(tests_of(plan_)),
      cells_(static_cast<std::size_t>(plan_.cells.count)),
      errors_(draw_errors(plan_.instruments, cells_.size(), stream_seed(seed, BenchStream::kInstruments))) {
  VOLTLAP_DEMAND(!tests_.empty() && !cells_.empty());
  Spread spread(stream_seed(seed, BenchStream::kCells));
  const BenchCellsSection& section = plan_.cells;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const double capacity = 1.0 + spread(section.capacity_spread),
                 resistance = 1.0 + spread(section.resistance_spread);
    cells_[i].capacity_scale = section.capacity_scale.empty() ? capacity : section.capacity_scale[i];
    cells_[i].resistance_scale = section.resistance_scale.empty() ? resistance : section.resistance_scale[i];
  }
}

std::vector<CellVariation> Campaign::cells_of(std::size_t index) const {
  std::vector<CellVariation> cells = cells_;
  Spread spread(stream_seed(seed_, BenchStream::kInitialSoc, index));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double offset = spread(plan_.cells.soc_spread);
    cells[i].initial_soc_offset = plan_.cells.soc_offset.empty() ? offset : plan_.cells.soc_offset[i];
  }
  return cells;
}

BenchRecord Campaign::run(std::size_t index, const StopRequest& stop) const {
  VOLTLAP_DEMAND(index < tests_.size());
  return run_bench_test(plan_, tests_[index], {cell_, cells_of(index), false}, errors_,
                        stream_seed(seed_, BenchStream::kNoise, index), stop);
}

BenchRecord Campaign::rehearse(std::size_t index, const StopRequest& stop) const {
  VOLTLAP_DEMAND(index < tests_.size());
  return run_bench_test(rehearsal_, tests_[index], {cell_, {}, true}, draw_errors(rehearsal_.instruments, 1, 0), 0,
                        stop);
}

}  // namespace voltlap::plant
