// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/pack_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "car/battery/pack.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kStep = 0.1;  // s; also the plant's period of renewal here

VehicleParameters pack_of(const CellParameters& cell, const PlacedRecording& recording, int cells) {
  VehicleParameters car;
  car.cell = cell;
  car.battery.cells_in_series = cells;
  car.battery.cells_in_parallel = 1;
  car.battery.capacity_ah = cell.capacity_ah;
  car.battery.initial_soc = std::clamp(recording.run.soc(0), 0.0, 1.0);
  car.battery.initial_temperature_c = car.environment.ambient_c = recording.temperature.start_c;
  car.battery.lookup_current_floor_a = 0.005 * recording.run.current_a.cwiseAbs().maxCoeff();
  return car;
}

std::vector<CellVariation> variations(int cells, const CellSpread& spread) {
  std::mt19937_64 generator(spread.seed);
  std::normal_distribution<double> normal;
  std::vector<CellVariation> out;
  for (int k = 0; k < cells; ++k) {
    const double capacity = 1.0 + spread.capacity * normal(generator),
                 resistance = 1.0 + spread.resistance * normal(generator);
    out.push_back({capacity, resistance, spread.initial_soc * normal(generator)});
  }
  return out;
}

/// Gathers the difference of two packs that see the same current.
struct Gather {
  PackDifference out;
  double sum = 0.0, square = 0.0, count = 0.0;

  void take(const Pack& one, const Pack& all) {
    const double difference = one.voltage() - all.voltage();
    sum += difference;
    square += difference * difference;
    count += 1.0;
    out.voltage_max_v = std::max(out.voltage_max_v, std::abs(difference));
    out.soc_max = std::max(out.soc_max, std::abs(one.soc_mean() - all.soc_mean()));
    out.voltage_low_v = std::min(out.voltage_low_v, all.voltage());
    out.voltage_high_v = std::max(out.voltage_high_v, all.voltage());
    out.weakest_cell_v =
        std::max(out.weakest_cell_v, all.voltage() / static_cast<double>(all.cells()) - all.cell_voltage_min());
  }
  PackDifference finish() {
    if (count == 0.0) return out;
    out.voltage_mean_v = sum / count;
    out.voltage_rms_v = std::sqrt(square / count);
    const double sigma = std::sqrt(std::max(0.0, square / count - out.voltage_mean_v * out.voltage_mean_v));
    if (sigma > 0.0) out.snr = (out.voltage_high_v - out.voltage_low_v) / sigma;
    return out;
  }
};

PackDifference difference(const VehicleParameters& with_one, const VehicleParameters& with_all,
                          const PlacedRecording& recording) {
  Pack one(with_one, true, kStep), all(with_all, false, kStep);
  Gather gather;
  const MeasuredRun& run = recording.run;
  double ahead_s = 0.0;
  for (Index row = 1; row < run.rows(); ++row) {
    if (run.is_reset(row)) continue;
    ahead_s += run.dt_s(row);
    const double current = 0.5 * (run.current_begin_a(row) + run.current_end_a(row)),
                 ambient = with_one.environment.ambient_c;
    for (; ahead_s >= kStep; ahead_s -= kStep) {
      for (Pack* pack : {&one, &all}) {
        pack->renew(kStep, ambient);
        pack->advance(current);
      }
      if (one.soc_mean() < 0.0) return gather.finish();  // below empty the model has no meaning
      gather.take(one, all);
    }
  }
  return gather.finish();
}

}  // namespace

PackComparison compare_pack(const CellParameters& cell, const PlacedRecording& recording, int cells,
                            const CellSpread& spread) {
  const VehicleParameters equal = pack_of(cell, recording, cells);
  VehicleParameters differing = equal;
  differing.battery.cells = variations(cells, spread);
  return {cells, difference(equal, equal, recording), difference(equal, differing, recording)};
}

}  // namespace voltlap::plant
