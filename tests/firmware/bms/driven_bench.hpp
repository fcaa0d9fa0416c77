// SPDX-License-Identifier: Apache-2.0
// The bench with cells behind its channels: each has a charge, a capacity and a resistance, and gives a voltage under
// the current that flows. What a channel makes of the true voltages is up to the test.
#pragma once
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "bench.hpp"

namespace voltlap::bms::test {

class DrivenBench {
 public:
  explicit DrivenBench(const Config& c = pack_config(), double start = 0.75) : bench(c), cells(c.cells_in_series) {
    for (Cell& cell : cells) cell.soc = start;
    show();
  }

  struct Cell {
    double soc = 0.75, capacity = 1.0, resistance = 1.0;  ///< shares of the configured ones
    double slow_v = 0.0;                                  ///< a branch of 10 s with half of the resistance
  };

  Bench bench;
  std::vector<Cell> cells;
  std::function<double(std::size_t, double)> channel = [](std::size_t, double v) { return v; };
  std::function<double(double)> pack_channel = [](double v) { return v; };
  std::function<double(double)> sensor = [](double a) { return a; };  ///< of the current

  double voltage(std::size_t k) const {
    const Cell& cell = cells[k];
    return 3.0 + 1.2 * cell.soc - 0.001 * cell.resistance * current_a - cell.slow_v;
  }
  /// One step in which this current flows.
  const Output& tick(double amperes) {
    current_a = amperes;
    for (Cell& cell : cells) {
      cell.soc -= amperes * 0.01 / (36'000.0 * cell.capacity);
      cell.slow_v += (0.001 * cell.resistance * amperes - cell.slow_v) * 0.001;
    }
    show();
    return bench.tick();
  }
  void drive() {
    run(0.5, 0.0);
    bench.request(true);
    bench.until([](const Output& o) { return o.state == can::BmsState::kTsActive; });
    run(2.0, 0.0);
  }
  void run(double seconds, double amperes) {
    for (long i = std::lround(seconds * 100.0); i > 0; --i) tick(amperes);
  }
  /// Corners and straights: 0 to 120 A, as a car on a course. Milliseconds until `done`, or -1.
  std::int32_t lap_until(const std::function<bool(const Output&)>& done, double most_s = 60.0) {
    for (std::int32_t t = 0; t < static_cast<std::int32_t>(most_s * 1000.0); t += 10, ++step_) {
      const double phase = 0.01 * static_cast<double>(step_);
      const double wanted = 70.0 + 60.0 * std::sin(2.1 * phase) + 40.0 * std::sin(0.7 * phase);
      if (done(tick(std::max(0.0, wanted) * scale))) return t;
    }
    return -1;
  }

  double current_a = 0.0;
  double scale = 1.0;  ///< of the lap's current

 private:
  void show() {
    double sum = 0.0;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      sum += voltage(k);
      bench.cell_100uv[k] = static_cast<std::int32_t>(std::lround(1e4 * channel(k, voltage(k))));
    }
    bench.sum_follows_cells = false;
    bench.pack.pack_voltage_100uv = static_cast<std::int32_t>(std::lround(1e4 * pack_channel(sum * pack_gain)));
    bench.current(amps(sensor(current_a)));
  }

  long step_ = 0;

 public:
  double pack_gain = 1.0;
};

inline std::function<bool(const Output&)> sees(can::BmsFault fault) {
  return [=](const Output& o) { return has(o, fault); };
}

}  // namespace voltlap::bms::test
